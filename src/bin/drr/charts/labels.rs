//! Where the names of points go, so that they lie neither on each other nor on points.

use std::f64::consts::PI;

/// Directions and distances that are tried, the latter in pixels from the mark's edge.
const DIRECTIONS: usize = 16;
const DISTANCES: [f64; 9] = [0.0, 6.0, 14.0, 24.0, 36.0, 52.0, 72.0, 96.0, 124.0];
/// From this distance on, a line leads from the mark to its name.
const LED: f64 = 14.0;
/// After all have a place, each looks for a better one at most so many times.
const ROUNDS: usize = 4;

/// Costs. An overlap costs more than any detour.
const OVERLAP: f64 = 1e4;
const OUTSIDE: f64 = 1e5;
const CROSSING_LEADER: f64 = 300.0;
const STRIKE: f64 = 35.0;
/// The name is nearer to another mark than to its own.
const AMBIGUOUS: f64 = 60.0;

/// An upright box, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    pub(super) least: [f64; 2],
    pub(super) most: [f64; 2],
}

pub(super) type Segment = [[f64; 2]; 2];

/// A name that needs a place.
#[derive(Debug, Clone)]
pub(super) struct Request {
    /// The mark that is named.
    pub(super) at: [f64; 2],
    pub(super) radius: f64,
    pub(super) size: [f64; 2],
}

/// What is in the way.
#[derive(Debug, Clone)]
pub(super) struct Obstacles {
    /// Where names have to be.
    pub(super) bounds: Rect,
    /// Marks and everything else that must stay visible.
    pub(super) boxes: Vec<Rect>,
    /// Lines that names had better not cross.
    pub(super) lines: Vec<Segment>,
}

/// The place of a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) area: Rect,
    /// From the mark to the name, where they are apart.
    pub(super) leader: Option<Segment>,
    /// Which end of the text is at the mark: −1 its left end, 0 its middle, 1 its right end.
    pub(super) side: i8,
    detour: f64,
}

/// A place for each name: the cheapest arrangement of some that are tried.
pub(super) fn place(requests: &[Request], obstacles: &Obstacles) -> Vec<Place> {
    let given: Vec<usize> = (0..requests.len()).collect();
    let mut across = given.clone();
    across.sort_by(|a, b| requests[*a].at[0].total_cmp(&requests[*b].at[0]));
    let reversed = [&given, &across].map(|order| order.iter().rev().copied().collect());
    let arrangements = [given, across].into_iter().chain(reversed).map(|order| {
        let places = arranged(requests, &order, obstacles);
        let all = |i: usize| cost(&places[i], &requests[i], &without(&places, i), obstacles);
        ((0..places.len()).map(all).sum::<f64>(), places)
    });
    arrangements.min_by(|(a, _), (b, _)| a.total_cmp(b)).expect("orders are tried").1
}

/// Each name in turn takes the place that is best, given the others' places; several times.
fn arranged(requests: &[Request], order: &[usize], obstacles: &Obstacles) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::with_capacity(requests.len());
    for i in order {
        places.push(best(&requests[*i], &places, obstacles));
    }
    // From the order of placing to that of the names.
    let mut numbered: Vec<(usize, Place)> = order.iter().copied().zip(places).collect();
    numbered.sort_by_key(|(i, _)| *i);
    let mut places: Vec<Place> = numbered.into_iter().map(|(_, place)| place).collect();
    for _ in 0..ROUNDS {
        let before = places.clone();
        for i in order {
            places[*i] = best(&requests[*i], &without(&places, *i), obstacles);
        }
        if places == before {
            break;
        }
    }
    places
}

fn without(places: &[Place], i: usize) -> Vec<Place> {
    places.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, place)| *place).collect()
}

fn best(request: &Request, others: &[Place], obstacles: &Obstacles) -> Place {
    let cost = |candidate: &Place| cost(candidate, request, others, obstacles);
    let candidates = DISTANCES.iter().flat_map(|d| (0..DIRECTIONS).map(|n| candidate(request, *d, n)));
    let rated = candidates.map(|candidate| (cost(&candidate), candidate));
    rated.min_by(|(a, _), (b, _)| a.total_cmp(b)).expect("there are candidates").1
}

