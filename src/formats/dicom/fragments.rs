//! Where the bytes of each frame are.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use dicom_core::header::Length;
use dicom_dictionary_std::tags;

use super::attributes::name;
use super::file::Container;
use super::syntax::Codec;
use crate::formats::Checked;

/// Tags of the items of encapsulated pixel data, as explicit VR little endian has them, which is the only one allowed
/// (part 5, A.4).
const ITEM: [u8; 4] = [0xfe, 0xff, 0x00, 0xe0];
const SEQUENCE_DELIMITER: [u8; 4] = [0xfe, 0xff, 0xdd, 0xe0];
/// Bytes of a tag and a length.
const ITEM_HEADER_BYTES: u64 = 8;

/// The pixel data of an object.
#[derive(Debug)]
pub(super) enum PixelData {
    /// Frames one after the other from a position of the data set on.
    Native(u64),
    /// The fragments of every frame: their positions and lengths.
    Encapsulated(Vec<Vec<(u64, u32)>>),
}

impl PixelData {
    /// The value of the pixel data that starts at `start`, with `frames` frames, each of `frame_bytes` bytes where it is
    /// not compressed.
    pub(super) fn new(
        container: &Container,
        path: &Path,
        start: u64,
        length: Length,
        frames: usize,
        frame_bytes: usize,
    ) -> Checked<Self> {
        let native = matches!(container.syntax.codec, Codec::Native { .. });
        match length.get() {
            Some(length) if native => {
                let needed = frames as u64 * frame_bytes as u64;
                if u64::from(length) < needed {
                    return Err(format!(
                        "{} has {length} bytes, but {frames} frame(s) of {frame_bytes} bytes are {needed}",
                        name(tags::PIXEL_DATA)
                    ));
                }
                if start + needed > container.length && !container.syntax.deflated {
                    return Err(format!(
                        "is truncated: its pixels end at byte {}, but it has {}",
                        start + needed,
                        container.length
                    ));
                }
                if container.syntax.deflated && frames > 1 {
                    let reason = "is deflated and has several frames; valid: frames that are not deflated; convert it, for \
                                  example with: gdcmconv --raw";
                    return Err(reason.to_owned());
                }
                Ok(Self::Native(start))
            }
            None if !native => Ok(Self::Encapsulated(fragments(container, path, start, frames)?)),
            _ => Err(format!(
                "{} does not fit TransferSyntaxUID: one of them is wrong",
                name(tags::PIXEL_DATA)
            )),
        }
    }
}

/// Finds the fragments of every frame.
fn fragments(container: &Container, path: &Path, start: u64, frames: usize) -> Checked<Vec<Vec<(u64, u32)>>> {
    let fail = |e: io::Error| e.to_string();
    let mut file = BufReader::new(File::open(path).map_err(fail)?);
    file.seek(SeekFrom::Start(start)).map_err(fail)?;
    let (mut found, mut table) = (vec![], None);
    let mut position = start;
    loop {
        let mut header = [0; ITEM_HEADER_BYTES as usize];
        file.read_exact(&mut header)
            .map_err(|_| format!("is truncated within {}", name(tags::PIXEL_DATA)))?;
        let [a, b, c, d, l0, l1, l2, l3] = header;
        if [a, b, c, d] == SEQUENCE_DELIMITER {
            break;
        }
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        position += ITEM_HEADER_BYTES;
        let end = position + u64::from(length);
        if [a, b, c, d] != ITEM || end > container.length {
            return Err(format!(
                "is truncated or damaged at byte {position}, within {}",
                name(tags::PIXEL_DATA)
            ));
        }
        if table.is_none() {
            // The basic offset table: where the first fragment of every frame is, from the first fragment's item on.
            let bytes = table.insert(vec![]);
            file.by_ref().take(length.into()).read_to_end(bytes).map_err(fail)?;
        } else {
            found.push((position, length));
            file.seek_relative(length.into()).map_err(fail)?;
        }
        position = end;
    }
    if frames == 1 {
        return Ok(vec![found]);
    }
    if found.len() == frames {
        return Ok(found.into_iter().map(|fragment| vec![fragment]).collect());
    }
    let table = table.unwrap_or_default();
    let offsets: Vec<_> =
        table.as_chunks().0.iter().map(|&bytes| u64::from(u32::from_le_bytes(bytes))).collect();
    let Some(&(first, _)) = found.first().filter(|_| offsets.len() == frames) else {
        return Err(format!(
            "has {} fragments and {} offsets for {frames} frames; valid: one of either for each frame",
            found.len(),
            offsets.len()
        ));
    };
    let mut of_frames = vec![vec![]; frames];
    for fragment in found {
        let offset = fragment.0 - first;
        let frame = offsets.partition_point(|&start| start <= offset);
        of_frames[frame.saturating_sub(1)].push(fragment);
    }
    Ok(of_frames)
}
