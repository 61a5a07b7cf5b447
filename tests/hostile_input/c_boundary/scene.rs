//! Scenes and projectors.

use std::ffi::CStr;

use drr::capi::context::DrrContext;
use drr::capi::effects::{DRR_EFFECT_BONE_PATH, DRR_EFFECT_POLYENERGETIC};
use drr::capi::physics::drr_physics_spectrum;
use drr::capi::projector::{DrrProjector, drr_projector_create};
use drr::capi::scene::{DRR_ALGORITHM_MARCH, DrrScene, drr_scene_init};
use drr::capi::volume::DrrVolume;

use super::call::{made, succeeded};
use super::effects::Effects;
use super::input::Input;
use super::memory::How;

/// Most energies of a grid.
const MOST_ENERGIES: usize = 4096;
/// The built-in materials attenuate less, cm²/g.
const BUILT_IN_ATTENUATION: f64 = 100.0;
const DEFAULT_SPECTRUM: &CStr = c"W120_2p5Al";

/// Errors that a scene may ask for.
const ERRORS: [f64; 8] = [2.0, 0.1, 50.0, 1000.0, 1e-12, -1.0, f64::NAN, f64::INFINITY];

/// What is known of a scene that was accepted.
pub(super) struct Accepted {
    pub(super) scene: DrrScene,
    /// Signal of a ray that meets nothing.
    pub(super) i0: f64,
    /// No coefficient is larger, cm²/g.
    pub(super) largest_attenuation: f64,
    /// What the scene points to: it may be read again.
    _tables: [Vec<f32>; 3],
    effects: Option<Effects>,
}

impl Accepted {
    pub(super) fn has(&self, effect: u32) -> bool {
        self.scene.effects & effect != 0
    }

    /// Images of signals per view.
    pub(super) fn layers(&self) -> usize {
        if self.has(DRR_EFFECT_POLYENERGETIC) && !self.scene.second_detector_response.is_null() {
            2
        } else {
            1
        }
    }

    /// Whether the images are not those of rays alone.
    pub(super) fn has_effects(&self) -> bool {
        self.effects.is_some()
    }

    /// Samples of a march through one voxel.
    pub(super) fn samples_per_voxel(&self) -> usize {
        if self.scene.algorithm == DRR_ALGORITHM_MARCH {
            (1.0 / self.scene.step_voxels).ceil() as usize
        } else {
            1
        }
    }
}

/// A table of `count` values, most of them `ordinary`.
pub(super) fn table(input: &mut Input<'_>, count: usize, ordinary: f32) -> Vec<f32> {
    (0..count).map(|_| input.float(ordinary)).collect()
}

/// A projector, if the library takes the scene.
pub(super) fn make(
    input: &mut Input<'_>,
    context: *const DrrContext,
    volume: *const DrrVolume,
) -> Option<(*mut DrrProjector, Accepted)> {
    let mut scene = numbers(input);
    // Of a number that is refused no array can be made.
    let energies = if scene.energy_count <= MOST_ENERGIES { scene.energy_count } else { 1 };
    let effects = Effects::set(input, &mut scene, energies);
    let materials = if scene.material_count <= 8 { scene.material_count } else { 1 };
    let [has_spectrum, has_response, has_attenuation] = [(); 3].map(|()| input.seldom());
    let [mut spectrum, mut response, mut attenuation] = [const { Vec::new() }; 3];
    if has_spectrum {
        spectrum = table(input, energies, 1.0);
        scene.spectrum = How::of(input).pass(spectrum.as_ptr());
    }
    if has_response {
        response = table(input, energies, 1.0);
        scene.detector_response = How::of(input).pass(response.as_ptr());
    }
    if has_attenuation {
        attenuation = table(input, energies * materials, 0.2);
        scene.mass_attenuation = How::of(input).pass(attenuation.as_ptr());
    }
    let given = How::of(input).pass(&raw const scene);
    // Another type's handle is refused.
    let volume = if input.byte() < 250 { How::of(input).pass(volume) } else { context.cast() };
    // SAFETY: the tables are as long as the scene says; the rest is good, NULL or misaligned.
    let projector = made(|projector| unsafe { drr_projector_create(volume, given, projector) })?;
    if scene.spectrum.is_null() {
        spectrum.clear();
    }
    if scene.detector_response.is_null() {
        response.clear();
    }
    let i0 =
        if scene.effects & DRR_EFFECT_POLYENERGETIC == 0 { 1.0 } else { i0(&scene, &spectrum, &response) };
    let largest = attenuation.iter().fold(BUILT_IN_ATTENUATION, |largest, &mu| largest.max(mu.into()));
    let tables = [spectrum, response, attenuation];
    Some((projector, Accepted { scene, i0, largest_attenuation: largest, _tables: tables, effects }))
}

/// A scene without tables.
fn numbers(input: &mut Input<'_>) -> DrrScene {
    let mut scene = std::mem::MaybeUninit::uninit();
    // SAFETY: a place for one struct; it is filled on success.
    let defaults: DrrScene = unsafe {
        assert!(succeeded(drr_scene_init(scene.as_mut_ptr())));
        scene.assume_init()
    };
    let effects = DRR_EFFECT_POLYENERGETIC | DRR_EFFECT_BONE_PATH;
    let [tolerance_hu, tolerance_mm, few_energies_hu] = [(); 3].map(|()| match input.last() {
        byte @ 192.. => ERRORS[usize::from(byte) % ERRORS.len()],
        _ => 0.0,
    });
    DrrScene {
        tolerance_hu,
        tolerance_mm,
        few_energies_hu,
        struct_size: input.count(defaults.struct_size, 0..200),
        detector_width: input.count(3, 1..10),
        detector_height: input.count(2, 1..10),
        effects: input.one_of(&[
            effects,
            0,
            DRR_EFFECT_POLYENERGETIC,
            DRR_EFFECT_BONE_PATH,
            1 << 9,
            u32::MAX,
        ]),
        algorithm: input.code(defaults.algorithm),
        supersampling: input.one_of(&[1, 2, 3, 4, 5, 16, 17, 0, u32::MAX]),
        step_voxels: input.number(defaults.step_voxels),
        bone_material: input.code(defaults.bone_material),
        material_count: input.count(defaults.material_count, 1..9),
        energy_count: input.count(defaults.energy_count, 1..9),
        first_energy_kev: input.number(defaults.first_energy_kev),
        energy_step_kev: input.number(defaults.energy_step_kev),
        mono_energy_kev: input.number(defaults.mono_energy_kev),
        ..defaults
    }
}

/// The sum of the spectrum's weights after the detector's response.
fn i0(scene: &DrrScene, spectrum: &[f32], response: &[f32]) -> f64 {
    let mut weights = spectrum.to_vec();
    if weights.is_empty() {
        weights = vec![0.0; scene.energy_count];
        // SAFETY: the name ends in NUL; there is one place per energy.
        let filled = unsafe {
            drr_physics_spectrum(
                DEFAULT_SPECTRUM.as_ptr(),
                scene.first_energy_kev,
                scene.energy_step_kev,
                scene.energy_count,
                weights.as_mut_ptr(),
            )
        };
        assert!(succeeded(filled), "the spectrum of a scene that was accepted");
    }
    let response = response.iter().copied().chain(std::iter::repeat(1.0));
    let response = response.take(weights.len());
    let response: Vec<f32> = response.collect();
    weights.iter().zip(&response).map(|(&w, &r)| f64::from(w) * f64::from(r)).sum()
}