fn candidate(request: &Request, distance: f64, direction: usize) -> Place {
    let angle = 2.0 * PI * direction as f64 / DIRECTIONS as f64;
    let (y, x) = angle.sin_cos();
    let reach = request.radius + distance;
    let centre = [
        request.at[0] + x * (reach + 4.0) + x * request.size[0] / 2.0,
        request.at[1] - y * reach - y * request.size[1] / 2.0,
    ];
    let half = request.size.map(|side| side / 2.0);
    let area = Rect {
        least: [centre[0] - half[0], centre[1] - half[1]],
        most: [centre[0] + half[0], centre[1] + half[1]],
    };
    let leader = (distance >= LED).then(|| leader(request, area));
    let side = if x > 0.3 { -1 } else { i8::from(x < -0.3) };
    // To the right is where a name is looked for first, then above, then below.
    let detour = 1.5 * distance + 4.0 * (1.0 - x) - 2.0 * y;
    Place { area, leader, side, detour }
}

/// From the mark's edge to the nearest spot of the name.
fn leader(request: &Request, area: Rect) -> Segment {
    let to = [0, 1].map(|axis| request.at[axis].clamp(area.least[axis], area.most[axis]));
    let along = [to[0] - request.at[0], to[1] - request.at[1]];
    let length = along[0].hypot(along[1]).max(1.0);
    let from = [0, 1].map(|axis| request.at[axis] + along[axis] * (request.radius / length).min(1.0));
    [from, to]
}

fn cost(candidate: &Place, request: &Request, others: &[Place], obstacles: &Obstacles) -> f64 {
    let mut cost = candidate.detour;
    if !obstacles.bounds.contains(candidate.area) {
        cost += OUTSIDE + candidate.area.beyond(obstacles.bounds);
    }
    let spot = Rect { least: request.at, most: request.at };
    let own_gap = candidate.area.gap(spot) - request.radius;
    for area in obstacles.boxes.iter().filter(|area| !area.contains(spot)) {
        if candidate.area.gap(*area) < own_gap + 3.0 {
            cost += AMBIGUOUS;
        }
    }
    // Names need a space between them to be read as two.
    let spaced = others.iter().map(|other| other.area.grown(3.0));
    for area in obstacles.boxes.iter().copied().chain(spaced) {
        cost += overlap(candidate.area, area);
        if candidate.leader.is_some_and(|leader| !area.contains(spot) && area.meets(leader)) {
            cost += CROSSING_LEADER;
        }
    }
    for other in others.iter().filter_map(|other| other.leader) {
        if candidate.area.meets(other) {
            cost += CROSSING_LEADER;
        }
        if candidate.leader.is_some_and(|leader| cross(leader, other)) {
            cost += CROSSING_LEADER;
        }
    }
    let wide = candidate.area.grown(2.0);
    let struck = obstacles.lines.iter().filter(|line| wide.meets(**line)).count();
    cost + STRIKE * struck as f64
}

fn overlap(a: Rect, b: Rect) -> f64 {
    let side = |axis: usize| a.most[axis].min(b.most[axis]) - a.least[axis].max(b.least[axis]);
    let (width, height) = (side(0), side(1));
    if width > 0.0 && height > 0.0 { OVERLAP + 100.0 * width * height } else { 0.0 }
}

impl Rect {
    /// The box around a spot.
    pub(super) fn around([x, y]: [f64; 2], half: f64) -> Self {
        Self { least: [x - half, y - half], most: [x + half, y + half] }
    }

    fn grown(self, margin: f64) -> Self {
        Self { least: self.least.map(|edge| edge - margin), most: self.most.map(|edge| edge + margin) }
    }

    fn contains(self, other: Self) -> bool {
        (0..2).all(|axis| self.least[axis] <= other.least[axis] && other.most[axis] <= self.most[axis])
    }

