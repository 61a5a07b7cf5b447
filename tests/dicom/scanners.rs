//! DICOM as scanners and makers of test data write it: series whose every voxel is known, and slices of real scanners. They
//! are beside the project where it is developed.

use std::path::{Path, PathBuf};

use drr::formats::{DicomCt, Slice, VoxelKind, open_ct};
use glam::DVec3;
use libtest_mimic::{Failed, Trial};
use serde_json::Value;

use crate::needing::ignored;
use crate::volume::{Read, check, open, read, refused};

const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/ct");

/// The tests, or one that says why there are none.
pub(crate) fn trials() -> Vec<Trial> {
    let shared = Path::new(SHARED);
    if !shared.exists() {
        return vec![ignored("scanners", format!("{SHARED} is not here"))];
    }
    let expected = std::fs::read_to_string(shared.join("synthetic_dicom/expected.json")).expect("readable");
    let expected: Value = serde_json::from_str(&expected).expect("JSON");
    let mut trials = vec![];
    for (name, series) in expected.as_object().expect("an object") {
        let (folder, series) = (shared.join("synthetic_dicom").join(name), series.clone());
        trials.push(Trial::test(format!("synthetic::{name}"), move || synthetic(&folder, &series)));
    }
    let field = expected["axial_unsigned12"].clone();
    trials.push(Trial::test("synthetic::a_series_is_chosen_by_its_uid", move || chosen(&field)));
    trials.push(Trial::test("lidc::twelve_slices_are_those_of_the_nifti_file", lidc));
    for name in [
        "deflated",
        "explicit_be",
        "implicit_le",
        "j2k_lossless",
        "jpeg_lossless_sv1",
        "jpegls_lossless",
        "rle",
    ] {
        trials.push(Trial::test(format!("lidc::{name}"), move || transfer_syntax(name)));
    }
    for (name, words) in REFUSED {
        trials.push(Trial::test(format!("real::{name}"), move || {
            refused(&shared.join("dicom_real").join(name), words)
        }));
    }
    for (name, from, to, expected) in STACKED {
        trials.push(Trial::test(format!("real::{name}"), move || stacked(name, from, to, expected)));
    }
    trials.push(Trial::test("real::series_ct5n", series_ct5n));
    trials.push(Trial::test("real::eCT_Supplemental", enhanced));
    trials
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

/// Words of the message for each reason to refuse a series.
fn words(reason: &str) -> &'static [&'static str] {
    match reason {
        "non-uniform slice spacing" => {
            &["uneven distances", "5.0000 mm", "2.5000 mm", "about 1 missing", "im002", "im003"]
        }
        "duplicate slice position" => &["at the position of another", "im002", "im003"],
        "single slice has no spacing" => &["single slice", "folder"],
        "ambiguous series unless a SeriesInstanceUID is chosen" => {
            &["2 series", "--series", "1.2.826.0.1.3680043.10.999.1.1.901", "8 slice(s) of 24 x 20"]
        }
        _ => &["a reason that this test doesn't know"],
    }
}

fn synthetic(folder: &Path, expected: &Value) -> Result<(), Failed> {
    if let Some(reason) = expected["must_fail"].as_str() {
        return refused(folder, words(reason));
    }
    known_field(&open(folder)?, expected)
}

/// Whether every voxel is that of the field at its place, and every place one that was scanned.
fn known_field(volume: &Read, expected: &Value) -> Result<(), Failed> {
    let Read { grid, hu, .. } = volume;
    let whole = |name: &str| expected[name].as_u64().expect("a number") as usize;
    let [n0, n1, n2] = [whole("columns"), whole("rows"), whole("slices")];
    check(grid.dimensions() == [n0, n1, n2], format!("{:?}", grid.dimensions()))?;
    let number = |name: &str| expected[name].as_f64().expect("a number");
    let (origin, slices) = (vector(&expected["origin_lps"]), numbers(&expected["slice_positions_mm"]));
    let [row, column, stack] =
        ["row_direction", "column_direction", "slice_direction"].map(|d| vector(&expected[d]));
    let (i_step, j_step) = (row * number("spacing_column_mm"), column * number("spacing_row_mm"));
    let (constant, gradient) =
        (expected["field"]["A"].as_f64().expect("a number"), vector(&expected["field"]["g"]));
    let quantum = number("hu_quantum");
    let padded = !expected["padding_stored"].is_null();
    let mut padding = 0;
    for (n, &hu) in hu.iter().enumerate() {
        let index = DVec3::new((n % n0) as f64, (n / n0 % n1) as f64, (n / n0 / n1) as f64);
        let place = grid.index_to_world().transform_point3(index);
        let slice_of = |k: &f64| origin + *k * stack + index.x * i_step + index.y * j_step;
        check(
            slices.iter().any(|k| (slice_of(k) - place).length() < 1e-3),
            format!("{index} is at {place}"),
        )?;
        let from_centre =
            (index.y - n1 as f64 / 2.0 + 0.5).powi(2) + (index.x - n0 as f64 / 2.0 + 0.5).powi(2);
        if padded && from_centre > (n1 as f64 / 2.0).powi(2) {
            padding += 1;
            check(hu < -1024.0, format!("padding at {index} is {hu} HU"))?;
            continue;
        }
        // A place that is a micrometre off is so many HU off.
        let tolerance = quantum / 2.0 + 1e-3 * gradient.length();
        let truth = constant + gradient.dot(place);
        check((hu - truth).abs() <= tolerance, format!("{hu} HU at {index}, where {truth} is"))?;
    }
    let whole =
        quantum.fract() == 0.0 && expected["note"] != "slope and intercept differ from slice to slice";
    check((volume.kind == VoxelKind::Int16) == whole, format!("{:?}", volume.kind))?;
    let note = volume.notes.iter().find(|note| note.contains("padding"));
    let counted = note.is_some_and(|note| note.starts_with(&format!("{padding} voxels")));
    check(if padded { counted } else { note.is_none() }, format!("{padding}, but {note:?}"))?;
    let tilted = expected["note"].as_str().is_some_and(|note| note.starts_with("tilted"));
    let note = volume.notes.iter().find(|note| note.contains("tilted by"));
    check(tilted == note.is_some(), format!("{note:?}"))
}

