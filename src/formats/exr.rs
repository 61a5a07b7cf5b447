//! OpenEXR: all layers of a view in one float32 file, and reading what it says about itself.

use std::io::{Cursor, Write};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, Layer, LayerAttributes, MetaData,
    Text, WritableImage,
};

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::replacement::Replacement;

/// The channels of one view and what is to be said about it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrImage<'a> {
    /// Columns of pixels.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Channels by name (`intensity`, `areal_density.bone`): width × height values each, pixel (i, j) at
    /// `j*width + i`, row 0 at the top.
    pub layers: Vec<(String, &'a [f32])>,
    /// Attributes of the file by name.
    pub metadata: Vec<(String, String)>,
}

/// Writes the image with lossless ZIP compression. The same image gives the same bytes.
pub fn write_exr(path: &Path, image: &ExrImage<'_>) -> Result<()> {
    let bytes = encode(path, image)?;
    let mut file = Replacement::create(path)?;
    file.write_all(&bytes).map_err(|e| file_error(path, e))?;
    file.commit()
}

/// Reads the texts among the attributes of a file, by name, without its pixels.
///
/// # Errors
/// `File` when it is no OpenEXR file.
pub fn read_exr_metadata(path: &Path) -> Result<Vec<(String, String)>> {
    let read = MetaData::read_from_file(path, false).map_err(|e| file_error(path, e))?;
    let attributes = read.headers.into_iter().flat_map(|header| header.own_attributes.other);
    let texts = attributes.filter_map(|(name, value)| match value {
        AttributeValue::Text(value) => Some((utf8(&name), utf8(&value))),
        _ => None,
    });
    Ok(texts.collect())
}

fn encode(path: &Path, image: &ExrImage<'_>) -> Result<Vec<u8>> {
    let size = (image.width, image.height);
    let mut attributes = LayerAttributes::default();
    for (name, value) in &image.metadata {
        let previous = attributes.other.insert(text(name)?, AttributeValue::Text(text(value)?));
        if previous.is_some() {
            return Err(Error::invalid("metadata", name, "names that differ"));
        }
    }
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels(image)?);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|e| file_error(path, e))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes).ok_or_else(|| file_error(path, "the header cannot be sorted"))?;
    Ok(bytes)
}

fn channels(image: &ExrImage<'_>) -> Result<AnyChannels<FlatSamples>> {
    let pixels = image.width.saturating_mul(image.height);
    if pixels == 0 || image.layers.is_empty() {
        let value = format!("{} x {}, {} layers", image.width, image.height, image.layers.len());
        return Err(Error::invalid("image", value, "at least one pixel and one layer"));
    }
    let mut channels = vec![];
    for (i, (name, values)) in image.layers.iter().enumerate() {
        if values.len() != pixels {
            return Err(Error::invalid(
                format!("layers[{i}] ({name})"),
                values.len(),
                format!("{pixels} values"),
            ));
        }
        if name.is_empty() || image.layers[..i].iter().any(|(other, _)| other == name) {
            return Err(Error::invalid(format!("layers[{i}]"), format!("\"{name}\""), "names that differ"));
        }
        channels.push(AnyChannel::new(text(name)?, FlatSamples::F32(values.to_vec())));
    }
    Ok(AnyChannels::sort(channels.into()))
}

/// UTF-8, as OpenEXR asks; the library itself would write Latin-1.
fn text(text: &str) -> Result<Text> {
    if text.contains('\0') {
        return Err(Error::invalid("text for OpenEXR", text.escape_debug(), "no NUL characters"));
    }
    Ok(Text::from_slice_unchecked(text.as_bytes()))
}

fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// Sorts the attributes of the header by name; the library writes them in an order that differs from run to run. Their
/// total length stays, so what follows keeps its place. `None` when the bytes are not such a header.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    const MAGIC_AND_VERSION: usize = 8;
    let zero = |from: usize| Some(from + file.get(from..)?.iter().position(|&b| b == 0)?);
    let mut attributes = vec![];
    let mut start = MAGIC_AND_VERSION;
    // name 0 type 0 size(4) value; an empty name ends the header.
    while *file.get(start)? != 0 {
        let value = zero(zero(start)? + 1)? + 5;
        let size = u32::from_le_bytes(file.get(value - 4..value)?.try_into().ok()?) as usize;
        attributes.push(file.get(start..value + size)?);
        start = value + size;
    }
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[MAGIC_AND_VERSION..start].copy_from_slice(&sorted);
    Some(())
}

