//! Letters at the edges of an image: which sides of the patient these are.

use anyhow::Result;
use drr::formats::{ColourPicture, first_column};
use drr::geometry::PatientOrientation;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, RGBColor, WHITE};

use super::canvas::Canvas;
use super::drawing::{Area, Surface, TEXT, TITLE, text_style};

/// Height of the letters in images of the size that detectors have, pixels.
const LARGE: f64 = 24.0;
/// From the image's edge to a letter, pixels.
const MARGIN: i32 = 5;
/// The smaller side of an image up to which its letters have this height, pixels; in the smallest there is no room.
const HEIGHTS: [(usize, Option<f64>); 4] =
    [(127, None), (299, Some(TEXT)), (599, Some(TITLE)), (usize::MAX, Some(LARGE))];

/// Writes what is at the edges of an image of `size` pixels whose upper left corner is at `corner` of the picture.
pub(crate) fn mark_sides(
    picture: &mut ColourPicture,
    corner: [usize; 2],
    size: [usize; 2],
    orientation: PatientOrientation,
) -> Result<()> {
    let smaller = size[0].min(size[1]);
    let Some(height) = HEIGHTS.iter().find(|(most, _)| smaller <= *most).and_then(|(_, height)| *height)
    else {
        return Ok(());
    };
    let [left, top] = corner.map(|n| n as i32);
    let [width, rows] = size.map(|n| n as i32);
    let [right, bottom] = [left + width - MARGIN, top + rows - MARGIN];
    let [middle, level] = [left + width / 2, top + rows / 2];
    let places = [
        ((left + MARGIN, level), HPos::Left, VPos::Center),
        ((right, level), HPos::Right, VPos::Center),
        ((middle, top + MARGIN), HPos::Center, VPos::Top),
        ((middle, bottom), HPos::Center, VPos::Bottom),
    ];
    let area = Canvas::new(picture).into_drawing_area();
    for (edge, (at, across, down)) in orientation.edges().into_iter().zip(places) {
        outlined(&area, &edge.to_string(), at, height, Pos::new(across, down))?;
    }
    Ok(())
}

/// The same for views side by side.
pub(crate) fn mark_views(
    picture: &mut ColourPicture,
    size: [usize; 2],
    orientations: &[PatientOrientation],
) -> Result<()> {
    let mut marked = orientations.iter().enumerate();
    marked.try_for_each(|(view, &own)| mark_sides(picture, [first_column(view, size[0]), 0], size, own))
}

/// White with a black edge, legible on whatever is behind.
fn outlined<B: Surface>(area: &Area<B>, text: &str, (x, y): (i32, i32), height: f64, pos: Pos) -> Result<()> {
    let write = |at, colour: RGBColor| {
        area.draw(&Text::new(text.to_owned(), at, text_style(height, true, colour).pos(pos)))
    };
    for (dx, dy) in (-1..=1).flat_map(|dx| [-1, 0, 1].map(|dy| (dx, dy))) {
        write((x + dx, y + dy), BLACK)?;
    }
    Ok(write((x, y), WHITE)?)
}

#[cfg(test)]
mod tests {
    use drr::geometry::AnatomicalDirection;
    use glam::DVec3;

    use super::*;

    const GREY: [u8; 3] = [120; 3];

    fn frontal() -> PatientOrientation {
        let [row, column] = [DVec3::X, DVec3::NEG_Z].map(AnatomicalDirection::of);
        PatientOrientation { row, column }
    }

    /// Where it was written in a part of a picture, from the part's corner.
    fn ink(picture: &ColourPicture, corner: [usize; 2], size: [usize; 2]) -> Vec<[usize; 2]> {
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        all.filter(|[x, y]| picture.pixel(corner[0] + x, corner[1] + y) != GREY).collect()
    }

    #[test]
    fn each_edge_has_its_letter_and_the_middle_stays() {
        for side in [128, 300, 720] {
            let mut picture = ColourPicture::filled(side, side, GREY);
            mark_sides(&mut picture, [0, 0], [side, side], frontal()).unwrap();
            let ink = ink(&picture, [0, 0], [side, side]);
            let near = |place: fn([usize; 2], usize) -> usize| {
                ink.iter().filter(|&&at| place(at, side) < side / 4).count()
            };
            let edges = [near(|[x, _], _| x), near(|[x, _], side| side - 1 - x)];
            let edges = [edges, [near(|[_, y], _| y), near(|[_, y], side| side - 1 - y)]].concat();
            assert!(edges.iter().all(|&count| count > 20), "{side}: {edges:?}");
            assert_eq!(edges.iter().sum::<usize>(), ink.len(), "{side}: nothing but at the edges");
            assert!(ink.len() < side * side / 20, "{side}: small");
        }
    }

    #[test]
    fn the_letters_are_those_of_the_sides() {
        let drawn = |orientation| {
            let mut picture = ColourPicture::filled(200, 200, GREY);
            mark_sides(&mut picture, [0, 0], [200, 200], orientation).unwrap();
            picture
        };
        let (own, turned) = (drawn(frontal()), drawn(frontal().upside_down()));
        let part = |picture: &ColourPicture, corner| -> Vec<_> {
            (0..40 * 40).map(|n| picture.pixel(corner + n % 40, 80 + n / 40)).collect()
        };
        // Left and right stay, head and feet change their places.
        assert!([0, 160].into_iter().all(|corner| part(&own, corner) == part(&turned, corner)));
        assert!(part(&own, 0) != part(&own, 160));
        let band = |picture: &ColourPicture, top: usize| picture.pixels[200 * top..200 * (top + 16)].to_vec();
        assert_eq!(band(&own, 5), band(&turned, 179));
        assert_ne!(band(&own, 5), band(&turned, 5));
    }

    #[test]
    fn views_side_by_side_are_marked_alike_and_small_ones_not_at_all() {
        let mut picture = ColourPicture::filled(2 * 150 + 2, 140, GREY);
        mark_views(&mut picture, [150, 140], &[frontal(); 2]).unwrap();
        let views = [0, first_column(1, 150)].map(|left| ink(&picture, [left, 0], [150, 140]));
        assert!(!views[0].is_empty() && views[0] == views[1]);
        let mut small = ColourPicture::filled(127, 400, GREY);
        mark_sides(&mut small, [0, 0], [127, 400], frontal()).unwrap();
        assert_eq!(small, ColourPicture::filled(127, 400, GREY));
    }
}
