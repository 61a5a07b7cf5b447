//! Letters as pixels.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster};

/// The letters of a text of this height (of lines, pixels), from left to right.
pub(super) fn glyphs(text: &str, height: f64, bold: bool) -> impl Iterator<Item = RasterizedChar> {
    let weight = if bold { FontWeight::Bold } else { FontWeight::Regular };
    let size = match height {
        ..18.0 => RasterHeight::Size16,
        ..22.0 => RasterHeight::Size20,
        _ => RasterHeight::Size24,
    };
    text.chars().filter_map(move |letter| {
        let drawn = get_raster(letter, weight, size).or_else(|| get_raster(plain(letter), weight, size));
        drawn.or_else(|| get_raster('?', weight, size))
    })
}

/// Width and height of a text, pixels.
pub(super) fn text_size(text: &str, height: f64, bold: bool) -> [i32; 2] {
    glyphs(text, height, bold)
        .fold([0, 0], |[width, _], glyph| [width + glyph.width() as i32, glyph.height() as i32])
}

/// A letter of the font in place of one that it lacks.
fn plain(letter: char) -> char {
    match letter {
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        '\u{2018}' | '\u{2019}' => '\'',
        '\u{201c}' | '\u{201d}' => '"',
        '\u{3bc}' => '\u{b5}',
        letter if letter.is_whitespace() => ' ',
        _ => '?',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_that_the_font_lacks_have_a_stand_in() {
        let ink = |text| glyphs(text, 16.0, false).map(|glyph| glyph.pixels().to_vec()).collect::<Vec<_>>();
        assert_eq!(ink("1 \u{2212} 2"), ink("1 - 2"));
        assert_eq!(ink("\u{6f22}"), ink("?"));
        assert_ne!(ink("\u{bd}"), ink("?"), "the march's half voxel");
    }

    #[test]
    fn the_size_grows_with_the_text() {
        let [width, height] = text_size("ab", 16.0, false);
        assert_eq!(text_size("abcd", 16.0, false), [2 * width, height]);
        assert_eq!(text_size("", 16.0, false)[0], 0);
        assert!(text_size("ab", 20.0, true)[1] > height);
        assert!(text_size("ab", 24.0, true)[1] > text_size("ab", 20.0, true)[1]);
    }
}