fn chosen(expected: &Value) -> Result<(), Failed> {
    let folder = Path::new(SHARED).join("synthetic_dicom/two_series_one_folder");
    let mut ct = DicomCt::open(&folder, Some("1.2.826.0.1.3680043.10.999.1.1.901"))?;
    known_field(&read(&mut ct)?, expected)?;
    let message = DicomCt::open(&folder, Some("1.2.3")).map(drop).expect_err("not there").to_string();
    check(message.contains("no series 1.2.3; valid:"), message)
}

fn lidc() -> Result<(), Failed> {
    let shared = Path::new(SHARED).join("lidc_idri_0001");
    let series = open(&shared.join("dicom_12"))?;
    let mut whole = open_ct(&shared.join("lidc_idri_0001.nii.gz"), None)?;
    let [n0, n1, n2] = series.grid.dimensions();
    check([n0, n1, n2] == [512, 512, 12], format!("{:?}", series.grid))?;
    let to_whole = whole.header().grid;
    // Where the first voxels of the first and of the last row are in the file.
    let map = |index: DVec3| to_whole.point_to_index(series.grid.index_to_world().transform_point3(index));
    let (corner, last) = (map(DVec3::ZERO), map(DVec3::new(0.0, 511.0, 11.0)));
    check((corner.round() - corner).length() < 1e-3, format!("{corner}"))?;
    check((last - corner - DVec3::new(0.0, -511.0, 11.0)).length() < 1e-3, format!("{corner} … {last}"))?;
    let [mut different, mut seen] = [0, 0];
    whole.read(&mut |k, slice| {
        let Slice::Int16(slice) = slice else { panic!("int16 was promised") };
        let k = k as f64 - corner.z.round();
        if (0.0..12.0).contains(&k) {
            for (j, row) in slice.chunks_exact(n0).enumerate() {
                let start = (k as usize * n1 + corner.y.round() as usize - j) * n0;
                let own = &series.hu[start..start + n0];
                different += own.iter().zip(row).filter(|&(&own, &hu)| own != f64::from(hu)).count();
                seen += n0;
            }
        }
        Ok(())
    })?;
    check(
        different == 0 && seen == series.hu.len() && n2 == 12,
        format!("{different} of {seen} voxels differ"),
    )
}

/// A folder with copies of files.
fn folder(files: &[PathBuf]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (n, file) in files.iter().enumerate() {
        std::fs::copy(file, folder.path().join(format!("{n}.dcm"))).expect("a copy");
    }
    folder
}

fn transfer_syntax(name: &str) -> Result<(), Failed> {
    let shared = Path::new(SHARED).join("lidc_idri_0001");
    let plain = |slice: &str| shared.join(format!("dicom_12/1-0{slice}.dcm"));
    let coded = shared.join(format!("transfer_syntaxes/{name}.dcm"));
    let expected = open(folder(&[plain("65"), plain("66"), plain("67")]).path())?;
    let decoded = open(folder(&[plain("65"), coded, plain("67")]).path())?;
    check(expected.grid == decoded.grid, format!("{:?}", decoded.grid))?;
    let different = decoded.hu.iter().zip(&expected.hu).filter(|(a, b)| a != b).count();
    check(different == 0 && decoded.hu.len() == 3 * 512 * 512, format!("{different} voxels differ"))
}

/// Files and folders that are no volume, and why.
const REFUSED: [(&str, &[&str]); 3] = [
    ("CT_small.dcm", &["CT_small.dcm", "single slice", "folder"]),
    (
        "series_ct2",
        &["uneven distances", "202.5000 mm", "1.2500 mm", "about 161 missing", "17106.dcm", "17136.dcm"],
    ),
    ("localizer_ct2n", &["2 localizer(s)", "no slices"]),
];

