//! What the reader promises, by files that the tests write.

use std::path::Path;

use dicom_core::value::PixelFragmentSequence;
use dicom_core::{DataElement, VR};
use dicom_dictionary_std::{tags, uids};
use drr::formats::{DicomCt, VoxelKind};
use glam::DVec3;
use libtest_mimic::{Failed, Trial};

use crate::series::{AXIAL, Image, Layout, SERIES, field, folder};
use crate::volume::{Read, check, open, read, refused};

type Test = fn() -> Result<(), Failed>;
type Change = fn(&mut Image);

/// The tests.
pub(crate) fn trials() -> Vec<Trial> {
    let tests: [(&str, Test); 19] = [
        ("a_field_is_where_it_was_scanned", a_field_is_where_it_was_scanned),
        ("every_byte_order_says_the_same", every_byte_order_says_the_same),
        ("a_tilted_gantry_shears_the_grid", a_tilted_gantry_shears_the_grid),
        ("every_slice_has_its_own_rescale", every_slice_has_its_own_rescale),
        ("int16_is_chosen_where_all_fits", int16_is_chosen_where_all_fits),
        ("padding_is_vacuum", padding_is_vacuum),
        ("bits_that_mean_nothing_are_masked", bits_that_mean_nothing_are_masked),
        ("positions_may_be_rounded_and_no_more", positions_may_be_rounded_and_no_more),
        ("gaps_and_repeated_slices_are_named", gaps_and_repeated_slices_are_named),
        ("slices_that_differ_are_named", slices_that_differ_are_named),
        ("series_are_listed_and_chosen", series_are_listed_and_chosen),
        ("a_series_is_read_beside_one_that_is_not", a_series_is_read_beside_one_that_is_not),
        ("localizers_are_no_slices", localizers_are_no_slices),
        ("other_files_are_passed_over", other_files_are_passed_over),
        ("what_is_missing_or_wrong_is_named", what_is_missing_or_wrong_is_named),
        ("frames_of_one_object_are_slices", frames_of_one_object_are_slices),
        ("frames_in_fragments_are_put_together", frames_in_fragments_are_put_together),
        ("truncated_files_are_refused", truncated_files_are_refused),
        ("sequences_of_any_length_are_passed_over", sequences_of_any_length_are_passed_over),
    ];
    tests.into_iter().map(|(name, test)| Trial::test(format!("written::{name}"), test)).collect()
}

/// Whether every voxel is that of the field at its place.
fn check_field(Read { grid, hu, .. }: &Read) -> Result<(), Failed> {
    let [n0, n1, n2] = grid.dimensions();
    check(hu.len() == n0 * n1 * n2, format!("{} voxels", hu.len()))?;
    for (n, &hu) in hu.iter().enumerate() {
        let index = DVec3::new((n % n0) as f64, (n / n0 % n1) as f64, (n / n0 / n1) as f64);
        let place = grid.index_to_world().transform_point3(index);
        check((hu - field(place)).abs() < 1e-6, format!("{hu} HU at {place}, where {} is", field(place)))?;
    }
    Ok(())
}

fn a_field_is_where_it_was_scanned() -> Result<(), Failed> {
    let oblique = [DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.0, 0.0, -1.0)];
    for directions in [[DVec3::X, DVec3::Y], [DVec3::X, -DVec3::Y], [DVec3::Y, -DVec3::Z], oblique] {
        let layout = Layout { directions, ..AXIAL };
        let normal = directions[0].cross(directions[1]);
        // Neither the order of names nor that of positions.
        let slices: Vec<_> =
            [2.0, 0.0, 6.0, 4.0].iter().map(|distance| layout.slice(distance * normal)).collect();
        let volume = open(folder(&slices).path())?;
        check(
            volume.grid.dimensions() == [5, 4, 4] && volume.kind == VoxelKind::Int16,
            format!("{:?}", volume.grid),
        )?;
        let expected = DVec3::new(0.5, 2.0, 2.0);
        check((volume.grid.spacing() - expected).length() < 1e-12, format!("{}", volume.grid.spacing()))?;
        check((volume.grid.index_to_world().translation - layout.origin).length() < 1e-12, "another origin")?;
        check_field(&volume)?;
    }
    Ok(())
}

