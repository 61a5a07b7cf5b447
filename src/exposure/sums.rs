//! Which sums over energies the images of a view are made of.

use crate::engine::{Images, Layers, Passed, Progress, SignalsJob, ViewJob};
use crate::error::Result;
use crate::exposure::RayCaster;
use crate::exposure::channels::Channels;
use crate::exposure::source::Source;
use crate::geometry::View;
use crate::scene::Scene;

/// A view's source, and the sums of its rays, that a scene needs for some layers.
pub(super) struct Sums<'a> {
    pub(super) source: Source<'a>,
    pub(super) channels: Channels,
    /// Whether those of the open field are needed too: pixels differ in it.
    pub(super) open: bool,
}

impl<'a> Sums<'a> {
    /// Of a view with `size` rays.
    pub(super) fn new(scene: &'a Scene, view: &View, size: [usize; 2], layers: Layers) -> Result<Self> {
        let source = Source::new(scene, view, size)?;
        let noisy = scene.effects.noise.as_ref().is_some_and(|noise| noise.quantum);
        let channels = source.channels(scene, noisy)?;
        let open = layers.line_integral && !source.is_even();
        Ok(Self { source, channels, open })
    }

    /// Takes them where the rays are cast, if the caster does: from `views`, the points of the focal spot. `layers`: what the
    /// development needs beside them.
    pub(super) fn in_the_march<T>(
        &self,
        caster: &(impl RayCaster<T> + ?Sized),
        views: &[ViewJob],
        size: [usize; 2],
        (layers, progress): (Layers, Progress<'_>),
    ) -> Result<Option<(Images<T>, Passed)>> {
        let before = self.source.planes(size)?;
        caster.signals(&SignalsJob {
            views,
            rows: self.channels.rows(),
            coefficients: self.channels.coefficients(),
            open: self.open && !before.is_empty(),
            before: &before,
            layers,
            progress,
        })
    }
}
