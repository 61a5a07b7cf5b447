//! The views of a projection, all together.

use std::ops::ControlFlow;
use std::time::Instant;

use anyhow::Result;
use drr::engine::{Backend, Images, Layers};
use drr::formats::ColourPicture;
use drr::planner::Effort;
use drr::{Projector, ViewRequest};

use crate::console::Console;
use crate::inputs::Setup;
use crate::output::{Output, Rendered};
use crate::value::{prefixed, seconds};
use crate::views::Views;

/// What is projected, and where to.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) setup: &'a Setup<'a>,
    pub(crate) projector: &'a Projector,
    pub(crate) views: &'a Views,
    pub(crate) output: &'a Output<'a>,
}

/// What parts of a run took, s, and what it did.
pub(crate) struct Times {
    pub(crate) reading: f64,
    pub(crate) classifying: f64,
    pub(crate) projecting: f64,
    /// Parts of it, of a scene with effects.
    pub(crate) stages: Vec<(&'static str, f64)>,
    /// Rays cast.
    pub(crate) rays: f64,
    /// Samples of the volume taken along them.
    pub(crate) samples: f64,
}

/// Views that were projected together.
pub(crate) struct Done {
    pub(crate) picture: ColourPicture,
    pub(crate) images: Images<f32>,
    pub(crate) times: Times,
}

impl Job<'_> {
    /// Projects all views together and writes them, with a picture. What was written, in words.
    pub(crate) fn run(
        self,
        layers: Layers,
        effort: &Effort,
        [reading, classifying]: [f64; 2],
        console: Console,
    ) -> Result<(String, Done)> {
        let Self { setup, projector, views, output } = self;
        let requests = views.requests();
        // The picture is made of line integrals, also when no file has them.
        let wanted = Layers { line_integral: true, ..layers };
        let start = Instant::now();
        let (rendered, stages) = self.render(&requests, wanted, console)?;
        let projecting = start.elapsed().as_secs_f64();
        // Each point of a focal spot has rays of its own.
        let rays = projector.rays(&requests) as f64;
        let samples = effort.samples(projector.plan().method.algorithm) * rays / effort.rays;
        console.say(format_args!(
            "time    loaded in {}, {} view(s) projected in {} by {} on {} with {} thread(s): {}rays/s, {}samples/s",
            seconds(reading + classifying),
            views.poses.len(),
            seconds(projecting),
            projector.plan().method,
            setup.context.backend().name(),
            setup.context.threads(),
            prefixed(rays / projecting),
            prefixed(samples / projecting),
        ));
        if !stages.is_empty() {
            let parts: Vec<_> = stages.iter().map(|(name, s)| format!("{name} {}", seconds(*s))).collect();
            console.say(format_args!("        of which {}", parts.join(", ")));
        }
        let named: Vec<_> = (0..views.poses.len()).map(|view| views.named(view)).collect();
        for (place, view) in named.iter().enumerate() {
            output.write_view(view, &rendered, place)?;
        }
        let picture = output.write_picture(views, &rendered.images)?;
        output.write_plan()?;
        let wrote = format!("{}, radiograph.png, plan.json", output.in_words(&named));
        let times = Times { reading, classifying, projecting, stages, rays, samples };
        Ok((wrote, Done { picture, images: rendered.images, times }))
    }

    /// The images, and what the stages of a scene with effects took.
    fn render(
        self,
        views: &[ViewRequest],
        layers: Layers,
        console: Console,
    ) -> Result<(Rendered, Vec<(&'static str, f64)>)> {
        let projector = self.projector;
        let bar = console.bar("projecting", projector.rays(views));
        let progress = |rays: usize| {
            bar.inc(rays as u64);
            ControlFlow::Continue(())
        };
        let rendered = if self.setup.context.backend() == Backend::Reference {
            let algorithm = projector.plan().method.algorithm;
            (projector.reference(algorithm, views, layers, &progress)?.into(), Vec::new())
        } else {
            let (images, times) = projector.project_timed(views, layers, &progress)?;
            (images.into(), times.seconds())
        };
        bar.finish_and_clear();
        Ok(rendered)
    }
}