fn every_byte_order_says_the_same() -> Result<(), Failed> {
    #[allow(deprecated, reason = "retired, but files have it")]
    let big = uids::EXPLICIT_VR_BIG_ENDIAN;
    for syntax in [uids::IMPLICIT_VR_LITTLE_ENDIAN, uids::EXPLICIT_VR_LITTLE_ENDIAN, big] {
        let folder = tempfile::tempdir()?;
        for (n, slice) in AXIAL.stack(&[0.0, 3.0]).iter().enumerate() {
            slice.save(&folder.path().join(format!("{n}")), syntax);
        }
        check_field(&open(folder.path())?)?;
    }
    let mut bytes = AXIAL.slice(DVec3::ZERO);
    bytes.word(tags::BITS_ALLOCATED, 8).word(tags::BITS_STORED, 8).word(tags::HIGH_BIT, 7);
    let folder = tempfile::tempdir()?;
    bytes.save(&folder.path().join("0"), big);
    refused(folder.path(), &["BitsAllocated", "is 8 in big endian"])
}

fn a_tilted_gantry_shears_the_grid() -> Result<(), Failed> {
    let (sin, cos) = 17.5_f64.to_radians().sin_cos();
    let layout = Layout { directions: [DVec3::X, DVec3::new(0.0, cos, -sin)], ..AXIAL };
    let volume = open(folder(&layout.stack(&[0.0, 5.0, 10.0])).path())?;
    let step = volume.grid.index_to_world().matrix3.z_axis;
    check((step - DVec3::Z * 5.0).length() < 1e-9, format!("{step}"))?;
    check_field(&volume)?;
    check(volume.notes.iter().any(|note| note.contains("tilted by 17.50°")), format!("{:?}", volume.notes))
}

fn every_slice_has_its_own_rescale() -> Result<(), Failed> {
    let mut slices = AXIAL.stack(&[0.0, 1.0, 2.0]);
    for (slice, slope) in slices.iter_mut().zip([0.25, 0.5, 2.0]) {
        let intercept = -1024.0 - 8.0 * slope;
        let rescaled = |stored: u16| ((f64::from(stored as i16) - 1024.0 - intercept) / slope) as i16 as u16;
        // Stored numbers are whole for even HU.
        slice.map(|_, stored| rescaled(stored & !1)).numbers(tags::RESCALE_SLOPE, &[slope]);
        slice.numbers(tags::RESCALE_INTERCEPT, &[intercept]);
    }
    let volume = open(folder(&slices).path())?;
    check(volume.kind == VoxelKind::Float32, format!("{:?}", volume.kind))?;
    let truth = (0..3).flat_map(|k| AXIAL.places(DVec3::Z * f64::from(k))).map(field);
    let even = |hu: f64| 2.0 * (hu / 2.0).floor();
    check(volume.hu.iter().zip(truth).all(|(&hu, truth)| hu == even(truth)), format!("{:?}", volume.hu))
}

fn int16_is_chosen_where_all_fits() -> Result<(), Failed> {
    // Unsigned numbers of 16 bits may or may not fit.
    for (largest, kind) in [(32767 + 1024, VoxelKind::Int16), (32768 + 1024, VoxelKind::Float32)] {
        let mut slices = AXIAL.stack(&[0.0, 1.0]);
        slices[0].word(tags::PIXEL_REPRESENTATION, 0);
        slices[1].word(tags::PIXEL_REPRESENTATION, 0).map(|n, stored| if n == 7 { largest } else { stored });
        let volume = open(folder(&slices).path())?;
        check(
            volume.kind == kind && volume.hu[27] == f64::from(largest) - 1024.0,
            format!("{:?}", volume.kind),
        )?;
    }
    // What an int16 cannot hold at its lower end is padding whatever it is.
    let mut slices = AXIAL.stack(&[0.0, 1.0]);
    slices[1].map(|n, stored| if n == 3 { i16::MIN as u16 } else { stored });
    let volume = open(folder(&slices).path())?;
    check(volume.kind == VoxelKind::Int16 && volume.hu[23] < -1024.0, format!("{}", volume.hu[23]))
}

