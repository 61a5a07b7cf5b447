//! Charts as a whole.

use std::path::Path;

use super::chart::{Chart, Group, Point};
use super::curves::{Curves, Series};
use super::drawing::Drawing as _;

fn point(name: &str, group: Group, seconds: f64, error_hu: f64) -> Point {
    Point {
        name: name.into(),
        group,
        seconds,
        seconds_range: [0.96 * seconds, 1.07 * seconds],
        error_hu,
        error_range: [0.9 * error_hu, 1.1 * error_hu],
        on_front: false,
        chosen: false,
        of_another_model: false,
    }
}

/// As many points as a run has, many of them nearly in one place.
fn sample() -> Chart {
    use Group::{Joseph, March, Other, Siddon};
    let mut points = vec![
        point("march 8 voxels", March, 0.8, 15.0),
        point("march 4 voxels", March, 1.4, 4.0),
        point("march 2 voxels", March, 2.6, 1.1),
        point("march 1 voxel", March, 4.5, 0.4),
        point("march \u{bd} voxel", March, 8.0, 0.1),
        point("march \u{bc} voxel", March, 16.0, 0.03),
        point("joseph", Joseph, 2.5, 0.13),
        point("joseph, 8-bit", Joseph, 1.7, 0.35),
        point("joseph, naive sums", Joseph, 2.45, 0.14),
        point("joseph, 9 nodes", Joseph, 2.3, 0.131),
        point("joseph, 17 nodes", Joseph, 2.6, 0.129),
        point("joseph, no culling", Joseph, 3.1, 0.13),
        point("joseph, f64", Joseph, 5.2, 0.12),
        point("joseph 2x2", Joseph, 10.0, 0.13),
        point("joseph 3x3", Joseph, 21.0, 0.128),
        point("siddon", Siddon, 6.1, 0.8),
        point("siddon 2x2", Siddon, 24.0, 0.75),
        point("reference", Other, 60.0, 0.0),
    ];
    for point in &mut points {
        point.on_front = [
            "march 8 voxels",
            "march 4 voxels",
            "joseph, 8-bit",
            "joseph, 9 nodes",
            "joseph",
            "march \u{bd} voxel",
            "march \u{bc} voxel",
        ]
        .contains(&point.name.as_str());
        point.chosen = point.name == "joseph";
        point.of_another_model = point.group == Siddon;
    }
    Chart {
        title: "What accuracy costs: 720 x 720 rays through 512 x 512 x 400 voxels".into(),
        subtitle: "CPU, 16 threads; error against exact integration, 4096 rays; a long subtitle goes on in a second line and loses no word".into(),
        points,
        limit_hu: Some((2.0, "the specification's 2 HU".into())),
    }
}

fn curves() -> Curves {
    let series = |name: &str, f: &dyn Fn(f64) -> f64| Series {
        name: name.into(),
        points: (3..=12).map(|i| 2f64.powi(i)).map(|n| [n, f(n)]).collect(),
    };
    Curves {
        title: "Error growth with path length".into(),
        subtitle: "RMS of 1000 rays, f32 against exact sums".into(),
        x_label: "samples on the path".into(),
        y_label: "relative error".into(),
        series: vec![
            series("naive", &|n| 3e-8 * n.sqrt()),
            series("blocked by 32", &|n| 6e-8 * (1.0 + n / 64.0).powf(0.3)),
            series("compensated", &|_| 3.4e-8),
        ],
    }
}

#[test]
fn look() {
    let folder = Path::new("/tmp/w/chart/look");
    std::fs::create_dir_all(folder).unwrap();
    sample().write_png(&folder.join("chart.png")).unwrap();
    sample().write_svg(&folder.join("chart.svg")).unwrap();
    curves().write_png(&folder.join("curves.png")).unwrap();
    curves().write_svg(&folder.join("curves.svg")).unwrap();
    let error = |s: f64| {
        (0..240 * 240)
            .map(|i| {
                let (x, y) = (f64::from(i % 240) / 120.0 - 1.0, f64::from(i / 240) / 120.0 - 1.0);
                if x * x + y * y > 0.9 { f32::NAN } else { (s * (3.0 * x).sin() * (4.0 * y).cos()) as f32 }
            })
            .collect::<Vec<f32>>()
    };
    let (a, b) = (error(2.4), error(-1.0));
    let map = drr::formats::error_map(&[&a, &b], 240, 240, 2.0).unwrap();
    super::colour_bar::with_colour_bar(&map, 2.0).unwrap().write_png(&folder.join("map.png")).unwrap();
}
