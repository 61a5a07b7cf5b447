use std::io::Write as _;

use flate2::{Compression, write::ZlibEncoder};

use crate::formats::test_volume::read;
use crate::formats::{VoxelKind, open_labels};

use super::*;

const FIELDS: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\n\
                      Offset = 10 -20 30\nCenterOfRotation = 5 5 5\nElementSpacing = 0.5 2 3\nDimSize = 3 1 2\n";
const VALUES: [f64; 6] = [0.0, 1.0, 2.0, 100.0, 126.0, 127.0];

fn file(name: &str, fields: &str, voxels: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, [format!("{FIELDS}{fields}").as_bytes(), voxels].concat()).unwrap();
    (folder, path)
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(vec![], Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn every_type_and_byte_order_gives_its_values() {
    macro_rules! check {
        ($($number:ty, $kind:literal, $voxels:ident);*) => {$(
            let little: Vec<u8> = VALUES.iter().flat_map(|&v| (v as $number).to_le_bytes()).collect();
            let big: Vec<u8> = VALUES.iter().flat_map(|&v| (v as $number).to_be_bytes()).collect();
            for (fields, bytes) in [
                ("BinaryDataByteOrderMSB = False\n", little.clone()),
                ("ElementByteOrderMSB = True\nCompressedData = False\n", big.clone()),
                ("CompressedData = True\nCompressedDataSize = 7\n", zlib(&little)),
            ] {
                let fields = format!("{fields}ElementType = {}\nElementDataFile = LOCAL\n", $kind);
                let (_folder, path) = file("ct.mha", &fields, &bytes);
                let (grid, kind, values) = read(&path).unwrap();
                assert_eq!((kind, values.as_slice()), (VoxelKind::$voxels, &VALUES[..]), "{fields}");
                // The first axis runs to y, the second to −x.
                let place = grid.index_to_world().transform_point3(DVec3::new(2.0, 1.0, 1.0));
                assert_eq!(place, DVec3::new(8.0, -19.0, 33.0));
            }
        )*};
    }
    check!(i8, "MET_CHAR", Int16; u8, "MET_UCHAR", Int16; i16, "MET_SHORT", Int16; u16, "MET_USHORT", Int16;
        i32, "MET_INT", Int16; u32, "MET_UINT", Int16; i32, "MET_LONG", Int16; u32, "MET_ULONG", Int16;
        i64, "MET_LONG_LONG", Int16; u64, "MET_ULONG_LONG", Int16; f32, "MET_FLOAT", Float32;
        f64, "MET_DOUBLE", Float32);
}

#[test]
fn voxels_in_another_file_are_found_beside_the_header() {
    for (fields, before) in [("", 0), ("HeaderSize = 9\n", 9), ("HeaderSize = -1\n", 5)] {
        let fields = format!("{fields}ElementType = MET_UCHAR\nElementDataFile = voxels.raw\n");
        let (folder, path) = file("CT.MHD", &fields, &[]);
        let mut bytes = vec![77; before];
        bytes.extend(VALUES.map(|v| v as u8));
        std::fs::write(folder.path().join("voxels.raw"), &bytes).unwrap();
        assert_eq!(read(&path).unwrap().2, VALUES);
        std::fs::write(folder.path().join("voxels.raw"), &bytes[..5]).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("voxels.raw: truncated"), "{message}");
    }
}

#[test]
fn labels_come_from_it_too() {
    let (_folder, path) = file(
        "labels.mha",
        "ElementType = MET_SHORT\nElementDataFile = LOCAL\n",
        &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0],
    );
    let mut labels = vec![];
    let mut reader = open_labels(&path, &read(&path).unwrap().0).unwrap();
    reader
        .read(&mut |_, slice| {
            labels.extend_from_slice(slice);
            Ok(())
        })
        .unwrap();
    assert_eq!(labels, [1, 2, 3, 4, 5, 6]);
}

#[test]
fn what_is_wrong_is_named() {
    let local = "ElementDataFile = LOCAL\n";
    for (from, to, words) in [
        ("NDims = 3", "NDims = 2", "NDims is 2; valid: 3"),
        ("NDims = 3", "NDims = 4", "NDims is 4; valid: 3"),
        ("DimSize = 3 1 2", "DimSize = 3 1", "DimSize is \"3 1\"; valid: 3 numbers"),
        ("DimSize = 3 1 2", "DimSize = 3 -1 2", "DimSize is"),
        ("DimSize = 3 1 2", "DimSize = 30000 30000 4", "truncated"),
        ("DimSize = 3 1 2\n", "", "has no DimSize"),
        ("0.5 2 3", "0.5 0 3", "singular"),
        ("0.5 2 3", "nan 2 3", "index_to_world"),
        ("BinaryData = True", "BinaryData = False", "voxels are text"),
        ("ElementType = MET_UCHAR", "ElementType = MET_OTHER", "ElementType is MET_OTHER"),
        (
            "ElementType = MET_UCHAR",
            "ElementNumberOfChannels = 3\nElementType = MET_UCHAR",
            "ElementNumberOfChannels is 3",
        ),
        (local, "ElementDataFile = LIST\n", "a file for each slice"),
        (local, "HeaderSize = -1\nElementDataFile = LOCAL\n", "HeaderSize is -1"),
        (local, "DistanceUnits = um\nElementDataFile = LOCAL\n", "DistanceUnits is um; valid: mm"),
        (local, "ElementDataFile = %03d.raw 1 9 1\n", "a file for each slice"),
        (local, "", "not MetaImage"),
        ("ObjectType = Image", "something", "not MetaImage"),
        ("ObjectType = Image", "NDims = 3", "ndims twice"),
    ] {
        let text = format!("{FIELDS}ElementType = MET_UCHAR\n{local}").replacen(from, to, 1);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ct.mha");
        std::fs::write(&path, [text.as_bytes(), &[1; 6]].concat()).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("ct.mha: ") && message.contains(words), "{words}: {message}");
    }
}