fn padding_is_vacuum() -> Result<(), Failed> {
    let padded = |limit: Option<i16>, values: [i16; 3]| {
        let mut slices = AXIAL.stack(&[0.0, 1.0]);
        for slice in &mut slices {
            // Signed pixels, but the attribute has the VR of unsigned ones.
            slice.word(tags::PIXEL_PADDING_VALUE, -2000_i16 as u16);
            if let Some(limit) = limit {
                slice.word(tags::PIXEL_PADDING_RANGE_LIMIT, limit as u16);
            }
            slice.map(|n, stored| if n < 3 { values[n] as u16 } else { stored });
        }
        open(folder(&slices).path())
    };
    let volume = padded(None, [-2000, -1999, 3000])?;
    check(volume.hu[0] < -1024.0 && volume.hu[1..3] == [-3023.0, 1976.0], format!("{:?}", &volume.hu[..3]))?;
    check(
        volume.notes.iter().any(|note| note.starts_with("2 voxels are padding")),
        format!("{:?}", volume.notes),
    )?;
    // Before rescale: with an intercept of −1024, 3000 is tissue.
    let volume = padded(Some(3000), [-1000, 3000, 3001])?;
    let vacuum = volume.hu[..2].iter().all(|&hu| hu < -1024.0);
    check(vacuum && volume.hu[2] == 1977.0, format!("{:?}", &volume.hu[..3]))
}

fn bits_that_mean_nothing_are_masked() -> Result<(), Failed> {
    for signed in [0, 1] {
        let mut slices = AXIAL.stack(&[0.0, 1.0]);
        for slice in &mut slices {
            slice
                .word(tags::BITS_STORED, 12)
                .word(tags::HIGH_BIT, 11)
                .word(tags::PIXEL_REPRESENTATION, signed);
            let offset = if signed == 1 { 1024 } else { 0 };
            slice.numbers(tags::RESCALE_INTERCEPT, &[f64::from(offset) - 1024.0]);
            slice.map(|n, stored| stored.wrapping_sub(offset as u16) & 0xfff | (n as u16) << 12);
        }
        check_field(&open(folder(&slices).path())?)?;
    }
    Ok(())
}

fn positions_may_be_rounded_and_no_more() -> Result<(), Failed> {
    // 0.625 mm, with two decimals.
    let volume = open(folder(&AXIAL.stack(&[0.0, 0.63, 1.25, 1.88, 2.5])).path())?;
    check((volume.grid.spacing().z - 0.625).abs() < 1e-9, format!("{}", volume.grid.spacing()))?;
    refused(folder(&AXIAL.stack(&[0.0, 0.34, 0.6, 0.9])).path(), &["uneven distances"])?;
    // Sideways, which distances along the normal do not show.
    let mut slices = AXIAL.stack(&[0.0, 1.0, 2.0, 3.0]);
    slices[1] = AXIAL.slice(DVec3::new(0.02, 0.0, 1.0));
    refused(folder(&slices).path(), &["not on a line", "im1.dcm", "0.0200 mm"])
}

fn gaps_and_repeated_slices_are_named() -> Result<(), Failed> {
    let words =
        ["uneven distances", "4.0000 mm between", "im1.dcm and", "im2.dcm", "2.0000 mm: about 1 missing"];
    refused(folder(&AXIAL.stack(&[0.0, 2.0, 6.0, 8.0])).path(), &words)?;
    let words = ["1 slice(s) at the position of another", "im1.dcm and", "im2.dcm"];
    refused(folder(&AXIAL.stack(&[0.0, 2.0, 2.0, 4.0])).path(), &words)?;
    refused(folder(&AXIAL.stack(&[0.0])).path(), &["single slice", "im0.dcm", "valid: the folder"])
}

