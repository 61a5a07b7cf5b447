use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::*;
use crate::engine::Backend;
use crate::geometry::{DetectorPose, Grid, Projection};
use crate::physics::{Calibration, Thresholds};
use crate::volume::Classification;

const SIZE: [usize; 2] = [33, 21];

/// A box of bone in vacuum: voxels 24 … 31 of 64 along each axis, which are one brick.
fn volume(grid: Grid) -> Arc<Volume> {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let [n0, n1, _] = grid.dimensions();
    let in_box = |at: usize| [at % n0, at / n0 % n1, at / (n0 * n1)].iter().all(|i| (24..32).contains(i));
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|at| if in_box(at) { 1000 } else { -2000 }).collect();
    Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"))
}

fn grid() -> Grid {
    Grid::centred([64; 3], DVec3::new(1.0, 2.0, 0.5)).expect("valid")
}

fn cache(grid: Grid) -> RayCache {
    RayCache::new(&Context::new(Backend::Cpu, 2).expect("threads"), volume(grid))
}

fn pose() -> DetectorPose {
    DetectorPose::c_arm(DVec3::ZERO, 25.0, 500.0, 800.0, 2.0, SIZE)
}

fn bone() -> Matter {
    Matter::new(1 << 3, 0.0).expect("valid")
}

#[test]
fn a_view_is_computed_once_until_something_changes() {
    let mut cache = cache(grid());
    let pose = View::Pose(pose());
    let first = cache.update(&pose, SIZE, bone()).expect("valid").clone();
    let again = cache.update(&pose, SIZE, bone()).expect("valid").clone();
    assert_eq!((cache.computed().views, &first), (1, &again));
    assert!(first.hits() > 10 && first.hits() < SIZE[0] * SIZE[1], "{} hits", first.hits());
    let other = View::Pose(DetectorPose { source: DVec3::new(0.0, -501.0, 0.0), ..self::pose() });
    let floor = Matter::new(1 << 3, 0.1).expect("valid");
    for (n, (view, size, matter)) in
        [(other, SIZE, bone()), (other, [21, 33], bone()), (other, [21, 33], floor)].into_iter().enumerate()
    {
        cache.update(&view, size, matter).expect("valid");
        assert_eq!(cache.computed().views, 2 + n as u64);
    }
    let same = cache.volume().clone();
    cache.set_volume(same);
    assert!(cache.view().is_some());
    cache.set_volume(volume(grid()));
    assert!(cache.view().is_none() && cache.samples().is_none());
    assert_eq!(cache.update(&pose, SIZE, bone()).expect("valid"), &first);
    assert_eq!(cache.computed().views, 5);
}

#[test]
fn the_idle_source_of_a_parallel_beam_does_not_matter() {
    let mut cache = cache(grid());
    let matrix = DMat4::from_diagonal(DVec4::new(0.02, 0.03, 0.005, 1.0)) * DMat4::from_rotation_y(0.3);
    for x in [f64::NAN, 1.0, f64::NAN] {
        let view = View::Projection(Projection { matrix, source: DVec3::splat(x) });
        cache.update(&view, SIZE, bone()).expect("valid");
    }
    assert_eq!(cache.computed().views, 1);
}

/// A call that is refused.
type Fails<'a> = &'a dyn Fn(&mut RayCache) -> Option<Error>;

