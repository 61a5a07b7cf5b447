//! perf probe
#![allow(missing_docs)]
use drr::engine::{Backend, Layers};
use drr::geometry::{DetectorPose, Grid, View};
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, VolumeBuilder};
use drr::{Algorithm, Context, Projector, Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
fn main() {
    let dims = [720, 720, 665];
    let grid = Grid::centred(dims, DVec3::splat(0.5)).unwrap();
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).unwrap();
    let mut b = VolumeBuilder::int16(grid, &how, false).unwrap();
    let mut slice = vec![0i16; 720 * 720];
    let t = Instant::now();
    for k in 0..665 {
        slice.par_chunks_mut(720).enumerate().for_each(|(j, row)| {
            for (i, hu) in row.iter_mut().enumerate() {
                let (x, y, z) = ((i as f64 - 360.) * 0.5, (j as f64 - 360.) * 0.5, (k as f64 - 332.) * 0.5);
                let inside =
                    |cx: f64, cy: f64, a: f64, b: f64| ((x - cx) / a).powi(2) + ((y - cy) / b).powi(2) < 1.0;
                let n = ((i * 7919 + j * 104729 + k * 1299709) as u32).wrapping_mul(2654435761) >> 27;
                let v = if !inside(0., 0., 165., 110.) {
                    -1000
                } else if inside(0., 76., 20., 17.)
                    || (!inside(0., 0., 150., 95.) && (z as i32).rem_euclid(27) < 10)
                {
                    600
                } else if inside(75., -2., 55., 72.) || inside(-75., -2., 55., 72.) {
                    -830
                } else {
                    45
                };
                *hu = if v > -1000 { v + n as i16 - 15 } else { v };
            }
        });
        b.push_int16(&slice, None).unwrap();
    }
    let volume = Arc::new(b.finish().unwrap());
    println!("build {:?}", t.elapsed());
    let size = [720, 720];
    let views: Vec<_> = DetectorPose::stereo_pair(&grid, 1000., 1500., 0.9, size)
        .into_iter()
        .map(|p| View::Pose(p).into())
        .collect();
    let ctx = Context::new(Backend::Cpu, 0).unwrap();
    for alg in [Algorithm::Joseph, Algorithm::Siddon] {
        let p = Projector::new(&ctx, volume.clone(), Scene { algorithm: alg, ..Scene::new(size).unwrap() })
            .unwrap();
        let n = if alg == Algorithm::Joseph { 3 } else { 1 };
        for _ in 0..n {
            let t = Instant::now();
            let c0 = cpu();
            let im = p.project(&views, Layers { intensity: true, ..Layers::default() }, &|_| ()).unwrap();
            println!(
                "{alg:?} cpu/2 {:.2} {:?} {}",
                (cpu() - c0) / 2.0,
                t.elapsed(),
                im.intensity[360 * 720 + 360]
            );
        }
    }
}
