//! A volume's voxels as the kernel reads them: `shaders/voxels.h`.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::allocation::filled;
use crate::engine::gpu::wire::StandIn;
use crate::error::{Error, Result};
use crate::physics::MAX_MATERIALS;
use crate::volume::{Matter, Volume, Voxel, Voxels, bricks};

/// Voxels around the volume that repeat its outermost ones, so that interpolation needs no limits.
pub(super) const FRAME: usize = 1;

/// Values of a code: 8 × value + label fits 15 bits.
const VALUES: usize = 1 << 12;

/// What one code counts in a stand-in.
const CODE_UNIT: f64 = 1.0 / (1 << 23) as f64;

/// Where the voxels are: `DRR_VOXELS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// 16-bit codes in a buffer.
    Coded = 0,
    /// Densities and labels in buffers.
    Dense = 1,
    /// HU in the caller's texture.
    Texture = 2,
}

/// How a code's value becomes a density in g/cm³.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Density {
    /// slope × value.
    Line { slope: f64 },
    /// The lower of slope × value and `intercept + upper_slope` × value.
    Kink { slope: f64, intercept: f64, upper_slope: f64 },
    /// By value.
    Table(Vec<f32>),
}

/// How the voxels of one volume are given to a kernel.
#[derive(Debug)]
pub(crate) struct DeviceVoxels {
    dimensions: [usize; 3],
    stored: Stored,
    layout: Layout,
    /// Whether all voxels have the same label.
    pub one_label: bool,
}

#[derive(Debug)]
enum Stored {
    Coded { density: Density, code: Vec<u16>, range: [Option<[u16; 2]>; MAX_MATERIALS] },
    Dense,
}

impl DeviceVoxels {
    /// Decides how `volume` is stored.
    ///
    /// # Errors
    /// `Unsupported` when the kernel cannot number so many voxels; `OutOfMemory`.
    pub(crate) fn new(volume: &Volume) -> Result<Self> {
        let dimensions = volume.grid().dimensions();
        if dimensions.iter().map(|n| n + 2 * FRAME).product::<usize>() > u32::MAX as usize {
            let text = format!("{dimensions:?} voxels are too many for GPU engines, which count to 2^32");
            return Err(Error::Unsupported(text));
        }
        let stored = match volume.voxels() {
            Voxels::Coded { table, .. } | Voxels::Texture { table, .. } => {
                let values = Values::of(volume, table);
                Stored::Coded {
                    density: values.density(),
                    code: values.codes(table)?,
                    range: values.ranges(table),
                }
            }
            Voxels::Dense { .. } => Stored::Dense,
        };
        let layout = match volume.voxels() {
            Voxels::Coded { .. } => Layout::Coded,
            Voxels::Dense { .. } => Layout::Dense,
            Voxels::Texture { .. } => Layout::Texture,
        };
        let one_label = volume.materials().iter().filter(|material| material.labelled).count() == 1;
        Ok(Self { dimensions, stored, layout, one_label })
    }

    /// How codes become densities; `None` when densities are stored.
    pub(crate) fn density(&self) -> Option<&Density> {
        match &self.stored {
            Stored::Coded { density, .. } => Some(density),
            Stored::Dense => None,
        }
    }

    /// Where they are to be.
    pub(crate) fn layout(&self) -> Layout {
        self.layout
    }

    /// The table of densities; empty when the kernel needs none.
    pub(crate) fn density_of_value(&self) -> &[f32] {
        match self.density() {
            Some(Density::Table(table)) => table,
            _ => &[],
        }
    }

    /// The device's code of each of the volume's; none when densities are stored.
    fn codes(&self) -> &[u16] {
        match &self.stored {
            Stored::Coded { code, .. } => code,
            Stored::Dense => &[],
        }
    }

