//! `drr project --views`: any number of views, of which few are held. What is finished is not made again.

mod made_of;
mod shard;
mod unfinished;

use std::time::Instant;

use anyhow::Result;
use drr::engine::{Backend, Layers, SILENT};
use rayon::prelude::*;

use crate::console::Console;
use crate::job::Job;
use crate::output::Rendered;
use crate::times::median;
use crate::value::seconds;

pub(crate) use shard::Shard;

/// Bytes of images that are written together, unless one view has more.
const MOST_BYTES: usize = 32 << 20;

/// Views that are written together, for each thread.
const PER_THREAD: usize = 2;

/// The rows of a table, or a shard of them.
pub(crate) struct Batch<'a> {
    pub(crate) job: Job<'a>,
    pub(crate) shard: Shard,
    pub(crate) layers: Layers,
}

impl Batch<'_> {
    /// Makes what is missing, and says what that was. What was written, in words.
    pub(crate) fn run(&self, loading: f64, console: Console) -> Result<String> {
        let Job { setup, projector, views, output } = self.job;
        made_of::check(output.folder(), &output.metadata)?;
        let rows = unfinished::unfinished(self)?;
        made_of::claim(output.folder(), &output.metadata)?;
        output.write_plan()?;
        let start = Instant::now();
        let times = self.make(&rows, console)?;
        let making = seconds(start.elapsed().as_secs_f64());
        let shard = self.shard.rows(views.poses.len()).len();
        let (made, finished) = (rows.len(), shard - rows.len());
        let each = if times.is_empty() {
            String::new()
        } else {
            format!(", median {} each with its files", seconds(median(&times)))
        };
        console.say(format_args!(
            "time    loaded in {}, {made} view(s) made in {making}{each}, by {} on {} with {} thread(s)",
            seconds(loading),
            projector.plan().method,
            setup.context.backend().name(),
            setup.context.threads(),
        ));
        Ok(format!(
            "{made} view(s), {finished} finished before: shard {} of {} rows, plan.json, made_of.json",
            self.shard,
            views.poses.len()
        ))
    }

    /// What each view took, s.
    fn make(&self, rows: &[usize], console: Console) -> Result<Vec<f64>> {
        let requests = rows.iter().map(|&row| self.job.views.request(row));
        let mut images: Box<dyn Iterator<Item = drr::Result<Rendered>>> = if self.is_reference() {
            let algorithm = self.job.projector.plan().method.algorithm;
            let each = self.job.projector.reference_each(algorithm, requests, self.layers, SILENT);
            Box::new(each.map(|images| images.map(Rendered::from)))
        } else {
            let each = self.job.projector.project_each(requests, self.layers, SILENT);
            Box::new(each.map(|images| images.map(Rendered::from)))
        };
        let bar = console.bar("projecting", rows.len());
        let most = PER_THREAD * self.job.setup.context.threads();
        let mut times = Vec::with_capacity(rows.len());
        while times.len() < rows.len() {
            let start = Instant::now();
            let (mut group, mut bytes) = (Vec::new(), 0);
            for image in images.by_ref() {
                let image = image?;
                bytes += image.bytes();
                group.push(image);
                if group.len() == most || bytes >= MOST_BYTES {
                    break;
                }
            }
            let rows = &rows[times.len()..][..group.len()];
            let write = |(image, &row): (&Rendered, &usize)| {
                self.job.output.write_view(&self.job.views.named(row), image, 0)
            };
            self.job.setup.context.install(|| group.par_iter().zip(rows).try_for_each(write))?;
            let each = start.elapsed().as_secs_f64() / group.len() as f64;
            times.extend(group.iter().map(|_| each));
            bar.inc(group.len() as u64);
        }
        bar.finish_and_clear();
        Ok(times)
    }

    fn is_reference(&self) -> bool {
        self.job.setup.context.backend() == Backend::Reference
    }
}
