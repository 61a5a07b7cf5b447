//! Views that are projected as they come: any number of them, of which few are held.

use crate::engine::{Images, Layers, Report};
use crate::error::{Error, Result};
use crate::method::Algorithm;
use crate::projector::{Projector, ViewRequest};

/// Most views that are projected together: what one launch of a GPU takes.
const MOST_VIEWS: usize = 8;

/// Bytes of images that are held, unless one view has more.
const MOST_BYTES: usize = 64 << 20;

impl Projector {
    /// Projects any number of views, taken from `views` a few at a time, and gives the images of one after the other: the
    /// bytes of [`Projector::project`] for all of them, but at most 64 MiB of images, or one view's, and the one that is
    /// handed out are held. A view without a [`number`](ViewRequest::number) has its place in `views` as its own. Nothing is
    /// projected before it is asked for; `progress` as in [`Projector::project`]. It ends with the first error.
    ///
    /// ```
    /// # use std::sync::Arc;
    /// # use drr::engine::{Backend, Layers, SILENT};
    /// # use drr::geometry::{DetectorPose, View};
    /// # use drr::phantom::Phantom;
    /// # use drr::physics::{Calibration, Thresholds};
    /// # use drr::volume::{Classification, VolumeBuilder};
    /// # use drr::{Context, Projector, Scene};
    /// # let phantom = Phantom::water_cylinder();
    /// # let grid = phantom.grid([20, 20, 20])?;
    /// # let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT)?;
    /// # let mut volume = VolumeBuilder::int16(grid, &how, true)?;
    /// # phantom.voxelise(&grid, |_, hu, labels| volume.push_int16(hu, Some(labels)))?;
    /// # let context = Context::new(Backend::Cpu, 2)?;
    /// # let projector = Projector::new(&context, Arc::new(volume.finish()?), Scene::new([24, 24])?)?;
    /// let angles = (0..1000).map(|n| 0.36 * f64::from(n));
    /// let views = angles.map(|a| View::Pose(DetectorPose::c_arm(grid.centre(), a, 1000.0, 1500.0, 27.0, [24, 24])).into());
    /// let wanted = Layers { line_integral: true, ..Layers::default() };
    /// for image in projector.project_each(views, wanted, SILENT) {
    ///     let p = image?.line_integral; // one view's: train with it, write it, drop it
    ///     # assert_eq!(p.len(), 24 * 24);
    /// }
    /// # drr::Result::Ok(())
    /// ```
    pub fn project_each<'a>(
        &'a self,
        views: impl IntoIterator<Item = ViewRequest> + 'a,
        layers: Layers,
        progress: Report<'a>,
    ) -> impl Iterator<Item = Result<Images<f32>>> + 'a {
        self.each(views, layers, move |group| self.project(group, layers, progress))
    }

    /// As [`Projector::project_each`], in float64 by the reference engine: see [`Projector::reference`].
    pub fn reference_each<'a>(
        &'a self,
        algorithm: Algorithm,
        views: impl IntoIterator<Item = ViewRequest> + 'a,
        layers: Layers,
        progress: Report<'a>,
    ) -> impl Iterator<Item = Result<Images<f64>>> + 'a {
        self.each(views, layers, move |group| self.reference(algorithm, group, layers, progress))
    }

    fn each<'a, T: Copy + Default + 'a>(
        &'a self,
        views: impl IntoIterator<Item = ViewRequest> + 'a,
        layers: Layers,
        project: impl Fn(&[ViewRequest]) -> Result<Images<T>> + 'a,
    ) -> impl Iterator<Item = Result<Images<T>>> + 'a {
        let most = (MOST_BYTES / self.bytes_per_view::<T>(layers).max(1)).clamp(1, MOST_VIEWS);
        let mut views = views.into_iter().enumerate().fuse();
        let mut group: Option<(Images<T>, usize)> = None;
        let mut failed = false;
        let mut next = move || {
            if group.as_ref().is_none_or(|(images, given)| *given == images.views) {
                // What was handed out is not held while more is made.
                group = None;
                let coming: Vec<_> = views.by_ref().take(most).collect();
                let Some(&(first, _)) = coming.first() else { return Ok(None) };
                let coming: Vec<_> = coming.into_iter().map(|(n, view)| numbered(n, view)).collect();
                let images = project(&coming).map_err(|error| in_place(error, coming.len(), first))?;
                group = Some((images, 0));
            }
            match &mut group {
                Some((images, given)) if images.views > 1 => {
                    *given += 1;
                    images.only(*given - 1).map(Some)
                }
                alone => Ok(alone.take().map(|(images, _)| images)),
            }
        };
        std::iter::from_fn(move || {
            if failed {
                return None;
            }
            let image = next().transpose();
            failed = matches!(image, Some(Err(_)));
            image
        })
    }

    /// Bytes of one view's images.
    fn bytes_per_view<T>(&self, layers: Layers) -> usize {
        let scene = self.scene();
        let signals = usize::from(layers.intensity) + usize::from(layers.line_integral);
        let materials = if layers.areal_density { scene.materials.names().len() } else { 0 };
        let planes = signals * scene.layers() + materials + usize::from(layers.bone_path);
        planes * scene.detector[0] * scene.detector[1] * size_of::<T>()
    }
}

