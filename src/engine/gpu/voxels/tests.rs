use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::engine::gpu::Prepared;
use crate::engine::gpu::wire::Launch;
use crate::engine::{Backend, Layers};
use crate::geometry::Grid;
use crate::physics::{Calibration, MassAttenuation, Thresholds};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Classification;

/// A few roundings to float32.
const ROUNDINGS: f64 = 3.0 * 0.5 * f32::EPSILON as f64;

fn classification(calibration: &str, thresholds: &str) -> Classification {
    Classification::named(calibration, thresholds).expect("built in")
}

/// Every HU from far below padding to far above the ceiling, in a row.
fn every_hu(how: &Classification, labels: impl Fn(usize) -> Option<u8>) -> Volume {
    let hu: Vec<i16> = (-3000..4500).collect();
    let labels: Option<Vec<u8>> = (0..hu.len()).map(labels).collect();
    let grid = Grid::centred([hu.len(), 1, 1], DVec3::ONE).expect("valid");
    Volume::from_int16(grid, &hu, labels.as_deref(), how).expect("valid")
}

/// What a kernel is told about the volume.
fn launch(volume: &Volume, voxels: &DeviceVoxels, materials: &[&str]) -> Launch {
    let scene = Scene::new([1, 1]).expect("valid");
    let materials = MassAttenuation::named(materials, *scene.spectrum.grid()).expect("tabulated");
    let scene = Scene { materials, bone: None, ..scene };
    let plan = Plan::new(&scene, volume, Backend::Metal, None).expect("valid");
    let prepared = Prepared::new(volume, voxels, &scene, &plan).expect("memory");
    prepared.views(&[], Layers::ALL).launch
}

/// The density of a code, as `drr_density` in `shaders/voxels.h` makes it.
fn density(launch: &Launch, voxels: &DeviceVoxels, code: u16) -> f32 {
    let value = f32::from(code & !7);
    match voxels.density().expect("codes") {
        Density::Line { .. } => launch.scale * value,
        Density::Kink { .. } => launch.scale * value.min(launch.kink[1].mul_add(value, launch.kink[0])),
        Density::Table(table) => table[usize::from(code >> 3)],
    }
}

/// The density of a code by its stand-in, as `drr_standing_in` and the end of a run make it.
fn by_stand_in(launch: &Launch, code: u16) -> f32 {
    let how = launch.stand_in[usize::from(code & 7)];
    let t = f32::from(code).mul_add(CODE_UNIT as f32, how.origin);
    how.scale.mul_add((-how.kink).mul_add(t.abs(), t), how.offset)
}

/// Holds the code of every voxel to its density and label.
fn decodes(name: &str, volume: &Volume, materials: &[&str]) {
    let voxels = DeviceVoxels::new(volume).expect("not many");
    let launch = launch(volume, &voxels, materials);
    let Voxels::Coded { codes, .. } = volume.voxels() else { unreachable!("int16") };
    for (i, &code) in codes.iter().enumerate() {
        let exact = volume.voxels().get(i);
        let device = voxels.codes()[usize::from(code)];
        assert_eq!(device & 7, u16::from(exact.label), "{name}, voxel {i}");
        let error = (f64::from(density(&launch, &voxels, device)) - exact.density).abs();
        assert!(error <= ROUNDINGS * exact.density, "{name}, voxel {i}: {error:e} of {}", exact.density);
        if !matches!(voxels.density(), Some(Density::Table(_))) {
            let largest = volume.materials()[usize::from(exact.label)].max_density;
            let error = (f64::from(by_stand_in(&launch, device)) - exact.density).abs();
            // In a run with denser voxels, what matters is their rounding.
            let bound = if device < 8 { 2.0 * ROUNDINGS * largest } else { ROUNDINGS * largest };
            assert!(error <= bound, "{name}, voxel {i}: the stand-in is off by {error:e} of {largest}");
        }
    }
}

#[test]
fn codes_decode_to_the_volumes_densities_and_labels() {
    for calibration in Calibration::names() {
        for thresholds in Thresholds::names() {
            let how = classification(calibration, thresholds);
            let names: Vec<&str> = how.thresholds.materials().iter().map(String::as_str).collect();
            decodes(&format!("{calibration}, {thresholds}"), &every_hu(&how, |_| None), &names);
        }
        let eight = ["air", "lung", "soft_tissue", "bone_cortical", "adipose", "muscle", "blood", "titanium"];
        let how = classification(calibration, Thresholds::DEFAULT);
        decodes(calibration, &every_hu(&how, |i| Some((i * 5 % 8) as u8)), &eight);
    }
}

