//! Detector poses in a JSON file.

use std::io::Write;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::formats::replacement::Replacement;
use crate::formats::{Checked, file_error};
use crate::geometry::DetectorPose;

/// Most pixels along a side of a detector.
const LARGEST_SIDE: usize = 1 << 15;

/// One or more detector poses with a common number of pixels:
/// `{"width": …, "height": …, "views": [{"source": [x, y, z], "first_pixel": …, "column_step": …, "row_step": …}]}`,
/// lengths in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct GeometryFile {
    /// Columns of pixels.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// One pose per view, at least one.
    pub views: Vec<DetectorPose>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with width, height and views")]
struct JsonGeometry {
    width: usize,
    height: usize,
    views: Vec<JsonView>,
}

#[derive(Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a view: an object with source, first_pixel, column_step and row_step"
)]
struct JsonView {
    source: [f64; 3],
    first_pixel: [f64; 3],
    column_step: [f64; 3],
    row_step: [f64; 3],
}

impl GeometryFile {
    /// Reads and checks a file. Fields that are not known are refused: they may be mistyped.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| file_error(path, e))?;
        let json: JsonGeometry = serde_json::from_str(&text).map_err(|e| file_error(path, e))?;
        let pose = |view: JsonView| DetectorPose {
            source: DVec3::from_array(view.source),
            first_pixel: DVec3::from_array(view.first_pixel),
            column_step: DVec3::from_array(view.column_step),
            row_step: DVec3::from_array(view.row_step),
        };
        let views = json.views.into_iter().map(pose).collect();
        let geometry = Self { width: json.width, height: json.height, views };
        geometry.validate().map_err(|reason| file_error(path, reason))?;
        Ok(geometry)
    }

    /// Writes a file that `read` turns into the same poses, to the last bit.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.validate().map_err(|reason| file_error(path, reason))?;
        let view = |pose: &DetectorPose| JsonView {
            source: pose.source.to_array(),
            first_pixel: pose.first_pixel.to_array(),
            column_step: pose.column_step.to_array(),
            row_step: pose.row_step.to_array(),
        };
        let views = self.views.iter().map(view).collect();
        let json = JsonGeometry { width: self.width, height: self.height, views };
        let mut file = Replacement::create(path)?;
        serde_json::to_writer_pretty(&mut file, &json).map_err(|e| file_error(path, e))?;
        file.write_all(b"\n").map_err(|e| file_error(path, e))?;
        file.commit()
    }

    fn validate(&self) -> Checked<()> {
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if !(1..=LARGEST_SIDE).contains(&side) {
                return Err(format!("{name} is {side}; valid: 1 … {LARGEST_SIDE}"));
            }
        }
        if self.views.is_empty() {
            return Err("views is empty; valid: at least one".to_owned());
        }
        for (i, pose) in self.views.iter().enumerate() {
            pose.validate().map_err(|error| error.of(&format!("views[{i}]")).to_string())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: &str =
        r#"{"source":[0,-500,0],"first_pixel":[-1,500,-1],"column_step":[1,0,0],"row_step":[0,0,1]}"#;

    fn read(text: &str) -> Result<GeometryFile> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        GeometryFile::read(file.path())
    }

    #[test]
    fn poses_come_back_to_the_last_bit() {
        let pose = |angle| {
            DetectorPose::c_arm(DVec3::new(0.1, 1e6 / 3.0, -7e-9), angle, 510.7, 1020.3, 0.1941, [720, 333])
        };
        let views = (0..100).map(|i| pose(f64::from(i) * 3.7)).collect();
        let geometry = GeometryFile { width: 720, height: 333, views };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("geometry.json");
        geometry.write(&path).unwrap();
        assert_eq!(GeometryFile::read(&path).unwrap(), geometry);
    }

    #[test]
    fn a_hand_written_file_is_read() {
        let geometry = read(&format!(r#"{{"width": 3, "height": 2, "views": [{VIEW}]}}"#)).unwrap();
        assert_eq!((geometry.width, geometry.height), (3, 2));
        assert_eq!(geometry.views[0].first_pixel, DVec3::new(-1.0, 500.0, -1.0));
        assert_eq!(geometry.views[0].row_step, DVec3::Z);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let views = |view: &str| format!(r#"{{"width": 3, "height": 2, "views": [{VIEW}, {view}]}}"#);
        let cases = [
            ("line 1", "{".to_owned()),
            ("expected an object with width, height and views", "[]".to_owned()),
            ("expected an object with width, height and views", "7".to_owned()),
            ("expected a view: an object with source, first_pixel", views("[]")),
            ("height", r#"{"width": 3, "views": []}"#.to_owned()),
            ("at least one", r#"{"width": 3, "height": 2, "views": []}"#.to_owned()),
            ("width is 0", format!(r#"{{"width": 0, "height": 2, "views": [{VIEW}]}}"#)),
            ("height is 40000", format!(r#"{{"width": 1, "height": 40000, "views": [{VIEW}]}}"#)),
            ("`pitch`", format!(r#"{{"width": 3, "height": 2, "pitch": 1, "views": [{VIEW}]}}"#)),
            ("`pixel`", views(&VIEW.replace("first_pixel", "pixel"))),
            ("`up`", views(&VIEW.replace('{', r#"{"up": 1, "#))),
            ("length", views(&VIEW.replace("[0,-500,0]", "[0,-500]"))),
            ("views[1].column_step and row_step", views(&VIEW.replace("[1,0,0]", "[0,0,2]"))),
            ("views[1].source", views(&VIEW.replace("-500", "500"))),
            ("out of range", views(&VIEW.replace("-500", "1e999"))),
        ];
        for (word, text) in cases {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(word), "{word}: {message}");
        }
    }

    #[test]
    fn an_invalid_geometry_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let geometry = GeometryFile { width: 1, height: 1, views: vec![] };
        assert!(geometry.write(&folder.path().join("geometry.json")).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
