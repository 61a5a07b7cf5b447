//! Values of effects on the command line.

use drr::effects::{DetectorBlur, FillFactor, FocalSpot, Heel, Scatter};

/// An error's text for clap, which names the argument itself.
fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn numbers(list: &str, separator: char) -> Option<Vec<f64>> {
    list.split(separator).map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// `ANGLE[,DEPTH_UM[,CATHODE_DEGREES]]`; what is left out is typical.
pub(super) fn heel(list: &str) -> Result<Heel, String> {
    let typical = Heel::TYPICAL;
    let (angle, depth_mm, cathode) = match numbers(list, ',').as_deref() {
        Some([angle]) => (*angle, typical.depth_mm, typical.cathode_degrees),
        Some([angle, um]) => (*angle, 1e-3 * um, typical.cathode_degrees),
        Some([angle, um, cathode]) => (*angle, 1e-3 * um, *cathode),
        _ => {
            return Err(
                "expected ANGLE, ANGLE,DEPTH or ANGLE,DEPTH,CATHODE: degrees, \u{b5}m, degrees".into()
            );
        }
    };
    let heel = Heel { target_angle_degrees: angle, depth_mm, cathode_degrees: cathode };
    heel.validate().map(|()| heel).map_err(text)
}

/// `MM`, a square, or `WxH`.
pub(super) fn focal_spot(sides: &str) -> Result<FocalSpot, String> {
    let (width_mm, height_mm) = match numbers(&sides.to_lowercase(), 'x').as_deref() {
        Some([side]) => (*side, *side),
        Some([width, height]) => (*width, *height),
        _ => return Err("expected MM or WIDTHxHEIGHT, such as 0.6 or 0.6x1.2, mm".into()),
    };
    let spot = FocalSpot { width_mm, height_mm };
    spot.validate().map(|()| spot).map_err(text)
}

/// Photons that kernels are made of.
pub(super) fn scatter(count: &str) -> Result<Scatter, String> {
    let histories = count.parse().map_err(|_| "expected a whole number of photons".to_owned())?;
    let scatter = Scatter { histories, ..Scatter::default() };
    scatter.validate().map(|()| scatter).map_err(text)
}

/// `MM`, one Gaussian, or `WEIGHT:MM,WEIGHT:MM,...`.
pub(super) fn blur(list: &str) -> Result<DetectorBlur, String> {
    let pair = |part: &str| match numbers(part, ':').as_deref() {
        Some([weight, sigma]) => Some((*weight, *sigma)),
        _ => None,
    };
    let parts = match list.trim().parse::<f64>() {
        Ok(sigma) => Some(vec![(1.0, sigma)]),
        Err(_) => list.split(',').map(pair).collect(),
    };
    let parts = parts.ok_or("expected MM, or WEIGHT:MM,WEIGHT:MM,... with weights that sum to 1")?;
    DetectorBlur::gaussians(&parts).map_err(text)
}

/// The active part of a pixel's area.
pub(super) fn fill_factor(part: &str) -> Result<FillFactor, String> {
    let part = part.parse().map_err(|_| "expected a number from 0.01 to 1".to_owned())?;
    FillFactor::new(part).map_err(text)
}

/// A number that is at least 0.
pub(super) fn not_negative(number: &str) -> Result<f64, String> {
    match number.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("expected a number of at least 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_of_a_heel_is_typical() {
        assert_eq!(heel("12"), Ok(Heel::TYPICAL));
        let own = Heel { target_angle_degrees: 8.0, depth_mm: 0.01, cathode_degrees: -90.0 };
        assert_eq!(heel("8,10,-90"), Ok(own));
        for bad in ["", "0", "12,5,0,1", "12,five", "46", "12,-5", "nan"] {
            assert!(heel(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn one_side_is_a_square() {
        assert_eq!(focal_spot("0.6"), focal_spot("0.6x0.6"));
        assert_eq!(focal_spot("0.6X1.2"), Ok(FocalSpot { width_mm: 0.6, height_mm: 1.2 }));
        for bad in ["x", "0", "-1", "0.6x", "0.6x0.6x1", "11"] {
            assert!(focal_spot(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn one_number_is_one_gaussian() {
        assert_eq!(blur("0.2"), DetectorBlur::gaussians(&[(1.0, 0.2)]).map_err(text));
        assert_eq!(blur("0.9:0.2,0.1:3").expect("valid").components().len(), 2);
        for bad in ["", "0.9:0.2", "0.9:0.2,0.1", "a", "-1"] {
            assert!(blur(bad).is_err(), "{bad}");
        }
    }
}
