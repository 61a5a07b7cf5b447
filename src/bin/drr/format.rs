//! The formats of image files. To add one: a variant, and what it is called, says and is written by.

use std::path::Path;

use anyhow::Result;
use clap::ValueEnum;
use drr::formats::{
    ExrImage, RtImage, SixteenBits, TiffPage, read_exr_metadata, read_png_texts, read_rt_image_description,
    read_tiff_metadata, write_exr, write_png_gray16, write_rt_image, write_tiff,
};

use crate::layer::{Channel, LayerName};
use crate::metadata::PREFIX;
use crate::views::NamedView;

/// A format that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// OpenEXR: all layers of a view in float32
    Exr,
    /// PNG: a file per layer, 16 bits; value = offset + scale * sample, both in its text chunks
    Png16,
    /// TIFF: all layers of a view as pages of float32, with a JSON object in ImageDescription
    Tiff,
    /// DICOM: line integrals as an RT Image of 16 bits with rescale slope and intercept, head up, as the source sees it
    Dicom,
}

/// A view, to be written.
pub(crate) struct ViewImage<'a> {
    pub(crate) view: &'a NamedView,
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    pub(crate) channels: &'a [Channel],
    /// Those of each channel.
    pub(crate) values: Vec<&'a [f32]>,
    /// What the file says, by name.
    pub(crate) metadata: Vec<(String, String)>,
}

impl<'a> ViewImage<'a> {
    fn layers(&self) -> impl Iterator<Item = (&'a Channel, &'a [f32])> {
        self.channels.iter().zip(self.values.iter().copied())
    }

    /// A UID for all that was made of the same (part 5 of DICOM, B.2).
    fn study(&self) -> Option<String> {
        let made_of = self.metadata.iter().find(|(name, _)| name.strip_prefix(PREFIX) == Some("made_of"));
        let number = u128::from_str_radix(&made_of?.1, 16).ok()?;
        Some(format!("2.25.{number}"))
    }

    fn write_dicom(&self, path: &Path, channel: &Channel, values: &[f32]) -> drr::Result<()> {
        let (pose, values) = self.view.seen_from_source(values, self.size[0]);
        let own = [("rows", "the head's first; left and right as the source sees them".into())];
        let (label, study) = (format!("view {}", self.view.number), self.study());
        let description = self.metadata_of(channel, &own);
        let image = RtImage {
            pose: &pose,
            size: self.size,
            line_integrals: &values,
            source_axis_mm: self.view.source_axis_mm,
            label: &label,
            number: self.view.number + 1,
            study: study.as_deref(),
            description: &description,
        };
        write_rt_image(path, &image)
    }

    /// What a file of one layer says beside what all say.
    fn metadata_of(&self, channel: &Channel, own: &[(&str, String)]) -> Vec<(String, String)> {
        let layer = [("layer", channel.name.clone()), ("unit", channel.layer.unit().to_owned())];
        let own = layer.into_iter().chain(own.iter().cloned());
        let own = own.map(|(name, value)| (format!("{PREFIX}{name}"), value));
        self.metadata.iter().cloned().chain(own).collect()
    }
}

impl Format {
    /// The files of a view in this format.
    pub(crate) fn files(self, view: &str, channels: &[Channel]) -> Vec<String> {
        match self {
            Self::Exr => vec![format!("{view}.exr")],
            Self::Png16 => channels.iter().map(|channel| format!("{view}_{}.png", channel.file)).collect(),
            Self::Tiff => vec![format!("{view}.tiff")],
            Self::Dicom => {
                let names = channels.iter().filter(|channel| channel.layer == LayerName::LineIntegral);
                names.map(|channel| format!("{view}_{}.dcm", channel.file)).collect()
            }
        }
    }

    /// The same in words.
    pub(crate) fn in_words(self, view: &str) -> String {
        match self {
            Self::Exr => format!("{view}.exr"),
            Self::Png16 => format!("{view}_LAYER.png"),
            Self::Tiff => format!("{view}.tiff"),
            Self::Dicom => format!("{view}_LAYER.dcm"),
        }
    }

    /// Writes [`Self::files`].
    pub(crate) fn write<'a>(self, folder: &Path, view: &str, image: &ViewImage<'a>) -> drr::Result<()> {
        let mut paths = self.files(view, image.channels).into_iter().map(|name| folder.join(name));
        let [width, height] = image.size;
        match self {
            Self::Exr => {
                let layers = image.layers().map(|(channel, values)| (channel.name.clone(), values)).collect();
                let exr = ExrImage { width, height, layers, metadata: image.metadata.clone() };
                paths.try_for_each(|path| write_exr(&path, &exr))
            }
            Self::Png16 => paths.zip(image.layers()).try_for_each(|(path, (channel, values))| {
                let SixteenBits { offset, scale, samples } = SixteenBits::of(values);
                let own = [
                    ("value", "offset + scale * sample; sample 65535 also where infinite".into()),
                    ("offset", offset.to_string()),
                    ("scale", scale.to_string()),
                ];
                write_png_gray16(&path, width, height, &samples, &image.metadata_of(channel, &own))
            }),
            Self::Tiff => {
                let page = |(channel, values): (&'a Channel, &'a [f32])| {
                    let description = image.metadata_of(channel, &[]);
                    TiffPage { name: channel.name.clone(), values, description }
                };
                let pages: Vec<_> = image.layers().map(page).collect();
                paths.try_for_each(|path| write_tiff(&path, image.size, &pages))
            }
            Self::Dicom => {
                let mut layers =
                    image.layers().filter(|(channel, _)| channel.layer == LayerName::LineIntegral);
                paths
                    .zip(&mut layers)
                    .try_for_each(|(path, (channel, values))| image.write_dicom(&path, channel, values))
            }
        }
    }

    /// Layers without which there is nothing to write.
    pub(crate) fn needs(self) -> Option<LayerName> {
        (self == Self::Dicom).then_some(LayerName::LineIntegral)
    }

    /// What a file in this format says, by name.
    pub(crate) fn metadata(self, path: &Path) -> Result<Vec<(String, String)>> {
        Ok(match self {
            Self::Exr => read_exr_metadata(path),
            Self::Png16 => read_png_texts(path),
            Self::Tiff => read_tiff_metadata(path),
            Self::Dicom => read_rt_image_description(path),
        }?)
    }
}