    /// The device's code of each HU of a texture, by the HU's bits. The volume's codes are HU in ascending order.
    #[cfg_attr(
        not(any(test, target_vendor = "apple")),
        expect(dead_code, reason = "textures of the caller's are Metal's")
    )]
    pub(crate) fn codes_of_hu(&self) -> Vec<u16> {
        let (negative, others) = self.codes().split_at(self.codes().len() / 2);
        [others, negative].concat()
    }

    /// How codes of one label stand in for densities. Below the kink the stand-in counts from vacuum and above it from
    /// where its line would meet vacuum, so that little is lost where densities are low; across the kink it counts from
    /// there.
    pub(crate) fn stand_in(&self, label: u8) -> StandIn {
        let Stored::Coded { density, range, .. } = &self.stored else { return StandIn::default() };
        let Some([least, largest]) = range[usize::from(label)].map(|range| range.map(f64::from)) else {
            return StandIn::default();
        };
        let made = |origin: f64, kink: f64, slope: f64, offset: f64| StandIn {
            origin: (-(8.0 * origin + f64::from(label)) * CODE_UNIT) as f32,
            kink: kink as f32,
            scale: (slope / (8.0 * CODE_UNIT)) as f32,
            offset: offset as f32,
        };
        match *density {
            Density::Line { slope } => made(0.0, 0.0, slope, 0.0),
            Density::Kink { slope, intercept, upper_slope } => {
                let kink = intercept / (slope - upper_slope);
                if largest <= kink {
                    made(0.0, 0.0, slope, 0.0)
                } else if least >= kink && intercept.abs() > VALUES as f64 * upper_slope.abs() {
                    // All but level: its line meets vacuum nowhere near.
                    made(0.0, 0.0, upper_slope, intercept)
                } else if least >= kink {
                    made(-intercept / upper_slope, 0.0, upper_slope, 0.0)
                } else {
                    let [sum, difference] = [slope + upper_slope, slope - upper_slope];
                    made(kink, difference / sum, 0.5 * sum, slope * kink)
                }
            }
            Density::Table(_) => StandIn::default(),
        }
    }

    /// Where `volume` holds anything but vacuum, by brick; see [`Occupied::dilated`](crate::volume::Occupied). Nothing is said
    /// of a texture.
    pub(crate) fn occupancy(&self, volume: &Volume) -> Result<Vec<u8>> {
        match self.layout {
            Layout::Coded | Layout::Dense => volume.occupancy()?.of(Matter::ANY)?.dilated(),
            Layout::Texture => Ok(Vec::new()),
        }
    }

    /// Bricks along each axis.
    pub(crate) fn bricks(&self) -> [usize; 3] {
        bricks(self.dimensions)
    }

    /// Voxels along each axis, frame included.
    pub(crate) fn framed(&self) -> [usize; 3] {
        self.dimensions.map(|n| n + 2 * FRAME)
    }

    /// Calls `take` with slices of the framed volume, several at a time: codes, or densities and labels. What is in a
    /// texture stays there.
    pub(crate) fn slabs(
        &self,
        volume: &Volume,
        mut take: impl FnMut(usize, Slab<'_>) -> Result<()>,
    ) -> Result<()> {
        /// Bytes made at a time, about.
        const SLAB: usize = 64 << 20;
        let [width, height, depth] = self.framed();
        let slice = width * height;
        let at_once = (SLAB / (4 * slice)).clamp(1, depth);
        match (volume.voxels(), &self.stored) {
            (Voxels::Coded { codes, .. }, Stored::Coded { code, .. }) => {
                let mut slab = filled(at_once * slice, 0, "voxels on their way to the device")?;
                for first in (0..depth).step_by(at_once) {
                    let slab = &mut slab[..at_once.min(depth - first) * slice];
                    self.frame(slab, first, |index| code[usize::from(codes[index])]);
                    take(first * slice, Slab::Coded(slab))?;
                }
            }
            (Voxels::Dense { density, label }, _) => {
                let mut densities = filled(at_once * slice, 0.0, "densities on their way to the device")?;
                let mut labels = filled(at_once * slice, 0, "labels on their way to the device")?;
                for first in (0..depth).step_by(at_once) {
                    let count = at_once.min(depth - first) * slice;
                    self.frame(&mut densities[..count], first, |index| density[index]);
                    self.frame(&mut labels[..count], first, |index| label[index]);
                    take(first * slice, Slab::Dense(&densities[..count], &labels[..count]))?;
                }
            }
            (Voxels::Texture { .. }, _) => {}
            (Voxels::Coded { .. }, Stored::Dense) => unreachable!("made for this volume"),
        }
        Ok(())
    }

    /// Fills slices of the framed volume, from slice `first` on.
    fn frame<T: Copy + Send>(&self, slab: &mut [T], first: usize, voxel: impl Fn(usize) -> T + Sync) {
        let [n0, n1, n2] = self.dimensions;
        let [width, height, _] = self.framed();
        let inside = |framed: usize, n: usize| framed.saturating_sub(FRAME).min(n - 1);
        slab.par_chunks_mut(width).enumerate().for_each(|(line, values)| {
            let (j, k) = (inside(line % height, n1), inside(first + line / height, n2));
            let start = (k * n1 + j) * n0;
            for (i, value) in values.iter_mut().enumerate() {
                *value = voxel(start + inside(i, n0));
            }
        });
    }
}

