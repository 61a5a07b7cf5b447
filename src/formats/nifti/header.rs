//! The header of a NIfTI-1 file, checked.

use nifti::{Endianness, NiftiHeader};

use super::affine::index_to_world;
use crate::formats::Checked;
use crate::formats::stored::{Array, Storage};
use crate::geometry::Grid;

/// Bytes of the header.
pub(super) const HEADER_BYTES: usize = 348;
/// Where voxels start at the earliest: the header is followed by four bytes that announce extensions.
pub(super) const FIRST_VOXEL: u64 = 352;
/// Header bytes of NIfTI-2, the first number in such a file.
const NIFTI_2_BYTES: i32 = 540;

/// What a header says about the voxels that follow it.
pub(super) fn parse(bytes: &[u8; HEADER_BYTES]) -> Checked<Array> {
    let size = [bytes[0], bytes[1], bytes[2], bytes[3]];
    if [i32::from_le_bytes(size), i32::from_be_bytes(size)].contains(&NIFTI_2_BYTES) {
        return Err("is NIfTI-2; valid: NIfTI-1".to_owned());
    }
    let header = NiftiHeader::from_reader(&bytes[..]).map_err(|e| format!("is not NIfTI-1: {e}"))?;
    if header.sizeof_hdr != HEADER_BYTES as i32 {
        return Err(format!("sizeof_hdr is {}; valid: {HEADER_BYTES}", header.sizeof_hdr));
    }
    if header.magic != *b"n+1\0" {
        return Err("is a header whose voxels are in another file (.img); valid: both in one .nii".to_owned());
    }
    let (slope, intercept) = scaling(&header)?;
    let storage = storage(header.datatype)?;
    let grid = Grid::new(dimensions(&header)?, index_to_world(&header)?).map_err(|e| e.to_string())?;
    let big_endian = header.endianness == Endianness::Big;
    Ok(Array { grid, storage, big_endian, slope, intercept, offset: offset(&header)? })
}

/// From the header's `datatype`.
fn storage(code: i16) -> Checked<Storage> {
    Ok(match code {
        2 => Storage::U8,
        4 => Storage::I16,
        8 => Storage::I32,
        16 => Storage::F32,
        64 => Storage::F64,
        256 => Storage::I8,
        512 => Storage::U16,
        768 => Storage::U32,
        1024 => Storage::I64,
        1280 => Storage::U64,
        _ => {
            return Err(format!(
                "datatype is {code}; valid: 2, 4, 8, 256, 512, 768, 1024, 1280 (integers), 16, 64 (floats)"
            ));
        }
    })
}

/// Three dimensions; more are accepted when they are trivial.
fn dimensions(header: &NiftiHeader) -> Checked<[usize; 3]> {
    let signed = header.dim.map(|n| n as i16);
    let rank = signed[0];
    let wrong = |what: &str| Err(format!("dim is {signed:?}; valid: {what}"));
    if !(3..=7).contains(&rank) {
        return wrong("three dimensions");
    }
    if signed[1..=3].iter().any(|&n| n < 1) {
        return wrong("positive numbers of voxels");
    }
    if signed[4..=rank as usize].iter().any(|&n| n > 1) {
        return wrong("one volume of three dimensions");
    }
    Ok([header.dim[1], header.dim[2], header.dim[3]].map(usize::from))
}

/// Slope and intercept. The standard: a slope of 0 means that there is no scaling, so no intercept either; NaN is what
/// a common writer leaves for "none".
fn scaling(header: &NiftiHeader) -> Checked<(f64, f64)> {
    let (slope, intercept) = (header.scl_slope, header.scl_inter);
    if slope == 0.0 || slope.is_nan() {
        return Ok((1.0, 0.0));
    }
    if !slope.is_finite() || !intercept.is_finite() {
        return Err(format!("scl_slope is {slope} and scl_inter {intercept}; valid: finite numbers"));
    }
    Ok((slope.into(), intercept.into()))
}

fn offset(header: &NiftiHeader) -> Checked<u64> {
    let offset = header.vox_offset;
    if offset == 0.0 {
        return Ok(FIRST_VOXEL);
    }
    // Float32 holds whole numbers up to 2²⁴; extensions are smaller than that.
    if !(FIRST_VOXEL as f32..=16_777_216.0).contains(&offset) || offset.fract() != 0.0 {
        return Err(format!("vox_offset is {offset}; valid: 0 or a whole number from {FIRST_VOXEL} to 2^24"));
    }
    Ok(offset as u64)
}

#[cfg(test)]
mod tests {
    use super::super::TestFile;
    use super::*;

    fn read(file: &TestFile) -> Checked<Array> {
        parse(file.bytes[..HEADER_BYTES].try_into().unwrap())
    }

    #[test]
    fn both_byte_orders_say_the_same() {
        let in_order = |big| {
            let mut file = TestFile::new(big, [4, 3, 2], 512);
            file.put_f32(108, 400.0).put_f32(112, 2.0).put_f32(116, -1024.0);
            read(&file).unwrap()
        };
        let (little, big) = (in_order(false), in_order(true));
        assert_eq!((little.offset, little.slope, little.intercept), (400, 2.0, -1024.0));
        assert_eq!((little.storage, little.grid.dimensions()), (Storage::U16, [4, 3, 2]));
        assert_eq!((little.big_endian, big.big_endian), (false, true));
        assert_eq!(Array { big_endian: false, ..big }, little);
        assert_eq!(little.bytes(), 4 * 3 * 2 * 2);
    }

    #[test]
    fn no_slope_means_no_scaling() {
        for slope in [0.0, f32::NAN] {
            let mut file = TestFile::new(false, [4, 3, 2], 4);
            file.put_f32(112, slope).put_f32(116, 7.0);
            let header = read(&file).unwrap();
            assert_eq!((header.slope, header.intercept), (1.0, 0.0));
        }
    }

    #[test]
    fn one_volume_in_four_dimensions_is_one_volume() {
        let mut file = TestFile::new(false, [4, 3, 2], 4);
        file.put_i16(40, 4).put_i16(48, 1);
        assert_eq!(read(&file).unwrap().grid.dimensions(), [4, 3, 2]);
        file.put_i16(48, 5);
        assert!(read(&file).unwrap_err().contains("one volume"));
    }

    #[test]
    fn what_is_wrong_is_named() {
        type Damage = fn(&mut TestFile);
        let cases: [(&str, Damage); 11] = [
            ("NIfTI-2", |f| f.bytes[..4].copy_from_slice(&540_i32.to_le_bytes())),
            ("sizeof_hdr", |f| f.bytes[0] = 1),
            ("not NIfTI", |f| f.bytes[344] = b'x'),
            (".img", |f| f.bytes[345] = b'i'),
            ("three dimensions", |f| _ = f.put_i16(40, 2)),
            ("positive", |f| _ = f.put_i16(44, -3)),
            ("datatype", |f| _ = f.put_i16(70, 32)),
            ("vox_offset", |f| _ = f.put_f32(108, 100.0)),
            ("vox_offset", |f| _ = f.put_f32(108, f32::NAN)),
            ("scl_slope", |f| _ = f.put_f32(112, f32::INFINITY)),
            ("index_to_world", |f| _ = f.put_f32(280, 0.0)),
        ];
        for (word, damage) in cases {
            let mut file = TestFile::new(false, [4, 3, 2], 4);
            damage(&mut file);
            let message = read(&file).unwrap_err();
            assert!(message.contains(word), "{word}: {message}");
        }
    }
}