fn slices_that_differ_are_named() -> Result<(), Failed> {
    let other = |layout: Layout| {
        let mut slices = AXIAL.stack(&[0.0, 1.0]);
        slices.push(layout.slice(DVec3::Z * 2.0));
        folder(&slices)
    };
    let (sin, cos) = 0.01_f64.sin_cos();
    let turned = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)];
    for (layout, words) in [
        (Layout { rows: 5, ..AXIAL }, ["different size", "5 x 4", "5 x 5"]),
        (Layout { spacing: [0.5, 1.9], ..AXIAL }, ["different pixel spacing", "2 mm", "1.9 mm"]),
        (Layout { directions: turned, ..AXIAL }, ["different orientation", "im0.dcm", "im2.dcm"]),
    ] {
        refused(other(layout).path(), &words)?;
    }
    let mut slices = AXIAL.stack(&[0.0, 1.0, 2.0]);
    for (slice, frame) in slices.iter_mut().zip(["1.2", "1.2", "1.3"]) {
        slice.text(tags::FRAME_OF_REFERENCE_UID, VR::UI, frame);
    }
    refused(folder(&slices).path(), &["different FrameOfReferenceUID: 1.2 in", "1.3 in", "im2.dcm"])
}

fn series_are_listed_and_chosen() -> Result<(), Failed> {
    let mut slices = AXIAL.stack(&[0.0, 1.0, 2.0]);
    for slice in &mut AXIAL.stack(&[0.0, 1.0]) {
        slice.text(tags::SERIES_INSTANCE_UID, VR::UI, "9.8.7").text(tags::SERIES_DESCRIPTION, VR::LO, "LUNG");
        slices.push(slice.clone());
    }
    let folder = folder(&slices);
    let words =
        ["2 series", "--series", SERIES, "THORAX 2.0: 3 slice(s) of 5 x 4", "9.8.7  LUNG: 2 slice(s)"];
    refused(folder.path(), &words)?;
    for (uid, count) in [(SERIES, 3), ("9.8.7", 2)] {
        let volume = read(&mut DicomCt::open(folder.path(), Some(uid))?)?;
        check(volume.grid.dimensions()[2] == count, format!("{:?}", volume.grid))?;
        check_field(&volume)?;
    }
    let message = DicomCt::open(folder.path(), Some("1")).map(drop).expect_err("not there").to_string();
    check(message.contains("no series 1; valid:") && message.contains("9.8.7"), message)
}

fn a_series_is_read_beside_one_that_is_not() -> Result<(), Failed> {
    let mut slices = AXIAL.stack(&[0.0, 1.0, 2.0]);
    let mut atomic = AXIAL.slice(DVec3::ZERO);
    atomic.text(tags::SERIES_INSTANCE_UID, VR::UI, "9.8.7").text(tags::RESCALE_TYPE, VR::LO, "Z_EFF");
    slices.push(atomic.clone());
    let folder = folder(&slices);
    check_field(&read(&mut DicomCt::open(folder.path(), Some(SERIES))?)?)?;
    refused(folder.path(), &["im3.dcm", "RescaleType", "Z_EFF"])?;
    // A film of another modality is passed over, whatever encodes it.
    let file = folder.path().join("im3.dcm");
    atomic.text(tags::MODALITY, VR::CS, "XC").save(&file, uids::MPEG4HP41);
    check_field(&open(folder.path())?)?;
    atomic.text(tags::MODALITY, VR::CS, "CT").save(&file, uids::MPEG4HP41);
    refused(folder.path(), &["im3.dcm", "TransferSyntaxUID", "MPEG-4"])
}

fn localizers_are_no_slices() -> Result<(), Failed> {
    let mut scouts = AXIAL.stack(&[0.0, 1.0]);
    for scout in &mut scouts {
        scout.text(tags::IMAGE_TYPE, VR::CS, "ORIGINAL\\PRIMARY\\LOCALIZER");
    }
    refused(folder(&scouts).path(), &["2 localizer(s)", "no slices"])?;
    let all = [scouts, AXIAL.stack(&[0.0, 1.0, 2.0])].concat();
    let volume = open(folder(&all).path())?;
    check(
        volume.notes.iter().any(|note| note == "2 localizer(s) passed over"),
        format!("{:?}", volume.notes),
    )?;
    check_field(&volume)
}

