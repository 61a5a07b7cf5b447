use std::io::Write as _;

use flate2::{Compression, write::GzEncoder};

use crate::formats::VoxelKind;
use crate::formats::test_volume::read;

use super::*;

const FIELDS: &str = "NRRD0004\n# a remark: none\ncontent:\nkey:=value: of a user\ndimension: 3\nsizes: 3 1 2\n\
                      space: left-posterior-superior\nspace directions: (0,0.5,0) (-2,0,0) (0, 0.25 ,3)\n\
                      kinds: domain domain domain\nspace origin: (10,-20,30)\n";
const VALUES: [f64; 6] = [0.0, 1.0, 2.0, 100.0, 126.0, 127.0];

fn file(name: &str, fields: &str, voxels: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, [fields.as_bytes(), voxels].concat()).unwrap();
    (folder, path)
}

#[test]
fn every_type_byte_order_and_encoding_gives_its_values() {
    macro_rules! check {
        ($($number:ty, $kind:literal, $voxels:ident);*) => {$(
            let little: Vec<u8> = VALUES.iter().flat_map(|&v| (v as $number).to_le_bytes()).collect();
            let big: Vec<u8> = VALUES.iter().flat_map(|&v| (v as $number).to_be_bytes()).collect();
            let mut encoder = GzEncoder::new(vec![], Compression::fast());
            encoder.write_all(&big).unwrap();
            for (fields, bytes) in [
                ("endian: little\nencoding: raw\n\n", little),
                ("endian: big\nencoding: raw\n\n", big),
                ("endian: big\nencoding: gzip\n\n", encoder.finish().unwrap()),
            ] {
                let (_folder, path) = file("ct.nrrd", &format!("{FIELDS}type: {}\n{fields}", $kind), &bytes);
                let (grid, kind, values) = read(&path).unwrap();
                assert_eq!((kind, values.as_slice()), (VoxelKind::$voxels, &VALUES[..]), "{}", $kind);
                let place = grid.index_to_world().transform_point3(DVec3::new(2.0, 1.0, 1.0));
                assert_eq!(place, DVec3::new(8.0, -18.75, 33.0));
            }
        )*};
    }
    check!(i8, "signed char", Int16; u8, "uchar", Int16; i16, "short", Int16; u16, "unsigned short", Int16;
        i32, "int32_t", Int16; u32, "uint", Int16; i64, "long long", Int16; u64, "uint64", Int16;
        f32, "float", Float32; f64, "double", Float32);
}

#[test]
fn spaces_become_lps() {
    for (space, signs) in [
        ("left-posterior-superior", [1.0, 1.0]),
        ("LPS", [1.0, 1.0]),
        ("right-anterior-superior", [-1.0, -1.0]),
        ("RAS", [-1.0, -1.0]),
        ("left-anterior-superior", [1.0, -1.0]),
    ] {
        let fields = FIELDS.replace("left-posterior-superior", space);
        let (_folder, path) = file("ct.nrrd", &format!("{fields}type: uint8\nencoding: raw\n\n"), &[0; 6]);
        let map = read(&path).unwrap().0.index_to_world();
        let [x, y] = signs;
        assert_eq!(map.translation, DVec3::new(10.0 * x, -20.0 * y, 30.0), "{space}");
        assert_eq!(map.matrix3.x_axis, DVec3::new(0.0, 0.5 * y, 0.0), "{space}");
        assert_eq!(map.matrix3.y_axis, DVec3::new(-2.0 * x, 0.0, 0.0), "{space}");
    }
}

#[test]
fn voxels_in_another_file_are_found_beside_the_header() {
    for (fields, before) in [("", 0), ("byte skip: 9\n", 9), ("byteskip: -1\n", 5)] {
        let (folder, path) = file(
            "ct.nhdr",
            &format!("{FIELDS}{fields}type: uint8\nencoding: raw\ndata file: voxels.raw\n"),
            &[],
        );
        let mut bytes = vec![77; before];
        bytes.extend(VALUES.map(|v| v as u8));
        std::fs::write(folder.path().join("voxels.raw"), &bytes).unwrap();
        assert_eq!(read(&path).unwrap().2, VALUES);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let encoding = "encoding: raw";
    for (from, to, words) in [
        ("NRRD0004\n", "", "doesn't start with NRRD000"),
        ("dimension: 3", "dimension: 4", "dimension is 4; valid: 3"),
        ("dimension: 3", "dimension: 2", "dimension is 2; valid: 3"),
        ("dimension: 3", "dimension 3", "is not NRRD: it has \"dimension 3\""),
        ("sizes: 3 1 2", "sizes: 3 1", "sizes is"),
        ("sizes: 3 1 2", "sizes: 30000 30000 4", "truncated"),
        ("kinds: domain domain", "kinds: vector domain", "kinds has vector"),
        ("space: left-posterior-superior\n", "", "has no space; valid: left"),
        ("space: left-posterior-superior", "space: scanner-xyz", "space is scanner-xyz"),
        ("(0,0.5,0)", "none", "space directions are"),
        ("(0,0.5,0)", "(0,0.5)", "space directions are"),
        ("(0,0.5,0)", "(0,0,0)", "singular"),
        ("(10,-20,30)", "(10,-20,30", "space origin is"),
        ("type: uint8", "type: block", "type is block"),
        ("type: uint8", "type: int16", "has no endian"),
        (encoding, "encoding: bzip2", "encoding is bzip2; valid: raw, gzip"),
        (encoding, "encoding: hex", "encoding is hex; valid: raw, gzip"),
        (encoding, "encoding: raw\nline skip: 2", "line skip is 2"),
        (encoding, "encoding: raw\nspace units: \"m\" \"m\" \"m\"", "valid: mm"),
        (encoding, "encoding: raw\ndata file: LIST", "a file for each slice"),
    ] {
        let text = format!("{FIELDS}type: uint8\n{encoding}\n\n").replacen(from, to, 1);
        let (_folder, path) = file("ct.nrrd", &text, &[1; 6]);
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("ct.nrrd: ") && message.contains(words), "{words}: {message}");
    }
}