#[test]
fn every_hu_of_a_texture_has_the_code_of_its_density_and_label() {
    for calibration in Calibration::names() {
        let how = classification(calibration, Thresholds::DEFAULT);
        let names: Vec<&str> = how.thresholds.materials().iter().map(String::as_str).collect();
        let grid = Grid::centred([2, 3, 4], DVec3::ONE).expect("valid");
        let volume = Volume::from_texture(grid, Arc::new(()), &how).expect("memory");
        let voxels = DeviceVoxels::new(&volume).expect("not many");
        assert_eq!(voxels.layout(), Layout::Texture);
        let (launch, codes) = (launch(&volume, &voxels, &names), voxels.codes_of_hu());
        for hu in i16::MIN..=i16::MAX {
            let (code, exact) = (codes[usize::from(hu.cast_unsigned())], how.voxel(hu.into(), None));
            assert_eq!(code & 7, u16::from(exact.label), "{calibration}, {hu} HU");
            let error = (f64::from(density(&launch, &voxels, code)) - exact.density).abs();
            assert!(error <= ROUNDINGS * exact.density, "{calibration}, {hu} HU: off by {error:e}");
        }
    }
}

/// Lines start from vacuum; `bilinear_1p03` does not.
#[test]
fn a_table_is_read_only_where_lines_do_not_do() {
    for (calibration, expected) in [
        ("linear", "line"),
        ("water_anchored", "kink"),
        ("bilinear_1p03", "table"),
        ("schneider2000", "table"),
    ] {
        let volume = every_hu(&classification(calibration, Thresholds::DEFAULT), |_| None);
        let voxels = DeviceVoxels::new(&volume).expect("not many");
        let kind = match voxels.density() {
            Some(Density::Line { .. }) => "line",
            Some(Density::Kink { .. }) => "kink",
            Some(Density::Table(_)) => "table",
            None => "densities",
        };
        assert_eq!(kind, expected, "{calibration}");
        assert_eq!(voxels.density_of_value().is_empty(), expected != "table", "{calibration}");
    }
}

/// Holds every voxel of the framed volume to the nearest of the volume.
fn is_framed(volume: &Volume) {
    let voxels = DeviceVoxels::new(volume).expect("not many");
    let [n0, n1, n2] = volume.grid().dimensions();
    let framed = voxels.framed();
    assert_eq!(framed, [n0 + 2, n1 + 2, n2 + 2]);
    let mut next = 0;
    let nearest = |place: usize| {
        let at = [place % framed[0], place / framed[0] % framed[1], place / (framed[0] * framed[1])];
        let [i, j, k] = [0, 1, 2].map(|axis| at[axis].clamp(1, [n0, n1, n2][axis]) - 1);
        (k * n1 + j) * n0 + i
    };
    let taken = voxels.slabs(volume, |first, slab| {
        assert_eq!(first, next, "slabs follow each other");
        match (slab, volume.voxels()) {
            (Slab::Coded(slab), Voxels::Coded { codes, .. }) => {
                next += slab.len();
                let expected = |place| voxels.codes()[usize::from(codes[nearest(place)])];
                assert!(slab.iter().enumerate().all(|(i, &code)| code == expected(first + i)));
            }
            (Slab::Dense(densities, labels), Voxels::Dense { density, label }) => {
                next += densities.len();
                let expected = |place| (density[nearest(place)], label[nearest(place)]);
                let mut both = densities.iter().zip(labels).enumerate();
                assert!(both.all(|(i, (&density, &label))| (density, label) == expected(first + i)));
            }
            _ => panic!("stored in another way than the volume"),
        }
        Ok(())
    });
    taken.expect("memory");
    assert_eq!(next, framed.iter().product::<usize>());
}

#[test]
fn the_frame_repeats_the_edge() {
    let how = classification(Calibration::DEFAULT, Thresholds::DEFAULT);
    // The last one in several slabs.
    for dimensions in [[5, 4, 3], [1, 1, 1], [1, 7, 2], [2500, 1500, 6]] {
        let grid = Grid::centred(dimensions, DVec3::ONE).expect("valid");
        let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| (i * 7919 % 4000) as i16 - 1000).collect();
        is_framed(&Volume::from_int16(grid, &hu, None, &how).expect("valid"));
        let hu: Vec<f32> = hu.into_iter().map(|hu| f32::from(hu) + 0.5).collect();
        is_framed(&Volume::from_float32(grid, &hu, None, &how).expect("valid"));
    }
}

#[test]
fn one_label_is_seen() {
    let how = classification(Calibration::DEFAULT, Thresholds::DEFAULT);
    let one_label = |labels: &dyn Fn(usize) -> Option<u8>| {
        DeviceVoxels::new(&every_hu(&how, labels)).expect("not many").one_label
    };
    assert!(one_label(&|_| Some(5)));
    assert!(!one_label(&|i| Some(u8::from(i == 0))));
    assert!(!one_label(&|_| None));
}
