//! The rays of a view whose detector columns each stay in one plane of the volume.

use glam::DVec3;

use super::axes::Axes;
use super::spans::RowSpans;
use crate::engine::cpu::level::LANES;
use crate::geometry::Grid;
use crate::raycast::ray::TRANSVERSE;
use crate::raycast::{Beam, Ray};

/// How far a column's rays may be off their plane, voxels: a hundredth of what a float32 matrix is off by.
const FLAT: f64 = 1e-5;
/// Slopes along a column below which a ray is clipped on its own: it may lie in a face.
const LEVEL: f64 = 1e-7;

/// A coordinate along a ray: `base + slope·(s − centre)`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Straight {
    base: f64,
    slope: f64,
}

impl Straight {
    #[inline(always)]
    pub(super) fn at(self, from_centre: f64) -> f64 {
        self.base + self.slope * from_centre
    }

    fn of(ray: &Ray, axis: usize) -> Self {
        let t = usize::from(TRANSVERSE[ray.axis][1] == axis);
        Self { base: ray.base[t], slope: ray.slope[t] }
    }

    /// Largest distance from another, within some reach of the centre.
    fn distance(self, other: Self, reach: f64) -> f64 {
        (self.base - other.base).abs() + reach * (self.slope - other.slope).abs()
    }

    fn minus(self, other: Self) -> Self {
        Self { base: self.base - other.base, slope: self.slope - other.slope }
    }

    fn over(self, steps: f64) -> Self {
        Self { base: self.base / steps, slope: self.slope / steps }
    }
}

/// A column's rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// Across the columns, the same in every row.
    pub across: Straight,
    /// Along the column, of row 0, and from one row to the next.
    along: Straight,
    pub per_row: Straight,
    /// The part of s between source, detector and the faces but those along, from the centre.
    limits: [f64; 2],
    /// Way per slice, mm, of row 0 and from one row to the next.
    way: [DVec3; 2],
}

impl Column {
    /// Whether a ray of the column's is in its row where the first and the last one say. It is not where the detector leans, so that
    /// rows are at different distances.
    fn describes(&self, ray: &Ray, along: usize, row: f64, reach: f64) -> bool {
        let step = Straight { base: row * self.per_row.base, slope: row * self.per_row.slope };
        let expected = Straight { base: self.along.base + step.base, slope: self.along.slope + step.slope };
        Straight::of(ray, along).distance(expected, reach) <= FLAT
    }

    /// Where a row's ray is along the column.
    #[inline(always)]
    pub(super) fn along(&self, row: f64, from_centre: f64) -> f64 {
        self.along.at(from_centre) + row * self.per_row.at(from_centre)
    }
}

/// All columns of a view; the last one is repeated up to a whole block.
pub(super) struct Columns {
    beam: Beam,
    /// Of the detector.
    pub width: usize,
    pub axes: Axes,
    /// Of the volume along the driving axis.
    pub centre: f64,
    pub all: Vec<Column>,
    /// First and last face along the columns.
    faces: [f64; 2],
    dimensions: [usize; 3],
}

impl Columns {
    /// `None` unless all rays have one driving axis and each column a plane.
    pub(super) fn of(beam: &Beam, grid: &Grid, [width, height]: [usize; 2]) -> Option<Self> {
        let dimensions = grid.dimensions();
        let last_row = (height - 1) as f64;
        let ends = |column: usize| [0.0, last_row].map(|row| beam.ray(column as f64, row));
        let first = ends(0);
        let driving = first[0].axis;
        let reach = 0.5 * dimensions[driving] as f64 + 1.0;
        let flat = |rays: &[Ray; 2], axis| {
            let [a, b] = rays.each_ref().map(|ray| Straight::of(ray, axis));
            let ends = [0, 1].map(|end| (rays[0].limits[end] - rays[1].limits[end]).abs());
            // Of ends at infinity the difference is no number.
            let level = !ends.into_iter().any(|apart| apart > FLAT);
            level && rays.iter().all(|ray| ray.axis == driving) && a.distance(b, reach) <= FLAT
        };
        let across = TRANSVERSE[driving].into_iter().find(|&axis| flat(&first, axis))?;
        let along = 3 - driving - across;
        let middle_row = (0.5 * last_row).floor();
        let column = |column: usize| {
            let at = column.min(width - 1);
            let rays = ends(at);
            let column =
                flat(&rays, across).then(|| Column::new(&rays, [across, along], grid, last_row.max(1.0)))?;
            column.describes(&beam.ray(at as f64, middle_row), along, middle_row, reach).then_some(column)
        };
        Some(Self {
            beam: *beam,
            width,
            axes: Axes { driving, across, along },
            centre: first[0].centre,
            all: (0..width.next_multiple_of(LANES)).map(column).collect::<Option<_>>()?,
            faces: [-0.5, dimensions[along] as f64 - 0.5],
            dimensions,
        })
    }

    /// A block of columns.
    #[inline(always)]
    pub(super) fn block(&self, block: usize) -> &[Column; LANES] {
        self.all[block * LANES..].first_chunk().expect("whole blocks")
    }

    /// The rays of a block in one row.
    #[inline(always)]
    pub(super) fn spans(&self, block: usize, row: usize) -> RowSpans {
        let columns = self.block(block);
        let row = row as f64;
        let (mut spans, mut level) = (RowSpans::default(), false);
        for (n, column) in columns.iter().enumerate() {
            let (base, slope) = (column.along(row, 0.0), column.along.slope + row * column.per_row.slope);
            level |= slope.abs() < LEVEL;
            let inverse = 1.0 / slope;
            let [a, b] = self.faces.map(|face| (face - base) * inverse);
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            let from = if low > column.limits[0] { low } else { column.limits[0] };
            let to = if high < column.limits[1] { high } else { column.limits[1] };
            spans.enter[n] = from as f32;
            spans.leave[n] = if to > from { to as f32 } else { from as f32 };
            spans.cm[n] = (0.1 * (column.way[0] + row * column.way[1]).length()) as f32;
        }
        if level {
            self.clip_level(block, row, &mut spans);
        }
        spans
    }

    #[cold]
    fn clip_level(&self, block: usize, row: f64, spans: &mut RowSpans) {
        for (n, column) in self.block(block).iter().enumerate() {
            if (column.along.slope + row * column.per_row.slope).abs() < LEVEL {
                let at = (block * LANES + n).min(self.width - 1) as f64;
                let span = self.beam.ray(at, row).clip(self.dimensions);
                let ends = span.map_or([self.centre; 2], |span| [span.enter, span.leave]);
                [spans.enter[n], spans.leave[n]] = ends.map(|s| (s - self.centre) as f32);
            }
        }
    }
}

impl Column {
    fn new(rays: &[Ray; 2], [across, along]: [usize; 2], grid: &Grid, steps: f64) -> Self {
        let ray = &rays[0];
        let [a, b] = rays.each_ref().map(|ray| Straight::of(ray, along));
        let way = |ray: &Ray| {
            let [from, to] = [0.0, 1.0].map(|s| DVec3::from_array(ray.point(ray.centre + s)));
            grid.index_to_world().transform_vector3(to - from)
        };
        let [first, last] = rays.each_ref().map(way);
        Self {
            across: Straight::of(ray, across),
            along: a,
            per_row: b.minus(a).over(steps),
            limits: ray
                .clip_but(grid.dimensions(), along)
                .map_or([0.0; 2], |span| [span.enter - ray.centre, span.leave - ray.centre]),
            way: [first, (last - first) / steps],
        }
    }
}
