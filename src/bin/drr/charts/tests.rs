//! Charts as a whole.

use std::fs::File;
use std::io::BufReader;

use drr::formats::{ColourPicture, Rgb};
use plotters::drawing::IntoDrawingArea as _;
use plotters::style::RGBColor;
use proptest::prelude::*;
use roxmltree::{Document, Node};

use super::axes::Frame;
use super::canvas::Canvas;
use super::chart::{Chart, FRONT, Group, Point};
use super::curves::{Curves, Scale, Series};
use super::drawing::{Drawing, SIZE, TEXT, TITLE};
use super::glyphs::text_size;
use super::growth::{Growth, GrowthSheet};
use super::marker::{BLUE, INK, PALE_INK, VERMILION};

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
        subtitle: "CPU, 16 threads; error against exact integration, 4096 rays; a long subtitle goes on in a second line and loses no word of it".into(),
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
        x_scale: Scale::Decades,
        x_label: "samples on the path".into(),
        y_label: "relative error".into(),
        series: vec![
            series("naive", &|n| 3e-8 * n.sqrt()),
            series("blocked by 32", &|n| 6e-8 * (1.0 + n / 64.0).powf(0.3)),
            series("compensated", &|_| 3.4e-8),
        ],
    }
}

/// A point with this time and error, on the front.
fn fronted(name: &str, seconds: f64, error_hu: f64) -> Point {
    Point { on_front: true, ..point(name, Group::Joseph, seconds, error_hu) }
}

fn chart(points: Vec<Point>) -> Chart {
    Chart { title: "title".into(), subtitle: "subtitle".into(), points, limit_hu: None }
}

/// Where the chart's axes put values.
fn frame(chart: &Chart) -> Frame {
    let mut picture = ColourPicture::filled(SIZE.0 as usize, SIZE.1 as usize, [255; 3]);
    let points: Vec<&Point> = chart.points.iter().collect();
    chart.axes(&points).draw(&Canvas::new(&mut picture).into_drawing_area()).unwrap()
}

fn colour(picture: &ColourPicture, (column, row): (i32, i32)) -> Rgb {
    picture.pixel(column as usize, row as usize)
}

fn rgb(RGBColor(red, green, blue): RGBColor) -> Rgb {
    [red, green, blue]
}

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.map(|node| node.text().unwrap_or_default().trim().into()).collect()
}

/// Left, right, top and bottom of a text that is not turned, as wide as the letters of PNG.
fn extent(node: Node<'_, '_>) -> [f64; 4] {
    let number = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let bold = node.attribute("font-weight") == Some("bold");
    let height = if number("font-size") > TEXT { TITLE } else { TEXT };
    let width = f64::from(text_size(node.text().unwrap().trim(), height, bold)[0]);
    let left = number("x")
        - width
            * match node.attribute("text-anchor").unwrap() {
                "start" => 0.0,
                "middle" => 0.5,
                _ => 1.0,
            };
    // Letters without the space between lines.
    let middle = number("y") + if node.attribute("dy") == Some("0.76em") { height / 2.0 } else { 0.0 };
    [left, left + width, middle - 0.4 * height, middle + 0.4 * height]
}

#[test]
fn a_png_is_written_whole_and_in_the_right_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chart.png");
    sample().write_png(&path).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (SIZE.0, SIZE.1, png::ColorType::Rgb));
    assert_eq!(bytes, sample().picture().unwrap().pixels.as_flattened());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn an_svg_is_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chart.svg");
    sample().write_svg(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), sample().svg().unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn marks_have_their_colour_where_their_values_are() {
    let chart = chart(vec![
        point("a", Group::Joseph, 0.1, 10.0),
        point("b", Group::March, 1.0, 1.0),
        Point { of_another_model: true, ..point("c", Group::Siddon, 10.0, 0.1) },
    ]);
    let (frame, picture) = (frame(&chart), chart.picture().unwrap());
    let [a, b, c] = [0, 1, 2].map(|i| frame.pixel([chart.points[i].seconds, chart.points[i].error_hu]));
    assert_eq!([a, b, c].map(|at| colour(&picture, at)), [rgb(BLUE), rgb(VERMILION), [255; 3]]);
    // Equal factors are equal distances, more time is further right, less error further down.
    assert!(((b.0 - a.0) - (c.0 - b.0)).abs() <= 1 && b.0 - a.0 > 100);
    assert!(((b.1 - a.1) - (c.1 - b.1)).abs() <= 1 && b.1 - a.1 > 50);
}

