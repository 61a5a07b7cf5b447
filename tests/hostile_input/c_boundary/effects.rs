//! Effects of scenes.

use std::ffi::{CStr, CString};

use drr::capi::blur::DrrBlurComponent;
use drr::capi::effects::*;
use drr::capi::filter::DrrFilter;
use drr::capi::implant::{DRR_IMPLANT_SPHERE, DrrImplant, DrrScrewSection};
use drr::capi::scene::DrrScene;

use super::input::Input;
use super::memory::How;
use super::scene::table;

/// By which an input says that its end is about effects.
const MARK: u8 = 0xef;
/// How many bytes of it.
const BYTES: usize = 256;
/// Photons of an estimate of scatter, so that an input takes milliseconds.
const FEW_PHOTONS: usize = 1000;

/// What a scene points to.
#[derive(Default)]
pub(super) struct Effects {
    tables: Vec<Vec<f32>>,
    numbers: Vec<Vec<f64>>,
    names: Vec<CString>,
    filters: Vec<DrrFilter>,
    sections: Vec<DrrScrewSection>,
    implants: Vec<DrrImplant>,
    blur: Vec<DrrBlurComponent>,
}

impl Effects {
    /// Sets the fields of a scene whose tables have so many energies, if the input says so.
    pub(super) fn set(input: &mut Input<'_>, scene: &mut DrrScene, energies: usize) -> Option<Self> {
        let mut input = input.end(MARK, BYTES)?;
        let mut effects = Self::default();
        let bits = [
            DRR_EFFECT_FALL_OFF,
            DRR_EFFECT_HEEL,
            DRR_EFFECT_FOCAL_SPOT,
            DRR_EFFECT_FILL_FACTOR,
            DRR_EFFECT_SCATTER,
            DRR_EFFECT_QUANTUM_NOISE,
            DRR_EFFECT_ELECTRONIC_NOISE,
        ];
        for bit in bits {
            scene.effects |= if input.seldom() { bit } else { 0 };
        }
        scene.heel_target_angle_degrees = input.number(scene.heel_target_angle_degrees);
        scene.heel_depth_mm = input.number(scene.heel_depth_mm);
        scene.heel_cathode_degrees = input.number(scene.heel_cathode_degrees);
        scene.focal_spot_width_mm = input.number(0.1);
        scene.focal_spot_height_mm = input.number(0.1);
        scene.fill_factor = input.number(0.5);
        scene.photons_per_pixel = input.number(1000.0);
        scene.electronic_noise_photons = input.number(1.0);
        // Few seeds of scatter: kernels that are known take no time.
        (scene.noise_seed, scene.scatter_seed) = (input.byte().into(), (input.byte() % 2).into());
        scene.scatter_photons = input.count(FEW_PHOTONS, 0..FEW_PHOTONS) as u64;
        effects.detector(&mut input, scene, energies);
        effects.filters(&mut input, scene, energies);
        effects.implants(&mut input, scene);
        effects.blur(&mut input, scene);
        // A million histories are right, and take too long.
        if scene.scatter_photons > FEW_PHOTONS as u64 && scene.scatter_photons <= 10_000_000 {
            scene.scatter_photons = FEW_PHOTONS as u64;
        }
        Some(effects)
    }

    fn table(&mut self, input: &mut Input<'_>, count: usize, ordinary: f32) -> *const f32 {
        self.tables.push(table(input, count, ordinary));
        How::of(input).pass(self.tables.last().map_or(std::ptr::null(), Vec::as_ptr))
    }

    fn numbers(&mut self, input: &mut Input<'_>, ordinary: &[f64]) -> *const f64 {
        self.numbers.push(ordinary.iter().map(|&number| input.number(number)).collect());
        How::of(input).pass(self.numbers.last().map_or(std::ptr::null(), Vec::as_ptr))
    }

    fn detector(&mut self, input: &mut Input<'_>, scene: &mut DrrScene, energies: usize) {
        if input.seldom() {
            scene.detector_efficiency = self.table(input, energies, 0.5);
        }
        if input.seldom() {
            scene.second_detector_response = self.table(input, energies, 1.0);
        }
        if input.seldom() {
            scene.second_detector_efficiency = self.table(input, energies, 0.5);
        }
    }

    fn filters(&mut self, input: &mut Input<'_>, scene: &mut DrrScene, energies: usize) {
        if !input.seldom() {
            return;
        }
        let built_in: [&CStr; 4] = [c"aluminium", c"water", c"", c"\xff"];
        self.names.push(input.one_of(&built_in).to_owned());
        let names = How::of(input).pass(self.names[0].as_ptr());
        let slab = DrrFilter {
            material: if names.is_null() || names == self.names[0].as_ptr() {
                names
            } else {
                std::ptr::null()
            },
            mass_attenuation: std::ptr::null(),
            density: input.number(0.0),
            thickness_mm: input.number(1.0),
            angles_degrees: std::ptr::null(),
            thicknesses_mm: std::ptr::null(),
            point_count: 0,
        };
        let bow_tie = DrrFilter {
            material: std::ptr::null(),
            mass_attenuation: self.table(input, energies, 0.2),
            density: input.number(1.0),
            angles_degrees: self.numbers(input, &[-10.0, 0.0, 10.0]),
            thicknesses_mm: self.numbers(input, &[5.0, 1.0, 5.0]),
            // No more than there are, or a number that is refused.
            point_count: match input.count(3, 0..4) {
                4..=1024 => 3,
                count => count,
            },
            ..slab
        };
        self.filters = vec![slab, bow_tie];
        scene.filters = How::of(input).pass(self.filters.as_ptr());
        scene.filter_count = at_most(input, 2, 64);
    }

    fn implants(&mut self, input: &mut Input<'_>, scene: &mut DrrScene) {
        if !input.seldom() {
            return;
        }
        let section = DrrScrewSection { length_mm: input.number(1.0), radius_mm: input.number(0.5) };
        self.sections = vec![section; 2];
        let implant = DrrImplant {
            shape: input.code(DRR_IMPLANT_SPHERE),
            material: input.code(0),
            density: input.number(4.5),
            position: [0; 3].map(|_| input.number(0.0)),
            axes: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0].map(|x| input.number(x)),
            radius_mm: input.number(1.0),
            sections: How::of(input).pass(self.sections.as_ptr()),
            section_count: at_most(input, 2, 1024),
        };
        let upright = DrrImplant { axes: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], ..implant };
        self.implants = vec![implant, upright];
        scene.implants = How::of(input).pass(self.implants.as_ptr());
        scene.implant_count = at_most(input, 2, 64);
    }

    fn blur(&mut self, input: &mut Input<'_>, scene: &mut DrrScene) {
        if input.seldom() {
            let part = DrrBlurComponent { weight: 0.5, sigma_mm: input.number(0.5) };
            self.blur = vec![part, DrrBlurComponent { weight: input.number(0.5), ..part }];
            scene.blur = How::of(input).pass(self.blur.as_ptr());
            scene.blur_count = at_most(input, 2, 8);
        }
        if input.seldom() {
            scene.mtf_frequencies_per_mm = self.numbers(input, &[0.0, 1.0, 2.0]);
            scene.mtf = self.numbers(input, &[1.0, 0.5, 0.2]);
            scene.mtf_count = at_most(input, 3, 256);
        }
    }
}

/// A number of things of which there are `present`: no more, or more than is valid.
fn at_most(input: &mut Input<'_>, present: usize, valid: usize) -> usize {
    match input.count(present, 0..present + 1) {
        count if count <= valid => count.min(present),
        count => count,
    }
}
