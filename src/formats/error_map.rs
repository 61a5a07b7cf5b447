//! Errors as a picture for people: blue where too low, white where right, red where too high.

use crate::error::{Error, Result};
use crate::formats::colour_picture::{ColourPicture, Rgb};
use crate::formats::mosaic::side_by_side;

/// From 0 to −range in equal steps: a straight line in CIELAB from white to lightness 38, chroma 55, hue 284°, so that
/// equal steps of the error look equally large.
const LOW: [Rgb; 9] = [
    [255, 255, 255],
    [230, 232, 245],
    [205, 210, 236],
    [179, 188, 226],
    [154, 167, 216],
    [127, 146, 207],
    [98, 126, 197],
    [65, 106, 187],
    [0, 88, 177],
];
/// From 0 to +range: the same lightness and chroma at hue 28°, so that neither sign looks larger.
const HIGH: [Rgb; 9] = [
    [255, 255, 255],
    [247, 229, 227],
    [239, 203, 199],
    [229, 177, 172],
    [218, 152, 146],
    [206, 126, 121],
    [193, 101, 96],
    [179, 75, 73],
    [164, 46, 51],
];
/// A ray that has no error to speak of: it meets nothing, or too little. Also the gap between views.
const NONE: Rgb = [160, 160, 160];

/// Signed errors, HU, as colours: 0 is white, −range and below blue, +range and above red, NaN grey. The views,
/// width × height values each, stand side by side with a thin gap.
pub fn error_map(views: &[&[f32]], width: usize, height: usize, range_hu: f64) -> Result<ColourPicture> {
    if !(range_hu > 0.0 && range_hu.is_finite()) {
        return Err(Error::invalid("range_hu", range_hu, "a finite number above 0"));
    }
    let shade = |error: f32| error_colour(f64::from(error) / range_hu);
    let (total, pixels) = side_by_side(views, [width, height], NONE, shade)?;
    Ok(ColourPicture { width: total, height, pixels })
}

/// The colour of an error as a fraction of the range: −1 blue, 0 white, 1 red, NaN grey.
pub fn error_colour(fraction: f64) -> Rgb {
    if fraction.is_nan() {
        return NONE;
    }
    let colours = if fraction < 0.0 { LOW } else { HIGH };
    let last = colours.len() - 1;
    let place = fraction.abs().min(1.0) * last as f64;
    let below = (place as usize).min(last - 1);
    let weight = place - below as f64;
    let blend = |channel: usize| {
        let [from, to] = [colours[below][channel], colours[below + 1][channel]].map(f64::from);
        (from + weight * (to - from)).round() as u8
    };
    [blend(0), blend(1), blend(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L* of an sRGB colour.
    fn lightness(colour: Rgb) -> f64 {
        let [red, green, blue] = colour.map(|channel| {
            let v = f64::from(channel) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        });
        116.0 * (0.2126 * red + 0.7152 * green + 0.0722 * blue).cbrt() - 16.0
    }

    #[test]
    fn no_error_is_white_and_the_ends_are_the_end_colours() {
        let errors = [0.0, -2.0, 2.0, -1e9, f32::INFINITY, f32::NAN];
        let map = error_map(&[&errors], 6, 1, 2.0).unwrap();
        assert_eq!((map.width, map.height), (6, 1));
        assert_eq!(map.pixels, [[255; 3], LOW[8], HIGH[8], LOW[8], HIGH[8], NONE]);
    }

    #[test]
    fn both_signs_are_equally_dark_and_darken_evenly() {
        for i in 0..=100 {
            let fraction = f64::from(i) / 100.0;
            let [low, high] = [-fraction, fraction].map(|f| lightness(error_colour(f)));
            assert!((low - high).abs() < 1.0, "at {fraction}: {low} and {high}");
            let expected = 100.0 - 62.0 * fraction;
            assert!((low - expected).abs() < 1.5, "at {fraction}: {low}, not {expected}");
        }
    }

    #[test]
    fn too_low_is_blue_and_too_high_is_red() {
        for i in 1..=100 {
            let fraction = f64::from(i) / 100.0;
            let ([r, _, b], [red, _, blue]) = (error_colour(-fraction), error_colour(fraction));
            assert!(b >= r && red >= blue, "at {fraction}");
        }
    }

    #[test]
    fn views_stand_side_by_side() {
        let map = error_map(&[&[1.0], &[-1.0]], 1, 1, 1.0).unwrap();
        assert_eq!(map.pixels, [HIGH[8], NONE, NONE, LOW[8]]);
    }

    #[test]
    fn wrong_sizes_and_ranges_are_refused() {
        assert!(error_map(&[], 1, 1, 1.0).is_err());
        let message = error_map(&[&[0.0; 3]], 2, 2, 1.0).unwrap_err().to_string();
        assert!(message.contains("views[0]") && message.contains('4'), "{message}");
        for range in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let message = error_map(&[&[0.0]], 1, 1, range).unwrap_err().to_string();
            assert!(message.contains("range_hu"), "{message}");
        }
    }
}
