//! What `align` and `reconstruct` project: a CT or a phantom, as attenuation at one energy.

use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use drr::geometry::Grid;
use drr::phantom::Phantom;
use drr::physics::{Calibration, EnergyGrid, MassAttenuation, Thresholds};
use drr::volume::{Classification, Volume, VolumeBuilder};
use glam::{DAffine3, DMat3, DVec3};

use crate::console::Console;
use crate::ct::CtArguments;
use crate::value;

/// Most voxels a side of a phantom's means.
const MOST_OF_PHANTOM: usize = 1024;

/// Which object, in which X-rays.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Volume")]
pub(crate) struct ObjectArguments {
    #[command(flatten)]
    ct: CtArguments,
    /// A phantom in place of a CT
    #[arg(long, value_name = "NAME", conflicts_with = "ct", value_parser = PossibleValuesParser::new(Phantom::names()))]
    phantom: Option<String>,
    /// The X-rays' energy, keV
    #[arg(long, value_name = "KEV", value_parser = value::positive, default_value = "60")]
    #[arg(allow_negative_numbers = true)]
    pub(crate) kev: f64,
}

/// An object with known voxels.
pub(crate) struct Object {
    pub(crate) volume: Arc<Volume>,
    /// Those of the voxels' labels, at the X-rays' energy.
    pub(crate) materials: MassAttenuation,
}

/// Linear attenuation coefficients at one energy.
#[derive(Debug, Clone)]
pub(crate) struct Attenuation {
    pub(crate) grid: Grid,
    /// 1/mm.
    pub(crate) values: Vec<f32>,
}

impl ObjectArguments {
    /// What is projected, in words.
    pub(crate) fn name(&self) -> String {
        self.phantom.as_ref().map_or_else(|| self.ct.name(), |name| format!("phantom {name}"))
    }

    /// The CT with all of its voxels, or a phantom with `finely` ones a side to each of `voxels` means along its
    /// longest.
    pub(crate) fn load(&self, voxels: usize, finely: usize, console: Console) -> Result<Object> {
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT)?;
        let names: Vec<_> = how.thresholds.materials().iter().map(String::as_str).collect();
        let energy = EnergyGrid::single(self.kev).context("--kev")?;
        let materials = MassAttenuation::named(&names, energy).context("--kev")?;
        let volume = match &self.phantom {
            Some(name) => {
                let phantom = Phantom::named(name).context("--phantom")?;
                voxelised(&phantom, voxels, finely, &how, console)?
            }
            None => self.ct.load(&how, console)?.volume,
        };
        Ok(Object { volume: Arc::new(volume), materials })
    }

    /// Linear attenuation coefficient of water, 1/mm.
    pub(crate) fn water(&self) -> Result<f64> {
        water(self.kev).context("--kev")
    }
}

/// That of 1 g/cm³.
fn water(kev: f64) -> drr::Result<f64> {
    // 1/cm to 1/mm.
    Ok(0.1 * MassAttenuation::named(&["water"], EnergyGrid::single(kev)?)?.coefficients(0)[0])
}

fn voxelised(
    phantom: &Phantom,
    voxels: usize,
    finely: usize,
    how: &Classification,
    console: Console,
) -> Result<Volume> {
    if voxels > MOST_OF_PHANTOM {
        bail!("--voxels is {voxels}; valid with --phantom: up to {MOST_OF_PHANTOM}");
    }
    let size = phantom.extent() / phantom.extent().max_element();
    let along = |part: f64| finely * ((voxels as f64 * part).round() as usize).max(1);
    let grid = phantom.grid(size.to_array().map(along)).context("--voxels")?;
    let mut builder = VolumeBuilder::int16(grid, how, true)?;
    let bar = console.bar("voxelising", grid.dimensions()[2]);
    phantom.voxelise(&grid, |_, hu, labels| {
        bar.inc(1);
        builder.push_int16(hu, Some(labels))
    })?;
    bar.finish_and_clear();
    Ok(builder.finish()?)
}

impl Object {
    /// Means over blocks of voxels; see [`Attenuation::means`].
    pub(crate) fn means(&self, most: usize, margin: usize) -> Result<Attenuation> {
        Attenuation::means(&self.volume, &self.materials, most, margin).context("--ct")
    }
}

