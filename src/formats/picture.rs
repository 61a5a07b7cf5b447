//! Line integrals as a picture for people.

use crate::error::Result;
use crate::formats::{ColourPicture, mosaic};

/// The window runs between these fractions of the pixels that hit anything: a few metal or grazing pixels must not
/// decide what the rest looks like.
const WINDOW: [f64; 2] = [0.005, 0.998];
/// Brightness of the gap between views.
const GAP: u16 = u16::MAX / 2;

/// A gray picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns of pixels.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Pixel (i, j) at `j*width + i`, row 0 at the top; 0 is black.
    pub pixels: Vec<u16>,
}

impl Picture {
    /// The pixels in 8 bits.
    pub fn to_gray8(&self) -> Vec<u8> {
        self.pixels.iter().map(|&v| ((u32::from(v) * 255 + 32767) / 65535) as u8).collect()
    }

    /// The same picture in colours that are grey, of 8 bits.
    pub fn to_colour(&self) -> ColourPicture {
        let pixels = self.to_gray8().into_iter().map(|grey| [grey; 3]).collect();
        ColourPicture { width: self.width, height: self.height, pixels }
    }
}

/// A conventional radiograph of line integrals p = −ln(I/I₀): bone bright, air black. The views, width × height values
/// each, stand side by side with a thin gap and share one window. Pixels that hit nothing (p = 0) or are NaN are black;
/// an infinite p is white.
pub fn radiograph(views: &[&[f32]], width: usize, height: usize) -> Result<Picture> {
    let window = window(views);
    let (total, pixels) = mosaic::side_by_side(views, [width, height], GAP, |p| brightness(p, window))?;
    Ok(Picture { width: total, height, pixels })
}

/// The p shown black and the p shown white; `None` when nothing is hit.
fn window(views: &[&[f32]]) -> Option<[f32; 2]> {
    let mut hits: Vec<f32> =
        views.iter().flat_map(|view| view.iter().copied()).filter(|p| p.is_finite() && *p > 0.0).collect();
    let last = hits.len().checked_sub(1)?;
    Some(WINDOW.map(|fraction| {
        let rank = (fraction * last as f64).round() as usize;
        *hits.select_nth_unstable_by(rank, f32::total_cmp).1
    }))
}

fn brightness(p: f32, window: Option<[f32; 2]>) -> u16 {
    let Some([black, white]) = window else { return if p == f32::INFINITY { u16::MAX } else { 0 } };
    if p.is_nan() || p <= 0.0 {
        return 0;
    }
    // Without contrast, what is hit is mid-grey.
    let fraction = if white > black { ((p - black) / (white - black)).clamp(0.0, 1.0) } else { 0.5 };
    (fraction * f32::from(u16::MAX)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_attenuation_is_never_darker_and_the_window_is_used() {
        let values: Vec<f32> = (0..10_000).map(|i| i as f32 * 1e-3).collect();
        let picture = radiograph(&[&values], 100, 100).unwrap();
        assert!(picture.pixels.is_sorted());
        assert_eq!((picture.pixels[0], picture.pixels[9999]), (0, u16::MAX));
        let clipped = |value| picture.pixels.iter().filter(|&&p| p == value).count();
        assert!((45..=55).contains(&clipped(0)), "0.5 % black: {}", clipped(0));
        assert!((15..=25).contains(&clipped(u16::MAX)), "0.2 % white: {}", clipped(u16::MAX));
    }

    #[test]
    fn background_and_outliers_do_not_move_the_window() {
        let mut values: Vec<f32> = (0..10_000).map(|i| 1.0 + i as f32 * 1e-4).collect();
        let plain = radiograph(&[&values], 100, 100).unwrap();
        values.resize(20_000, 0.0);
        values[3] = 1e6;
        let other = radiograph(&[&values], 100, 200).unwrap();
        let (a, b) = (i32::from(plain.pixels[5000]), i32::from(other.pixels[5000]));
        assert!((a - b).abs() < 100, "{a} {b}");
        assert!(other.pixels[10_000..].iter().all(|&p| p == 0));
    }

    #[test]
    fn views_stand_side_by_side_and_share_one_window() {
        let (weak, strong) = ([1.0; 6], [3.0; 6]);
        let picture = radiograph(&[&weak, &strong], 3, 2).unwrap();
        assert_eq!((picture.width, picture.height), (3 + 2 + 3, 2));
        let row = [0, 0, 0, GAP, GAP, u16::MAX, u16::MAX, u16::MAX];
        assert_eq!(picture.pixels, [row, row].concat());
        assert_eq!(picture.to_gray8()[2..6], [0, 127, 127, 255]);
        let colour = picture.to_colour();
        assert_eq!((colour.width, colour.pixel(4, 0), colour.pixel(5, 1)), (8, [127; 3], [255; 3]));
    }

    #[test]
    fn pictures_without_contrast_are_grey_or_black() {
        assert_eq!(radiograph(&[&[0.0; 4]], 2, 2).unwrap().pixels, [0; 4]);
        assert_eq!(radiograph(&[&[f32::NAN, f32::INFINITY]], 2, 1).unwrap().pixels, [0, u16::MAX]);
        assert_eq!(radiograph(&[&[2.0, 0.0, 2.0, 2.0]], 2, 2).unwrap().pixels, [32768, 0, 32768, 32768]);
        let opaque = radiograph(&[&[1.0, 2.0, f32::INFINITY, -1.0]], 4, 1).unwrap();
        assert_eq!(opaque.pixels, [0, u16::MAX, u16::MAX, 0]);
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(radiograph(&[], 2, 2).is_err());
        assert!(radiograph(&[&[]], 0, 2).is_err());
        assert!(radiograph(&[&[0.0; 4], &[0.0; 3]], 2, 2).unwrap_err().to_string().contains("views[1]"));
    }
}
