//! Writing a radiograph as an RT Image (part 3, A.17): line integrals with their geometry.

use std::path::Path;

use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject, OpenFileOptions};
use glam::DVec3;

use crate::error::{Error, Result};
use crate::formats::file_error;
use crate::formats::json_texts::{from_json, to_json};
use crate::formats::replacement::Replacement;
use crate::geometry::{DetectorPose, PatientOrientation};

/// Largest stored number.
const LARGEST: f64 = 65535.0;
/// Longest side: the number of rows has 16 bits.
const LARGEST_SIDE: usize = 65535;
/// Longest text of a short string.
const LONGEST_LABEL: usize = 16;
/// Longest long text.
const LONGEST_TEXT: usize = 10240;
/// Largest cosine between rows and columns: pixels of an image are rectangles.
const LARGEST_SKEW: f64 = 1e-6;

/// A radiograph of a patient.
#[derive(Debug, Clone, Copy)]
pub struct RtImage<'a> {
    /// Source and detector, mm in LPS; columns and rows at right angles, to the right and downwards as seen from the source.
    pub pose: &'a DetectorPose,
    /// Columns and rows.
    pub size: [usize; 2],
    /// −ln(I/I₀) of every pixel, pixel (i, j) at `j*columns + i`; where it is infinite the largest finite one is stored.
    pub line_integrals: &'a [f32],
    /// Distance from the source to the axis that it turns about, mm; none where it does not turn.
    pub source_axis_mm: Option<f64>,
    /// A name of 1 to 16 characters of ASCII, without `\`.
    pub label: &'a str,
    /// `InstanceNumber`: its number in the series.
    pub number: usize,
    /// The `StudyInstanceUID` that the image belongs to; images with one are one series. None for one of its own.
    pub study: Option<&'a str>,
    /// What is to be said about it, by names that differ: `ImageComments` has it as a JSON object of texts, sorted by name, of at
    /// most 10240 characters.
    pub description: &'a [(String, String)],
}

/// Writes an RT Image, which is DERIVED\SECONDARY\DRR: 16 bits to a pixel, of which the rescale slope and intercept make line
/// integrals again, with an error of at most half a slope: 1/131070 of their range. The same image has the same UIDs.
///
/// # Errors
/// `InvalidArgument` for a size, a label or a pose that an RT Image cannot hold, and for values that are NaN or −∞; `File`.
pub fn write_rt_image(path: &Path, image: &RtImage<'_>) -> Result<()> {
    let samples = Samples::new(image)?;
    let object = object(image, &samples)?;
    let failed = |e: &dyn std::fmt::Display| file_error(path, e);
    let meta = FileMetaTableBuilder::new()
        .transfer_syntax(uids::EXPLICIT_VR_LITTLE_ENDIAN)
        .media_storage_sop_class_uid(uids::RT_IMAGE_STORAGE)
        .media_storage_sop_instance_uid(samples.uid("instance"));
    let file = object.with_meta(meta).map_err(|e| failed(&e))?;
    let mut to = Replacement::create(path)?;
    file.write_all(&mut to).map_err(|e| failed(&e))?;
    to.commit()
}

/// Reads the description of an RT Image that [`write_rt_image`] has written, without pixels.
///
/// # Errors
/// `File` when it is no DICOM file, or its `ImageComments` no JSON object of texts.
pub fn read_rt_image_description(path: &Path) -> Result<Vec<(String, String)>> {
    let object = OpenFileOptions::new().read_until(tags::PIXEL_DATA).open_file(path);
    let object = object.map_err(|e| file_error(path, e))?;
    let comments = object.element(tags::IMAGE_COMMENTS).map_err(|e| file_error(path, e))?;
    let comments = comments.to_str().map_err(|e| file_error(path, e))?;
    from_json(&comments).map_err(|e| file_error(path, e))
}

/// The pixels as they are stored.
struct Samples {
    pixels: Vec<u16>,
    slope: String,
    intercept: String,
    hash: u128,
}

