//! Some of the pixels of some views, which stand for all of them.

use glam::DMat4;

use crate::geometry::{DetectorPose, Projection, View};
use crate::projector::ViewRequest;

/// Samples with starts of their own: their differences tell how far the mean of all is from that of all pixels.
const REPLICATES: usize = 8;

/// From the start of one replicate to that of the next, parts of the room that starts have: the points of this sequence
/// fill a square evenly (Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
const EVENLY: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Most views that a replicate looks at.
const MOST_VIEWS: usize = 64;

/// Replicated systematic samples of the pixels of some views (Cochran, Sampling Techniques, 3rd ed. 1977, §8.9): each is an
/// even grid of pixels with a random start. The same arguments give the same sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Those of the first replicate, those of the second, …
    grids: Vec<PixelGrid>,
    /// Width and height of each grid, pixels.
    size: [usize; 2],
    replicates: usize,
    /// Of all pixels of all views.
    part: f64,
}

/// Every nth pixel of every nth row of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PixelGrid {
    view: View,
    /// Of the view's detector.
    size: [usize; 2],
    first: [usize; 2],
    stride: usize,
}

impl Sample {
    /// About `rays` of the pixels of `views`, whose detectors have `size` = width × height pixels; `seed` decides which.
    pub fn new(views: &[View], size: [usize; 2], rays: usize, seed: u64) -> Self {
        let seen = views.len().min(MOST_VIEWS);
        let all = size[0] * size[1] * seen <= rays && seen == views.len();
        let replicates = if all { 1 } else { REPLICATES };
        let stride = if all { 1 } else { stride(size, rays as f64 / (replicates * seen) as f64) };
        let coarse = size.map(|n| (n / stride).max(1));
        let mut random = Random(seed);
        // Where not all views are looked at, every replicate looks at others: views differ as well.
        let order = if seen < views.len() { random.order(views.len()) } else { (0..seen).collect() };
        let starts: Vec<_> = (0..seen).map(|_| [random.unit(), random.unit()]).collect();
        let grid = |(r, v): (usize, usize)| {
            // Random for each view; from there on the replicates lie evenly.
            let start = |axis: usize| (starts[v][axis] + r as f64 * EVENLY[axis]).fract();
            let room = |axis: usize| (size[axis] - (coarse[axis] - 1) * stride) as f64;
            let first = [0, 1].map(|axis| (start(axis) * room(axis)) as usize);
            let view = views[order[(r * seen + v) % order.len()]];
            PixelGrid { view, size, first, stride }
        };
        let grids = (0..replicates).flat_map(|r| (0..seen).map(move |v| (r, v))).map(grid).collect();
        Self { grids, size: coarse, replicates, part: 0.0 }.of_all(views.len() * size[0] * size[1])
    }

    /// One even grid of about `rays` pixels per view, with its first pixel as near to the corner as to the opposite one.
    pub fn even(views: &[View], size: [usize; 2], rays: usize) -> Self {
        let stride = stride(size, rays as f64);
        let coarse = size.map(|n| n.div_ceil(stride));
        let first = [0, 1].map(|axis| (size[axis] - 1 - (coarse[axis] - 1) * stride) / 2);
        let grids = views.iter().map(|&view| PixelGrid { view, size, first, stride }).collect();
        Self { grids, size: coarse, replicates: 1, part: 0.0 }.of_all(views.len() * size[0] * size[1])
    }

    fn of_all(self, pixels: usize) -> Self {
        Self { part: self.rays() as f64 / pixels as f64, ..self }
    }

    /// The part of all pixels that it has.
    pub fn part(&self) -> f64 {
        self.part
    }

    /// Width and height of each of the sample's views, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The views of the first replicate, those of the second, …, with the chosen pixels alone. All their rays go as far to
    /// the right and down of these pixels' centres as `shift` says, pixels.
    pub fn views(&self, shift: [f64; 2]) -> Vec<ViewRequest> {
        self.grids.iter().map(|grid| grid.request(shift, self.size)).collect()
    }

    /// Some of its rays, each as a view of one pixel. Ray k is the one whose value is the kth of an image of all views.
    pub(crate) fn rays_of(&self, rays: &[usize]) -> Vec<ViewRequest> {
        let [width, height] = self.size;
        let view = |&ray: &usize| {
            let grid = &self.grids[ray / (width * height)];
            let at = [ray % width, ray / width % height];
            let first = [0, 1].map(|axis| grid.first[axis] + grid.stride * at[axis]);
            PixelGrid { first, ..*grid }.request([0.0; 2], [1, 1])
        };
        rays.iter().map(view).collect()
    }

    /// Pixels from one ray of a view to the next.
    pub(crate) fn stride(&self) -> usize {
        self.grids[0].stride
    }

    /// Number of replicates; 1 where nothing is left to chance.
    pub fn replicates(&self) -> usize {
        self.replicates
    }

    /// Rays of all replicates.
    pub fn rays(&self) -> usize {
        self.grids.len() * self.size[0] * self.size[1]
    }

    /// The values of each replicate, of one value per ray.
    pub fn split<'a, T>(&self, values: &'a [T]) -> impl Iterator<Item = &'a [T]> + use<'a, T> {
        values.chunks(values.len() / self.replicates)
    }
}

