//! The march of an exposure: every ray of every view, from every point of the focal spot.

use std::sync::Arc;

use crate::context::Context;
use crate::engine::reference::Reference;
use crate::engine::{Images, Job, Layers, Passed, Progress, Report, ViewJob};
use crate::error::{Error, Result};
use crate::exposure::rays::{from_point, on_ray_grid};
use crate::exposure::shot::{Shot, penumbra};
use crate::exposure::sums::Sums;
use crate::exposure::{Exposure, Focus, RayCaster, Sample, implants};
use crate::geometry::View;
use crate::method::Algorithm;
use crate::projector::ViewRequest;
use crate::raycast::Beam;
use crate::scene::Scene;
use crate::volume::Volume;

/// What casts the rays of exposures.
pub(crate) struct March<'a> {
    pub(crate) context: &'a Context,
    pub(crate) volume: &'a Arc<Volume>,
    /// What was asked for, and what the plan left of it.
    pub(crate) asked: &'a Scene,
    pub(crate) scene: &'a Scene,
    pub(crate) focus: Focus,
    /// By which implants take away what the volume has.
    pub(crate) algorithm: Algorithm,
    /// Whether the path through bone is wanted.
    pub(crate) bone_path: bool,
    /// The layers that are made of the rays at once, before anything else; `None`: the rays are kept.
    pub(crate) developed: Option<Layers>,
    pub(crate) progress: Report<'a>,
}

/// A point of the focal spot, mm from its centre, and its part of the photons.
type Point = ([f64; 2], f64);

impl March<'_> {
    /// Exposes `views`; the caster is for rays that are the pixels of the ray grid.
    pub(crate) fn expose<T: Sample>(
        &self,
        views: &[ViewRequest],
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<Exposure<T>> {
        let shots = (0..views.len()).map(|v| self.shot(views, v, caster)).collect::<Result<_>>()?;
        Ok(self.exposure(shots))
    }

    /// Exposes one of `views` only.
    pub(crate) fn expose_nth<T: Sample>(
        &self,
        views: &[ViewRequest],
        nth: usize,
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<Exposure<T>> {
        Ok(self.exposure(vec![self.shot(views, nth, caster)?]))
    }

    fn exposure<T>(&self, shots: Vec<Shot<T>>) -> Exposure<T> {
        Exposure { context: self.context.clone(), scene: self.asked.clone(), focus: self.focus, shots }
    }

    /// An error says which view it is about.
    fn shot<T: Sample>(
        &self,
        views: &[ViewRequest],
        nth: usize,
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<Shot<T>> {
        let view = &views[nth];
        let shot = check_tables(view).and_then(|()| self.shot_of(view, view.number.unwrap_or(nth), caster));
        shot.map_err(|error| error.of(&format!("views[{nth}]")))
    }

    fn shot_of<T: Sample>(
        &self,
        request: &ViewRequest,
        number: usize,
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<Shot<T>> {
        let (view, stride) = (&request.view, request.checked_stride()?);
        view.validate()?;
        let (grid, n) = (self.volume.grid(), self.scene.supersampling);
        let size = self.scene.detector.map(|side| side * n);
        let points = self.points(view)?;
        let beam = |offset: [f64; 2]| {
            let view = if offset == [0.0; 2] { *view } else { from_point(view, offset)? };
            Ok(Beam::new(&on_ray_grid(&view, n), grid, size)?.of_parts(stride))
        };
        let beams = points.iter().map(|(offset, _)| beam(*offset)).collect::<Result<Vec<_>>>()?;
        let job =
            |beam: &Beam| ViewJob { beam: *beam, early_exit: false, spectral: None, lut_addresses: [0, 0] };
        let jobs: Vec<_> = beams.iter().map(job).collect();
        let view = on_ray_grid(view, n);
        let parts = points.iter().map(|(_, part)| *part).collect();
        if let Some((images, passed)) = self.context.install(|| self.passed(&view, &jobs, size, caster))? {
            return Ok(Shot { number, view, grid: *grid, images, passed: Some(passed), parts });
        }
        let layers = Layers { areal_density: true, bone_path: self.bone_path, ..Layers::default() };
        let progress = Progress::new(self.progress);
        let mut images = self.context.install(|| caster.cast(&Job { views: &jobs, layers, progress }))?;
        self.put_implants(&beams, &mut images)?;
        Ok(Shot { number, view, grid: *grid, images, passed: None, parts })
    }

    /// Has the caster sum over energies what its rays meet, if it can. The one place where this is decided: not for rays that
    /// are kept, of which other spectra may be wanted; not with implants, which change areal densities after the march; not
    /// without a signal.
    fn passed<T: Sample>(
        &self,
        view: &View,
        jobs: &[ViewJob],
        size: [usize; 2],
        caster: &(impl RayCaster<T> + ?Sized),
    ) -> Result<Option<(Images<T>, Passed)>> {
        let effects = &self.scene.effects;
        let Some(layers) = self.developed.filter(|layers| layers.intensity || layers.line_integral) else {
            return Ok(None);
        };
        if !caster.has_signals() || !effects.implants.is_empty() {
            return Ok(None);
        }
        let sums = Sums::new(self.scene, view, size, layers)?;
        // Scatter comes from what the rays have passed.
        let areal_density = layers.areal_density || effects.scatter.is_some();
        let beside = Layers { areal_density, bone_path: layers.bone_path, ..Layers::default() };
        sums.in_the_march(caster, jobs, size, (beside, Progress::new(self.progress)))
    }

    fn put_implants<T: Sample>(&self, beams: &[Beam], images: &mut Images<T>) -> Result<()> {
        let (with, grid) = (&self.scene.effects.implants, self.volume.grid());
        if with.is_empty() {
            return Ok(());
        }
        let reference = Reference::new(self.volume.clone(), self.scene, self.algorithm)?;
        for (point, beam) in beams.iter().enumerate() {
            self.context
                .install(|| implants::put(with, beam, &reference, grid, self.scene.bone, point, images));
        }
        Ok(())
    }

    /// The points that a view is exposed from.
    fn points(&self, view: &View) -> Result<Vec<Point>> {
        let centre = || Ok(vec![([0.0; 2], 1.0)]);
        match &self.scene.effects.focal_spot {
            Some(spot) if self.focus == Focus::Points => {
                let counts = spot.counts(penumbra(spot, view, self.volume.grid())?)?;
                Ok(spot.offsets(counts))
            }
            _ => centre(),
        }
    }

    /// Rays of a view, over all points of the focal spot.
    pub(crate) fn rays(&self, view: &View) -> usize {
        let points = self.points(view).map_or(1, |points| points.len());
        let n = self.scene.supersampling;
        points * self.scene.detector.map(|side| side * n).into_iter().product::<usize>()
    }
}

/// A view's own tables are spectra of engines that see one signal.
fn check_tables(view: &ViewRequest) -> Result<()> {
    if view.spectral.is_none() && view.lut_addresses == [0, 0] {
        return Ok(());
    }
    let valid = "0 in an exposure and in a scene with effects or two detector layers: the scene's own tables are used";
    Err(Error::invalid("spectrumLutAddress or muLutAddress", "given", valid))
}