impl Samples {
    fn new(image: &RtImage<'_>) -> Result<Self> {
        let values = image.line_integrals;
        let [columns, rows] = image.size;
        if ![columns, rows].iter().all(|side| (1..=LARGEST_SIDE).contains(side)) {
            let valid = format!("1 … {LARGEST_SIDE} a side");
            return Err(Error::invalid("size", format!("{columns} x {rows}"), valid));
        }
        if values.len() != columns * rows {
            return Err(Error::invalid("line_integrals.len()", values.len(), format!("{columns} x {rows}")));
        }
        if let Some(index) = values.iter().position(|value| value.is_nan() || *value == f32::NEG_INFINITY) {
            let valid = "a number, or +infinity";
            return Err(Error::invalid(format!("line_integrals[{index}]"), values[index], valid));
        }
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let [low, high] =
            [finite().reduce(f32::min), finite().reduce(f32::max)].map(Option::unwrap_or_default);
        // As they are written, with at most 16 characters: stored numbers are those of the rounded ones.
        let intercept = format!("{:.8e}", f64::from(low));
        let range = f64::from(high) - number(&intercept);
        let slope = format!("{:.8e}", if range > 0.0 { range / LARGEST } else { 1.0 });
        let store = |&value: &f32| {
            ((f64::from(value) - number(&intercept)) / number(&slope)).round().clamp(0.0, LARGEST) as u16
        };
        let pixels: Vec<u16> = values.iter().map(store).collect();
        let place = format!("{:?} {} {} {:?}", image.pose, image.number, image.label, image.study);
        let bytes = pixels.iter().flat_map(|pixel| pixel.to_le_bytes()).chain(place.bytes());
        let hash = fnv1a(bytes.chain(slope.bytes()).chain(intercept.bytes()));
        Ok(Self { pixels, slope, intercept, hash })
    }

    /// A UID from the content (part 5, B.2).
    fn uid(&self, part: &str) -> String {
        uid(part.bytes().chain(self.hash.to_le_bytes()))
    }
}

fn uid(content: impl Iterator<Item = u8>) -> String {
    format!("2.25.{}", fnv1a(content))
}

/// The number of a text that was made of one.
fn number(text: &str) -> f64 {
    text.parse().unwrap_or_default()
}

/// Fowler, Noll and Vo's hash 1a of 128 bits (RFC 9923).
fn fnv1a(bytes: impl Iterator<Item = u8>) -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = (1 << 88) + 0x13b;
    bytes.fold(BASIS, |hash, byte| (hash ^ u128::from(byte)).wrapping_mul(PRIME))
}

/// Where the detector is, seen from the source (part 3, C.8.8.2).
struct Plane {
    /// From the source to the detector's plane, mm.
    distance: f64,
    /// Of the first pixel from where the beam's axis meets the plane, to the right and upwards, mm.
    position: [f64; 2],
}

impl Plane {
    fn new(pose: &DetectorPose) -> Result<Self> {
        pose.validate()?;
        let wrong = |valid: &str| {
            let steps = format!("{} and {}", pose.column_step, pose.row_step);
            Err(Error::invalid("column_step and row_step", steps, valid))
        };
        let [along_row, along_column] = [pose.column_step, pose.row_step].map(DVec3::normalize);
        if along_row.dot(along_column).abs() > LARGEST_SKEW {
            return wrong("at right angles");
        }
        // The beam's axis is at right angles to the detector, so the plane is NORMAL whatever part of it the detector has.
        let normal = along_row.cross(along_column);
        let distance = normal.dot(pose.first_pixel - pose.source);
        if distance <= 0.0 {
            return wrong("to the right and downwards as seen from the source; reverse rows or columns");
        }
        let first = pose.first_pixel - (pose.source + distance * normal);
        // y is upwards, where rows run down (C.8.8.2.2).
        Ok(Self { distance, position: [first.dot(along_row), -first.dot(along_column)] })
    }
}

