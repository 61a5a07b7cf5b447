use super::*;

const ARM: CArm =
    CArm { centre: DVec3::new(1.0, -2.0, 30.5), size: [7, 5], sad_mm: 1000.0, sdd_mm: 1500.0, pixel_mm: 0.9 };

fn read(text: &str) -> Result<PoseTable> {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    PoseTable::read(file.path(), &ARM)
}

#[test]
fn a_c_arm_s_columns_stand_for_its_defaults_in_any_order() {
    let table = read("# two\nsdd_mm, angle_degrees,offset_z_mm\n1400,-6,2\n\n1300.5,1e1,0\n").unwrap();
    let pose = |angle, sdd, z| {
        DetectorPose::c_arm(
            ARM.centre + DVec3::new(0.0, 0.0, z),
            angle,
            ARM.sad_mm,
            sdd,
            ARM.pixel_mm,
            ARM.size,
        )
    };
    assert_eq!(
        table,
        PoseTable { poses: vec![pose(-6.0, 1400.0, 2.0), pose(10.0, 1300.5, 0.0)], names: None }
    );
    let all = "name,angle_degrees,sad_mm,sdd_mm,pixel_mm,offset_x_mm,offset_y_mm,offset_z_mm\na.1,3,9e2,1e3,0.5,1,2,3\n";
    let own = DetectorPose::c_arm(ARM.centre + DVec3::new(1.0, 2.0, 3.0), 3.0, 900.0, 1000.0, 0.5, ARM.size);
    assert_eq!(read(all).unwrap(), PoseTable { poses: vec![own], names: Some(vec!["a.1".into()]) });
}

/// Shortest decimals that come back, which is what programs write.
#[test]
fn poses_come_back_to_the_last_bit() {
    let pose = |n: u32| {
        let centre = DVec3::new(0.1, 1e6 / 3.0, -7e-9);
        DetectorPose::c_arm(centre, f64::from(n) * 3.7, 510.7, 1020.3, 0.1941, [720, 333])
    };
    let poses: Vec<_> = (0..100).map(pose).collect();
    let row = |pose: &DetectorPose| {
        let vectors = [pose.source, pose.first_pixel, pose.column_step, pose.row_step];
        vectors.iter().flat_map(DVec3::to_array).map(|x| x.to_string()).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<_> = poses.iter().map(row).collect();
    let table = read(&format!("{}\n{}\n", POSE.join(","), rows.join("\n"))).unwrap();
    assert_eq!(table, PoseTable { poses, names: None });
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let twelve = POSE.join(",");
    let pose = "0,-500,0,-1,500,-1,1,0,0,0,0,1";
    let many = format!("angle_degrees\n{}", "0\n".repeat(MAX_VIEWS + 1));
    let long = format!("name,angle_degrees\n{},0\n", "n".repeat(MAX_NAME + 1));
    let cases = [
        ("no lines below its header", "angle_degrees\n".to_owned()),
        ("line 1: has no column angle_degrees", "sad_mm\n1000\n".to_owned()),
        (
            "line 1: column 2 is \"sid_mm\"; valid: name, angle_degrees",
            "angle_degrees,sid_mm\n0,1\n".to_owned(),
        ),
        ("line 1: column 2 repeats the name \"name\"", "name,name\na,b\n".to_owned()),
        ("line 1: has columns of a pose and sad_mm", format!("{twelve},sad_mm\n{pose},1\n")),
        ("line 1: has no column row_step_z_mm", twelve.replace(",row_step_z_mm", "\n")),
        ("line 3: angle_degrees is \"left\"; valid: a finite number", "angle_degrees\n0\nleft\n".to_owned()),
        ("line 2: angle_degrees is \"NaN\"", "angle_degrees\nNaN\n".to_owned()),
        ("line 2: angle_degrees is \"\"", "angle_degrees,sad_mm\n,1\n".to_owned()),
        ("line 2: sad_mm is \"0\"; valid: a number above 0", "angle_degrees,sad_mm\n0,0\n".to_owned()),
        ("line 2: pixel_mm is \"inf\"", "angle_degrees,pixel_mm\n0,inf\n".to_owned()),
        ("line: 3", "angle_degrees,sad_mm\n0,1\n0,1,2\n".to_owned()),
        ("line 2: source is", format!("{twelve}\n{}\n", pose.replace("-500", "500"))),
        (
            "line 3: column_step and row_step is",
            format!("{twelve}\n{pose}\n{}\n", pose.replace("0,0,1", "2,0,0")),
        ),
        ("line 2: name is \"../a\"; valid: 1 … 100 of", "name,angle_degrees\n../a,0\n".to_owned()),
        ("line 2: name is \"\"", "name,angle_degrees\n,0\n".to_owned()),
        ("line 2: name is \".a\"", "name,angle_degrees\n.a,0\n".to_owned()),
        ("line 2: name is \"-a\"", "name,angle_degrees\n-a,0\n".to_owned()),
        ("line 2: name is \"nn", long),
        ("line 4: name is \"A\" as in a line before", "name,angle_degrees\na,0\nb,0\nA,0\n".to_owned()),
        ("line 1000002: more than 1000000 views", many),
    ];
    for (words, text) in cases {
        let message = read(&text).unwrap_err().to_string();
        assert!(message.contains(words), "{words}: {message}");
    }
}
