//! What one file says of itself: the series that it belongs to, and its frames.

use std::path::{Path, PathBuf};

use dicom_core::Tag;
use dicom_dictionary_std::{tags, uids};

use super::attributes::{Attributes, missing, name};
use super::data_set::DataSet;
use super::file::Container;
use super::fragments::PixelData;
use super::plane::Plane;
use super::stored::Stored;
use super::syntax::Codec;
use crate::formats::Checked;

/// Longest side of an image. Also bounds what a damaged header can ask for.
const LARGEST_SIDE: u16 = 1 << 15;

/// What the SOP classes of secondary captures start with. Those of a CT are reports of dose and screens: no slices.
const SECONDARY_CAPTURE: &str = uids::SECONDARY_CAPTURE_IMAGE_STORAGE;

/// What a file holds for a CT.
#[derive(Debug)]
pub(super) enum Content {
    /// A report, a plan, a folder's index: no image.
    NoImage,
    /// An image of another modality.
    Other(String),
    Ct(Object),
    /// A CT image of that series which is not read, and why.
    Unreadable(String, String),
}

/// A CT image, or several frames of one.
#[derive(Debug)]
pub(super) struct Object {
    pub(super) path: PathBuf,
    pub(super) series: String,
    pub(super) description: Option<String>,
    /// The coordinate system of its positions.
    pub(super) frame_of_reference: Option<String>,
    /// Whether this is a scout, a projection for planning, and no slice.
    pub(super) localizer: bool,
    pub(super) container: Container,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    pub(super) stored: Stored,
    /// Smallest and largest stored number that is padding.
    pub(super) padding: Option<[i64; 2]>,
    pub(super) lossy: bool,
    pub(super) pixels: PixelData,
    pub(super) frames: Vec<Frame>,
}

/// One image plane.
#[derive(Debug)]
pub(super) struct Frame {
    pub(super) plane: Plane,
    /// Value = slope × stored number + intercept.
    pub(super) slope: f64,
    pub(super) intercept: f64,
    /// What the value is said to be, where that isn't HU.
    pub(super) unit: Option<String>,
}

impl Content {
    /// Reads a file's header.
    pub(super) fn read(path: &Path) -> Checked<Self> {
        let (container, data_set, pixels) = Container::open(path)?;
        let root = &data_set.attributes;
        let past_end = data_set.position > container.length && !container.syntax.deflated;
        if past_end {
            return Err(format!(
                "is truncated: it has {} bytes, but elements up to byte {}",
                container.length, data_set.position
            ));
        }
        if !root.values.contains_key(&tags::ROWS) {
            return Ok(Self::NoImage);
        }
        let modality = root.text(tags::MODALITY).ok_or_else(|| missing(tags::MODALITY))?;
        if modality != "CT" {
            return Ok(Self::Other(modality));
        }
        if root.text(tags::SOP_CLASS_UID).is_some_and(|class| class.starts_with(SECONDARY_CAPTURE)) {
            return Ok(Self::Other("CT (secondary capture)".to_owned()));
        }
        let series =
            root.text(tags::SERIES_INSTANCE_UID).ok_or_else(|| missing(tags::SERIES_INSTANCE_UID))?;
        let object = pixels.and_then(|()| Object::new(path, container, &data_set, series.clone()));
        Ok(object.map_or_else(|reason| Self::Unreadable(series, reason), Self::Ct))
    }
}

impl Object {
    fn new(path: &Path, container: Container, data_set: &DataSet, series: String) -> Checked<Self> {
        let root = &data_set.attributes;
        let (start, length) = data_set.pixels.ok_or_else(|| missing(tags::PIXEL_DATA))?;
        let [columns, rows] = [tags::COLUMNS, tags::ROWS].map(|tag| {
            let side = root.required_word(tag)?;
            if (1..=LARGEST_SIDE).contains(&side) {
                return Ok(usize::from(side));
            }
            Err(format!("{} is {side}; valid: 1 … {LARGEST_SIDE}", name(tag)))
        });
        let size = [columns?, rows?];
        check_grey(root)?;
        let stored = Stored::from_attributes(root)?;
        if stored.allocated == 8 && container.syntax.codec == (Codec::Native { big_endian: true }) {
            // Whether they are swapped in pairs depends on their VR (part 5, A.3), which files have wrong.
            return Err(format!(
                "{} is 8 in big endian, where pixels may be swapped; valid: 16; convert it, for example with: gdcmconv --raw",
                name(tags::BITS_ALLOCATED)
            ));
        }
        let count = frame_count(root)?;
        let frames = (0..count).map(|frame| Frame::new(root, frame)).collect::<Checked<Vec<_>>>()?;
        let kinds = [
            root.text(tags::IMAGE_TYPE),
            group(root, 0, tags::CT_IMAGE_FRAME_TYPE_SEQUENCE, tags::FRAME_TYPE)
                .and_then(|attributes| attributes.text(tags::FRAME_TYPE)),
        ];
        let localizer =
            kinds.iter().flatten().any(|kind| kind.split('\\').any(|part| part.trim() == "LOCALIZER"));
        let frame_bytes = size[0] * size[1] * usize::from(stored.allocated) / 8;
        Ok(Self {
            path: path.to_owned(),
            series,
            frame_of_reference: root.text(tags::FRAME_OF_REFERENCE_UID),
            description: root.text(tags::SERIES_DESCRIPTION),
            localizer,
            pixels: PixelData::new(&container, path, start, length, count, frame_bytes)?,
            container,
            size,
            stored,
            padding: padding(root, stored),
            lossy: root.text(tags::LOSSY_IMAGE_COMPRESSION).is_some_and(|lossy| lossy == "01"),
            frames,
        })
    }
}