fn other_files_are_passed_over() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let nested = folder.path().join("study/series");
    std::fs::create_dir_all(&nested)?;
    for (n, slice) in AXIAL.stack(&[0.0, 1.0, 2.0]).iter().enumerate() {
        slice.save(&nested.join(format!("IM{n}")), uids::EXPLICIT_VR_LITTLE_ENDIAN);
    }
    std::fs::write(folder.path().join("README"), "not DICOM")?;
    // Opening a pipe would wait for its writer.
    #[cfg(unix)]
    check(std::process::Command::new("mkfifo").arg(nested.join("pipe")).status()?.success(), "mkfifo")?;
    std::fs::write(nested.join("._IM0.dcm"), [0; 500])?;
    let mut report = AXIAL.slice(DVec3::ZERO);
    for tag in [tags::ROWS, tags::COLUMNS, tags::PIXEL_DATA] {
        report.without(tag);
    }
    report.save(&folder.path().join("DICOMDIR"), uids::EXPLICIT_VR_LITTLE_ENDIAN);
    let mut dose = AXIAL.slice(DVec3::ZERO);
    dose.text(tags::MODALITY, VR::CS, "RTDOSE").save(&nested.join("dose"), uids::EXPLICIT_VR_LITTLE_ENDIAN);
    let mut report = AXIAL.slice(DVec3::ZERO);
    report.text(tags::SOP_CLASS_UID, VR::UI, uids::SECONDARY_CAPTURE_IMAGE_STORAGE);
    report.text(tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "RGB").without(tags::IMAGE_POSITION_PATIENT);
    report.save(&nested.join("dose_report.dcm"), uids::EXPLICIT_VR_LITTLE_ENDIAN);
    for path in [folder.path(), &folder.path().join("DICOMDIR"), &nested] {
        let volume = open(path)?;
        check(
            volume.notes.iter().any(|note| note.contains("images of CT (secondary capture), RTDOSE")),
            format!("{:?}", volume.notes),
        )?;
        check_field(&volume)?;
    }
    std::fs::remove_dir_all(&nested)?;
    refused(folder.path(), &["no DICOM image in 2 file(s)"])?;
    std::fs::write(folder.path().join("slice.dcm"), "not DICOM")?;
    refused(folder.path(), &["slice.dcm: is not DICOM"])
}

fn what_is_missing_or_wrong_is_named() -> Result<(), Failed> {
    let with = |change: &dyn Fn(&mut Image)| {
        let mut slices = AXIAL.stack(&[0.0, 1.0]);
        change(&mut slices[1]);
        folder(&slices)
    };
    for (tag, name) in [
        (tags::IMAGE_POSITION_PATIENT, "ImagePositionPatient"),
        (tags::IMAGE_ORIENTATION_PATIENT, "ImageOrientationPatient"),
        (tags::PIXEL_SPACING, "PixelSpacing"),
        (tags::RESCALE_SLOPE, "RescaleSlope"),
        (tags::RESCALE_INTERCEPT, "RescaleIntercept"),
        (tags::BITS_STORED, "BitsStored"),
        (tags::PIXEL_REPRESENTATION, "PixelRepresentation"),
        (tags::MODALITY, "Modality"),
        (tags::SERIES_INSTANCE_UID, "SeriesInstanceUID"),
        (tags::PHOTOMETRIC_INTERPRETATION, "PhotometricInterpretation"),
        (tags::PIXEL_DATA, "PixelData"),
    ] {
        refused(
            with(&|image| _ = image.without(tag)).path(),
            &["im1.dcm", &format!("{name} ("), "is missing"],
        )?;
    }
    let changes: [(&str, Change); 9] = [
        ("is RGB; valid: MONOCHROME1", |image| {
            image.text(tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "RGB");
        }),
        ("BitsAllocated (0028,0100) is 12", |image| _ = image.word(tags::BITS_ALLOCATED, 12)),
        ("HighBit (0028,0102) is 16", |image| _ = image.word(tags::HIGH_BIT, 16)),
        ("PixelSpacing (0028,0030) is 0, 1", |image| _ = image.numbers(tags::PIXEL_SPACING, &[0.0, 1.0])),
        ("PixelSpacing (0028,0030) is \"nan", |image| _ = image.text(tags::PIXEL_SPACING, VR::DS, "nan\\1")),
        ("RescaleSlope (0028,1053) is 0", |image| _ = image.numbers(tags::RESCALE_SLOPE, &[0.0])),
        ("RescaleType (0028,1054) is EDW", |image| _ = image.text(tags::RESCALE_TYPE, VR::LO, "EDW")),
        ("valid: unit vectors at right angles", |image| {
            image.numbers(tags::IMAGE_ORIENTATION_PATIENT, &[1.0, 0.0, 0.0, 0.1, 1.0, 0.0]);
        }),
        ("NumberOfFrames (0028,0008) is 2", |image| _ = image.text(tags::NUMBER_OF_FRAMES, VR::IS, "2")),
    ];
    for (words, change) in changes {
        refused(with(&change).path(), &["im1.dcm", words])?;
    }
    let mut slices = AXIAL.stack(&[0.0, 1.0]);
    for slice in &mut slices {
        slice.text(tags::MODALITY, VR::CS, "MR");
    }
    refused(folder(&slices).path(), &["Modality is MR", "valid: CT"])
}

