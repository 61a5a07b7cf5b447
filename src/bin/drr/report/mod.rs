//! `drr project --report`: a run on one page, for people. The file has everything in it and asks for nothing else.

mod html;
mod json;
mod pictures;
mod provenance;

use std::path::Path;

use anyhow::Result;
use drr::Projector;
use drr::accuracy::Certificate;
use drr::formats::{ColourPicture, write_text};

use crate::certificate;
use crate::inputs::Setup;
use crate::job::Times;
use crate::metadata::Metadata;
use crate::value::{prefixed, seconds};
use crate::views::Views;
use html::Html;
pub(crate) use pictures::Layer;

/// What a report is called.
pub(crate) const FILE: &str = "report.html";
const STYLE: &str = include_str!("style.css");

/// What a run was, and what came of it.
pub(crate) struct Report<'a> {
    pub(crate) setup: &'a Setup<'a>,
    pub(crate) projector: &'a Projector,
    pub(crate) views: &'a Views,
    pub(crate) metadata: &'a Metadata,
    /// The picture of the first views.
    pub(crate) picture: &'a ColourPicture,
    /// The layers of the first views, one view after the other.
    pub(crate) layers: Vec<Vec<Layer>>,
    pub(crate) times: &'a Times,
    pub(crate) certificate: Option<&'a Certificate>,
    pub(crate) warnings: &'a [String],
}

impl Report<'_> {
    pub(crate) fn write(&self, folder: &Path) -> Result<()> {
        let name = self.setup.name();
        let body = [
            Html::of("h1", format!("X-ray projections of {name}")),
            Html::element("p", &[("class", "pale")], [Html::text(self.summary())]),
            self.facts(),
            section("Warnings", [self.warnings()]),
            section("Pictures", [self.pictures()?]),
            section("Error", [self.error()]),
            section("Plan", self.plan()),
            section("Time", [self.time()]),
            section("Provenance", [self.provenance()]),
            Html::element(
                "footer",
                &[],
                [Html::text(
                    "Lengths are mm, energies keV, areal densities g/cm\u{b2}. World: LPS, x to the patient's left, y to the back, z to the head. A simulation; not for diagnosis.",
                )],
            ),
        ];
        Ok(write_text(&folder.join(FILE), &Html::document(&format!("drr: {name}"), STYLE, body))?)
    }

    fn summary(&self) -> String {
        let plan = self.projector.plan();
        let ([width, height], [i, j, k]) = (plan.detector, plan.volume);
        let views = self.views.poses.len();
        let engine = plan.engine.name();
        format!(
            "{views} view(s) of {width}×{height} pixels from {i}×{j}×{k} voxels, by {} on {engine}",
            plan.method
        )
    }

    /// What is asked first.
    fn facts(&self) -> Html {
        let rms = self.certificate.and_then(|certificate| certificate.total.hu);
        let error = match rms {
            Some(hu) => format!("{} HU", certificate::short(hu.rms)),
            None => "not measured".into(),
        };
        let times = self.times;
        let facts = [
            (error, "RMSE against the exact integral"),
            (seconds(times.projecting), "for all views"),
            (format!("{}rays/s", prefixed(times.rays / times.projecting)), "cast"),
            (format!("{}samples/s", prefixed(times.samples / times.projecting)), "of the volume"),
        ];
        let fact = |(value, what): (String, &str)| {
            Html::element("div", &[("class", "fact")], [Html::of("b", value), Html::of("span", what)])
        };
        Html::element("div", &[("class", "facts")], facts.map(fact))
    }

    fn warnings(&self) -> Html {
        if self.warnings.is_empty() {
            return Html::of("p", "None.");
        }
        let items = self.warnings.iter().map(|warning| Html::of("li", warning));
        Html::element("ul", &[("class", "warnings")], items)
    }

    fn error(&self) -> Html {
        let Some(certificate) = self.certificate else {
            return Html::of("p", "It was not measured (--no-check).");
        };
        let plan = self.projector.plan();
        let rows = certificate::rows(certificate, plan).map(|row| {
            let numbers =
                row.estimate.map_or(["no ray above the floor".into(), String::new(), String::new()], |e| {
                    [e.rms, e.rms_high, e.max]
                        .map(|value| format!("{} {}", certificate::short(value), row.unit))
                });
            [row.what].into_iter().chain(numbers).map(Html::text).collect()
        });
        let heads = ["", "RMSE", "of all rays below", "largest"];
        [
            Html::of("p", format!("Error {}", certificate::method(certificate, plan).join(" "))),
            Html::table(&heads, rows),
        ]
        .into_iter()
        .collect()
    }

    /// Everything that plan.json says, what runs first.
    fn plan(&self) -> Vec<Html> {
        let plan = self.projector.plan();
        let mut rest = serde_json::to_value(plan).unwrap_or_default();
        let mut take = |name: &str| rest.as_object_mut().and_then(|plan| plan.remove(name));
        let parts = [
            ("What runs, and why", "stages"),
            ("What does not run, and why", "omissions"),
            ("Effects that change too little", "left_out"),
        ];
        let parts = parts.map(|(title, name)| Some([Html::of("h3", title), json::shown(&take(name)?)]));
        let mut shown: Vec<Html> = parts.into_iter().flatten().flatten().collect();
        shown.extend([Html::of("h3", "Everything else"), json::shown(&rest)]);
        shown
    }

    fn time(&self) -> Html {
        let times = self.times;
        let given = [
            ("reading", times.reading),
            ("HU to voxels", times.classifying),
            ("projecting", times.projecting),
        ];
        let stages = times.stages.iter().map(|(name, seconds)| (format!("of which {name}"), *seconds));
        let rows = given.map(|(name, seconds)| (name.to_owned(), seconds)).into_iter().chain(stages);
        let context = &self.setup.context;
        let on = format!("On {} with {} thread(s).", context.backend().name(), context.threads());
        let table = Html::table(
            &["", "time"],
            rows.map(|(name, time)| vec![Html::text(name), Html::text(seconds(time))]),
        );
        [Html::of("p", on), table].into_iter().collect()
    }
}

fn section(title: &str, content: impl IntoIterator<Item = Html>) -> Html {
    let heading = [Html::of("h2", title)];
    Html::element("section", &[], heading.into_iter().chain(content))
}