#[test]
fn whatever_fails_leaves_the_cache_empty() {
    let mut cache = cache(grid());
    let camera = Camera::towards(DVec3::new(0.0, -200.0, 0.0), DVec3::ZERO, DVec3::Z, 30.0, 1.5);
    let view = View::Pose(pose());
    let fill = |cache: &mut RayCache| {
        cache.cast_camera(&camera).expect("valid");
        cache.update(&view, SIZE, bone()).expect("valid");
        assert!(cache.view().is_some() && cache.samples().is_some());
    };
    let flat = View::Pose(DetectorPose { row_step: DVec3::ZERO, ..pose() });
    let failures: [(&str, Fails<'_>); 4] = [
        ("view.column_step and row_step", &|cache| cache.update(&flat, SIZE, bone()).err()),
        ("width", &|cache| cache.update(&view, [0, 21], bone()).err()),
        ("height", &|cache| cache.update(&view, [33, 32769], bone()).err()),
        ("camera.up", &|cache| cache.cast_camera(&Camera { up: DVec3::Y, ..camera }).err()),
    ];
    for (argument, fail) in failures {
        fill(&mut cache);
        let message = fail(&mut cache).expect("refused").to_string();
        assert!(message.starts_with(&format!("{argument} is ")), "{message}");
        assert!(cache.view().is_none() && cache.samples().is_none(), "{argument}");
    }
}

#[test]
fn a_list_keeps_its_indices_and_is_computed_once() {
    let mut cache = cache(grid());
    let ray = |x: f64, towards: DVec3| WorldRay::new(DVec3::new(x, -100.0, 0.0), towards).expect("valid");
    let rays = [ray(0.0, DVec3::Y), ray(0.0, DVec3::NEG_Y), ray(40.0, DVec3::Y), ray(31.5, DVec3::Y)];
    for _ in 0..2 {
        let hits = cache.cast(&rays).expect("memory").iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(hits, [true, false, false, true]);
    }
    assert_eq!(cache.computed().lists, 1);
    let sample = cache.samples().and_then(|samples| samples[0]).expect("the first hits");
    assert_eq!((sample.world_entry, sample.world_exit), (36.0, 164.0));
    cache.cast(&rays[..3]).expect("memory");
    assert_eq!(cache.computed().lists, 2);
}

/// Bone from −8 to 0 mm along x, −16 to 0 along y, −4 to 0 along z.
#[test]
fn spans_are_distances_from_the_source_to_the_bricks() {
    let mut cache = cache(grid());
    let size = [1, 1];
    let through = DVec3::new(-4.0, -8.0, -2.0);
    let pose = DetectorPose::c_arm(through, 0.0, 100.0, 300.0, 1.0, size);
    let projection = Projection::from_pose(&pose, size).expect("valid");
    // The ray is along y: the brick begins 92 mm from the source and ends 108 mm from it, the box from 44 to 172.
    for view in [View::Pose(pose), View::Projection(projection)] {
        let span = cache.update(&view, size, bone()).expect("valid").spans()[0];
        let reach = 2.0 * crate::raycast::tighten::REACH;
        assert!(
            (span.entry_mm - (92.0 - reach)).abs() < 1e-9 && (span.exit_mm - (108.0 + reach)).abs() < 1e-9
        );
        assert!((span.skipped_mm + span.length_mm() - 128.0).abs() < 1e-9, "{span:?}");
    }
    // Seen from inside the bone: the rest of it.
    let inside = DetectorPose { source: through, ..pose };
    let span = cache.update(&View::Pose(inside), size, bone()).expect("valid").spans()[0];
    assert_eq!(span.entry_mm, 0.0);
    assert!((span.exit_mm - 10.0).abs() < 1e-9, "{span:?}");
    // A detector in front of all matter.
    let before = DetectorPose { first_pixel: pose.source + DVec3::new(0.0, 50.0, 0.0), ..pose };
    let span = cache.update(&View::Pose(before), size, bone()).expect("valid").spans()[0];
    assert_eq!((span.entry_mm, span.exit_mm), (0.0, 0.0));
    assert!((span.skipped_mm - 6.0).abs() < 1e-9, "{span:?}");
}

#[test]
fn in_a_parallel_beam_distances_are_from_the_volumes_centre() {
    let mut cache = cache(grid());
    // Along +z, then along −z: the brick is from −4 to 0 mm, and its reach half a millimetre.
    for (sign, expected) in [(1.0, [-4.5, 0.5]), (-1.0, [-0.5, 4.5])] {
        let matrix = DMat4::from_cols(
            DVec4::new(0.1, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 0.1 * sign, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.01, 0.0),
            DVec4::new(0.4, 0.8 * sign, 0.5, 1.0),
        );
        let view = View::Projection(Projection { matrix, source: DVec3::NAN });
        let span = cache.update(&view, [1, 1], bone()).expect("valid").spans()[0];
        let off = [span.entry_mm - expected[0], span.exit_mm - expected[1]];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{sign}: {span:?}");
    }
}

/// The same voxels stored in another order and mirrored, and all moved: spans of the same length from the same places.
#[test]
fn how_voxels_are_stored_does_not_matter() {
    let far = DVec3::new(256.0, -512.0, 1024.0);
    let mirrored = DMat3::from_cols(DVec3::new(0.0, -2.0, 0.0), DVec3::new(0.0, 0.0, 0.5), DVec3::NEG_X);
    // Voxels 24 … 31 are 32 … 39 from the other end: mirrored about the box of bone, not about the volume.
    let middle = grid().index_to_world().transform_point3(DVec3::splat(27.5));
    let translation = middle - mirrored * DVec3::splat(27.5) + far;
    let stored = Grid::new([64; 3], DAffine3 { matrix3: mirrored, translation }).expect("valid");
    let moved = DetectorPose { source: pose().source + far, first_pixel: pose().first_pixel + far, ..pose() };
    let (mut one, mut other) = (cache(grid()), cache(stored));
    let spans = one.update(&View::Pose(pose()), SIZE, bone()).expect("valid").spans();
    let others = other.update(&View::Pose(moved), SIZE, bone()).expect("valid").spans();
    let mut hits = 0;
    for (one, other) in spans.iter().zip(others) {
        // Where a span may begin early depends on the order of bricks: by twice the reach at most, of voxels of 2 mm.
        assert_eq!(one.length_mm() > 0.0, other.length_mm() > 0.0);
        hits += usize::from(one.length_mm() > 0.0);
        assert!((one.entry_mm - other.entry_mm).abs() < 4.0 && (one.exit_mm - other.exit_mm).abs() < 4.0);
    }
    assert!(hits > 10);
}

#[test]
fn what_is_skipped_is_bounded_by_the_floor() {
    let mut cache = cache(grid());
    let floor = Matter::new(u8::MAX, 0.01).expect("valid");
    let spans = cache.update(&View::Pose(pose()), SIZE, floor).expect("valid");
    let most = spans.spans().iter().map(|span| span.skipped_mm).fold(0.0, f64::max);
    assert!(most > 100.0 && (spans.largest_loss() - 0.001 * most).abs() < 1e-15);
    let without = cache.update(&View::Pose(pose()), SIZE, bone()).expect("valid");
    assert_eq!(without.largest_loss(), 0.0);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let spans = [1, 3].map(|threads| {
        let context = Context::new(Backend::Cpu, threads).expect("threads");
        let mut cache = RayCache::new(&context, volume(grid()));
        cache.update(&View::Pose(pose()), SIZE, bone()).expect("valid").clone()
    });
    assert_eq!(spans[0], spans[1]);
}
