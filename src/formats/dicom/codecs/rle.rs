//! RLE Lossless (part 5, annex G).

use crate::formats::Checked;
use crate::formats::dicom::pixels::Words;

/// Bytes of the header: the number of segments, and where 15 of them start.
const HEADER_BYTES: usize = 64;

/// Decodes a frame of `count` pixels of `allocated` bits: a segment for each byte of a pixel, the highest first.
pub(in crate::formats::dicom) fn decode(frame: &[u8], count: usize, allocated: u16) -> Checked<Words> {
    let header = frame.get(..HEADER_BYTES).ok_or("RLE: its header is truncated")?;
    let numbers: Vec<_> =
        header.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes) as usize).collect();
    let planes = usize::from(allocated) / 8;
    if numbers[0] != planes {
        return Err(format!("RLE: it has {} segments; valid: {planes}, the bytes of a pixel", numbers[0]));
    }
    let mut words = vec![0_u32; count];
    for plane in 0..planes {
        let end = if plane + 1 < planes { numbers[plane + 2] } else { frame.len() };
        let segment =
            frame.get(numbers[plane + 1]..end).ok_or_else(|| format!("RLE: segment {plane} is outside"))?;
        let mut rest = words.iter_mut();
        unpack(segment, |byte| {
            rest.next().is_some_and(|word| {
                *word = *word << 8 | u32::from(byte);
                true
            })
        });
        if rest.next().is_some() {
            return Err(format!("RLE: segment {plane} is too short"));
        }
    }
    Ok(Words { words, precision: allocated })
}

/// Gives the bytes of a segment to `push`, until it wants no more.
fn unpack(segment: &[u8], mut push: impl FnMut(u8) -> bool) {
    let mut bytes = segment.iter().copied();
    while let Some(control) = bytes.next() {
        // A number of bytes as they are, a byte so many times, or nothing.
        let going = match control as i8 {
            length @ 0.. => bytes.by_ref().take(length as usize + 1).all(&mut push),
            -128 => true,
            length => bytes.next().is_some_and(|byte| (0..1 - i32::from(length)).all(|_| push(byte))),
        };
        if !going {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(segments: &[&[u8]]) -> Vec<u8> {
        let mut frame = vec![0; HEADER_BYTES];
        frame[0] = segments.len() as u8;
        for (n, segment) in segments.iter().enumerate() {
            let start = frame.len() as u32;
            frame[4 * n + 4..4 * n + 8].copy_from_slice(&start.to_le_bytes());
            frame.extend_from_slice(segment);
        }
        frame
    }

    #[test]
    fn runs_literals_and_nothing() {
        // High bytes: three times 1, then 2; low bytes: 3, 4, nothing, twice 255, and one that pads.
        let frame = frame(&[&[0xfe, 1, 0, 2], &[1, 3, 4, 0x80, 0xff, 255, 0]]);
        assert_eq!(decode(&frame, 4, 16).unwrap().words, [0x103, 0x104, 0x1ff, 0x2ff]);
        let message = decode(&frame, 5, 16).err().unwrap();
        assert!(message.contains("too short"), "{message}");
    }

    #[test]
    fn what_is_damaged_is_refused() {
        let mut frame = frame(&[&[0, 1], &[0, 2]]);
        assert!(decode(&frame[..63], 1, 16).is_err());
        assert!(decode(&frame, 1, 8).is_err());
        frame[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode(&frame, 1, 16).is_err());
        frame[8..12].copy_from_slice(&0_u32.to_le_bytes());
        assert!(decode(&frame, 1, 16).is_err());
    }
}
