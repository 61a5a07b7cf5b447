//! Rows of several planes.

/// The same row of every plane, row by row.
pub(super) fn rows_of<'a, T>(
    planes: impl Iterator<Item = &'a mut [T]>,
    [width, height]: [usize; 2],
) -> Vec<Vec<&'a mut [T]>> {
    let mut rows: Vec<Vec<&mut [T]>> = (0..height).map(|_| Vec::new()).collect();
    for plane in planes {
        for (row, values) in rows.iter_mut().zip(plane.chunks_mut(width)) {
            row.push(values);
        }
    }
    rows
}
