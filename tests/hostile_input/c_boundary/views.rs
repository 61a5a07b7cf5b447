//! Views: poses, and uniforms with tables of their own.

use drr::capi::geometry::{DrrDetectorPose, drr_pose_c_arm, drr_uniforms_cone};
use drr::capi::scene::DrrScene;
use drr::shared::{DrrBool, DrrFloat3, DrrFloat4x4, ProjectionUniforms};

use super::call::succeeded;
use super::input::Input;
use super::scene::table;
use super::volume::Extent;

/// A pose that sees the volume, with any number replaced.
pub(super) fn pose(input: &mut Input<'_>, grid: &Extent, [width, height]: [usize; 2]) -> DrrDetectorPose {
    let size = if grid.diagonal_mm.is_normal() { grid.diagonal_mm } else { 1.0 };
    let angle = input.number(6.0);
    let pixel = size / width.clamp(1, 16) as f64;
    let mut pose = DrrDetectorPose {
        source: [0.0, -10.0, 0.0],
        first_pixel: [-1.0, 5.0, -1.0],
        column_step: [1.0, 0.0, 0.0],
        row_step: [0.0, 0.0, 1.0],
    };
    // SAFETY: three numbers to read and a place for one struct.
    let arm = unsafe {
        drr_pose_c_arm(
            grid.centre.as_ptr(),
            angle,
            input.number(4.0 * size),
            input.number(6.0 * size),
            input.number(pixel),
            width,
            height,
            &raw mut pose,
        )
    };
    succeeded(arm);
    for vector in [&mut pose.source, &mut pose.first_pixel, &mut pose.column_step, &mut pose.row_step] {
        // One byte leaves all of it alone: twelve bytes in a row rarely would.
        if input.seldom() {
            for x in vector {
                *x = input.number(*x);
            }
        }
    }
    pose
}

/// A view and the memory behind its addresses.
pub(super) struct View {
    pub(super) uniforms: ProjectionUniforms,
    /// No coefficient is larger, cm²/g, if the view has a table of its own.
    pub(super) largest_attenuation: Option<f64>,
    /// Signal of a ray that meets nothing, if the view has a spectrum of its own.
    pub(super) i0: Option<f64>,
    _tables: [Vec<f32>; 2],
}

/// Uniforms of a pose or of a parallel beam, with any number replaced.
pub(super) fn view(input: &mut Input<'_>, grid: &Extent, scene: &DrrScene) -> View {
    let size = [scene.detector_width, scene.detector_height];
    let mut uniforms = if input.seldom() { parallel(grid) } else { cone(&pose(input, grid, size), size) };
    if input.seldom() {
        let columns = &mut uniforms.modelViewProjectionMatrix.columns;
        columns.iter_mut().flatten().for_each(|x| *x = input.float(*x));
    }
    let DrrFloat3 { x, y, z } = &mut uniforms.sourcePosition;
    for x in [x, y, z] {
        *x = input.float(*x);
    }
    uniforms.enableEarlyExit = DrrBool(input.byte());
    uniforms._padding = f32::NAN;
    let counts = [scene.energy_count, scene.energy_count * scene.material_count];
    let tables = [(counts[0], 1.0), (counts[1], 0.2)]
        .map(|(count, ordinary)| if input.seldom() { table(input, count, ordinary) } else { Vec::new() });
    let address = |table: &Vec<f32>, off: u64| {
        if table.is_empty() { off } else { table.as_ptr().expose_provenance() as u64 + off }
    };
    let off = input.one_of(&[0, 0, 0, 0, 1, 2]);
    uniforms.spectrumLutAddress = address(&tables[0], off);
    uniforms.muLutAddress = address(&tables[1], off);
    let own = |table: &[f32]| !table.is_empty();
    View {
        uniforms,
        i0: own(&tables[0]).then(|| tables[0].iter().map(|&w| f64::from(w)).sum()),
        largest_attenuation: own(&tables[1])
            .then(|| tables[1].iter().fold(0.0, |largest, &mu| f64::max(largest, mu.into()))),
        _tables: tables,
    }
}

fn cone(pose: &DrrDetectorPose, [width, height]: [usize; 2]) -> ProjectionUniforms {
    let mut uniforms = without_matrix();
    // SAFETY: one struct to read, a place for the other.
    if succeeded(unsafe { drr_uniforms_cone(pose, width, height, &raw mut uniforms) }) {
        let columns = uniforms.modelViewProjectionMatrix.columns;
        assert!(columns.iter().flatten().all(|x| x.is_finite()));
    } else {
        assert_eq!(uniforms, without_matrix(), "written by a call that failed");
    }
    uniforms
}

/// Rays along y.
fn parallel(grid: &Extent) -> ProjectionUniforms {
    let scale = 1.0 / grid.diagonal_mm;
    let [x, y, z] = grid.centre.map(|c| (-c * scale) as f32);
    let scale = scale as f32;
    let columns = [[scale, 0.0, 0.0, 0.0], [0.0, 0.0, scale, 0.0], [0.0, scale, 0.0, 0.0], [x, z, y, 1.0]];
    ProjectionUniforms { modelViewProjectionMatrix: DrrFloat4x4 { columns }, ..without_matrix() }
}

fn without_matrix() -> ProjectionUniforms {
    ProjectionUniforms {
        modelViewProjectionMatrix: DrrFloat4x4 { columns: [[0.0; 4]; 4] },
        sourcePosition: DrrFloat3 { x: 0.0, y: 0.0, z: 0.0 },
        spectrumLutAddress: 0,
        muLutAddress: 0,
        enableEarlyExit: DrrBool(0),
        _padding: 0.0,
    }
}