/// Some slices of a framed volume.
pub(crate) enum Slab<'a> {
    /// Codes.
    Coded(&'a [u16]),
    /// Densities in g/cm³, and labels.
    Dense(&'a [f32], &'a [u8]),
}

/// Value and density of every code that occurs.
struct Values {
    value: Vec<Option<u16>>,
    density: Vec<Option<f64>>,
}

impl Values {
    /// The value is the CT number from −1000 on; 0 is vacuum, so where −1000 HU has a density it starts at 1.
    fn of(volume: &Volume, table: &[Voxel]) -> Self {
        let occurring = |voxel: &Voxel| volume.materials()[usize::from(voxel.label)].labelled;
        let hu = |code: usize| volume.hu_of(code as u16).clamp(-1000, 3071);
        let first = table.iter().enumerate().any(|(code, voxel)| hu(code) == -1000 && voxel.density > 0.0);
        let mut values = Self { value: vec![None; table.len()], density: vec![None; VALUES] };
        for (code, voxel) in table.iter().enumerate().filter(|(_, voxel)| occurring(voxel)) {
            let value = if voxel.density > 0.0 { hu(code) + 1000 + i32::from(first) } else { 0 };
            values.value[code] = Some(value as u16);
            values.density[value as usize] = Some(voxel.density);
        }
        values
    }

    /// The device's codes.
    fn codes(&self, table: &[Voxel]) -> Result<Vec<u16>> {
        let mut codes = filled(table.len(), 0, "the table of codes")?;
        for ((code, value), voxel) in codes.iter_mut().zip(&self.value).zip(table) {
            *code = 8 * value.unwrap_or(0) + u16::from(voxel.label);
        }
        Ok(codes)
    }

    /// Least and largest value by label, of the labels that occur.
    fn ranges(&self, table: &[Voxel]) -> [Option<[u16; 2]>; MAX_MATERIALS] {
        let mut ranges = [None; MAX_MATERIALS];
        for (voxel, value) in table.iter().zip(&self.value) {
            let Some(value) = *value else { continue };
            let [least, largest] = ranges[usize::from(voxel.label)].unwrap_or([value, value]);
            ranges[usize::from(voxel.label)] = Some([value.min(least), value.max(largest)]);
        }
        ranges
    }

    /// One line or two when they say the same as the table, which costs a read per voxel.
    fn density(&self) -> Density {
        /// What float64 makes of a calibration's line.
        const ROUNDING: f64 = 1e-10;
        let points =
            self.density.iter().enumerate().filter_map(|(value, &density)| Some((value as f64, density?)));
        let points: Vec<(f64, f64)> = points.filter(|&(value, _)| value > 0.0).collect();
        let [(first, lowest), .., (before, lower), (last, highest)] = points[..] else {
            let slope = points.last().map_or(0.0, |(value, density)| density / value);
            return Self::checked(Density::Line { slope }, &points, |value| slope * value, ROUNDING)
                .unwrap_or_else(|| self.table());
        };
        let slope = lowest / first;
        let upper_slope = (highest - lower) / (last - before);
        let intercept = highest - upper_slope * last;
        let line = |value: f64| slope * value;
        let kink = |value: f64| (slope * value).min(intercept + upper_slope * value);
        Self::checked(Density::Line { slope }, &points, line, ROUNDING)
            .or_else(|| {
                // Stand-ins across the kink are by the mean of the slopes, which must not vanish.
                let density = Density::Kink { slope, intercept, upper_slope };
                if upper_slope < -0.5 * slope {
                    None
                } else {
                    Self::checked(density, &points, kink, ROUNDING)
                }
            })
            .unwrap_or_else(|| self.table())
    }

    fn checked(
        density: Density,
        points: &[(f64, f64)],
        of: impl Fn(f64) -> f64,
        rounding: f64,
    ) -> Option<Density> {
        points.iter().all(|&(value, exact)| (of(value) - exact).abs() <= rounding * exact).then_some(density)
    }

    fn table(&self) -> Density {
        Density::Table(self.density.iter().map(|density| density.unwrap_or(0.0) as f32).collect())
    }
}
