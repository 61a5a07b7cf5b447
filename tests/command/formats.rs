//! The formats of images.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;

use dicom_dictionary_std::tags;
use drr::formats::{read_exr_metadata, read_png_texts, read_tiff_metadata};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

use super::*;

const ALL: [&str; 2] = ["--formats", "exr,png16,tiff,dicom"];

/// The pages of a file: name, description, values.
fn pages(path: &Path) -> Vec<(String, BTreeMap<String, String>, Vec<f32>)> {
    let mut decoder = Decoder::new(BufReader::new(File::open(path).expect("a file"))).expect("TIFF");
    let mut pages = Vec::new();
    loop {
        let name = decoder.get_tag_ascii_string(Tag::Unknown(285)).expect("a name");
        let text = decoder.get_tag_ascii_string(Tag::ImageDescription).expect("a description");
        let DecodingResult::F32(values) = decoder.read_image().expect("pixels") else { panic!("float32") };
        pages.push((name, serde_json::from_str(&text).expect("JSON"), values));
        if !decoder.more_images() {
            return pages;
        }
        decoder.next_image().expect("another page");
    }
}

fn samples(path: &Path) -> Vec<u16> {
    let file = BufReader::new(File::open(path).expect("a file"));
    let mut reader = png::Decoder::new(file).read_info().expect("PNG");
    assert_eq!(
        (reader.info().color_type, reader.info().bit_depth),
        (png::ColorType::Grayscale, png::BitDepth::Sixteen)
    );
    let mut bytes = vec![0; reader.output_buffer_size().expect("small")];
    reader.next_frame(&mut bytes).expect("pixels");
    bytes.as_chunks().0.iter().map(|&b| u16::from_be_bytes(b)).collect()
}

#[test]
fn every_format_has_the_same_values_and_says_the_same() {
    let folder = write_inputs();
    let text = project(folder.path(), &[&RAW, &LAYERS, &ALL, &["--raw", "--output", "out"]]);
    let words = "wrote   view0.exr ... view1.exr, view0_LAYER.png ... view1_LAYER.png, view0.tiff ... view1.tiff, view0_LAYER.dcm ... view1_LAYER.dcm,";
    assert!(text.contains(words), "{text}");
    let out = folder.path().join("out");
    for view in ["view0", "view1"] {
        let own: BTreeMap<_, _> =
            read_exr_metadata(&out.join(format!("{view}.exr"))).expect("EXR").into_iter().collect();
        assert_eq!(own["drr.patient_orientation"], r"L\H");
        let pages = pages(&out.join(format!("{view}.tiff")));
        let layers: Vec<&str> = own["drr.layers"].split(", ").collect();
        assert!(pages.iter().map(|(name, ..)| name).eq(&layers) && layers.len() == 7);
        for (name, description, values) in &pages {
            let file = format!("{view}_{}", name.replace('.', "_"));
            let exact = f32s(&out, &format!("{file}.f32"));
            assert!(
                values.iter().zip(&exact).all(|(a, b)| a.to_bits() == b.to_bits())
                    && values.len() == exact.len()
            );
            let png: BTreeMap<_, _> =
                read_png_texts(&out.join(format!("{file}.png"))).expect("PNG").into_iter().collect();
            for (key, value) in &own {
                assert_eq!((description.get(key), png.get(key)), (Some(value), Some(value)), "{name}: {key}");
            }
            for says in [description, &png] {
                assert_eq!(&says["drr.layer"], name);
            }
            let [offset, scale] =
                ["drr.offset", "drr.scale"].map(|key| png[key].parse::<f64>().expect("a number"));
            let samples = samples(&out.join(format!("{file}.png")));
            let most = exact.iter().copied().fold(0.0, f32::max);
            for (&sample, &exact) in samples.iter().zip(&exact) {
                let back = offset + scale * f64::from(sample);
                assert!((back - f64::from(exact)).abs() <= 0.500_001 * scale, "{name}: {exact} {back}");
            }
            // Sixteen bits, all of them.
            assert!(most == 0.0 || (scale - f64::from(most) / 65535.0).abs() < 1e-9 * scale, "{name}");
        }
        let unit = |layer: usize| pages[layer].1["drr.unit"].as_str();
        assert_eq!([0, 1, 2, 6].map(unit), ["weights of the spectrum", "1", "g/cm\u{b2}", "mm"]);
    }
}

