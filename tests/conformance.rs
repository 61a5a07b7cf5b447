//! Each fast algorithm against its float64 twin: numerics.md's first line, for every layer and awkward geometry.
#![allow(missing_docs, reason = "a test program")]

mod support;

use drr::engine::Backend;
use drr::{Algorithm, Scene};
use support::{ALL, awkward_grid, max_relative, poses, projector, quiet, relative_l2, requests, volume};

const ALGORITHMS: [Algorithm; 5] = [
    Algorithm::Joseph,
    Algorithm::March { step: 1.0 },
    Algorithm::March { step: 0.5 },
    Algorithm::March { step: 0.3 },
    Algorithm::Siddon,
];

#[test]
fn the_cpu_engine_equals_its_twin() {
    let size = [40, 28];
    let grid = awkward_grid([70, 61, 53]);
    let volume = volume(grid);
    for algorithm in ALGORITHMS {
        for (name, pose) in poses(&grid, size) {
            let projector =
                projector(Backend::Cpu, &volume, Scene { algorithm, ..Scene::new(size).expect("valid") });
            let views = requests([pose]);
            let fast = projector.project(&views, ALL, &quiet).expect("projects");
            let truth = projector.reference(algorithm, &views, ALL, &quiet).expect("projects");
            for (layer, x, t) in [
                ("intensity", &fast.intensity, &truth.intensity),
                ("line integral", &fast.line_integral, &truth.line_integral),
                ("areal density", &fast.areal_density, &truth.areal_density),
                ("bone path", &fast.bone_path, &truth.bone_path),
            ] {
                let l2 = relative_l2(x, t);
                assert!(l2 <= 2e-6, "{algorithm:?}, {name}, {layer}: relative L2 {l2:.2e}");
            }
            let floor = 0.05 * truth.line_integral.iter().copied().fold(0.0, f64::max);
            let worst = max_relative(&fast.line_integral, &truth.line_integral, floor);
            assert!(worst <= 1e-5, "{algorithm:?}, {name}: max relative {worst:.2e}");
            println!(
                "{algorithm:?} {name}: L2 {:.1e} max {worst:.1e}",
                relative_l2(&fast.line_integral, &truth.line_integral)
            );
        }
    }
}
