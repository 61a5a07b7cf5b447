//! CTs become images.

use super::*;

#[test]
#[cfg_attr(debug_assertions, ignore = "half a minute without optimisation")]
fn the_main_job_needs_no_arguments() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = succeed(folder.path(), &[]);
    for word in ["720×720 pixels", "rays/s", "samples/s", "RMSE", "HU", "drr-output"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let names = ["plan.json", "radiograph.png", "view0.exr", "view1.exr"];
    assert_eq!(files(&folder.path().join("drr-output")), names);
}

#[test]
fn the_built_in_ct_gives_every_file_and_a_measured_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["project", "--size", "40x36", "--angles", "-6,0,90"];
    let text = succeed(folder.path(), &arguments);
    let names = ["plan.json", "radiograph.png", "view0.exr", "view1.exr", "view2.exr"];
    assert_eq!(files(&folder.path().join("drr-output")), names);
    let rounding = text.lines().find(|line| line.contains("rounding")).expect("the error is stated");
    let rmse: f64 = between(rounding, "RMSE ", " HU").parse().expect("a number");
    assert!(rmse > 0.0 && rmse < 0.01, "{rounding}");
    let plan: serde_json::Value =
        serde_json::from_slice(&bytes(folder.path(), "drr-output/plan.json")).expect("JSON");
    assert_eq!(plan["detector"], serde_json::json!([40, 36]));
    assert_eq!(plan["volume"], serde_json::json!([128, 128, 133]));
    assert_eq!(succeed(folder.path(), &[&arguments[..], &["--quiet"]].concat()), "");
}

#[test]
fn raw_and_nifti_inputs_give_identical_bytes() {
    let folder = write_inputs();
    let pair: [(&[&str], &[&str]); 2] = [
        (&["--ct", "ct.nii.gz"], &RAW),
        (&["--ct", "ct.nii.gz", "--labels", "labels.nii"], &[&RAW[..], &["--labels", "labels.raw"]].concat()),
    ];
    for (nifti, raw) in pair {
        project(folder.path(), &[nifti, &LAYERS, &["--output", "a"]]);
        project(folder.path(), &[raw, &LAYERS, &["--output", "b"]]);
        // NIfTI's frame is mirrored twice: both grids are the same, so every byte is.
        for name in ["view0.exr", "view1.exr", "radiograph.png", "plan.json"] {
            assert!(
                bytes(folder.path(), &format!("a/{name}")) == bytes(folder.path(), &format!("b/{name}")),
                "{name}"
            );
        }
    }
}

#[test]
fn raw_outputs_are_the_layers_of_the_exr() {
    let folder = write_inputs();
    project(folder.path(), &[&["--ct", "ct.nii.gz", "--raw", "--output", "out"], &LAYERS]);
    let out = folder.path().join("out");
    for view in 0..2 {
        let file = read_all_flat_layers_from_file(out.join(format!("view{view}.exr"))).expect("OpenEXR");
        let layer = &file.layer_data[0];
        let attributes: Vec<_> = layer.attributes.other.keys().map(ToString::to_string).collect();
        for name in ["source", "spectrum", "algorithm", "version", "units"] {
            assert!(attributes.contains(&format!("drr.{name}")), "{name}: {attributes:?}");
        }
        let mut names = Vec::new();
        for channel in &layer.channel_data.list {
            let FlatSamples::F32(values) = &channel.sample_data else { panic!("float32 is written") };
            let name = channel.name.to_string();
            assert_eq!(&f32s(&out, &format!("view{view}_{}.f32", name.replace('.', "_"))), values, "{name}");
            // The air around this chest has −1000 HU and no density.
            assert_eq!(values.iter().any(|&v| v != 0.0), name != "areal_density.air", "{name}");
            names.push(name);
        }
        let materials = ["air", "bone_cortical", "lung", "soft_tissue"].map(|m| format!("areal_density.{m}"));
        assert_eq!(
            names,
            [&materials[..], &["bone_path", "intensity", "line_integral"].map(String::from)].concat()
        );
    }
}

/// Columns and pixels of 8 bits.
fn grey_picture(path: &Path) -> (usize, Vec<u8>) {
    let file = std::fs::File::open(path).expect("a picture");
    let mut picture = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("PNG");
    let mut pixels = vec![0; picture.output_buffer_size().expect("small")];
    let info = picture.next_frame(&mut pixels).expect("PNG");
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Eight));
    (info.width as usize, pixels)
}