fn object(image: &RtImage<'_>, samples: &Samples) -> Result<InMemDicomObject> {
    let RtImage { pose, size: [columns, rows], label, study, .. } = *image;
    let Plane { distance, position } = Plane::new(pose)?;
    if !(1..=LONGEST_LABEL).contains(&label.len())
        || !label.bytes().all(|b| (b' '..=b'~').contains(&b) && b != b'\\')
    {
        return Err(Error::invalid("label", label, "1 to 16 characters of ASCII, without \\"));
    }
    let orientation = PatientOrientation::of(pose).to_string();
    let spacing = [pose.row_step.length(), pose.column_step.length()];
    let comments = to_json(image.description)?;
    if comments.len() > LONGEST_TEXT {
        let valid = format!("at most {LONGEST_TEXT} characters in JSON");
        return Err(Error::invalid("description", format!("{} characters", comments.len()), valid));
    }
    let mut object = InMemDicomObject::new_empty();
    let mut put = |tag: Tag, vr: VR, value: PrimitiveValue| _ = object.put(DataElement::new(tag, vr, value));
    let own_study = samples.uid("study");
    let study = study.unwrap_or(&own_study);
    let number = image.number.to_string();
    for (tag, vr, text) in [
        (tags::SOP_CLASS_UID, VR::UI, uids::RT_IMAGE_STORAGE),
        (tags::SOP_INSTANCE_UID, VR::UI, &samples.uid("instance")),
        (tags::STUDY_INSTANCE_UID, VR::UI, study),
        (tags::SERIES_INSTANCE_UID, VR::UI, &uid("series ".bytes().chain(study.bytes()))),
        (tags::IMAGE_TYPE, VR::CS, "DERIVED\\SECONDARY\\DRR"),
        (tags::MODALITY, VR::CS, "RTIMAGE"),
        (tags::CONVERSION_TYPE, VR::CS, "WSD"),
        (tags::MANUFACTURER_MODEL_NAME, VR::LO, "drr"),
        (tags::SOFTWARE_VERSIONS, VR::LO, crate::VERSION),
        (tags::INSTANCE_NUMBER, VR::IS, &number),
        (tags::PATIENT_ORIENTATION, VR::CS, &orientation),
        (tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "MONOCHROME2"),
        (tags::RESCALE_INTERCEPT, VR::DS, &samples.intercept),
        (tags::RESCALE_SLOPE, VR::DS, &samples.slope),
        (tags::RESCALE_TYPE, VR::LO, "US"),
        (tags::RT_IMAGE_LABEL, VR::SH, label),
        (
            tags::RT_IMAGE_DESCRIPTION,
            VR::ST,
            "line integrals: -ln of the intensity relative to that without a patient",
        ),
        (tags::IMAGE_COMMENTS, VR::LT, &comments),
        (tags::RT_IMAGE_PLANE, VR::CS, "NORMAL"),
    ] {
        put(tag, vr, PrimitiveValue::from(text));
    }
    for (tag, numbers) in [
        (tags::IMAGE_PLANE_PIXEL_SPACING, &spacing[..]),
        (tags::RT_IMAGE_POSITION, &position),
        (tags::RADIATION_MACHINE_SAD, image.source_axis_mm.as_slice()),
        (tags::RT_IMAGE_SID, &[distance]),
    ] {
        let text: Vec<_> = numbers.iter().map(|number| decimal(*number)).collect();
        put(tag, VR::DS, PrimitiveValue::from(text.join("\\")));
    }
    for (tag, word) in [
        (tags::SAMPLES_PER_PIXEL, 1),
        (tags::ROWS, rows as u16),
        (tags::COLUMNS, columns as u16),
        (tags::BITS_ALLOCATED, 16),
        (tags::BITS_STORED, 16),
        (tags::HIGH_BIT, 15),
        (tags::PIXEL_REPRESENTATION, 0),
    ] {
        put(tag, VR::US, PrimitiveValue::from(word));
    }
    // Attributes that must be there, but may be unknown.
    for (tag, vr) in [
        (tags::STUDY_DATE, VR::DA),
        (tags::STUDY_TIME, VR::TM),
        (tags::ACCESSION_NUMBER, VR::SH),
        (tags::MANUFACTURER, VR::LO),
        (tags::REFERRING_PHYSICIAN_NAME, VR::PN),
        (tags::OPERATORS_NAME, VR::PN),
        (tags::PATIENT_NAME, VR::PN),
        (tags::PATIENT_ID, VR::LO),
        (tags::PATIENT_BIRTH_DATE, VR::DA),
        (tags::PATIENT_SEX, VR::CS),
        (tags::STUDY_ID, VR::SH),
        (tags::SERIES_NUMBER, VR::IS),
        (tags::X_RAY_IMAGE_RECEPTOR_ANGLE, VR::DS),
        (tags::RADIATION_MACHINE_NAME, VR::SH),
        (tags::PRIMARY_DOSIMETER_UNIT, VR::CS),
    ] {
        put(tag, vr, PrimitiveValue::Empty);
    }
    put(tags::PIXEL_DATA, VR::OW, PrimitiveValue::U16(samples.pixels.as_slice().into()));
    Ok(object)
}

