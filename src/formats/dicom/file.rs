//! A DICOM file: what stands before its data set, and the stream of the data set.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use dicom_dictionary_std::{tags, uids};
use flate2::bufread::DeflateDecoder;

use super::attributes::missing;
use super::data_set::{DataSet, DataSetReader};
use super::syntax::Syntax;
use crate::formats::Checked;

/// Bytes of anything before [`MAGIC`] (part 10, section 7.1).
const PREAMBLE_BYTES: usize = 128;
const MAGIC: &[u8; 4] = b"DICM";
const BUFFER_BYTES: usize = 1 << 16;

/// Where the data set of a file is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Container {
    pub(super) syntax: Syntax,
    /// Byte of the file at which the data set starts.
    start: u64,
    /// Bytes of the file.
    pub(super) length: u64,
}

/// Whether a file's content says that it is DICOM.
pub(crate) fn is_dicom(path: &Path) -> io::Result<bool> {
    let mut bytes = [0; PREAMBLE_BYTES + MAGIC.len()];
    match File::open(path)?.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes.ends_with(MAGIC)),
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(e) => Err(e),
    }
}

impl Container {
    /// Opens a file and reads its data set up to the pixels; an error beside them where these are encoded in a way that is
    /// not read.
    pub(super) fn open(path: &Path) -> Checked<(Self, DataSet, Checked<()>)> {
        let fail = |e: io::Error| e.to_string();
        let mut file = File::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        let magic = (PREAMBLE_BYTES + MAGIC.len()) as u64;
        file.seek(SeekFrom::Start(magic)).map_err(fail)?;
        let explicit = Syntax::from_uid(uids::EXPLICIT_VR_LITTLE_ENDIAN)?.elements()?;
        let mut meta = DataSetReader::new(BufReader::new(file), explicit, magic)?;
        let attributes = meta.read_meta()?;
        let uid =
            attributes.text(tags::TRANSFER_SYNTAX_UID).ok_or_else(|| missing(tags::TRANSFER_SYNTAX_UID))?;
        // Whatever encodes pixels, the elements around them are explicit VR little endian (part 5, A.4).
        let (syntax, pixels) = match Syntax::from_uid(&uid) {
            Ok(syntax) => (syntax, Ok(())),
            Err(reason) => (Syntax::from_uid(uids::EXPLICIT_VR_LITTLE_ENDIAN)?, Err(reason)),
        };
        let container = Self { syntax, start: meta.position(), length };
        let stream = container.stream(path, container.origin()).map_err(fail)?;
        let data_set =
            DataSetReader::new(stream, container.syntax.elements()?, container.origin())?.read()?;
        Ok((container, data_set, pixels))
    }

    /// The position of the data set's first byte: in the file, or after inflating.
    fn origin(&self) -> u64 {
        if self.syntax.deflated { 0 } else { self.start }
    }

    /// The data set from a position in it.
    pub(super) fn stream(&self, path: &Path, position: u64) -> io::Result<Box<dyn Read>> {
        let mut file = File::open(path)?;
        if !self.syntax.deflated {
            file.seek(SeekFrom::Start(position))?;
            return Ok(Box::new(BufReader::with_capacity(BUFFER_BYTES, file)));
        }
        file.seek(SeekFrom::Start(self.start))?;
        let mut stream = DeflateDecoder::new(BufReader::with_capacity(BUFFER_BYTES, file));
        io::copy(&mut stream.by_ref().take(position), &mut io::sink())?;
        Ok(Box::new(stream))
    }
}
