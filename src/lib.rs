//! Digitally reconstructed radiographs (DRRs): X-ray images of a CT, poly-energetic, cone beam, with their error stated.
//!
//! A [`Scene`] says what is simulated: detector, spectrum, materials, algorithm. With a [`volume::Volume`] it becomes a
//! [`plan::Plan`]: the stages that the scene calls for, each with its reason, cost and error, and what is left out. A
//! [`Projector`] runs the plan on an [`engine`]: `cpu` in float32, or `reference` in float64, the truth that the fast one
//! is held to. Rays accumulate the areal density of each material; energies come after the march, once per ray.
//!
//! Beside images there are their derivatives by the object's pose, in parallel ([`parallel`]) and cone beams
//! ([`pose_gradient`]), and the adjoints of line integrals ([`RayTransform`]): [`alignment`], [`registration`] and
//! [`reconstruction`] are made of them.
//!
//! ```
//! use std::sync::Arc;
//!
//! use drr::engine::{Backend, Layers, SILENT};
//! use drr::geometry::{DetectorPose, View};
//! use drr::phantom::Phantom;
//! use drr::physics::{Calibration, Thresholds};
//! use drr::volume::{Classification, VolumeBuilder};
//! use drr::{Context, Projector, Scene};
//!
//! // A CT: int16 HU, x fastest, here a water cylinder of 200 mm.
//! let phantom = Phantom::water_cylinder();
//! let grid = phantom.grid([60, 60, 56])?;
//! let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT)?;
//! let mut volume = VolumeBuilder::int16(grid, &how, true)?;
//! phantom.voxelise(&grid, |_, hu, labels| volume.push_int16(hu, Some(labels)))?;
//!
//! // 120 kVp, air, lung, soft tissue and bone, 90 × 90 pixels; two views at ±6°.
//! let context = Context::new(Backend::Cpu, 0)?;
//! let projector = Projector::new(&context, Arc::new(volume.finish()?), Scene::new([90, 90])?)?;
//! println!("{}", projector.plan());
//! let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 7.2, [90, 90]);
//! let views = pair.map(|pose| View::Pose(pose).into());
//! let wanted = Layers { line_integral: true, ..Layers::default() };
//! let images = projector.project(&views, wanted, SILENT)?;
//!
//! // Pixel (45, 45) of the first view against the cylinder's closed form.
//! let water = phantom.areal_densities(pair[0].source, pair[0].pixel(45.0, 45.0), &|_hu| 1.0, 4)?;
//! let exact = projector.scene().spectral_model()?.line_integral(&water);
//! let p = images.view(&images.line_integral, 0)[45 * 90 + 45];
//! assert!((f64::from(p) / exact - 1.0).abs() < 1e-2); // 6 mm voxels
//! # drr::Result::Ok(())
//! ```

pub mod accuracy;
pub mod alignment;
mod allocation;
pub mod capi;
mod context;
pub mod effects;
pub mod engine;
pub mod error;
mod exposure;
#[cfg(feature = "formats")]
pub mod formats;
pub mod geometry;
mod least_squares;
pub mod levenberg_marquardt;
mod linear_operator;
mod method;
mod normal_equations;
pub mod parallel;
pub mod phantom;
pub mod physics;
mod pixel_blocks;
pub mod plan;
pub mod planner;
pub mod pose_gradient;
mod projector;
pub mod ray_transform;
pub mod raycast;
mod real;
pub mod reconstruction;
pub mod registration;
mod scene;
pub mod shared;
mod tolerance;
mod values;
mod vector;
mod view_stream;
pub mod volume;

pub use context::{Context, MAX_THREADS};
pub use error::{Error, Result};
pub use exposure::{Exposure, Focus, StageTimes};
pub use linear_operator::LinearOperator;
pub use method::{Accumulation, Algorithm, Energies, FEW_ENERGIES_RANGE, Method, STEP_RANGE, Storage};
pub use normal_equations::NormalEquations;
pub use projector::{Projector, ViewRequest};
pub use ray_transform::RayTransform;
pub use real::Real;
pub use scene::{MAX_DETECTOR, MAX_DETECTOR_LAYERS, MAX_SUPERSAMPLING, Scene};
pub use tolerance::Tolerance;

/// The library's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
