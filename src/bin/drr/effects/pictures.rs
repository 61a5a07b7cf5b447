//! The chart of times, and what each effect does to an image.

use std::path::Path;

use anyhow::Result;
use drr::formats::{ColourPicture, error_map, radiograph};

use super::Study;
use super::measured::Shown;
use super::report::{Report, Row};
use crate::charts::{Bar, Bars, ContactSheet, Drawing as _, Panel, colour_range, mark_sides};

pub(super) struct Pictures<'a> {
    pub(super) study: &'a Study<'a>,
    pub(super) report: &'a Report,
    pub(super) other: Option<&'a Report>,
    pub(super) shown: &'a [Shown],
}

impl Pictures<'_> {
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let chart = self.chart();
        chart.write_svg(&folder.join("cost.svg"))?;
        chart.write_png(&folder.join("cost.png"))?;
        self.contact_sheet()?.picture()?.write_png(&folder.join("effects.png"))?;
        Ok(())
    }

    fn chart(&self) -> Bars {
        let reports: Vec<&Report> = [self.report].into_iter().chain(self.other).collect();
        let series = |report: &&Report| {
            let plain = crate::value::seconds(report.plain_seconds);
            format!("{} on {}: plain {plain}", report.engine, report.machine)
        };
        let mut rows: Vec<&Row> = Vec::new();
        for row in reports.iter().flat_map(|report| &report.effects) {
            if rows.iter().all(|known| known.name != row.name) {
                rows.push(row);
            }
        }
        let bar = |row: &Row| Bar { value: row.ratio, range: row.ratio_spread, pale: row.instead };
        let bars = |name: &str| {
            let of = |report: &&Report| report.effects.iter().find(|row| row.name == name).map(bar);
            reports.iter().map(of).collect()
        };
        Bars {
            title: "What each effect costs".into(),
            subtitle: self.report.scene.clone(),
            x_label: "time relative to the plain projection of the same views".into(),
            series: reports.iter().map(series).collect(),
            rows: rows.iter().map(|row| (row.name.clone(), bars(&row.name))).collect(),
            pale: "instead of a projection".into(),
        }
    }

    fn contact_sheet(&self) -> Result<ContactSheet> {
        let plain = &self.shown[0];
        let mut panels = vec![Panel {
            name: "plain".into(),
            caption: "p = −ln(I/I0)".into(),
            picture: self.radiograph(plain)?,
        }];
        for shown in &self.shown[1..] {
            if shown.name.starts_with("plain")
                || shown.name == "scatter, first time"
                || shown.size != plain.size
            {
                continue;
            }
            panels.push(self.panel(shown, plain)?);
        }
        let [width, height] = self.study.scene.detector;
        Ok(ContactSheet {
            title: "What each effect does to the first view".into(),
            subtitle: format!(
                "Change of −ln(signal), blue where the signal grows, red where it shrinks; the number is full colour. {width}×{height} pixels, thinned."
            ),
            panels,
        })
    }

    fn panel(&self, shown: &Shown, plain: &Shown) -> Result<Panel> {
        let name = shown.name.to_owned();
        if shown.name == "everything" {
            return Ok(Panel {
                name,
                caption: "p of the first layer".into(),
                picture: self.radiograph(shown)?,
            });
        }
        let (change, of): (Vec<f32>, &str) = if let [top, bottom] = &shown.line_integral[..] {
            (top.iter().zip(bottom).map(|(top, bottom)| bottom - top).collect(), "bottom − top: ")
        } else if ["another spectrum", "noise, integrating"].contains(&shown.name) {
            let both = shown.line_integral[0].iter().zip(&plain.line_integral[0]);
            (both.map(|(own, plain)| own - plain).collect(), "of p: ")
        } else {
            let both = shown.intensity[0].iter().zip(&plain.intensity[0]);
            (both.map(|(own, plain)| -(own / plain).ln()).collect(), "")
        };
        let range = colour_range(&change);
        let [width, height] = shown.size;
        let picture = error_map(&[&change], width, height, range.unwrap_or(1.0))?;
        let caption = range.map_or("no change".into(), |range| format!("{of}±{range}"));
        Ok(Panel { name, caption, picture })
    }

    fn radiograph(&self, shown: &Shown) -> Result<ColourPicture> {
        let [width, height] = shown.size;
        let mut picture = radiograph(&[&shown.line_integral[0]], width, height)?.to_colour();
        mark_sides(&mut picture, [0, 0], shown.size, self.study.views.upright_orientation(0))?;
        Ok(picture)
    }
}
