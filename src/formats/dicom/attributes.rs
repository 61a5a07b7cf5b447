//! The attributes of a data set that a CT needs, as the bytes that the file holds.

use std::collections::BTreeMap;
use std::str::FromStr;

use dicom_core::Tag;
use dicom_core::dictionary::{DataDictionary as _, DataDictionaryEntry as _};
use dicom_dictionary_std::StandardDataDictionary;

use crate::formats::Checked;

/// Values and sequences by tag. Values stay bytes until they are asked for: what they are follows from the tag, so that a
/// wrong VR in the file does no harm.
#[derive(Debug, Default)]
pub(super) struct Attributes {
    pub(super) big_endian: bool,
    pub(super) values: BTreeMap<Tag, Vec<u8>>,
    pub(super) sequences: BTreeMap<Tag, Vec<Attributes>>,
}

impl Attributes {
    /// The text without control characters and the padding around it; none where the attribute is missing or empty.
    /// Whatever the character set, codes and numbers are ASCII.
    pub(super) fn text(&self, tag: Tag) -> Option<String> {
        let text = String::from_utf8_lossy(self.values.get(&tag)?);
        let text: String = text.chars().filter(|c| !c.is_control()).collect();
        Some(text.trim().to_owned()).filter(|text| !text.is_empty())
    }

    /// An unsigned number of 16 bits.
    pub(super) fn word(&self, tag: Tag) -> Option<u16> {
        let bytes = self.values.get(&tag)?.first_chunk()?;
        Some(if self.big_endian { u16::from_be_bytes(*bytes) } else { u16::from_le_bytes(*bytes) })
    }

    /// As `word`, for an attribute that must be there.
    pub(super) fn required_word(&self, tag: Tag) -> Checked<u16> {
        self.word(tag).ok_or_else(|| missing(tag))
    }

    /// `N` decimal numbers written as text; an error where they are something else.
    pub(super) fn decimals<const N: usize>(&self, tag: Tag) -> Checked<Option<[f64; N]>> {
        let Some(text) = self.text(tag) else { return Ok(None) };
        let wrong = || format!("{} is {text:?}; valid: {N} finite number(s)", name(tag));
        let numbers: Vec<f64> = text
            .split('\\')
            .map(|part| f64::from_str(part.trim()))
            .collect::<Result<_, _>>()
            .map_err(|_| wrong())?;
        let numbers = <[f64; N]>::try_from(numbers).map_err(|_| wrong())?;
        if numbers.iter().all(|number| number.is_finite()) { Ok(Some(numbers)) } else { Err(wrong()) }
    }

    /// The items of a sequence; none where it is missing.
    pub(super) fn items(&self, tag: Tag) -> &[Attributes] {
        self.sequences.get(&tag).map_or(&[], Vec::as_slice)
    }
}

/// The keyword of an attribute and its tag.
pub(super) fn name(tag: Tag) -> String {
    let entry = StandardDataDictionary.by_tag(tag);
    format!("{} {tag}", entry.map_or("attribute", |entry| entry.alias()))
}

/// The message for an attribute that is not there.
pub(super) fn missing(tag: Tag) -> String {
    format!("{} is missing", name(tag))
}
