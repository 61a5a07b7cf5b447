//! A projection can be cancelled at any report of its progress, and then does no further work.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::{Context, Error, Projector, Result, Scene, ViewRequest};
use support::{awkward_grid, poses, requests, volume};

/// Engines that promise to stop within 1024 rays of a thread, and are here.
fn backends() -> Vec<Backend> {
    let host = support::host_compiler().is_ok().then_some(Backend::Host);
    [Backend::Cpu, Backend::Reference].into_iter().chain(host).collect()
}

const SIZE: [usize; 2] = [24, 17];
const WANTED: Layers =
    Layers { intensity: false, line_integral: true, areal_density: false, bone_path: false };

/// Cancels at the given report, if there are as many; the result, and how often the caller was asked.
fn cancelled(projector: &Projector, views: &[ViewRequest], at: usize) -> (Result<Images<f32>>, usize) {
    let reports = AtomicUsize::new(0);
    let report = |_| {
        let n = reports.fetch_add(1, Ordering::Relaxed) + 1;
        if n > at {
            // Leaves the processor to the thread that was answered, which has yet to tell the others.
            std::thread::sleep(Duration::from_millis(20));
        }
        if n == at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let result = projector.project(views, WANTED, &report);
    (result, reports.into_inner())
}

#[test]
fn no_work_begins_after_a_break_and_the_projector_is_as_before() {
    let volume = volume(awkward_grid([12, 10, 9]));
    for backend in backends() {
        for threads in [1, 4] {
            let context = Context::new(backend, threads).expect("threads start");
            let scene = Scene { supersampling: 3, ..Scene::new(SIZE).expect("valid") };
            let projector = Projector::new(&context, volume.clone(), scene).expect("valid");
            let views = requests(poses(volume.grid(), SIZE).into_iter().take(4).map(|(_, pose)| pose));
            let (before, all) = cancelled(&projector, &views, usize::MAX);
            assert!(all >= 40, "{backend:?}: only {all} reports");
            for at in [1, 7] {
                let (result, reports) = cancelled(&projector, &views, at);
                assert_eq!(result, Err(Error::Cancelled));
                // Other threads may go on until they hear of it.
                let most = if threads == 1 { at } else { all - 1 };
                assert!((at..=most).contains(&reports), "{backend:?}: {reports} of {all} reports");
            }
            assert_eq!(projector.project(&views, WANTED, SILENT), before);
        }
    }
}

#[test]
fn all_rays_are_reported() {
    let volume = volume(awkward_grid([12, 10, 9]));
    for backend in backends() {
        for supersampling in [1, 3, 16] {
            let size = [9, 3];
            let scene = Scene { supersampling, ..Scene::new(size).expect("valid") };
            let projector = support::projector(backend, &volume, scene);
            let views = requests(poses(volume.grid(), size).into_iter().take(2).map(|(_, pose)| pose));
            let (rays, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let report = |n| {
                rays.fetch_add(n, Ordering::Relaxed);
                most.fetch_max(n, Ordering::Relaxed);
                ControlFlow::Continue(())
            };
            projector.project(&views, WANTED, &report).expect("projects");
            assert_eq!(rays.into_inner(), 2 * projector.plan().rays_per_view());
            assert!(most.into_inner() <= 1024, "as the documentation says of cancelling");
        }
    }
}