/// An enhanced object of frames at these distances; the last frame has a slope of its own.
fn enhanced(distances: &[f64]) -> Image {
    let mut whole = AXIAL.slice(DVec3::ZERO);
    let orientation = whole.moved(&[tags::IMAGE_ORIENTATION_PATIENT]);
    let measures = whole.moved(&[tags::PIXEL_SPACING, tags::SLICE_THICKNESS]);
    let rescale = whole.moved(&[tags::RESCALE_SLOPE, tags::RESCALE_INTERCEPT]);
    let mut shared = whole.moved(&[]);
    shared.sequence(tags::PLANE_ORIENTATION_SEQUENCE, vec![orientation]);
    shared.sequence(tags::PIXEL_MEASURES_SEQUENCE, vec![measures]);
    shared.sequence(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, vec![rescale]);
    let (mut frames, mut pixels) = (vec![], vec![]);
    for (n, &z) in distances.iter().enumerate() {
        let mut slice = AXIAL.slice(DVec3::Z * z);
        let mut frame = slice.moved(&[]);
        if n + 1 == distances.len() {
            // Half of the number, and twice its weight.
            slice.map(|_, stored| (stored as i16 * 2) as u16);
            slice.numbers(tags::RESCALE_SLOPE, &[0.5]);
            let own = slice.moved(&[tags::RESCALE_SLOPE, tags::RESCALE_INTERCEPT]);
            frame.sequence(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, vec![own]);
        }
        pixels.extend(
            slice.object.element(tags::PIXEL_DATA).expect("there").to_multi_int::<u16>().expect("words"),
        );
        frame.sequence(tags::PLANE_POSITION_SEQUENCE, vec![slice.moved(&[tags::IMAGE_POSITION_PATIENT])]);
        frames.push(frame);
    }
    whole.without(tags::IMAGE_POSITION_PATIENT).text(
        tags::NUMBER_OF_FRAMES,
        VR::IS,
        &distances.len().to_string(),
    );
    whole.sequence(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, vec![shared]);
    whole.sequence(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, frames).pixels(pixels);
    whole
}

fn frames_of_one_object_are_slices() -> Result<(), Failed> {
    for distances in [[0.0, 3.0, 6.0], [6.0, 0.0, 3.0]] {
        for syntax in [uids::EXPLICIT_VR_LITTLE_ENDIAN, uids::IMPLICIT_VR_LITTLE_ENDIAN] {
            let folder = tempfile::tempdir()?;
            let path = folder.path().join("enhanced");
            enhanced(&distances).save(&path, syntax);
            let volume = open(&path)?;
            check(volume.grid.dimensions() == [5, 4, 3], format!("{:?}", volume.grid))?;
            check(volume.kind == VoxelKind::Float32, format!("{:?}", volume.kind))?;
            check_field(&volume)?;
        }
    }
    let folder = folder(&[enhanced(&[0.0, 3.0, 9.0])]);
    refused(folder.path(), &["uneven distances", "frame 2", "frame 3"])
}

/// A frame in RLE, byte for byte.
fn rle(pixels: &[u16]) -> Vec<u8> {
    let plane = |shift: u32| -> Vec<u8> {
        let bytes: Vec<u8> = pixels.iter().map(|pixel| (pixel >> shift) as u8).collect();
        bytes
            .chunks(100)
            .flat_map(|part| std::iter::once(part.len() as u8 - 1).chain(part.to_vec()))
            .collect()
    };
    let (high, low) = (plane(8), plane(0));
    let starts = [2, 64, 64 + high.len() as u32].into_iter().chain([0; 13]);
    let mut frame: Vec<u8> = starts.flat_map(u32::to_le_bytes).chain(high).chain(low).collect();
    frame.resize(frame.len().next_multiple_of(4), 0);
    frame
}