/// Which pixels and rows to take of a detector for about so many of them. Of a thin one there is but one column or row.
fn stride([width, height]: [usize; 2], pixels: f64) -> usize {
    let (narrow, wide) = (width.min(height) as f64, width.max(height) as f64);
    let both = (narrow * wide / pixels.max(1.0)).sqrt().ceil().max(1.0);
    if both <= narrow { both as usize } else { (wide / pixels.max(1.0)).ceil() as usize }
}

impl PixelGrid {
    fn request(&self, shift: [f64; 2], coarse: [usize; 2]) -> ViewRequest {
        ViewRequest { stride: self.stride, ..self.view(shift, coarse).into() }
    }

    /// With `coarse` = width × height pixels.
    fn view(&self, shift: [f64; 2], coarse: [usize; 2]) -> View {
        let first = [0, 1].map(|axis| self.first[axis] as f64 + shift[axis]);
        let stride = self.stride as f64;
        match &self.view {
            View::Pose(pose) => View::Pose(DetectorPose {
                first_pixel: pose.pixel(first[0], first[1]),
                column_step: stride * pose.column_step,
                row_step: stride * pose.row_step,
                ..*pose
            }),
            View::Projection(projection) => {
                // Pixel i of n is at (2i + 1)/n − 1 in clip space; y runs the other way.
                let [x, y] = [0, 1].map(|axis| {
                    let (n, m) = (self.size[axis] as f64, coarse[axis] as f64);
                    (stride * m / n, (stride * (m - 1.0) + 2.0 * first[axis] + 1.0) / n - 1.0)
                });
                let mut rows = [0, 1, 2, 3].map(|row| projection.matrix.row(row));
                rows[0] = (rows[0] - x.1 * rows[3]) / x.0;
                rows[1] = (rows[1] + y.1 * rows[3]) / y.0;
                let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
                View::Projection(Projection { matrix, ..*projection })
            }
        }
    }
}

/// Split-mix (Steele, Lea and Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    /// The numbers below `n`, shuffled.
    fn order(&mut self, n: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        for k in (1..n).rev() {
            order.swap(k, (self.unit() * (k + 1) as f64) as usize);
        }
        order
    }

    /// From 0 on, below 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Grid;
    use crate::raycast::Beam;

    const SIZE: [usize; 2] = [97, 61];

    fn pose() -> DetectorPose {
        DetectorPose::c_arm(DVec3::ZERO, 20.0, 1000.0, 1500.0, 3.0, SIZE)
    }

    #[test]
    fn every_ray_is_that_of_a_pixel() {
        let grid = Grid::centred([50, 60, 70], DVec3::splat(2.0)).expect("valid");
        let pose = pose();
        let matrix = View::Projection(Projection::from_pose(&pose, SIZE).expect("valid"));
        for view in [View::Pose(pose), matrix] {
            let sample = Sample::new(&[view], SIZE, 400, 7);
            let whole = Beam::new(&view, &grid, SIZE).expect("valid");
            let pixels: Vec<_> =
                (0..SIZE[1]).flat_map(|j| (0..SIZE[0]).map(move |i| (i as f64, j as f64))).collect();
            let mut seen = std::collections::HashSet::new();
            for view in &sample.views([0.0; 2]) {
                let beam = Beam::new(&view.view, &grid, sample.size()).expect("valid");
                for (i, j) in [(0, 0), (sample.size()[0] - 1, sample.size()[1] - 1), (2, 1)] {
                    let ray = beam.ray(i as f64, j as f64);
                    let near = |other: f64, own: f64| (other - own).abs() < 1e-6;
                    let pixel = pixels.iter().position(|&(i, j)| {
                        let other = whole.ray(i, j);
                        (0..2).all(|t| near(other.base[t], ray.base[t]) && near(other.slope[t], ray.slope[t]))
                    });
                    seen.insert(pixel.expect("one of the detector's pixels"));
                }
            }
            assert!(seen.len() > 20, "replicates start at different pixels: {}", seen.len());
        }
    }

    #[test]
    fn few_pixels_are_all_taken() {
        let sample = Sample::new(&[View::Pose(pose())], SIZE, 97 * 61, 0);
        assert_eq!((sample.replicates(), sample.size()), (1, SIZE));
    }

    #[test]
    fn a_thin_detector_gives_no_more_rays_than_asked_for() {
        for size in [[1, 30_000], [30_000, 1], [3, 20_000]] {
            let rays = Sample::new(&[View::Pose(pose()); 16], size, 3000, 5).rays();
            assert!((500..=9000).contains(&rays), "{size:?}: {rays}");
        }
    }

    #[test]
    fn of_many_views_all_get_their_turn() {
        let views =
            (0..120).map(|n| View::Pose(DetectorPose { source: DVec3::splat(f64::from(n)), ..pose() }));
        let sample = Sample::new(&views.collect::<Vec<_>>(), SIZE, 4000, 3);
        let seen: std::collections::HashSet<_> =
            sample.grids.iter().map(|grid| format!("{:?}", grid.view)).collect();
        assert_eq!(seen.len(), 120);
        assert!(sample.replicates() > 1);
    }

    #[test]
    fn about_as_many_rays_as_asked_for() {
        for (views, rays) in [(1, 1000), (2, 1000), (40, 3000), (100, 2000)] {
            let sample = Sample::new(&vec![View::Pose(pose()); views], SIZE, rays, 3);
            assert!((rays / 3..=3 * rays).contains(&sample.rays()), "{views} views: {}", sample.rays());
            assert_eq!(sample.split(&vec![0; sample.rays()]).count(), sample.replicates());
        }
    }
}