#[test]
fn the_picture_has_the_head_up_and_the_left_side_right() {
    let folder = tempfile::tempdir().expect("a folder");
    // Bone where x (to the patient's left) and z (to the head) are large, air elsewhere.
    let hu = (0..8_u16 * 8 * 8).map(|n| if n % 8 >= 5 && n / 64 >= 5 { 1000_i16 } else { -1000 });
    let raw: Vec<u8> = hu.flat_map(i16::to_le_bytes).collect();
    std::fs::write(folder.path().join("ct.raw"), raw).expect("written");
    std::fs::write(folder.path().join("alike.csv"), "energy_keV,a b,a_b\n60,0.2,0.2\n").expect("written");
    let ct = ["--ct", "ct.raw", "--dims", "8,8,8", "--spacing", "10,10,10", "--angles", "0"];
    succeed(folder.path(), &[&["project"], &ct[..], &["--size", "40x40", "--output", "out"]].concat());
    let (_, pixels) = grey_picture(&folder.path().join("out/radiograph.png"));
    let bright: Vec<usize> = (0..1600).filter(|&n| pixels[n] > 0).collect();
    assert!(bright.len() > 3 && bright.iter().all(|n| n % 40 >= 20 && n / 40 < 20), "{bright:?}");
}

#[test]
fn the_sides_of_the_patient_are_in_the_picture_and_in_the_files() {
    let folder = write_inputs();
    let run = |angles: &str, output: &str| {
        let own = ["project", "--angles", angles, "--size", "200x160", "--pixel", "1", "--output", output];
        succeed(folder.path(), &[&own[..], &RAW].concat());
        let (width, picture) = grey_picture(&folder.path().join(output).join("radiograph.png"));
        let part = move |left: usize| -> Vec<u8> {
            (0..30 * 30).map(|n| picture[(65 + n / 30) * width + left + n % 30]).collect()
        };
        (part(0), part(170))
    };
    // From the front the right edge is the patient's left, from the back the right: the letters change sides.
    let (front, back) = (run("0", "front"), run("180", "back"));
    let letters = |part: &[u8]| part.iter().filter(|&&grey| grey > 200).count();
    assert!([&front.0, &front.1, &back.0, &back.1].iter().all(|part| letters(part) > 8));
    assert_eq!([letters(&front.0), letters(&front.1)], [letters(&back.1), letters(&back.0)]);
    assert_ne!(letters(&front.0), letters(&front.1));
    for (output, expected) in [("front", r"L\H"), ("back", r"R\H")] {
        let metadata = drr::formats::read_exr_metadata(&folder.path().join(output).join("view0.exr"));
        let metadata: std::collections::HashMap<_, _> = metadata.expect("OpenEXR").into_iter().collect();
        // As the rows are stored: from the feet on.
        assert_eq!(metadata["drr.patient_orientation"], expected);
    }
}

#[test]
fn labels_win_over_thresholds() {
    let folder = write_inputs();
    let all_bone = vec![3_u8; SIZE.iter().product()];
    std::fs::write(folder.path().join("bone.raw"), all_bone).expect("written");
    let layers = ["--layers", "areal_density", "--raw", "--ct", "ct.nii.gz"];
    project(folder.path(), &[&layers, &["--output", "plain"]]);
    project(folder.path(), &[&layers, &["--labels", "bone.raw", "--output", "labelled"]]);
    let sum = |name: &str| f32s(folder.path(), name).iter().map(|&v| f64::from(v)).sum::<f64>();
    let tissues = ["air", "lung", "soft_tissue", "bone_cortical"];
    let plain: f64 = tissues.iter().map(|m| sum(&format!("plain/view0_areal_density_{m}.f32"))).sum();
    assert!(sum("plain/view0_areal_density_soft_tissue.f32") > 0.5 * plain);
    assert_eq!(sum("labelled/view0_areal_density_soft_tissue.f32"), 0.0);
    // The same mass, all of it bone.
    let bone = sum("labelled/view0_areal_density_bone_cortical.f32");
    assert!((bone / plain - 1.0).abs() < 1e-5, "{bone} {plain}");
}

#[test]
fn a_geometry_file_says_the_same_as_angles() {
    let folder = write_inputs();
    let pose = |angle| DetectorPose::c_arm(grid().centre(), angle, 1000.0, 1500.0, 6.0, [22, 14]);
    let geometry = GeometryFile { width: 22, height: 14, views: vec![pose(-6.0), pose(6.0)] };
    geometry.write(&folder.path().join("geometry.json")).expect("written");
    project(folder.path(), &[&RAW, &["--output", "a"]]);
    let arguments = [&["project"], &RAW[..], &["--geometry", "geometry.json", "--output", "b"]].concat();
    succeed(folder.path(), &arguments);
    for name in ["view0.exr", "view1.exr", "radiograph.png"] {
        assert!(
            bytes(folder.path(), &format!("a/{name}")) == bytes(folder.path(), &format!("b/{name}")),
            "{name}"
        );
    }
}