fn frames_in_fragments_are_put_together() -> Result<(), Failed> {
    let whole = enhanced(&[0.0, 3.0, 6.0]);
    let pixels: Vec<u16> = whole.object.element(tags::PIXEL_DATA)?.to_multi_int()?;
    let frames: Vec<_> = pixels.chunks(20).map(rle).collect();
    let halves: Vec<_> =
        frames.iter().flat_map(|frame| frame.chunks(frame.len() / 2).map(<[u8]>::to_vec)).collect();
    // Each fragment has a header of 8 bytes.
    let offsets: Vec<u32> = (0..3).map(|n| n * (frames[0].len() as u32 + 16)).collect();
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("ct");
    for (table, fragments, read) in [
        (vec![], &frames, true),
        (offsets.clone(), &halves, true),
        (vec![], &halves, false),
        (vec![0, 9], &halves, false),
    ] {
        let mut coded = whole.clone();
        let value = PixelFragmentSequence::new(table.clone(), fragments.clone());
        coded.object.put(DataElement::new(tags::PIXEL_DATA, VR::OB, value));
        coded.save(&path, uids::RLE_LOSSLESS);
        if read {
            check_field(&open(&path)?)?;
        } else {
            refused(&path, &[&format!("6 fragments and {} offsets for 3 frames", table.len())])?;
        }
    }
    Ok(())
}

fn truncated_files_are_refused() -> Result<(), Failed> {
    let folder = folder(&AXIAL.stack(&[0.0, 1.0]));
    let path = folder.path().join("im1.dcm");
    let whole = std::fs::read(&path)?;
    check_field(&open(folder.path())?)?;
    for length in 132..whole.len() {
        std::fs::write(&path, &whole[..length])?;
        refused(folder.path(), &[]).map_err(|_| format!("{length} bytes are read"))?;
    }
    std::fs::write(&path, &whole[..whole.len() - 1])?;
    refused(folder.path(), &["im1.dcm", "truncated"])
}

fn sequences_of_any_length_are_passed_over() -> Result<(), Failed> {
    let folder = folder(&AXIAL.stack(&[0.0, 1.0]));
    let path: &Path = &folder.path().join("im1.dcm");
    let whole = std::fs::read(path)?;
    // Before the pixels, whose element header is the last of its kind: one of unknown VR and length, whose item, of unknown
    // length too, is implicit VR; and one of known VR, in which one is nested.
    let header = [0xe0, 0x7f, 0x10, 0x00, b'O', b'W', 0, 0];
    let at = whole.windows(8).position(|bytes| bytes == header).ok_or("no pixels")?;
    let open = [0xff; 4];
    let (item, end_item, end) = ([0xfe, 0xff, 0, 0xe0], [0xfe, 0xff, 0x0d, 0xe0], [0xfe, 0xff, 0xdd, 0xe0]);
    let element = [0x28, 0, 0x10, 0, 2, 0, 0, 0, 9, 9];
    let unknown = [&[0x09, 0x60, 1, 0x10, b'U', b'N', 0, 0], &open[..], &item, &open, &element].concat();
    let known = [&[0x0b, 0x60, 1, 0x10, b'S', b'Q', 0, 0], &open[..], &item, &open].concat();
    let inner = [&[0x0b, 0x60, 2, 0x10, b'S', b'Q', 0, 0], &open[..], &item, &[0; 4], &end, &[0; 4]].concat();
    let close = [&end_item[..], &[0; 4], &end, &[0; 4]].concat();
    let sequences = [unknown, close.clone(), known, inner, close].concat();
    std::fs::write(path, [&whole[..at], &sequences, &whole[at..]].concat())?;
    check_field(&self::open(folder.path())?)?;
    // Without end, each in the one before.
    let endless: Vec<u8> =
        [&[0x0b, 0x60, 1, 0x10, b'S', b'Q', 0, 0], &open[..], &item, &open].concat().repeat(1 << 16);
    std::fs::write(path, [&whole[..at], &endless].concat())?;
    refused(folder.path(), &["im1.dcm", "32 deep"])
}
