//! What the fields of a scene are called in C.

use crate::error::Error;

/// A scene's fields in Rust and in C, the longer ones first.
const FIELDS: [(&str, &str); 23] = [
    ("scene.expected_views", "scene.expected_poses"),
    ("scene.materials", "scene.mass_attenuation"),
    ("scene.detector_layers[0]", "scene.detector_efficiency"),
    ("scene.detector_layers[1]", "scene.second_detector_efficiency"),
    ("scene.effects.heel.target_angle_degrees", "scene.heel_target_angle_degrees"),
    ("scene.effects.heel.depth_mm", "scene.heel_depth_mm"),
    ("scene.effects.heel.cathode_degrees", "scene.heel_cathode_degrees"),
    ("scene.effects.heel.", "scene."),
    ("scene.effects.filters", "scene.filters"),
    ("scene.effects.implants", "scene.implants"),
    ("scene.effects.focal_spot.width_mm", "scene.focal_spot_width_mm"),
    ("scene.effects.focal_spot.height_mm", "scene.focal_spot_height_mm"),
    ("scene.effects.focal_spot", "scene.effects DRR_EFFECT_FOCAL_SPOT"),
    ("scene.effects.scatter.histories", "scene.scatter_photons"),
    ("scene.effects.scatter", "scene.effects DRR_EFFECT_SCATTER"),
    ("scene.effects.detector_blur.mtf: number of points", "scene.mtf_count"),
    ("scene.effects.detector_blur.frequencies_per_mm", "scene.mtf_frequencies_per_mm"),
    ("scene.effects.detector_blur.mtf", "scene.mtf"),
    ("scene.effects.detector_blur", "scene.blur"),
    ("scene.effects.fill_factor", "scene.fill_factor"),
    ("scene.effects.noise.photons_per_pixel", "scene.photons_per_pixel"),
    ("scene.effects.noise.electronic_photons", "scene.electronic_noise_photons"),
    ("scene.effects.noise", "scene.effects DRR_EFFECT_QUANTUM_NOISE"),
];

/// The same error to a caller in C. A view that it is about stays in front.
pub(super) fn in_c(error: Error) -> Error {
    let Error::InvalidArgument { argument, value, valid } = error else { return error };
    let (view, field) = argument.split_at(argument.find("scene.").unwrap_or(argument.len()));
    let known = FIELDS.into_iter().find_map(|(from, to)| Some((field.strip_prefix(from)?, to)));
    let argument = match known {
        Some((rest, to)) => format!("{view}{to}{rest}"),
        None => argument,
    };
    Error::InvalidArgument { argument, value, valid }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_the_names_of_the_header() {
        let header = include_str!("../../include/DRR_Shared.h");
        for (_, to) in FIELDS {
            let name = to.trim_start_matches("scene.").trim_start_matches("effects ");
            let name = name.trim_end_matches(['[', ']', '0', '1']);
            assert!(header.contains(name), "{name}");
        }
    }

    #[test]
    fn the_view_stays_and_indices_do() {
        let name = |argument: &str| match in_c(Error::invalid(argument, 0, "1")) {
            Error::InvalidArgument { argument, .. } => argument,
            other => panic!("{other}"),
        };
        assert_eq!(name("scene.effects.detector_blur[1].sigma_mm"), "scene.blur[1].sigma_mm");
        assert_eq!(name("views[2].scene.effects.focal_spot.width_mm"), "views[2].scene.focal_spot_width_mm");
        assert_eq!(name("poses[0].source"), "poses[0].source");
        assert_eq!(in_c(Error::Cancelled), Error::Cancelled);
    }
}
