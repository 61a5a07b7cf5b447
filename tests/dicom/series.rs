//! Series that the tests write, with what a scanner would write, and what it should not.

use std::path::Path;

use dicom_core::value::DataSetSequence;
use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject};
use glam::DVec3;

pub(crate) const SERIES: &str = "1.2.3.4.5";

/// A slice as an attribute set; tests change what they are about.
#[derive(Clone)]
pub(crate) struct Image {
    pub(crate) object: InMemDicomObject,
}

/// A field that is linear in the place, HU.
pub(crate) fn field(place: DVec3) -> f64 {
    (40.0 + DVec3::new(3.0, -7.0, 5.0).dot(place)).round()
}

/// How the slices of a series lie.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    pub(crate) columns: u16,
    pub(crate) rows: u16,
    pub(crate) origin: DVec3,
    /// Unit vectors along a row and along a column.
    pub(crate) directions: [DVec3; 2],
    /// Distances of columns and of rows, mm.
    pub(crate) spacing: [f64; 2],
}

pub(crate) const AXIAL: Layout = Layout {
    columns: 5,
    rows: 4,
    origin: DVec3::new(-10.0, 20.0, -30.0),
    directions: [DVec3::X, DVec3::Y],
    spacing: [0.5, 2.0],
};

impl Layout {
    /// The places of all pixels of a slice that is `shift` from the origin.
    pub(crate) fn places(&self, shift: DVec3) -> impl Iterator<Item = DVec3> + use<> {
        let Self { columns, rows, origin, directions: [row, column], spacing: [dx, dy] } = *self;
        (0..rows).flat_map(move |j| {
            (0..columns).map(move |i| origin + shift + f64::from(i) * dx * row + f64::from(j) * dy * column)
        })
    }

    /// A slice of the field: signed 16 bits, intercept −1024.
    pub(crate) fn slice(&self, shift: DVec3) -> Image {
        let pixels: Vec<u16> =
            self.places(shift).map(|place| (field(place) + 1024.0) as i16 as u16).collect();
        let mut image = Image { object: InMemDicomObject::new_empty() };
        let [row, column] = self.directions;
        image
            .text(tags::SOP_CLASS_UID, VR::UI, uids::CT_IMAGE_STORAGE)
            .text(tags::SOP_INSTANCE_UID, VR::UI, "1.2.3.4.5.6")
            .text(tags::IMAGE_TYPE, VR::CS, "ORIGINAL\\PRIMARY\\AXIAL")
            .text(tags::MODALITY, VR::CS, "CT")
            .text(tags::SERIES_INSTANCE_UID, VR::UI, SERIES)
            .text(tags::SERIES_DESCRIPTION, VR::LO, "THORAX 2.0")
            .text(tags::SLICE_THICKNESS, VR::DS, "7.5")
            .text(tags::SPACING_BETWEEN_SLICES, VR::DS, "7.5")
            .numbers(tags::IMAGE_POSITION_PATIENT, &(self.origin + shift).to_array())
            .numbers(tags::IMAGE_ORIENTATION_PATIENT, &[row.to_array(), column.to_array()].concat())
            .numbers(tags::PIXEL_SPACING, &[self.spacing[1], self.spacing[0]])
            .text(tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "MONOCHROME2")
            .word(tags::SAMPLES_PER_PIXEL, 1)
            .word(tags::ROWS, self.rows)
            .word(tags::COLUMNS, self.columns)
            .word(tags::BITS_ALLOCATED, 16)
            .word(tags::BITS_STORED, 16)
            .word(tags::HIGH_BIT, 15)
            .word(tags::PIXEL_REPRESENTATION, 1)
            .numbers(tags::RESCALE_SLOPE, &[1.0])
            .numbers(tags::RESCALE_INTERCEPT, &[-1024.0])
            .pixels(pixels);
        image
    }

    /// Slices at these distances from the first along z.
    pub(crate) fn stack(&self, distances: &[f64]) -> Vec<Image> {
        distances.iter().map(|&z| self.slice(DVec3::Z * z)).collect()
    }
}

impl Image {
    pub(crate) fn text(&mut self, tag: Tag, vr: VR, text: &str) -> &mut Self {
        self.object.put(DataElement::new(tag, vr, PrimitiveValue::from(text)));
        self
    }

    pub(crate) fn numbers(&mut self, tag: Tag, numbers: &[f64]) -> &mut Self {
        let text: Vec<_> = numbers.iter().map(ToString::to_string).collect();
        self.text(tag, VR::DS, &text.join("\\"))
    }

    pub(crate) fn word(&mut self, tag: Tag, word: u16) -> &mut Self {
        self.object.put(DataElement::new(tag, VR::US, PrimitiveValue::from(word)));
        self
    }

    pub(crate) fn pixels(&mut self, pixels: Vec<u16>) -> &mut Self {
        self.object.put(DataElement::new(tags::PIXEL_DATA, VR::OW, PrimitiveValue::U16(pixels.into())));
        self
    }

    /// The stored pixels, each changed.
    pub(crate) fn map(&mut self, change: impl Fn(usize, u16) -> u16) -> &mut Self {
        let pixels = self.object.element(tags::PIXEL_DATA).expect("there").to_multi_int().expect("words");
        self.pixels(pixels.into_iter().enumerate().map(|(n, pixel)| change(n, pixel)).collect())
    }

    pub(crate) fn sequence(&mut self, tag: Tag, items: Vec<Image>) -> &mut Self {
        let items: Vec<_> = items.into_iter().map(|item| item.object).collect();
        self.object.put(DataElement::new(tag, VR::SQ, DataSetSequence::from(items)));
        self
    }

    pub(crate) fn without(&mut self, tag: Tag) -> &mut Self {
        self.object.remove_element(tag);
        self
    }

    /// An item of a sequence with these attributes of this image, which loses them.
    pub(crate) fn moved(&mut self, moved: &[Tag]) -> Image {
        let mut item = Image { object: InMemDicomObject::new_empty() };
        for &tag in moved {
            item.object.put(self.object.take(tag).expect("there"));
        }
        item
    }

    pub(crate) fn save(&self, path: &Path, transfer_syntax: &str) {
        let meta = FileMetaTableBuilder::new()
            .transfer_syntax(transfer_syntax)
            .media_storage_sop_class_uid(uids::CT_IMAGE_STORAGE)
            .media_storage_sop_instance_uid("1.2.3.4.5.6");
        let file = self.object.clone().with_meta(meta).expect("valid");
        file.write_to_file(path).expect("written");
    }
}

/// A folder with the images, by number.
pub(crate) fn folder(images: &[Image]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (n, image) in images.iter().enumerate() {
        image.save(&folder.path().join(format!("im{n}.dcm")), uids::EXPLICIT_VR_LITTLE_ENDIAN);
    }
    folder
}