#[test]
fn tables_of_ones_own_stand_for_the_built_in_ones() {
    let folder = write_inputs();
    // One energy at which every gram attenuates alike: p is a tenth of the areal density.
    std::fs::write(folder.path().join("spectrum.csv"), "energy_keV,weight\n70,2\n71,6\n").expect("written");
    let rows = "energy_keV,a,b,c,d\n70,0.1,0.1,0.1,0.1\n71,0.1,0.1,0.1,0.1\n";
    std::fs::write(folder.path().join("materials.csv"), rows).expect("written");
    let tables = ["--spectrum", "spectrum.csv", "--materials", "materials.csv", "--raw", "--output", "out"];
    project(folder.path(), &[&RAW, &tables, &["--layers", "intensity,line_integral,areal_density"]]);
    let layer = |name: &str| f32s(folder.path(), &format!("out/view1_{name}.f32"));
    let densities = ["a", "b", "c", "d"].map(|m| layer(&format!("areal_density_{m}")));
    for (n, (p, i)) in layer("line_integral").into_iter().zip(layer("intensity")).enumerate() {
        let expected: f32 = densities.iter().map(|d| 0.1 * d[n]).sum();
        assert!((p - expected).abs() <= 2e-6 * expected + 1e-6, "{p} {expected}");
        assert!((i - 8.0 * (-p).exp()).abs() < 1e-5, "{i} {p}");
    }
}

#[test]
fn the_reference_engine_writes_float64_unrounded() {
    let folder = write_inputs();
    for algorithm in ["joseph", "exact"] {
        let arguments = ["--engine", "reference", "--algorithm", algorithm, "--raw", "--output", algorithm];
        project(folder.path(), &[&RAW, &arguments]);
    }
    project(folder.path(), &[&RAW, &["--raw", "--output", "cpu"]]);
    let reference = f64s(folder.path(), "joseph/view0_line_integral.f64");
    assert!(reference.iter().any(|&p| f64::from(p as f32) != p), "not rounded to float32");
    assert!(!folder.path().join("joseph/view0_line_integral.f32").exists());
    let fast = f32s(folder.path(), "cpu/view0_line_integral.f32");
    assert_eq!(fast.len(), reference.len());
    assert!(support::relative_l2(&fast, &reference) <= 2e-6);
    let exact = f64s(folder.path(), "exact/view0_line_integral.f64");
    assert!(exact != reference && support::relative_l2(&fast, &exact) < 0.05);
}

#[test]
fn a_phantom_projects_to_its_closed_form() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let files = ["--output", "ct.nii.gz", "--labels-output", "labels.nii.gz"];
    succeed(at, &[&["phantom", "water_cylinder", "--size", "90,90,80"], &files[..]].concat());
    let size = [36, 36];
    let inputs = ["--ct", "ct.nii.gz", "--labels", "labels.nii.gz", "--size", "36x36", "--pixel", "12"];
    let outputs = ["--layers", "areal_density", "--raw", "--output", "out"];
    succeed(at, &[&["project"], &inputs[..], &outputs].concat());
    let phantom = Phantom::water_cylinder();
    let calibration = Calibration::named(Calibration::DEFAULT).expect("built in");
    let water = f32s(at, "out/view1_areal_density_soft_tissue.f32");
    let pose = DetectorPose::c_arm(DVec3::ZERO, 6.0, 1000.0, 1500.0, 12.0, size);
    let mut compared = 0;
    for (n, &water) in water.iter().enumerate() {
        let pixel = pose.pixel((n % size[0]) as f64, (n / size[0]) as f64);
        let density = |hu: i16| calibration.density(f64::from(hu));
        let truth = phantom.areal_densities(pose.source, pixel, &density, 4).expect("four materials")[2];
        // Well inside: a chord of 15 cm, and away from the ends.
        if truth > 15.0 && (n / size[0]).abs_diff(size[1] / 2) < 12 {
            compared += 1;
            assert!((f64::from(water) / truth - 1.0).abs() < 0.01, "pixel {n}: {water} {truth}");
        }
    }
    assert!(compared > 200, "{compared}");
    let list = succeed(at, &["phantom", "--list"]);
    assert_eq!(list.lines().collect::<Vec<_>>(), Phantom::names());
}
