//! Reading a data set element by element, up to its pixel data.
//!
//! Elements are as section 7 of part 5 has them. What is not needed is passed over; memory and depth are bounded whatever a file
//! claims.

use std::io::{ErrorKind, Read};

use dicom_core::header::{DataElementHeader, Header as _, Length, SequenceItemHeader};
use dicom_core::{Tag, VR};
use dicom_dictionary_std::tags;
use dicom_encoding::decode::Error as DecodeError;
use dicom_encoding::transfer_syntax::{Endianness, TransferSyntax};
use dicom_parser::stateful::decode::{DynStatefulDecoder, Error as ParseError, StatefulDecode as _};

use super::attributes::{Attributes, name};
use crate::formats::Checked;

/// Longest value that is kept: what is needed is a few numbers, or a line of text.
const LARGEST_VALUE: u32 = 1 << 14;
/// Deepest nesting of sequences. Those of a CT are three deep.
const DEEPEST: usize = 32;
const ITEM_DELIMITER: Tag = Tag(0xfffe, 0xe00d);

/// The attributes that are kept.
const WANTED: [Tag; 33] = [
    tags::FILE_META_INFORMATION_GROUP_LENGTH,
    tags::TRANSFER_SYNTAX_UID,
    tags::IMAGE_TYPE,
    tags::SOP_CLASS_UID,
    tags::MODALITY,
    tags::SERIES_DESCRIPTION,
    tags::FRAME_TYPE,
    tags::SERIES_INSTANCE_UID,
    tags::FRAME_OF_REFERENCE_UID,
    tags::IMAGE_POSITION_PATIENT,
    tags::IMAGE_ORIENTATION_PATIENT,
    tags::SAMPLES_PER_PIXEL,
    tags::PHOTOMETRIC_INTERPRETATION,
    tags::NUMBER_OF_FRAMES,
    tags::ROWS,
    tags::COLUMNS,
    tags::PIXEL_SPACING,
    tags::BITS_ALLOCATED,
    tags::BITS_STORED,
    tags::HIGH_BIT,
    tags::PIXEL_REPRESENTATION,
    tags::PIXEL_PADDING_VALUE,
    tags::PIXEL_PADDING_RANGE_LIMIT,
    tags::RESCALE_INTERCEPT,
    tags::RESCALE_SLOPE,
    tags::RESCALE_TYPE,
    tags::LOSSY_IMAGE_COMPRESSION,
    // The sequences that are read.
    tags::CT_IMAGE_FRAME_TYPE_SEQUENCE,
    tags::PLANE_POSITION_SEQUENCE,
    tags::PLANE_ORIENTATION_SEQUENCE,
    tags::PIXEL_MEASURES_SEQUENCE,
    tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE,
    tags::MODALITY_LUT_SEQUENCE,
];
/// The sequences of [`WANTED`] that hold those of every frame.
const FUNCTIONAL_GROUPS: [Tag; 2] =
    [tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE];

/// A data set up to its pixel data.
pub(super) struct DataSet {
    pub(super) attributes: Attributes,
    /// Where the value of the pixel data starts, and its length, undefined where it is a sequence of fragments; none
    /// where there is no image.
    pub(super) pixels: Option<(u64, Length)>,
    /// Where reading ended; beyond the end of the file when its last element is cut off.
    pub(super) position: u64,
}

/// Reads a data set.
pub(super) struct DataSetReader<S: Read> {
    decoder: DynStatefulDecoder<S>,
    big_endian: bool,
    pixels: Option<(u64, Length)>,
}

impl<S: Read> DataSetReader<S> {
    /// A data set in a stream that stands at `position`.
    pub(super) fn new(stream: S, syntax: &TransferSyntax, position: u64) -> Checked<Self> {
        let decoder = DynStatefulDecoder::new_with_ts(stream, syntax, position);
        let big_endian = syntax.endianness() == Endianness::Big;
        Ok(Self { decoder: decoder.map_err(|e| e.to_string())?, big_endian, pixels: None })
    }

    /// Reads to the pixel data, or to the end of the stream.
    pub(super) fn read(mut self) -> Checked<DataSet> {
        let attributes = self.elements(None, 0)?;
        Ok(DataSet { attributes, pixels: self.pixels, position: self.position() })
    }

    /// The elements of the file meta information: those of group 2, whose length is its first element.
    pub(super) fn read_meta(&mut self) -> Checked<Attributes> {
        let header = self.header()?.filter(|h| h.tag == tags::FILE_META_INFORMATION_GROUP_LENGTH);
        let missing = "has no length of its file meta information; valid: DICOM files as part 10 of the standard has them";
        let header = header.ok_or(missing)?;
        let bytes = self.value(&header)?;
        let length = bytes.first_chunk().map(|&bytes| u32::from_le_bytes(bytes)).ok_or(missing)?;
        let end = self.decoder.position() + u64::from(length);
        self.elements(Some(end), 0)
    }

    /// Bytes of the stream so far.
    pub(super) fn position(&self) -> u64 {
        self.decoder.position()
    }

