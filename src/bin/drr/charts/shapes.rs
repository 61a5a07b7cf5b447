//! Which pixels a shape covers, and how much of each.

use std::collections::BTreeMap;

/// Samples per side of a pixel.
const SIDE: i32 = 4;

/// A point in pixels; pixel (i, j) has its centre there.
pub(super) type Spot = [f64; 2];

/// The covered samples of each covered pixel, a bit each: of overlapping parts, what both cover counts once.
#[derive(Default)]
pub(super) struct Coverage(BTreeMap<[i32; 2], u16>);

impl Coverage {
    /// The covered pixels, each with the covered fraction.
    pub(super) fn pixels(&self) -> impl Iterator<Item = ([i32; 2], f64)> {
        self.0
            .iter()
            .map(|(pixel, samples)| (*pixel, f64::from(samples.count_ones()) / f64::from(SIDE * SIDE)))
    }

    /// A line with round ends.
    pub(super) fn line(&mut self, [from, to]: [Spot; 2], width: f64) {
        let half = width / 2.0;
        self.add([from, to], half, |spot| distance(spot, [from, to]) <= half);
    }

    /// A disc, or the ring of this width along its edge.
    pub(super) fn circle(&mut self, centre: Spot, radius: f64, ring: Option<f64>) {
        let half = ring.unwrap_or(0.0) / 2.0;
        self.add([centre, centre], radius + half, |[x, y]| {
            let distance = (x - centre[0]).hypot(y - centre[1]);
            if ring.is_some() { (distance - radius).abs() <= half } else { distance <= radius }
        });
    }

    /// The inside of a closed line.
    pub(super) fn polygon(&mut self, corners: &[Spot]) {
        let Some(bounds) = bounds(corners) else { return };
        self.add(bounds, 0.0, |[x, y]| {
            let edges = corners.iter().zip(corners.iter().cycle().skip(1));
            let crossed = edges.filter(|([x0, y0], [x1, y1])| {
                (*y0 > y) != (*y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)
            });
            crossed.count() % 2 == 1
        });
    }

    /// Adds the samples that are inside, within `margin` of the box from one corner to the other.
    fn add(&mut self, [one, other]: [Spot; 2], margin: f64, inside: impl Fn(Spot) -> bool) {
        let range = |axis: usize| {
            let (least, most) = (one[axis].min(other[axis]) - margin, one[axis].max(other[axis]) + margin);
            (least - 1.0).floor() as i32..=(most + 1.0).ceil() as i32
        };
        let sample = |pixel: i32, n: i32| f64::from(pixel) + (f64::from(n) + 0.5) / f64::from(SIDE) - 0.5;
        for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
            let covered = (0..SIDE * SIDE)
                .filter(|n| inside([sample(column, n % SIDE), sample(row, n / SIDE)]))
                .fold(0, |samples, n| samples | 1 << n);
            if covered != 0 {
                *self.0.entry([column, row]).or_default() |= covered;
            }
        }
    }
}

/// The corners of the box around the spots.
fn bounds(spots: &[Spot]) -> Option<[Spot; 2]> {
    let first = *spots.first()?;
    Some(spots.iter().fold([first, first], |[least, most], [x, y]| {
        [[least[0].min(*x), least[1].min(*y)], [most[0].max(*x), most[1].max(*y)]]
    }))
}

/// From a spot to the nearest one of a line.
fn distance([x, y]: Spot, [from, to]: [Spot; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let dot = (x - from[0]) * along[0] + (y - from[1]) * along[1];
    let place = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - from[0] - place * along[0]).hypot(y - from[1] - place * along[1])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn area(coverage: &Coverage) -> f64 {
        coverage.pixels().map(|(_, fraction)| fraction).sum()
    }

    #[test]
    fn areas_are_those_of_geometry() {
        let [mut line, mut disc, mut ring, mut polygon] = [(); 4].map(|()| Coverage::default());
        line.line([[0.0, 0.0], [40.0, 30.0]], 2.0);
        assert!((area(&line) - (100.0 + PI)).abs() < 1.5, "{}", area(&line));
        disc.circle([3.3, 4.4], 8.0, None);
        assert!((area(&disc) - 64.0 * PI).abs() < 1.5, "{}", area(&disc));
        ring.circle([3.3, 4.4], 8.0, Some(2.0));
        assert!((area(&ring) - 32.0 * PI).abs() < 1.5, "{}", area(&ring));
        polygon.polygon(&[[0.0, 0.0], [30.0, 0.0], [0.0, 20.0]]);
        assert!((area(&polygon) - 300.0).abs() < 3.0, "{}", area(&polygon));
    }

    #[test]
    fn a_thin_upright_line_is_crisp_and_overlaps_count_once() {
        let mut line = Coverage::default();
        line.line([[5.0, 1.0], [5.0, 9.0]], 1.0);
        line.line([[5.0, 4.0], [5.0, 9.0]], 1.0);
        let inner: Vec<_> = line.pixels().filter(|([_, row], _)| (2..=8).contains(row)).collect();
        assert_eq!(inner, (2..=8).map(|row| ([5, row], 1.0)).collect::<Vec<_>>());
    }

    #[test]
    fn shapes_of_no_size_cover_nothing() {
        let mut coverage = Coverage::default();
        coverage.polygon(&[]);
        coverage.polygon(&[[1.0, 1.0]]);
        coverage.line([[1.0, 1.0]; 2], 0.0);
        assert_eq!(area(&coverage), 0.0);
    }
}
