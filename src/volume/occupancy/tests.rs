use glam::DVec3;

use super::*;
use crate::geometry::Grid;
use crate::physics::{Calibration, Thresholds};
use crate::volume::{Classification, Volume};

const DIMENSIONS: [usize; 3] = [37, 21, 18];

fn grid() -> Grid {
    Grid::centred(DIMENSIONS, DVec3::ONE).expect("valid")
}

fn how() -> Classification {
    Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in")
}

/// Numbers without order.
fn scattered(seed: usize) -> impl Iterator<Item = usize> {
    let mut state = seed as u64;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    })
}

/// Padding, with some matter of any kind here and there, and bricks full of it.
fn hu() -> Vec<i16> {
    let [n0, n1, _] = DIMENSIONS;
    let voxel = |(at, n): (usize, usize)| match (at % n0 / 8 + at / n0 % n1 / 8, n % 50) {
        (2, _) => [-1024, -990, -700, 40, 300, 1500][n % 6],
        (_, 0) => [-999, -300, 60, 2500][n / 50 % 4],
        _ => -2000,
    };
    (0..DIMENSIONS.iter().product()).zip(scattered(5)).map(voxel).collect()
}

/// Holds every brick to its voxels, one by one.
fn says_what_is_there(name: &str, volume: &Volume) {
    let occupancy = volume.occupancy().expect("voxels on the host");
    let [n0, n1, _] = DIMENSIONS;
    let [b0, b1, b2] = occupancy.bricks();
    let (mut labels, mut densest) = (vec![0_u8; b0 * b1 * b2], vec![0.0_f64; b0 * b1 * b2]);
    for at in 0..DIMENSIONS.iter().product() {
        let [i, j, k] = [at % n0, at / n0 % n1, at / (n0 * n1)].map(|voxel| voxel / BRICK);
        let (brick, voxel) = ((k * b1 + j) * b0 + i, volume.voxels().get(at));
        labels[brick] |= u8::from(voxel.density > 0.0) << voxel.label;
        densest[brick] = densest[brick].max(voxel.density);
    }
    assert!(labels.contains(&0) && labels.iter().any(|labels| labels.count_ones() > 2), "{name}");
    for brick in 0..labels.len() {
        assert_eq!(occupancy.labels(brick), labels[brick], "{name}, brick {brick}");
        let above = f64::from(occupancy.densest(brick)) - densest[brick];
        assert!((0.0..=2e-7 * densest[brick]).contains(&above), "{name}, brick {brick}: {above:e}");
    }
}

#[test]
fn a_brick_holds_the_labels_and_the_density_of_its_voxels() {
    let (hu, how) = (hu(), how());
    let labels: Vec<u8> = scattered(9).map(|n| (n % 5) as u8).take(hu.len()).collect();
    let numbers: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.25).collect();
    says_what_is_there("thresholds", &Volume::from_int16(grid(), &hu, None, &how).expect("valid"));
    says_what_is_there("labels", &Volume::from_int16(grid(), &hu, Some(&labels), &how).expect("valid"));
    says_what_is_there("float32", &Volume::from_float32(grid(), &numbers, None, &how).expect("valid"));
    // A curve with jumps, along which density may fall while CT numbers grow.
    let jumps = Classification { calibration: Calibration::named("schneider2000").expect("built in"), ..how };
    says_what_is_there("jumps", &Volume::from_int16(grid(), &hu, None, &jumps).expect("valid"));
}

#[test]
fn what_counts_is_denser_than_the_floor_and_has_the_label() {
    // Air below the floor, bone, and lung, a brick each; vacuum.
    let grid = Grid::centred([32, 8, 8], DVec3::ONE).expect("valid");
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|at| [-980, 1000, -700, -2000][at % 32 / 8]).collect();
    let volume = Volume::from_int16(grid, &hu, None, &how()).expect("valid");
    let occupancy = volume.occupancy().expect("voxels on the host");
    let which = |labels, floor| {
        let occupied = occupancy.of(Matter::new(labels, floor).expect("valid")).expect("little memory");
        [0, 1, 2, 3].map(|brick| occupied.holds([brick, 0, 0]))
    };
    assert_eq!(which(u8::MAX, 0.0), [true, true, true, false]);
    assert_eq!(which(u8::MAX, 0.05), [false, true, true, false]);
    assert_eq!(which(1 << 3, 0.0), [false, true, false, false]);
    assert_eq!(which(1 << 2, 0.0), [false; 4]);
    for floor in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(Matter::new(1, floor).expect_err("no density").to_string().starts_with("floor is "));
    }
}

#[test]
fn memory_is_a_small_part_of_the_voxels() {
    let grid = Grid::centred([65, 66, 71], DVec3::ONE).expect("valid");
    let volume = Volume::from_int16(grid, &vec![0; grid.voxel_count()], None, &how()).expect("valid");
    let occupancy = volume.occupancy().expect("voxels on the host");
    let with_levels = occupancy.bytes() + occupancy.of(Matter::ANY).expect("little memory").bytes();
    // Of bricks that end with the volume it is 0.6 %.
    assert!((with_levels as f64) < 0.015 * 2.0 * grid.voxel_count() as f64, "{with_levels} bytes");
}

#[test]
fn of_a_texture_nothing_is_known() {
    let volume = Volume::from_texture(grid(), std::sync::Arc::new(()), &how()).expect("memory");
    assert!(matches!(volume.occupancy(), Err(Error::Unsupported(_))));
}