    /// The distance to the other one; 0 where they overlap.
    fn gap(self, other: Self) -> f64 {
        let axis = |axis: usize| {
            (self.least[axis] - other.most[axis]).max(other.least[axis] - self.most[axis]).max(0.0)
        };
        axis(0).hypot(axis(1))
    }

    /// How far this one sticks out of the bounds, pixels.
    fn beyond(self, bounds: Self) -> f64 {
        let axis = |axis: usize| {
            (bounds.least[axis] - self.least[axis]).max(0.0) + (self.most[axis] - bounds.most[axis]).max(0.0)
        };
        axis(0) + axis(1)
    }

    /// Whether the line has a spot inside.
    fn meets(self, [from, to]: Segment) -> bool {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for axis in 0..2 {
            let along = to[axis] - from[axis];
            if along == 0.0 {
                if from[axis] <= self.least[axis] || from[axis] >= self.most[axis] {
                    return false;
                }
            } else {
                let [a, b] = [self.least[axis], self.most[axis]].map(|edge| (edge - from[axis]) / along);
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            }
        }
        enter < leave
    }
}

fn cross([a, b]: Segment, [c, d]: Segment) -> bool {
    let turn =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Rect = Rect { least: [0.0, 0.0], most: [800.0, 500.0] };

    fn placed(spots: &[[f64; 2]]) -> (Vec<Place>, Obstacles) {
        let boxes = spots.iter().map(|spot| Rect::around(*spot, 7.0)).collect();
        let obstacles = Obstacles { bounds: BOUNDS, boxes, lines: vec![] };
        let request = |at: &[f64; 2]| Request { at: *at, radius: 7.0, size: [90.0, 14.0] };
        let requests: Vec<_> = spots.iter().map(request).collect();
        (place(&requests, &obstacles), obstacles)
    }

    fn assert_apart(places: &[Place], obstacles: &Obstacles) {
        for (i, place) in places.iter().enumerate() {
            assert!(BOUNDS.contains(place.area), "{i}: {place:?}");
            let others = places[..i].iter().map(|other| other.area);
            for other in others.chain(obstacles.boxes.iter().copied()) {
                assert_eq!(overlap(place.area, other), 0.0, "{i}: {place:?} {other:?}");
            }
        }
    }

    #[test]
    fn a_lone_name_stands_right_of_its_mark() {
        let (places, obstacles) = placed(&[[300.0, 200.0]]);
        assert_apart(&places, &obstacles);
        assert!(places[0].area.least[0] >= 307.0 && places[0].leader.is_none() && places[0].side == -1);
    }

    #[test]
    fn names_of_marks_that_nearly_coincide_are_apart() {
        let spots: Vec<_> = (0..12).map(|i| [400.0 + 3.0 * f64::from(i % 4), 250.0 + f64::from(i)]).collect();
        let (places, obstacles) = placed(&spots);
        assert_apart(&places, &obstacles);
        assert!(places.iter().any(|place| place.leader.is_some()));
    }

    #[test]
    fn names_stay_inside_at_every_corner() {
        let (places, obstacles) = placed(&[[2.0, 2.0], [798.0, 2.0], [2.0, 498.0], [798.0, 498.0]]);
        assert_apart(&places, &obstacles);
    }

    #[test]
    fn lines_that_meet_a_box_are_seen() {
        let area = Rect { least: [10.0, 10.0], most: [20.0, 20.0] };
        assert!(area.meets([[0.0, 15.0], [30.0, 15.0]]) && area.meets([[12.0, 12.0], [13.0, 13.0]]));
        assert!(!area.meets([[0.0, 25.0], [30.0, 25.0]]) && !area.meets([[0.0, 15.0], [5.0, 15.0]]));
        assert!(cross([[0.0, 0.0], [2.0, 2.0]], [[0.0, 2.0], [2.0, 0.0]]));
        assert!(!cross([[0.0, 0.0], [2.0, 2.0]], [[3.0, 2.0], [3.0, 0.0]]));
    }
}