/// A view whose number does not change with the others that it is projected with.
fn numbered(place: usize, view: ViewRequest) -> ViewRequest {
    ViewRequest { number: Some(view.number.unwrap_or(place)), ..view }
}

/// An error about one of a group's `views`, of which the first has this place in the stream.
fn in_place(error: Error, views: usize, first: usize) -> Error {
    // From the last one on: none is renamed twice.
    (0..views)
        .rev()
        .fold(error, |error, v| error.called(&format!("views[{v}]"), &format!("views[{}]", first + v)))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::context::Context;
    use crate::effects::{Effects, Noise};
    use crate::engine::{Backend, SILENT};
    use crate::geometry::{DetectorPose, Grid, View};
    use crate::physics::{Calibration, Thresholds};
    use crate::scene::Scene;
    use crate::volume::{Classification, Volume};

    const SIZE: [usize; 2] = [6, 5];

    fn pose(n: usize) -> View {
        View::Pose(DetectorPose::c_arm(DVec3::ZERO, 17.0 * n as f64, 100.0, 150.0, 2.0, SIZE))
    }

    fn projector(backend: Backend) -> Projector {
        let grid = Grid::centred([4; 3], DVec3::ONE).expect("valid");
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        let hu: Vec<_> = (0..64).map(|n| 40 * n - 900).collect();
        let volume = Volume::from_int16(grid, &hu, None, &how).expect("valid");
        let noise = Noise { photons_per_pixel: 300.0, quantum: true, electronic_photons: 0.0, seed: 5 };
        let effects = Effects { noise: Some(noise), ..Effects::default() };
        let scene = Scene { effects, ..Scene::new(SIZE).expect("valid") };
        let context = Context::new(backend, 2).expect("threads start");
        Projector::new(&context, Arc::new(volume), scene).expect("planned")
    }

    #[test]
    fn a_stream_has_the_bytes_of_one_call_whatever_comes_with_a_view() {
        let projector = projector(Backend::Cpu);
        let views: Vec<ViewRequest> = (0..19).map(|n| pose(n).into()).collect();
        let all = projector.project(&views, Layers::ALL, SILENT).expect("projected");
        let each: Vec<_> = projector.project_each(views, Layers::ALL, SILENT).map(Result::unwrap).collect();
        assert_eq!(each.len(), 19);
        for (v, own) in each.iter().enumerate() {
            assert_eq!(*own, all.only(v).expect("small"), "view {v}");
        }
        // Every third one, by its number: noise is that of the view, not of its place.
        let third = (1..19).step_by(3).map(|n| ViewRequest { number: Some(n), ..pose(n).into() });
        let third: Vec<_> = projector.project_each(third, Layers::ALL, SILENT).map(Result::unwrap).collect();
        assert!(third.iter().eq(each.iter().skip(1).step_by(3)));
        let alone = ViewRequest { number: Some(7), ..pose(7).into() };
        assert_eq!(projector.project(&[alone], Layers::ALL, SILENT).as_ref(), Ok(&each[7]));
        assert_ne!(projector.project(&[pose(7).into()], Layers::ALL, SILENT).as_ref(), Ok(&each[7]));
    }

    #[test]
    fn the_reference_streams_too() {
        let projector = projector(Backend::Reference);
        let views: Vec<ViewRequest> = (0..10).map(|n| pose(n).into()).collect();
        let all = projector.reference(Algorithm::Exact, &views, Layers::ALL, SILENT).expect("projected");
        let each = projector.reference_each(Algorithm::Exact, views, Layers::ALL, SILENT);
        for (v, own) in each.enumerate() {
            assert_eq!(own, all.only(v), "view {v}");
        }
    }

    #[test]
    fn views_are_taken_when_they_are_needed_and_none_after_an_error() {
        let (projector, taken) = (projector(Backend::Cpu), Cell::new(0));
        let source = |n: usize| {
            taken.set(taken.get() + 1);
            ViewRequest { stride: usize::from(n != 9), ..pose(n).into() }
        };
        let mut stream = projector.project_each((0..1000).map(source), Layers::ALL, SILENT);
        assert_eq!(taken.get(), 0);
        assert!(stream.next().is_some_and(|image| image.is_ok()));
        assert_eq!(taken.get(), MOST_VIEWS);
        let rest: Vec<_> = stream.collect();
        assert_eq!((rest.len(), taken.get()), (8, 2 * MOST_VIEWS));
        let error = rest[7].as_ref().expect_err("a stride of 0").to_string();
        assert!(error.starts_with("views[9].stride is 0"), "{error}");
    }

    #[test]
    fn an_error_names_the_place_in_the_stream() {
        let named = |place: &str| in_place(Error::invalid(format!("views[{place}].stride"), 0, "1"), 8, 8);
        for (place, expected) in
            [("0", "views[8].stride"), ("7", "views[15].stride"), ("70", "views[70].stride")]
        {
            assert!(named(place).to_string().starts_with(expected), "{}", named(place));
        }
    }
}