impl Frame {
    fn new(root: &Attributes, frame: usize) -> Checked<Self> {
        let plane = Plane::new(|tag| {
            let sequence = match tag {
                tags::IMAGE_POSITION_PATIENT => tags::PLANE_POSITION_SEQUENCE,
                tags::IMAGE_ORIENTATION_PATIENT => tags::PLANE_ORIENTATION_SEQUENCE,
                _ => tags::PIXEL_MEASURES_SEQUENCE,
            };
            group(root, frame, sequence, tag)
        })?;
        let rescale = |tag| group(root, frame, tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, tag);
        let number =
            |tag| match rescale(tag).map(|attributes| attributes.decimals::<1>(tag)).transpose()?.flatten() {
                Some([number]) => Ok(number),
                None if root.sequences.contains_key(&tags::MODALITY_LUT_SEQUENCE) => Err(format!(
                    "has a table instead of a rescale slope ({}); valid: RescaleSlope and RescaleIntercept",
                    name(tags::MODALITY_LUT_SEQUENCE)
                )),
                None => Err(missing(tag)),
            };
        let (slope, intercept) = (number(tags::RESCALE_SLOPE)?, number(tags::RESCALE_INTERCEPT)?);
        if slope == 0.0 {
            return Err(format!("{} is 0; valid: anything else", name(tags::RESCALE_SLOPE)));
        }
        let unit = rescale(tags::RESCALE_TYPE).and_then(|attributes| attributes.text(tags::RESCALE_TYPE));
        // Unspecified, and what enhanced contrast is called, are HU in practice; densities and atomic numbers are not.
        if let Some(unit) = unit.as_deref().filter(|unit| !["HU", "US", "HU_MOD"].contains(unit)) {
            return Err(format!(
                "{} is {unit}; valid: HU, US (unspecified), HU_MOD",
                name(tags::RESCALE_TYPE)
            ));
        }
        Ok(Self { plane, slope, intercept, unit: unit.filter(|unit| unit != "HU") })
    }
}

/// The attributes that hold `tag` for a frame: its own functional group, the one that all frames share (part 3,
/// C.7.6.16), or those of the whole object.
fn group(root: &Attributes, frame: usize, sequence: Tag, tag: Tag) -> Option<&Attributes> {
    let own = root.items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).get(frame);
    let shared = root.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let groups = own.into_iter().chain(shared).filter_map(|groups| groups.items(sequence).first());
    groups.chain([root]).find(|attributes| attributes.values.contains_key(&tag))
}

fn check_grey(root: &Attributes) -> Checked<()> {
    let photometric = root.text(tags::PHOTOMETRIC_INTERPRETATION);
    // Monochrome 1 and 2 differ in how numbers are displayed only.
    match photometric.ok_or_else(|| missing(tags::PHOTOMETRIC_INTERPRETATION))?.as_str() {
        "MONOCHROME1" | "MONOCHROME2" => {}
        other => {
            let name = name(tags::PHOTOMETRIC_INTERPRETATION);
            return Err(format!("{name} is {other}; valid: MONOCHROME1, MONOCHROME2"));
        }
    }
    match root.word(tags::SAMPLES_PER_PIXEL).unwrap_or(1) {
        1 => Ok(()),
        samples => Err(format!("{} is {samples}; valid: 1", name(tags::SAMPLES_PER_PIXEL))),
    }
}

/// Frames of the object; each has a place of its own, or there is one.
fn frame_count(root: &Attributes) -> Checked<usize> {
    let tag = tags::NUMBER_OF_FRAMES;
    let Some(text) = root.text(tag) else { return Ok(1) };
    let count: usize = text.parse().map_err(|_| format!("{} is {text:?}; valid: a number", name(tag)))?;
    let places = root.items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).len();
    if count == 1 || count > 0 && count == places {
        return Ok(count);
    }
    Err(format!(
        "{} is {count}, but PerFrameFunctionalGroupsSequence has {places} items; valid: as many, which place each frame",
        name(tag)
    ))
}

fn padding(root: &Attributes, stored: Stored) -> Option<[i64; 2]> {
    let number = |tag| root.word(tag).map(|word| stored.padding(word));
    let value = number(tags::PIXEL_PADDING_VALUE)?;
    let limit = number(tags::PIXEL_PADDING_RANGE_LIMIT).unwrap_or(value);
    Some([value.min(limit), value.max(limit)])
}