/// RT Images are seen from the source with the head up, however the pose has rows and columns.
#[test]
fn rt_images_are_turned_as_viewers_show_them() {
    let folder = write_inputs();
    let [columns, rows] = [22, 14];
    let shot = |output: &str, others: &[&str]| {
        let own = ["--formats", "dicom", "--raw", "--layers", "line_integral", "--output", output];
        succeed(folder.path(), &[&["project"], &RAW[..], &own, others].concat());
        let out = folder.path().join(output);
        let object = dicom_object::open_file(out.join("view0_line_integral.dcm")).expect("DICOM");
        let decimal = |tag| object.element(tag).expect("there").to_float64().expect("a number");
        let (slope, intercept) = (decimal(tags::RESCALE_SLOPE), decimal(tags::RESCALE_INTERCEPT));
        let stored: Vec<u16> =
            object.element(tags::PIXEL_DATA).expect("there").to_multi_int().expect("16 bits");
        let values: Vec<f64> = stored.iter().map(|&s| intercept + slope * f64::from(s)).collect();
        let orientation = object.element(tags::PATIENT_ORIENTATION).expect("there").to_str().expect("text");
        let says =
            drr::formats::read_rt_image_description(&out.join("view0_line_integral.dcm")).expect("texts");
        assert!(says.iter().any(|(name, value)| name == "drr.layer" && value == "line_integral"), "{says:?}");
        (orientation.into_owned(), values, f32s(&out, "view0_line_integral.f32"), slope)
    };
    let c_arm = shot("c-arm", &[&SMALL[..], &["--angles", "0"]].concat());
    let (orientation, values, raw, slope) = &c_arm;
    assert_eq!(orientation, "L\\F");
    for (n, value) in values.iter().enumerate() {
        // The C-arm's first row is at the feet.
        let exact = raw[(rows - 1 - n / columns) * columns + n % columns];
        assert!((value - f64::from(exact)).abs() <= 0.51 * slope, "{n}: {value} {exact}");
    }
    // The same rays with columns the other way round.
    let mirrored = r#"{"width": 22, "height": 14, "views": [{"source": [13, -972.25, 34], "first_pixel": [76, 527.75, -5],
        "column_step": [-6, 0, 0], "row_step": [0, 0, 6]}]}"#;
    std::fs::write(folder.path().join("mirrored.json"), mirrored).expect("written");
    let (orientation, values, raw, _) = shot("mirrored", &["--geometry", "mirrored.json"]);
    assert_eq!(orientation, "L\\F");
    assert!(values.iter().zip(&c_arm.1).all(|(a, b)| (a - b).abs() <= 1.01 * slope));
    assert!(
        raw.chunks(columns)
            .zip(c_arm.2.chunks(columns))
            .all(|(a, b)| { a.iter().rev().zip(b).all(|(a, b)| (a - b).abs() < 1e-5) })
    );
    let output = drr(folder.path(), &["project", "--formats", "dicom", "--layers", "intensity"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("with line_integral in --layers"));
}

#[test]
fn only_the_formats_that_are_asked_for_are_written() {
    let folder = write_inputs();
    let written = |formats: &[&str], output: &str| {
        project(
            folder.path(),
            &[&RAW, &["--layers", "intensity", "--angles", "0", "--output", output], formats],
        );
        files(&folder.path().join(output))
    };
    assert_eq!(written(&[], "a"), ["plan.json", "radiograph.png", "view0.exr"]);
    let names = ["plan.json", "radiograph.png", "view0.tiff", "view0_intensity.png"];
    assert_eq!(written(&["--formats", "tiff,png16,tiff"], "b"), names);
    let output = drr(folder.path(), &["project", "--formats", "jpeg"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--formats"));
}

#[test]
fn a_table_s_views_are_finished_when_all_of_their_files_are_there() {
    let folder = write_inputs();
    std::fs::write(folder.path().join("views.csv"), "angle_degrees\n0\n10\n20\n").expect("written");
    let run = |formats: &str, others: &[&str]| {
        let own = ["project", "--views", "views.csv", "--no-check", "--output", "out", "--formats", formats];
        drr(folder.path(), &[&own[..], &RAW, &SMALL, others].concat())
    };
    let said = |formats: &str| {
        let output = run(formats, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    };
    assert!(said("png16").contains("3 view(s), 0 finished before"));
    assert!(said("png16").contains("0 view(s), 3 finished before"));
    // One file of one view is missing, then a format of all.
    let lost = folder.path().join("out/view000001_line_integral.png");
    let before = std::fs::read(&lost).expect("a file");
    std::fs::remove_file(&lost).expect("removed");
    assert!(said("png16").contains("1 view(s), 2 finished before"));
    assert_eq!(std::fs::read(&lost).expect("a file"), before);
    assert!(said("png16,tiff").contains("3 view(s), 0 finished before"));
    assert!(said("tiff").contains("0 view(s), 3 finished before"));
    assert!(said("dicom").contains("3 view(s), 0 finished before"));
    assert!(said("dicom").contains("0 view(s), 3 finished before"));
    // Files of any format say what they were made of.
    for (format, name) in [
        ("png16", "view000000_intensity.png"),
        ("tiff", "view000000.tiff"),
        ("dicom", "view000000_line_integral.dcm"),
    ] {
        std::fs::remove_file(folder.path().join("out/made_of.json")).ok();
        let output = run(format, &["--algorithm", "siddon"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(name) && error.contains("algorithm \"joseph\""), "{error}");
    }
    assert_eq!(
        read_tiff_metadata(&folder.path().join("out/view000002.tiff")).expect("TIFF")[0].0,
        "drr.algorithm"
    );
}