#[cfg(test)]
mod tests {
    use exr::prelude::read_all_flat_layers_from_file;

    use super::*;

    const WIDTH: usize = 37;
    const HEIGHT: usize = 21; // more than one block of 16 rows

    fn example<'a>(intensity: &'a [f32], bone: &'a [f32]) -> ExrImage<'a> {
        let metadata = (0..8).map(|i| (format!("drr.key{i}"), format!("value {i} × µ"))).collect();
        let layers = vec![("intensity".to_owned(), intensity), ("areal_density.bone".to_owned(), bone)];
        ExrImage { width: WIDTH, height: HEIGHT, layers, metadata }
    }

    #[test]
    fn every_bit_comes_back_under_its_name() {
        let mut intensity: Vec<f32> = (0..WIDTH * HEIGHT).map(|i| (i as f32).exp2().recip()).collect();
        intensity[5] = f32::INFINITY;
        intensity[6] = -0.0;
        intensity[7] = f32::from_bits(0x7fc0_1234);
        let bone: Vec<f32> = (0..WIDTH * HEIGHT).map(|i| (i as f32).sin()).collect();
        let image = example(&intensity, &bone);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.exr");
        write_exr(&path, &image).unwrap();

        let read = read_all_flat_layers_from_file(&path).unwrap();
        assert_eq!(read.layer_data.len(), 1);
        let layer = &read.layer_data[0];
        assert_eq!((layer.size.0, layer.size.1), (WIDTH, HEIGHT));
        let names: Vec<String> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["areal_density.bone", "intensity"]);
        for (channel, expected) in layer.channel_data.list.iter().zip([&bone, &intensity]) {
            let FlatSamples::F32(values) = &channel.sample_data else { panic!("float32 was written") };
            assert!(values.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
        let mut metadata = read_exr_metadata(&path).unwrap();
        metadata.sort();
        assert_eq!(metadata, image.metadata);
        for (name, value) in &image.metadata {
            let attribute = &layer.attributes.other[&text(name).unwrap()];
            assert_eq!(*attribute, AttributeValue::Text(text(value).unwrap()));
        }
    }

    #[test]
    fn the_same_image_gives_the_same_bytes() {
        let values = vec![1.0; WIDTH * HEIGHT];
        let encode = || encode(Path::new("view.exr"), &example(&values, &values)).unwrap();
        let first = encode();
        assert!((0..4).all(|_| encode() == first));
    }

    #[test]
    fn wrong_images_are_refused_and_nothing_is_written() {
        type Damage = fn(&mut ExrImage<'_>);
        let values = vec![1.0; WIDTH * HEIGHT];
        let folder = tempfile::tempdir().unwrap();
        let cases: [(&str, Damage); 6] = [
            ("777 values", |i| i.layers[1].1 = &[]),
            ("differ", |i| i.layers[1].0 = "intensity".to_owned()),
            ("differ", |i| i.metadata[1].0 = "drr.key0".to_owned()),
            ("one pixel", |i| i.width = 0),
            ("one layer", |i| i.layers.clear()),
            ("NUL", |i| i.metadata[0].1 = "a\0b".to_owned()),
        ];
        for (word, damage) in cases {
            let mut image = example(&values, &values);
            damage(&mut image);
            let message = write_exr(&folder.path().join("view.exr"), &image).unwrap_err().to_string();
            assert!(message.contains(word), "{word}: {message}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn text_is_utf8() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.exr");
        let values = vec![0.5; WIDTH * HEIGHT];
        let mut image = example(&values, &values);
        image.metadata[0].1 = "α × β, g/cm²".to_owned();
        image.layers[1].0 = "areal_density.Knöchel".to_owned();
        write_exr(&path, &image).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for text in ["α × β, g/cm²", "areal_density.Knöchel\0"] {
            assert!(bytes.windows(text.len()).any(|window| window == text.as_bytes()), "{text}");
        }
    }
}