/// What a single slice of a real scanner must be when a copy of it lies beside it: smallest and largest HU, the sum, and the
/// tilt of the grid, degrees. By pydicom 3.0.2 with pylibjpeg.
#[derive(Clone, Copy)]
struct Stacked {
    range: [f64; 2],
    sum: f64,
    tilt: f64,
    k_step: DVec3,
}

/// The file, a text of its position, and what the copy has instead.
const STACKED: [(&str, &str, &str, Stacked); 4] = [
    // Signed pixels that were compressed as if they were not.
    (
        "J2K_pixelrep_mismatch.dcm",
        "-98.1898\\72.1446",
        "-98.1898\\77.1446",
        Stacked {
            range: [-2000.0, 1896.0],
            sum: -172_605_258.0,
            tilt: 22.0,
            k_step: DVec3::new(0.0, 0.0, 5.0),
        },
    ),
    (
        "explicit_VR-UN.dcm",
        "0\\0\\-121",
        "0\\0\\-120",
        Stacked {
            range: [-1024.0, 1186.0],
            sum: -175_887_460.0,
            tilt: 0.0,
            k_step: DVec3::new(0.0, 0.0, -1.0),
        },
    ),
    (
        "bad_sequence.dcm",
        "\\1687.5",
        "\\1688.5",
        Stacked {
            range: [13.0 - 1024.0, 2267.0 - 1024.0],
            sum: 248_348_502.0 - 1024.0 * 262_144.0,
            tilt: 0.0,
            k_step: DVec3::new(0.0, 0.0, 1.0),
        },
    ),
    (
        "CT_small_twice.dcm",
        "\\-75.699997",
        "\\-70.699997",
        Stacked {
            range: [128.0 - 1024.0, 2191.0 - 1024.0],
            sum: 14_826_310.0 - 1024.0 * 16384.0,
            tilt: 0.0,
            k_step: DVec3::new(0.0, 0.0, 5.0),
        },
    ),
];

fn stacked(name: &str, from: &str, to: &str, expected: Stacked) -> Result<(), Failed> {
    let path = Path::new(SHARED).join("dicom_real").join(name.replace("_twice", ""));
    refused(&path, &["single slice"])?;
    let folder = folder(std::slice::from_ref(&path));
    let mut bytes = std::fs::read(&path)?;
    let at = bytes.windows(from.len()).position(|part| part == from.as_bytes()).ok_or("no such text")?;
    bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
    std::fs::write(folder.path().join("copy.dcm"), bytes)?;
    let Read { grid, kind, hu, .. } = open(folder.path())?;
    check(kind == VoxelKind::Int16, format!("{kind:?}"))?;
    let slice = &hu[..hu.len() / 2];
    check(*slice == hu[hu.len() / 2..], "the copy differs")?;
    let range =
        [slice.iter().copied().fold(f64::MAX, f64::min), slice.iter().copied().fold(f64::MIN, f64::max)];
    check(range == expected.range, format!("{range:?}"))?;
    let sum: f64 = slice.iter().sum();
    check(sum == expected.sum, format!("{sum}"))?;
    let matrix = grid.index_to_world().matrix3;
    check((matrix.z_axis - expected.k_step).length() < 1e-3, format!("{matrix}"))?;
    let normal = matrix.x_axis.cross(matrix.y_axis);
    let angle = normal.angle_between(matrix.z_axis).to_degrees();
    check((angle - expected.tilt).abs() < 0.01, format!("{angle}°"))
}

fn series_ct5n() -> Result<(), Failed> {
    let Read { grid, hu, .. } = open(&Path::new(SHARED).join("dicom_real/series_ct5n"))?;
    let map = grid.index_to_world();
    check(grid.dimensions() == [16, 16, 5], format!("{grid:?}"))?;
    check((map.matrix3.z_axis - DVec3::new(0.0, 0.0, 2.5)).length() < 1e-6, format!("{map}"))?;
    // The lowest slice first, which is the last file: 991, 999, 1002 by pydicom.
    check(map.translation == DVec3::new(-72.199_997, -143.0, -1.2375), format!("{map}"))?;
    check(hu[..3] == [991.0 - 1024.0, 999.0 - 1024.0, 1002.0 - 1024.0], format!("{:?}", &hu[..3]))
}

fn enhanced() -> Result<(), Failed> {
    let Read { grid, kind, hu, notes } = open(&Path::new(SHARED).join("dicom_real/eCT_Supplemental.dcm"))?;
    check(grid.dimensions() == [512, 512, 2], format!("{grid:?}"))?;
    let map = grid.index_to_world();
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis];
    check(columns == [DVec3::X * -0.388_672, DVec3::Y * 0.388_672], format!("{map}"))?;
    // Rows run to the right, so slices in order of their normal run to the feet: the second frame comes first.
    check(map.matrix3.z_axis == DVec3::Z * -10.0 && map.translation.z == -149.0, format!("{map}"))?;
    check(kind == VoxelKind::Int16, format!("{kind:?}"))?;
    let sum: f64 = hu.iter().sum();
    check(sum == 199_249_408.0 - 1024.0 * 524_288.0, format!("{sum}"))?;
    check(notes.iter().any(|note| note.contains("called US, not HU")), format!("{notes:?}"))
}