#[test]
fn the_front_is_a_stair_through_its_points() {
    let chart = chart(vec![fronted("c", 10.0, 0.1), fronted("a", 0.1, 10.0), fronted("b", 1.0, 1.0)]);
    let (frame, picture) = (frame(&chart), chart.picture().unwrap());
    for [from, to] in [[[0.1, 10.0], [1.0, 1.0]], [[1.0, 1.0], [10.0, 0.1]]] {
        let (start, end) = (frame.pixel(from), frame.pixel(to));
        assert_eq!(colour(&picture, (end.0 - 20, start.1)), rgb(FRONT), "level until the next one");
        assert_eq!(colour(&picture, (end.0, start.1 + 20)), rgb(FRONT), "then down to it");
    }
}

#[test]
fn the_chosen_point_has_a_ring() {
    let mut chart = chart(vec![point("a", Group::Joseph, 0.1, 10.0), point("b", Group::Joseph, 1.0, 1.0)]);
    chart.points[0].chosen = true;
    let (frame, picture) = (frame(&chart), chart.picture().unwrap());
    let above = |[x, y]: [f64; 2]| {
        let (column, row) = frame.pixel([x, y]);
        colour(&picture, (column, row - 10))
    };
    assert_eq!(above([0.1, 10.0]), rgb(INK));
    assert_ne!(above([1.0, 1.0]), rgb(INK));
    assert!(texts(&chart.svg().unwrap()).contains(&"a (chosen)".into()));
}

#[test]
fn the_limit_goes_from_one_side_to_the_other() {
    let mut chart = chart(vec![point("a", Group::Joseph, 0.1, 10.0), point("b", Group::Joseph, 1.0, 0.1)]);
    chart.limit_hu = Some((2.0, "2 HU".into()));
    let (frame, picture) = (frame(&chart), chart.picture().unwrap());
    let (_, row) = frame.pixel([1.0, 2.0]);
    let orange = (frame.columns.start + 2..frame.columns.end - 2)
        .filter(|column| colour(&picture, (*column, row)) == rgb(VERMILION))
        .count();
    assert!(orange as f64 > 0.8 * frame.columns.len() as f64, "{orange}");
}

#[test]
fn an_svg_has_all_names() {
    let mut chart = sample();
    chart.points[0].name = "a < b & \"c\" > 'd'".into();
    chart.title = "<title> & more".into();
    let texts = texts(&chart.svg().unwrap());
    for point in &chart.points {
        assert!(texts.iter().any(|text| text.starts_with(&point.name)), "{} in {texts:?}", point.name);
    }
    for text in ["<title> & more", "the specification's 2 HU", "1 s", "10 s", "0.1", "10", "Joseph", "chosen"]
    {
        assert!(texts.iter().any(|t| t == text), "{text} in {texts:?}");
    }
    assert!(texts.contains(&"reference (0 HU)".into()), "{texts:?}");
}

#[test]
fn texts_lie_in_the_picture_and_not_on_each_other() {
    let charts = [sample().svg().unwrap(), curves().svg().unwrap()];
    for svg in charts {
        let document = Document::parse(&svg).unwrap();
        let upright =
            |node: &Node<'_, '_>| node.has_tag_name("text") && node.attribute("transform").is_none();
        let texts: Vec<_> =
            document.descendants().filter(upright).map(|node| (node.text().unwrap(), extent(node))).collect();
        for (i, (text, [left, right, top, bottom])) in texts.iter().enumerate() {
            assert!(*left >= 0.0 && *right <= f64::from(SIZE.0), "{text}");
            assert!(*top >= 0.0 && *bottom <= f64::from(SIZE.1), "{text}");
            for (other, [l, r, t, b]) in &texts[..i] {
                assert!(right <= l || r <= left || bottom <= t || b <= top, "{text} and {other}");
            }
        }
    }
}

#[test]
fn nothing_one_point_and_equal_points_are_charts_too() {
    let equal = || point("a", Group::Other, 1.0, 1.0);
    for points in [vec![], vec![equal()], vec![equal(), equal()], vec![fronted("zero", 1.0, 0.0)]] {
        let chart = chart(points);
        chart.picture().unwrap();
        assert!(!texts(&chart.svg().unwrap()).is_empty());
    }
}

