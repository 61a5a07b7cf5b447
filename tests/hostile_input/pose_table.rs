//! The reader of tables of views: any text is poses that a projector takes with names that files can have, or an error.

use std::collections::HashSet;

use drr::formats::{CArm, PoseTable};
use glam::DVec3;

use crate::file;

/// Whether the file was accepted.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let path = file::with_content("views.csv", bytes);
    let c_arm = CArm {
        centre: DVec3::new(1.0, -2.0, 3.0),
        size: [7, 5],
        sad_mm: 1000.0,
        sdd_mm: 1500.0,
        pixel_mm: 0.9,
    };
    let Ok(table) = PoseTable::read(&path, &c_arm) else { return false };
    assert!(!table.poses.is_empty());
    for pose in &table.poses {
        pose.validate().expect("what was read is valid");
    }
    let names = table.names.iter().flatten();
    assert!(names.clone().all(|name| path.with_file_name(name).parent() == path.parent() && name != ".."));
    assert!(names.clone().all(|name| !name.starts_with(['.', '-']) && name.len() <= 100 && name.is_ascii()));
    let distinct: HashSet<_> = names.clone().map(|name| name.to_lowercase()).collect();
    assert_eq!(distinct.len(), table.names.as_ref().map_or(0, |_| table.poses.len()));
    true
}
