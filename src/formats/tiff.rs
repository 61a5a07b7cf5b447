//! TIFF: the layers of a view as pages of float32, and reading what they say about themselves.

use std::io::{Seek, Write};
use std::path::Path;

use tiff::TiffResult;
use tiff::decoder::Decoder;
use tiff::encoder::{TiffEncoder, TiffKind, colortype::Gray32Float};
use tiff::tags::Tag;

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::json_texts::{from_json, to_json};
use crate::formats::replacement::Replacement;

/// `PageName` of TIFF 6.0, section 12.
const PAGE_NAME: Tag = Tag::Unknown(285);
/// Bytes of pixels up to which offsets of 32 bits reach everything; beyond, the file is a `BigTIFF`.
const SMALL: usize = 0xf000_0000;

/// A layer of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct TiffPage<'a> {
    /// `PageName`; characters beyond ASCII, which TIFF's texts lack, become `_`.
    pub name: String,
    /// Width × height values, pixel (i, j) at `j*width + i`, row 0 at the top.
    pub values: &'a [f32],
    /// What is to be said about it, by names that differ: `ImageDescription` has it as a JSON object of texts, sorted by name.
    pub description: Vec<(String, String)>,
}

/// Writes the pages, width × height pixels each, uncompressed. The same pages give the same bytes.
pub fn write_tiff(path: &Path, size: [usize; 2], pages: &[TiffPage<'_>]) -> Result<()> {
    let pixels = check(size, pages)?;
    let descriptions = pages.iter().map(|page| to_json(&page.description)).collect::<Result<Vec<_>>>()?;
    let columns_and_rows = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let mut file = Replacement::create(path)?;
    let written = if pixels.saturating_mul(4 * pages.len()) <= SMALL {
        TiffEncoder::new(&mut file).and_then(|encoder| write(encoder, columns_and_rows, pages, &descriptions))
    } else {
        TiffEncoder::new_big(&mut file)
            .and_then(|encoder| write(encoder, columns_and_rows, pages, &descriptions))
    };
    written.map_err(|e| file_error(path, e))?;
    file.commit()
}

/// Reads what the first page's `ImageDescription` says, by name, without pixels.
///
/// # Errors
/// `File` when it is no TIFF file, or its description no JSON object of texts.
pub fn read_tiff_metadata(path: &Path) -> Result<Vec<(String, String)>> {
    let file = std::fs::File::open(path).map_err(|e| file_error(path, e))?;
    let mut decoder = Decoder::new(std::io::BufReader::new(file)).map_err(|e| file_error(path, e))?;
    let text = decoder.get_tag_ascii_string(Tag::ImageDescription).map_err(|e| file_error(path, e))?;
    from_json(&text).map_err(|e| file_error(path, e))
}

/// The number of pixels.
fn check(size: [usize; 2], pages: &[TiffPage<'_>]) -> Result<usize> {
    let pixels = size[0].saturating_mul(size[1]);
    let most = i32::MAX as usize;
    if pixels == 0 || pages.is_empty() || size.iter().any(|&side| side > most) {
        let value = format!("{} x {}, {} pages", size[0], size[1], pages.len());
        return Err(Error::invalid(
            "image",
            value,
            format!("sides of 1 … {most} pixels and at least one page"),
        ));
    }
    for (i, page) in pages.iter().enumerate() {
        if page.values.len() != pixels {
            let argument = format!("pages[{i}] ({})", page.name);
            return Err(Error::invalid(argument, page.values.len(), format!("{pixels} values")));
        }
    }
    Ok(pixels)
}

fn write<W: Write + Seek, K: TiffKind>(
    mut encoder: TiffEncoder<W, K>,
    [columns, rows]: [u32; 2],
    pages: &[TiffPage<'_>],
    descriptions: &[String],
) -> TiffResult<()> {
    for (page, description) in pages.iter().zip(descriptions) {
        let mut image = encoder.new_image::<Gray32Float>(columns, rows)?;
        image.encoder().write_tag(PAGE_NAME, ascii(&page.name).as_str())?;
        image.encoder().write_tag(Tag::ImageDescription, description.as_str())?;
        image.write_data(page.values)?;
    }
    Ok(())
}

fn ascii(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use tiff::decoder::DecodingResult;

    use super::*;

    const SIZE: [usize; 2] = [37, 21];

    fn page<'a>(name: &str, values: &'a [f32]) -> TiffPage<'a> {
        let description = vec![("unit".into(), "g/cm² \u{1d707}".into()), ("layer".into(), name.into())];
        TiffPage { name: name.into(), values, description }
    }

    #[test]
    fn every_bit_and_every_text_comes_back() {
        let mut first: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| (i as f32).sin()).collect();
        [first[5], first[6], first[7]] = [f32::INFINITY, -0.0, f32::from_bits(0x7fc0_1234)];
        let second = vec![2.5; first.len()];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.tiff");
        let pages = [page("intensity", &first), page("areal_density.Knöchel", &second)];
        write_tiff(&path, SIZE, &pages).unwrap();
        assert_eq!(
            read_tiff_metadata(&path).unwrap(),
            [("layer", "intensity"), ("unit", "g/cm² \u{1d707}")].map(|(a, b)| (a.to_owned(), b.to_owned()))
        );
        let file = std::fs::File::open(&path).unwrap();
        let mut decoder = Decoder::new(std::io::BufReader::new(file)).unwrap();
        for (n, (page, name)) in pages.iter().zip(["intensity", "areal_density.Kn_chel"]).enumerate() {
            assert_eq!(decoder.dimensions().unwrap(), (37, 21));
            assert_eq!(decoder.get_tag_ascii_string(PAGE_NAME).unwrap(), name);
            let DecodingResult::F32(values) = decoder.read_image().unwrap() else {
                panic!("float32 was written")
            };
            assert!(values.iter().zip(page.values).all(|(a, b)| a.to_bits() == b.to_bits()));
            assert_eq!(decoder.more_images(), n == 0);
            if n == 0 {
                decoder.next_image().unwrap();
            }
        }
        let bytes = std::fs::read(&path).unwrap();
        write_tiff(&path, SIZE, &pages).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }

    #[test]
    fn wrong_pages_are_refused_and_nothing_is_written() {
        let values = vec![1.0; SIZE[0] * SIZE[1]];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.tiff");
        let twice = TiffPage { description: vec![("a".into(), "1".into()); 2], ..page("p", &values) };
        let cases: [(&str, [usize; 2], &[TiffPage<'_>]); 5] = [
            ("at least one page", SIZE, &[]),
            ("1 … 2147483647 pixels", [0, 21], &[page("p", &[])]),
            ("1 … 2147483647 pixels", [usize::MAX, 2], &[page("p", &values)]),
            ("777 values", SIZE, &[page("p", &values), page("q", &[])]),
            ("names that differ", SIZE, &[twice]),
        ];
        for (words, size, pages) in cases {
            let message = write_tiff(&path, size, pages).unwrap_err().to_string();
            assert!(message.contains(words), "{words}: {message}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        std::fs::write(&path, "II*\0").unwrap();
        assert!(read_tiff_metadata(&path).unwrap_err().to_string().contains("view.tiff"));
    }
}