/// A decimal string: at most 16 characters, to the last digit that is worth something in mm.
fn decimal(number: f64) -> String {
    let plain = format!("{:.6}", number + 0.0);
    let plain = plain.trim_end_matches('0').trim_end_matches('.').to_owned();
    if plain.len() <= 16 { plain } else { format!("{number:.8e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A C-arm's, with the head up.
    fn pose() -> DetectorPose {
        let pose = DetectorPose::c_arm(DVec3::new(10.0, -20.0, 30.0), 0.0, 1000.0, 1500.0, 0.8, [5, 4]);
        DetectorPose { first_pixel: pose.first_pixel + 3.0 * pose.row_step, row_step: -pose.row_step, ..pose }
    }

    fn image<'a>(pose: &'a DetectorPose, line_integrals: &'a [f32]) -> RtImage<'a> {
        RtImage {
            pose,
            size: [5, 4],
            line_integrals,
            source_axis_mm: Some(1000.0),
            label: "left",
            number: 7,
            study: None,
            description: &[],
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let values: Vec<f32> = (0..20).map(|n| 0.37 * n as f32 - 0.5).collect();
        let (folder, pose) = (tempfile::tempdir().unwrap(), pose());
        let path = folder.path().join("left.dcm");
        write_rt_image(&path, &image(&pose, &values)).unwrap();
        let object = dicom_object::open_file(&path).unwrap();
        let decimals = |tag| object.element(tag).unwrap().to_multi_float64().unwrap();
        let (slope, intercept) = (decimals(tags::RESCALE_SLOPE)[0], decimals(tags::RESCALE_INTERCEPT)[0]);
        let pixels: Vec<u16> = object.element(tags::PIXEL_DATA).unwrap().to_multi_int().unwrap();
        assert_eq!((pixels[0], pixels[19]), (0, 65535), "the whole range is used");
        for (&pixel, &value) in pixels.iter().zip(&values) {
            assert!(
                (f64::from(pixel) * slope + intercept - f64::from(value)).abs() <= 0.51 * slope,
                "{value}"
            );
        }
        assert_eq!(decimals(tags::IMAGE_PLANE_PIXEL_SPACING), [0.8, 0.8]);
        // The detector is centred on the central ray: its first pixel is left and above.
        assert_eq!(decimals(tags::RT_IMAGE_POSITION), [-1.6, 1.2]);
        assert_eq!(
            (decimals(tags::RADIATION_MACHINE_SAD), decimals(tags::RT_IMAGE_SID)),
            (vec![1000.0], vec![1500.0])
        );
        // Columns run along x, to the left of the patient, and rows against z, to the feet.
        assert_eq!(object.element(tags::PATIENT_ORIENTATION).unwrap().to_str().unwrap(), "L\\F");
        let uid = object.element(tags::SOP_INSTANCE_UID).unwrap().to_str().unwrap().into_owned();
        assert_eq!(object.meta().media_storage_sop_instance_uid(), uid);
        assert!(uid.len() <= 64);
        let other = folder.path().join("other.dcm");
        let moved = DetectorPose { source: pose.source + DVec3::X, ..pose };
        write_rt_image(&other, &image(&moved, &values)).unwrap();
        let other = dicom_object::open_file(&other).unwrap();
        assert_ne!(other.element(tags::SOP_INSTANCE_UID).unwrap().to_str().unwrap(), uid.as_str());
        assert_ne!(other.element(tags::RT_IMAGE_POSITION).unwrap().to_multi_float64().unwrap(), [-1.6, 1.2]);
    }

    #[test]
    fn where_no_photon_came_the_largest_number_is_stored() {
        let (folder, pose) = (tempfile::tempdir().unwrap(), pose());
        let mut values = [0.5; 20];
        [values[3], values[4]] = [2.0, f32::INFINITY];
        let path = folder.path().join("dark.dcm");
        write_rt_image(&path, &image(&pose, &values)).unwrap();
        let pixels: Vec<u16> = dicom_object::open_file(&path)
            .unwrap()
            .element(tags::PIXEL_DATA)
            .unwrap()
            .to_multi_int()
            .unwrap();
        assert_eq!(pixels[2..6], [0, 65535, 65535, 0]);
    }

    #[test]
    fn images_of_a_study_are_one_series() {
        let (folder, pose) = (tempfile::tempdir().unwrap(), pose());
        let uids = [0.1, 0.2].map(|value| {
            let path = folder.path().join("view.dcm");
            write_rt_image(&path, &RtImage { study: Some("2.25.17"), ..image(&pose, &[value; 20]) }).unwrap();
            let object = dicom_object::open_file(&path).unwrap();
            [tags::STUDY_INSTANCE_UID, tags::SERIES_INSTANCE_UID, tags::SOP_INSTANCE_UID]
                .map(|tag| object.element(tag).unwrap().to_str().unwrap().into_owned())
        });
        assert_eq!((&uids[0][..2], &uids[0][0][..]), (&uids[1][..2], "2.25.17"));
        assert_ne!(uids[0][2], uids[1][2]);
    }

    #[test]
    fn a_constant_image_is_itself_and_every_text_comes_back() {
        let (folder, pose) = (tempfile::tempdir().unwrap(), pose());
        let path = folder.path().join("flat.dcm");
        let description =
            [("areal", "g/cm² \u{1d707}\\"), ("view", "left")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        let flat = RtImage { description: &description, ..image(&pose, &[0.25; 20]) };
        write_rt_image(&path, &flat).unwrap();
        assert_eq!(read_rt_image_description(&path).unwrap(), description);
        let object = dicom_object::open_file(&path).unwrap();
        let pixels: Vec<u16> = object.element(tags::PIXEL_DATA).unwrap().to_multi_int().unwrap();
        assert_eq!(pixels, [0; 20]);
        assert_eq!(object.element(tags::RESCALE_INTERCEPT).unwrap().to_float64().unwrap(), 0.25);
    }

    #[test]
    fn what_cannot_be_held_is_refused_and_nothing_written() {
        let (folder, pose) = (tempfile::tempdir().unwrap(), pose());
        let values = [0.0; 20];
        let mut infinite = values;
        infinite[7] = f32::NEG_INFINITY;
        let mirrored = DetectorPose { column_step: -pose.column_step, ..pose };
        let skewed = DetectorPose { row_step: pose.row_step + 0.1 * pose.column_step, ..pose };
        let valid = image(&pose, &values);
        let long = [("name".to_owned(), "x".repeat(10240))];
        for (image, words) in [
            (RtImage { line_integrals: &infinite, ..valid }, "line_integrals[7] is -inf"),
            (RtImage { line_integrals: &values[..19], ..valid }, "line_integrals.len() is 19; valid: 5 x 4"),
            (RtImage { size: [0, 4], ..valid }, "size is 0 x 4"),
            (RtImage { label: "", ..valid }, "label is "),
            (RtImage { label: "more than 16 characters", ..valid }, "label is more"),
            (RtImage { pose: &skewed, ..valid }, "valid: at right angles"),
            (RtImage { pose: &mirrored, ..valid }, "as seen from the source"),
            (RtImage { description: &long, ..valid }, "valid: at most 10240 characters"),
        ] {
            let message = write_rt_image(&folder.path().join("x.dcm"), &image).unwrap_err().to_string();
            assert!(message.contains(words), "{words}: {message}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
