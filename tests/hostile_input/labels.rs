//! The readers of labels: any bytes are one label per voxel of the CT, or an error.

use drr::formats::open_labels;
use drr::geometry::Grid;
use glam::DVec3;

use crate::file;

/// Whether the file was accepted, as NIfTI or as raw.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let grid = Grid::axis_aligned([4, 3, 2], DVec3::ONE, DVec3::ZERO).expect("valid");
    let mut accepted = false;
    for name in ["labels.nii", "labels.raw"] {
        let Ok(mut labels) = open_labels(&file::with_content(name, bytes), &grid) else { continue };
        let mut slices = 0;
        let read = labels.read(&mut |k, slice| {
            assert_eq!((k, slice.len()), (slices, 4 * 3));
            slices += 1;
            Ok(())
        });
        assert!(read.is_err() || slices == 2, "no slice is missing");
        accepted |= read.is_ok();
    }
    accepted
}