impl Attenuation {
    /// Means over blocks of voxels, so many per axis that no side has more than `most`; voxels beyond an axis' last whole
    /// block are left out, and `margin` more blocks on all sides are vacuum.
    fn means(volume: &Volume, materials: &MassAttenuation, most: usize, margin: usize) -> Result<Self> {
        let fine = volume.grid();
        let blocks = fine.dimensions().map(|n| n.div_ceil(most));
        let grid = coarse(fine, blocks, margin)?;
        let ([n0, n1, n2], [m0, m1, _]) = (fine.dimensions(), grid.dimensions());
        // g/cm³ · cm²/g is 1/cm.
        let per_gram: Vec<f64> =
            (0..materials.names().len()).map(|m| 0.1 * materials.coefficients(m)[0]).collect();
        let mut sums = vec![0.0_f64; grid.voxel_count()];
        let whole = |n: usize, axis: usize| n - n % blocks[axis];
        for k in 0..whole(n2, 2) {
            for j in 0..whole(n1, 1) {
                for i in 0..whole(n0, 0) {
                    let voxel = volume.voxels().get((k * n1 + j) * n0 + i);
                    let [x, y, z] = [i / blocks[0], j / blocks[1], k / blocks[2]].map(|n| n + margin);
                    let block = (z * m1 + y) * m0 + x;
                    sums[block] += per_gram[usize::from(voxel.label)] * voxel.density;
                }
            }
        }
        let part = 1.0 / blocks.iter().product::<usize>() as f64;
        Ok(Self { grid, values: sums.into_iter().map(|sum| (part * sum) as f32).collect() })
    }
}

/// The grid of whole blocks of voxels, with so many more on all sides.
fn coarse(fine: &Grid, blocks: [usize; 3], margin: usize) -> drr::Result<Grid> {
    let scale = DVec3::from_array(blocks.map(|n| n as f64));
    let DAffine3 { matrix3, .. } = fine.index_to_world();
    let translation = fine.index_to_world().transform_point3(0.5 * (scale - 1.0) - margin as f64 * scale);
    let dimensions = std::array::from_fn(|axis| fine.dimensions()[axis] / blocks[axis] + 2 * margin);
    Grid::new(dimensions, DAffine3 { matrix3: matrix3 * DMat3::from_diagonal(scale), translation })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_keep_mass_and_place() {
        let grid =
            Grid::axis_aligned([5, 4, 3], DVec3::new(1.0, 2.0, 3.0), DVec3::new(7.0, -3.0, 2.0)).unwrap();
        let hu: Vec<i16> = (0..60).map(|n| 10 * n - 300).collect();
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).unwrap();
        let volume = Volume::from_int16(grid, &hu, None, &how).unwrap();
        let names: Vec<_> = how.thresholds.materials().iter().map(String::as_str).collect();
        let materials = MassAttenuation::named(&names, EnergyGrid::single(60.0).unwrap()).unwrap();
        let mass = |a: &Attenuation| {
            let m = a.grid.index_to_world().matrix3;
            a.values.iter().map(|&v| f64::from(v)).sum::<f64>() * m.determinant()
        };
        let fine = Attenuation::means(&volume, &materials, 5, 0).unwrap();
        assert_eq!(fine.grid, grid);
        // The fifth column is in no whole block.
        let mut seen = fine.clone();
        seen.values.iter_mut().skip(4).step_by(5).for_each(|value| *value = 0.0);
        let means = Attenuation::means(&volume, &materials, 3, 0).unwrap();
        assert_eq!(means.grid.dimensions(), [2, 2, 3]);
        assert!((mass(&means) / mass(&seen) - 1.0).abs() < 1e-6);
        let wider = Attenuation::means(&volume, &materials, 3, 2).unwrap();
        assert_eq!(wider.grid.dimensions(), [6, 6, 7]);
        assert!((mass(&wider) / mass(&seen) - 1.0).abs() < 1e-6);
        assert_eq!(wider.values[(2 * 6 + 2) * 6 + 2], means.values[0]);
        // The first block's centre lies between the voxels 0 and 1 along x and y.
        assert_eq!(means.grid.index_to_world().translation, DVec3::new(7.5, -2.0, 2.0));
    }

    #[test]
    fn water_is_where_the_tables_have_it() {
        // NIST: 0.2059 cm²/g at 60 keV.
        assert!((water(60.0).unwrap() - 0.02059).abs() < 2e-5);
    }
}
