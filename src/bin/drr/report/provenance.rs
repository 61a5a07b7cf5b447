//! What a report's images were made of.

use std::time::SystemTime;

use drr::geometry::{AnatomicalDirection, PatientOrientation};
use glam::DVec3;

use super::Report;
use super::html::Html;

impl Report<'_> {
    pub(super) fn provenance(&self) -> Html {
        let grid = self.projector.volume().grid();
        let matrix = grid.index_to_world();
        let axes = [0, 1, 2].map(|axis| AnatomicalDirection::of(matrix.matrix3.col(axis)).to_string());
        let mut facts = vec![
            ("date", humantime::format_rfc3339_seconds(SystemTime::now()).to_string()),
            ("CT", self.setup.name()),
            ("voxels", grid.dimensions().map(|n| n.to_string()).join(" × ")),
            ("spacing", format!("{} mm", numbers(grid.spacing()))),
            ("first voxel", format!("{} mm", numbers(matrix.translation))),
            ("axes lead to", axes.join(", ")),
        ];
        facts.extend(self.metadata.common().iter().map(|(name, value)| (*name, value.clone())));
        let facts = facts.into_iter().map(|(name, value)| (name.replace('_', " "), Html::text(value)));
        let command = ("command line".to_owned(), Html::of("code", command_line()));
        [Html::list(facts.chain([command])), Html::of("h3", "Views as stored"), self.poses()]
            .into_iter()
            .collect()
    }

    fn poses(&self) -> Html {
        let heads = [
            "view",
            "number",
            "row \\ column",
            "source, mm",
            "first pixel, mm",
            "column step, mm",
            "row step, mm",
        ];
        let rows = (0..self.views.poses.len()).map(|view| {
            let named = self.views.named(view);
            let pose = &named.pose;
            let vectors = [pose.source, pose.first_pixel, pose.column_step, pose.row_step].map(numbers);
            let own =
                [named.name.clone(), named.number.to_string(), PatientOrientation::of(pose).to_string()];
            own.into_iter().chain(vectors).map(Html::text).collect()
        });
        Html::table(&heads, rows)
    }
}

fn numbers(vector: DVec3) -> String {
    vector.to_array().map(|x| format!("{}", (x * 1e6).round() / 1e6 + 0.0)).join(", ")
}

/// As it can be typed again.
fn command_line() -> String {
    let quoted = |argument: std::ffi::OsString| {
        let text = argument.to_string_lossy().into_owned();
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+@%".contains(c);
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
    };
    std::env::args_os().map(quoted).collect::<Vec<_>>().join(" ")
}