#[test]
fn points_without_numbers_are_named() {
    let chart =
        chart(vec![point("lost", Group::Joseph, f64::NAN, 1.0), point("kept", Group::March, 1.0, 1.0)]);
    let texts = texts(&chart.svg().unwrap());
    assert!(texts.iter().any(|text| text.contains("Without a finite") && text.contains("lost")), "{texts:?}");
}

#[test]
fn an_error_of_0_has_an_arrow_to_the_edge() {
    let chart = chart(vec![point("a", Group::Joseph, 1.0, 1.0), point("zero", Group::March, 10.0, 0.0)]);
    let (frame, picture) = (frame(&chart), chart.picture().unwrap());
    let (column, row) = frame.mark([10.0, 0.0]);
    assert!(row < frame.rows.end && row > frame.pixel([1.0, 1.0]).1);
    assert_eq!(colour(&picture, (column, row)), rgb(VERMILION));
    assert_eq!(colour(&picture, (column, row + 10)), rgb(INK));
}

#[test]
fn curves_go_through_their_points() {
    let curves = curves();
    let picture = curves.picture().unwrap();
    for colour in [BLUE, VERMILION].map(rgb) {
        let columns = (0..picture.width).filter(|x| (100..600).any(|y| picture.pixel(*x, y) == colour));
        assert!(columns.count() > 500, "{colour:?}");
    }
    let texts = texts(&curves.svg().unwrap());
    for text in ["naive", "blocked by 32", "compensated", "samples on the path", "relative error"] {
        assert!(texts.iter().any(|t| t == text), "{text} in {texts:?}");
    }
}

/// Four times the same panel, of work that is the count's square.
fn sheet(points: Vec<(f64, [f64; 3])>) -> GrowthSheet {
    let panel = Growth { held: "2 held".into(), x_label: "counts".into(), points, power: 2.0 };
    let panels = std::array::from_fn(|_| panel.clone());
    GrowthSheet { title: "title".into(), subtitle: "subtitle".into(), panels }
}

#[test]
fn growth_is_drawn_in_four_panels_beside_what_is_proportional() {
    let sheet =
        sheet(vec![(1.0, [0.01, 0.02, 0.03]), (10.0, [0.9, 1.0, 1.2]), (100.0, [90.0, 100.0, 101.0])]);
    assert!((sheet.panels[0].ideal(1.0) - 0.01).abs() < 1e-15);
    let picture = sheet.picture().unwrap();
    for (columns, rows) in [(0..450, 90..345), (450..900, 90..345), (0..450, 345..600), (450..900, 345..600)]
    {
        for colour in [rgb(BLUE), rgb(PALE_INK)] {
            let drawn = columns.clone().any(|x| rows.clone().any(|y| picture.pixel(x, y) == colour));
            assert!(drawn, "{colour:?} in {columns:?}, {rows:?}");
        }
    }
    let texts = texts(&sheet.svg().unwrap());
    for text in ["2 held", "counts", "time", "10 ms", "100 s"] {
        assert_eq!(texts.iter().filter(|t| *t == text).count(), 4, "{text} in {texts:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn any_numbers_make_a_chart(
        numbers in proptest::collection::vec(any::<[f64; 6]>(), 0..4),
        limit in any::<f64>(),
        pairs in proptest::collection::vec(any::<[f64; 2]>(), 0..4),
    ) {
        let points = numbers.iter().map(|[seconds, error_hu, a, b, c, d]| Point {
            seconds_range: [*a, *b],
            error_range: [*c, *d],
            ..fronted("name", *seconds, *error_hu)
        });
        let chart = Chart { limit_hu: Some((limit, "limit".into())), ..chart(points.collect()) };
        let series = vec![Series { name: "series".into(), points: pairs }];
        let [decades, counts] = [Scale::Decades, Scale::Counts]
            .map(|x_scale| Curves { series: series.clone(), x_scale, ..curves() }.svg().unwrap());
        let growth = sheet(numbers.iter().map(|[count, a, b, c, ..]| (*count, [*a, *b, *c])).collect());
        for svg in [chart.svg().unwrap(), decades, counts, growth.svg().unwrap()] {
            let document = Document::parse(&svg).unwrap();
            for attribute in document.descendants().flat_map(|node| node.attributes()) {
                prop_assert!(!attribute.value().contains("NaN") && !attribute.value().contains("inf"));
            }
        }
    }
}
