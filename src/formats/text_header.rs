//! Headers that are lines of text before the voxels.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::str::FromStr;

use crate::formats::Checked;

/// Longest header. Those of files with many remarks have some kilobytes.
const LONGEST_HEADER: u64 = 1 << 20;

/// The fields of a header, each a name and a value.
#[derive(Debug, Default)]
pub(super) struct TextHeader {
    fields: Vec<(String, String)>,
    /// Bytes of the header: where what follows it starts.
    pub(super) bytes: u64,
}

impl TextHeader {
    /// Reads lines until one is the last, which isn't a field where it is empty. `split` gives the name and the value
    /// of one, and none for a remark.
    pub(super) fn read(
        path: &Path,
        split: impl Fn(&str) -> Checked<Option<(&str, &str)>>,
        is_last: impl Fn(&str) -> bool,
    ) -> Checked<Self> {
        let mut file = BufReader::new(File::open(path).map_err(|e| e.to_string())?.take(LONGEST_HEADER));
        let mut header = Self::default();
        loop {
            let mut line = vec![];
            let bytes = file.read_until(b'\n', &mut line).map_err(|e| e.to_string())? as u64;
            header.bytes += bytes;
            if bytes == 0 && header.bytes == LONGEST_HEADER {
                return Err(format!("has a header of more than {LONGEST_HEADER} bytes"));
            }
            let line =
                std::str::from_utf8(&line).map_err(|_| "has a header that is not text".to_owned())?.trim();
            let last = bytes == 0 || is_last(line);
            if let Some((name, value)) = if line.is_empty() { None } else { split(line)? } {
                let (name, value) = (name.trim().to_lowercase(), value.trim().to_owned());
                if header.fields.iter().any(|(own, _)| *own == name) {
                    return Err(format!("has {name} twice"));
                }
                header.fields.push((name, value));
            }
            if last {
                return Ok(header);
            }
        }
    }

    /// The value of the first of these fields that is there. Names are compared without case.
    pub(super) fn get(&self, names: &[&str]) -> Option<&str> {
        let find = |name: &&str| self.fields.iter().find(|(own, _)| own.eq_ignore_ascii_case(name));
        names.iter().find_map(find).map(|(_, value)| value.as_str())
    }

    /// The value of a field that must be there.
    pub(super) fn required(&self, name: &str) -> Checked<&str> {
        self.get(&[name]).ok_or_else(|| format!("has no {name}"))
    }

    /// The field's `N` numbers; `default` where it isn't there.
    pub(super) fn numbers<T: FromStr, const N: usize>(
        &self,
        names: &[&str],
        default: Option<[T; N]>,
    ) -> Checked<[T; N]> {
        match (self.get(names), default) {
            (Some(text), _) => {
                numbers(text).ok_or_else(|| format!("{} is {text:?}; valid: {N} numbers", names[0]))
            }
            (None, Some(default)) => Ok(default),
            (None, None) => Err(format!("has no {}", names[0])),
        }
    }
}

/// The numbers of a text with nothing else in it.
pub(super) fn numbers<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers: Vec<T> = text.split_whitespace().map(T::from_str).collect::<Result<_, _>>().ok()?;
    numbers.try_into().ok()
}
