//! Runs a case on an engine and compares with the truth.

use drr::engine::{Backend, Images, SILENT};
use drr::physics::MAX_MATERIALS;
use drr::{Algorithm, Context, Error, Projector};

use super::bounds::Bounds;
use super::case::{Case, Demand, Set};
use super::row::Deviation;
use super::truth::{Line, Truth, Values};

/// A verdict: how far off, and what it rests on when that is not the bound alone.
pub(super) type Verdict = drr::Result<(Deviation, Option<String>)>;

/// A case with the answers of one algorithm, which all engines share.
pub(super) struct Judge<'a> {
    case: &'a Case,
    algorithm: Algorithm,
    expected: Vec<Expected>,
    /// For the rays beside those in a face, where they count too.
    beside: Option<Truth>,
}

/// One ray and its values: more than one where rounding decides the driving axis.
struct Expected {
    line: Line,
    values: Vec<Values>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(case: &'a Case, algorithm: Algorithm) -> Self {
        let (expected, beside) = match &case.demand {
            Demand::Exact(set) | Demand::NearFace(set) => {
                let truth = Truth::new(&set.volume, &set.scene);
                let near_face = matches!(case.demand, Demand::NearFace(_));
                (expected(&truth, set, of_set(algorithm, set)), near_face.then_some(truth))
            }
            Demand::Vacuum(_) | Demand::Same(..) | Demand::Refused(..) => (Vec::new(), None),
        };
        Self { case, algorithm, expected, beside }
    }

    /// Runs the case on the context's engine.
    pub(super) fn verdict(&self, context: &Context) -> Verdict {
        match &self.case.demand {
            Demand::Exact(set) | Demand::NearFace(set) => self.compare(context, set),
            Demand::Vacuum(set) => {
                let images = self.images(context, set)?;
                Ok((vacuum(context.backend(), set.scene.detected(0).expect("valid").total(), &images), None))
            }
            Demand::Same(sets) => {
                let same = same_bytes(&self.images(context, &sets[0])?, &self.images(context, &sets[1])?);
                Ok((if same { Deviation::NONE } else { Deviation::DIFFERENT }, None))
            }
            Demand::Refused(argument, attempt) => Ok(refused(argument, attempt(context))),
        }
    }

    fn images(&self, context: &Context, set: &Set) -> drr::Result<Images<f64>> {
        let mut scene = set.scene.clone();
        scene.method.algorithm = of_set(self.algorithm, set);
        let projector = Projector::new(context, set.volume.clone(), scene)?;
        match context.backend() {
            Backend::Reference => {
                projector.reference(projector.plan().method.algorithm, &set.views, set.layers, SILENT)
            }
            _ => Ok(projector.project(&set.views, set.layers, SILENT)?.map(|&x| f64::from(x))),
        }
    }

    fn compare(&self, context: &Context, set: &Set) -> Verdict {
        let images = self.images(context, set)?;
        let [width, height] = set.scene.detector;
        let mut worst = Deviation::NONE;
        let mut note = None;
        for (n, expected) in self.expected.iter().enumerate() {
            let (view, pixel) = (n / (width * height), n % (width * height));
            let got = values_at(&images, view, pixel);
            let bounds = Bounds::new(context.backend(), set, view);
            let against = |values: &Values| bounds.deviation(set.layers, &got, [values, values]);
            let mut best = closest(expected.values.iter().map(against));
            if let Some(truth) = self.beside.as_ref().filter(|_| best.ratio() > 1.0) {
                let [low, high] = self.range(truth, set, &expected.line, bounds.shift_mm);
                best = bounds.deviation(set.layers, &got, [&low, &high]);
                if best.ratio() <= 1.0 {
                    note = Some("as a ray beside it".to_owned());
                }
            }
            worst = worst.or_worse(best);
        }
        Ok((worst, note))
    }

    /// The least and the largest value of each layer, over rays moved by at most `shift_mm` along each axis.
    fn range(&self, truth: &Truth, set: &Set, line: &Line, shift_mm: f64) -> [Values; 2] {
        let shift = shift_mm / set.volume.grid().spacing();
        let moves = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9].map(|step| f64::from(step) - 1.0));
        let around: Vec<_> = moves
            .map(|step| line.moved([0, 1, 2].map(|axis| step[axis] * shift[axis])))
            .flat_map(|line| truth.values(&line, of_set(self.algorithm, set)))
            .collect();
        [f64::min, f64::max].map(|pick| Values::each(&around, pick))
    }
}

/// The march takes the case's step.
fn of_set(algorithm: Algorithm, set: &Set) -> Algorithm {
    match algorithm {
        Algorithm::March { .. } => Algorithm::March { step: set.step },
        other => other,
    }
}

