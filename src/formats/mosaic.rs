//! Views side by side in one picture.

use crate::error::{Error, Result};

/// Columns between views of `width` columns each.
fn gap(width: usize) -> usize {
    (width / 100).max(2)
}

/// The column of a [`radiograph`](crate::formats::radiograph) or an [`error_map`](crate::formats::error_map) of views of
/// `width` columns each in which one of the views, counted from 0, begins.
pub fn first_column(view: usize, width: usize) -> usize {
    view * (width + gap(width))
}

/// The shaded values of the views, width × height each, from left to right with a thin gap between them: the picture's
/// width, and its pixels row by row.
pub(super) fn side_by_side<T: Clone>(
    views: &[&[f32]],
    [width, height]: [usize; 2],
    gap_colour: T,
    shade: impl Fn(f32) -> T,
) -> Result<(usize, Vec<T>)> {
    check(views, [width, height])?;
    let gap = gap(width);
    let total = first_column(views.len(), width) - gap;
    let mut pixels = vec![gap_colour; total * height];
    for (row, line) in pixels.chunks_exact_mut(total).enumerate() {
        for (part, view) in line.chunks_mut(width + gap).zip(views) {
            let values = &view[row * width..(row + 1) * width];
            part.iter_mut().zip(values).for_each(|(pixel, &value)| *pixel = shade(value));
        }
    }
    Ok((total, pixels))
}

/// That there are views, and that each has width × height values.
fn check(views: &[&[f32]], [width, height]: [usize; 2]) -> Result<()> {
    let pixels = width.saturating_mul(height);
    if views.is_empty() || pixels == 0 {
        let value = format!("{} views of {width} x {height}", views.len());
        return Err(Error::invalid("views", value, "at least one view and one pixel"));
    }
    match views.iter().enumerate().find(|(_, view)| view.len() != pixels) {
        Some((i, view)) => Err(Error::invalid(format!("views[{i}].len()"), view.len(), pixels.to_string())),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_stand_side_by_side_with_a_gap() {
        let (left, right) = ([1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]);
        let (width, pixels) = side_by_side(&[&left, &right], [2, 2], 0, |value| value as i32).unwrap();
        assert_eq!((width, pixels), (6, vec![1, 2, 0, 0, 5, 6, 3, 4, 0, 0, 7, 8]));
        assert_eq!([0, 1].map(|view| first_column(view, 2)), [0, 4]);
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(check(&[], [2, 2]).is_err());
        assert!(check(&[&[]], [0, 2]).is_err());
        assert!(check(&[&[0.0; 4]], [usize::MAX, 2]).is_err());
        assert!(check(&[&[0.0; 4], &[0.0; 3]], [2, 2]).unwrap_err().to_string().contains("views[1]"));
    }
}