    /// The elements up to `end`, to a delimiter, or to the end of the stream. Stops at the pixel data.
    fn elements(&mut self, end: Option<u64>, depth: usize) -> Checked<Attributes> {
        let mut attributes = Attributes { big_endian: self.big_endian, ..Attributes::default() };
        if depth > DEEPEST {
            return Err(format!("nests sequences more than {DEEPEST} deep"));
        }
        while !self.is_at(end)? {
            let Some(header) = self.header()? else {
                return if depth == 0 && end.is_none() { Ok(attributes) } else { Err(self.truncated()) };
            };
            let DataElementHeader { tag, vr, len } = header;
            if tag == ITEM_DELIMITER && end.is_none() && depth > 0 {
                break;
            }
            if tag == tags::PIXEL_DATA && depth == 0 {
                self.pixels = Some((self.decoder.position(), len));
                break;
            }
            let sequence = vr == VR::SQ || len.is_undefined();
            if sequence
                && vr != VR::UN
                && (WANTED.contains(&tag) || depth == 0 && FUNCTIONAL_GROUPS.contains(&tag))
            {
                attributes.sequences.insert(tag, self.items(len, depth)?);
            } else if len.is_undefined() {
                self.pass_over_sequence(vr == VR::UN)?;
            } else if WANTED.contains(&tag) {
                attributes.values.insert(tag, self.value(&header)?);
            } else {
                self.pass_over(len)?;
            }
        }
        Ok(attributes)
    }

    fn items(&mut self, length: Length, depth: usize) -> Checked<Vec<Attributes>> {
        let end = length.get().map(|length| self.decoder.position() + u64::from(length));
        let mut items = vec![];
        while !self.is_at(end)? {
            match self.item_header()? {
                SequenceItemHeader::Item { len } => {
                    let end = len.get().map(|len| self.decoder.position() + u64::from(len));
                    items.push(self.elements(end, depth + 1)?);
                }
                SequenceItemHeader::SequenceDelimiter if end.is_none() => break,
                _ => return Err(format!("has a delimiter out of place at byte {}", self.decoder.position())),
            }
        }
        Ok(items)
    }

    fn value(&mut self, header: &DataElementHeader) -> Checked<Vec<u8>> {
        let length = header.len.get().filter(|&length| length <= LARGEST_VALUE).ok_or_else(|| {
            format!("{} has {} bytes; valid: at most {LARGEST_VALUE}", name(header.tag), header.len)
        })?;
        let mut bytes = vec![];
        self.decoder.read_to_vec(length, &mut bytes).map_err(|e| e.to_string())?;
        if bytes.len() < length as usize { Err(self.truncated()) } else { Ok(bytes) }
    }

    fn pass_over(&mut self, length: Length) -> Checked<()> {
        let length = length.get().unwrap_or_default();
        self.decoder.skip_bytes(length).map_err(|e| e.to_string())
    }

    /// Passes over a sequence that ends with a delimiter. In a sequence whose VR is unknown, everything is implicit VR
    /// little endian (part 5, section 6.2.2).
    fn pass_over_sequence(&mut self, implicit: bool) -> Checked<()> {
        // Whether what is open is an item.
        let mut open = vec![false];
        while let Some(&item) = open.last() {
            let (tag, length) = if implicit {
                let mut bytes = vec![];
                self.decoder.read_to_vec(8, &mut bytes).map_err(|e| e.to_string())?;
                let [g0, g1, e0, e1, l0, l1, l2, l3] = bytes.try_into().map_err(|_| self.truncated())?;
                let tag = Tag(u16::from_le_bytes([g0, g1]), u16::from_le_bytes([e0, e1]));
                (tag, Length(u32::from_le_bytes([l0, l1, l2, l3])))
            } else {
                let header = self.header()?.ok_or_else(|| self.truncated())?;
                (header.tag(), header.len)
            };
            match (item, tag) {
                (true, ITEM_DELIMITER) | (false, Tag(0xfffe, 0xe0dd)) => _ = open.pop(),
                (false, Tag(0xfffe, 0xe000)) | (true, _) if !length.is_undefined() => {
                    self.pass_over(length)?;
                }
                (false, Tag(0xfffe, 0xe000)) | (true, _) => open.push(!item),
                _ => return Err(format!("has {tag} out of place at byte {}", self.decoder.position())),
            }
            if open.len() > 2 * DEEPEST {
                return Err(format!("nests sequences more than {DEEPEST} deep"));
            }
        }
        Ok(())
    }

    /// Whether the stream stands at `end`.
    fn is_at(&self, end: Option<u64>) -> Checked<bool> {
        let position = self.decoder.position();
        match end {
            Some(end) if position > end => {
                Err(format!("has an element at byte {position} that its item is too short for"))
            }
            end => Ok(end == Some(position)),
        }
    }

    /// The next element's header; none at the end of the stream.
    fn header(&mut self) -> Checked<Option<DataElementHeader>> {
        match self.decoder.decode_header() {
            Ok(header) => Ok(Some(header)),
            Err(ParseError::DecodeElementHeader {
                source: DecodeError::ReadHeaderTag { source, .. },
                ..
            }) if source.kind() == ErrorKind::UnexpectedEof => Ok(None),
            Err(_) => Err(self.truncated()),
        }
    }

    fn item_header(&mut self) -> Checked<SequenceItemHeader> {
        let position = self.decoder.position();
        self.decoder.decode_item_header().map_err(|_| format!("has no item of a sequence at byte {position}"))
    }

    fn truncated(&self) -> String {
        format!("is truncated or damaged at byte {}", self.decoder.position())
    }
}