fn expected(truth: &Truth, set: &Set, algorithm: Algorithm) -> Vec<Expected> {
    let [width, height] = set.scene.detector;
    let rays = set.views.iter().flat_map(|request| {
        let line = move |pixel| {
            let (grid, pixel) = (set.volume.grid(), [pixel % width, pixel / width]);
            let line = Line::of(&request.view, grid, [width, height], pixel);
            if algorithm == Algorithm::DistanceDriven {
                line.with_pixel(&request.view, grid, [width, height], pixel)
            } else {
                line
            }
        };
        (0..width * height).map(line)
    });
    rays.map(|line| Expected { values: truth.values(&line, algorithm), line }).collect()
}

fn closest(deviations: impl Iterator<Item = Deviation>) -> Deviation {
    let better = |a: Deviation, b: Deviation| if b.ratio() < a.ratio() { b } else { a };
    deviations.reduce(better).unwrap_or(Deviation::NONE)
}

/// What a layer that was not asked for holds is 0.
fn values_at(images: &Images<f64>, view: usize, pixel: usize) -> Values {
    let pixels = images.size[0] * images.size[1];
    let at = |layer: &[f64], plane: usize| layer.get(plane * pixels + pixel).copied().unwrap_or(0.0);
    let density = |m: usize| {
        if m < images.materials { at(&images.areal_density, view * images.materials + m) } else { 0.0 }
    };
    Values {
        areal_density: std::array::from_fn::<_, MAX_MATERIALS, _>(density),
        bone_path: at(&images.bone_path, view),
        line_integral: at(&images.line_integral, view),
        intensity: at(&images.intensity, view),
    }
}

fn same_bytes(a: &Images<f64>, b: &Images<f64>) -> bool {
    let bits = |images: &Images<f64>| -> Vec<u64> {
        let layers = [&images.intensity, &images.line_integral, &images.areal_density, &images.bone_path];
        layers.into_iter().flatten().map(|x| x.to_bits()).collect()
    };
    bits(a) == bits(b)
}

/// A ray that meets nothing: not a bit more or less than I0, which a float32 engine rounds.
fn vacuum(backend: Backend, i0: f64, images: &Images<f64>) -> Deviation {
    let i0 = if backend == Backend::Reference { i0 } else { f64::from(i0 as f32) };
    let off = |layer, values: &[f64], exact: f64| {
        let each = values.iter().map(|x| Deviation { layer, error: (x - exact).abs(), bound: 0.0 });
        each.fold(Deviation::NONE, Deviation::or_worse)
    };
    off("intensity", &images.intensity, i0)
        .or_worse(off("line integral", &images.line_integral, 0.0))
        .or_worse(off("areal density", &images.areal_density, 0.0))
        .or_worse(off("bone path", &images.bone_path, 0.0))
}

fn refused(argument: &str, attempt: drr::Result<()>) -> (Deviation, Option<String>) {
    match attempt {
        Err(Error::InvalidArgument { argument: named, .. }) if named.starts_with(argument) => {
            (Deviation { layer: "refusal", ..Deviation::NONE }, None)
        }
        Err(error) => (Deviation::NOT_SEEN, Some(format!("names another argument: {error}"))),
        Ok(()) => (Deviation::NOT_SEEN, Some("was accepted".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const I0: f64 = 0.1;

    /// Two pixels of one material: I0, and nothing on the way.
    fn nothing(i0: f64) -> Images<f64> {
        Images {
            size: [2, 1],
            views: 1,
            materials: 1,
            detector_layers: 1,
            intensity: vec![i0; 2],
            line_integral: vec![0.0; 2],
            areal_density: vec![0.0; 2],
            bone_path: vec![0.0; 2],
        }
    }

    #[test]
    fn one_pixel_that_is_not_vacuum_is_seen() {
        let single = I0 as f32;
        for (backend, exact, beside) in [
            (Backend::Cpu, f64::from(single), [single.next_down(), single.next_up()].map(f64::from)),
            (Backend::Reference, I0, [I0.next_down(), I0.next_up()]),
        ] {
            let used = |images: &Images<f64>| vacuum(backend, I0, images).ratio();
            assert_eq!(used(&nothing(exact)), 0.0);
            for pixel in 0..2 {
                for layer in 0..4 {
                    let mut images = nothing(exact);
                    let Images { intensity, line_integral, areal_density, bone_path, .. } = &mut images;
                    [intensity, line_integral, areal_density, bone_path][layer][pixel] = f64::NAN;
                    assert!(used(&images) > 1.0);
                }
                for i0 in beside {
                    let mut images = nothing(exact);
                    images.intensity[pixel] = i0;
                    assert!(used(&images) > 1.0, "{i0:e}");
                }
            }
        }
    }

    #[test]
    fn a_refusal_must_name_the_argument_and_not_only_mention_it() {
        let used = |error| refused("spectrum", Err(error)).0.ratio();
        assert_eq!(used(Error::invalid("spectrum[7]", -1, "at least 0")), 0.0);
        assert!(used(Error::invalid("energies", 3, "as many as spectrum has")) > 1.0);
        assert!(used(Error::invalid("energies", "spectrum", "numbers")) > 1.0);
        assert!(used(Error::Unsupported("spectrum".into())) > 1.0);
        assert!(refused("spectrum", Ok(())).0.ratio() > 1.0);
    }
}
