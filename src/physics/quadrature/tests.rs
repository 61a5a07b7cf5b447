use super::*;
use crate::physics::{DetectorResponse, EnergyGrid, MassAttenuation, Spectrum};

const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;
const BODY: [f64; 4] = [0.1, 8.0, 45.0, 12.0];

/// Evenly spread numbers in 0 … 1 (the high bits of Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A path in the box, on faces and near 0 as often as elsewhere.
    fn path(&mut self, limits: &[f64]) -> Vec<f64> {
        let scale = self.next().powi(3);
        let scale = if self.next() < 0.3 { scale } else { 1.0 };
        let mut part = || match self.next() {
            face if face < 0.2 => 0.0,
            face if face < 0.3 => 1.0,
            _ => self.next().powi(2),
        };
        limits.iter().map(|limit| limit * scale * part()).collect()
    }
}

fn model_of(spectrum: &Spectrum, materials: &[&str]) -> SpectralModel {
    let attenuation = MassAttenuation::named(materials, *spectrum.grid()).unwrap();
    SpectralModel::new(spectrum, &attenuation).unwrap()
}

fn model(spectrum: &str, detector: &str, materials: &[&str]) -> SpectralModel {
    let detector = DetectorResponse::named(detector, GRID).unwrap();
    model_of(&Spectrum::named(spectrum, GRID).unwrap().folded(&detector).unwrap(), materials)
}

fn body() -> SpectralModel {
    model(Spectrum::DEFAULT, "ideal", &MassAttenuation::SPECIFICATION)
}

/// The largest `|Δp| / max(p, floor)` on many paths.
fn largest_error(exact: &SpectralModel, reduced: &SpectralModel, limits: &[f64], floor: f64) -> f64 {
    let mut random = Random(7);
    let error = |path: Vec<f64>| {
        let p = exact.line_integral(&path);
        (reduced.line_integral(&path) - p).abs() / p.max(floor)
    };
    (0..3000).map(|_| error(random.path(limits))).fold(0.0, f64::max)
}

fn assert_bounded(exact: &SpectralModel, limits: &[f64], floor: f64, tolerance: f64, case: &str) {
    let quadrature = Quadrature::new(exact, limits, floor, tolerance);
    let quadrature = quadrature.unwrap_or_else(|| panic!("{case}, {tolerance}: none"));
    let error = largest_error(exact, &quadrature.model(exact), limits, floor);
    let bound = quadrature.bound();
    // 1e-12: the rounding of both line integrals.
    assert!(error <= bound + 1e-12 && bound <= tolerance, "{case}, {tolerance}: {error} above {bound}");
    assert!(bound <= 30.0 * error, "{case}, {tolerance}: {bound} is far above {error}");
    let weights = || quadrature.nodes().iter().map(|node| node.weight);
    assert!(weights().all(|weight| weight > 0.0), "{case}, {tolerance}");
    assert!((weights().sum::<f64>() - 1.0).abs() < 1e-14, "{case}, {tolerance}");
    assert!(quadrature.nodes().is_sorted_by(|a, b| a.kev < b.kev), "{case}, {tolerance}");
}

/// Lead around its K edge (88.0 keV), roughly, on any energies.
fn lead(grid: EnergyGrid) -> Vec<f64> {
    grid.energies().map(|kev| if kev < 88.0 { 1.8 } else { 7.4 } * (88.0 / kev).powf(2.7)).collect()
}

#[test]
fn errors_stay_below_the_bound_for_every_tolerance() {
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        assert_bounded(&body(), &BODY, 0.25, tolerance, "body");
    }
    assert_bounded(&body(), &BODY, 0.01, 1e-4, "low floor");
}

#[test]
fn errors_stay_below_the_bound_for_tubes_and_detectors() {
    for spectrum in ["W60_2p5Al", "W80_2p5Al", "W120_2p5Al_0p1Cu", "W120_CT_3Al_0p9Ti"] {
        for detector in ["bottom_energy", "top_counting"] {
            let model = model(spectrum, detector, &MassAttenuation::SPECIFICATION);
            assert_bounded(&model, &BODY, 0.25, 1e-4, &format!("{spectrum}, {detector}"));
        }
    }
}

#[test]
fn errors_stay_below_the_bound_for_other_materials() {
    for (materials, limits) in [
        (vec!["water"], vec![60.0]),
        (vec!["tungsten"], vec![3.0]),
        (vec!["soft_tissue", "tungsten"], vec![30.0, 2.0]),
        (vec!["water", "iodine", "titanium"], vec![30.0, 0.3, 2.0]),
        (
            vec!["air", "lung", "soft_tissue", "bone_cortical", "titanium", "steel_316l"],
            vec![0.1, 5.0, 30.0, 6.0, 2.0, 1.0],
        ),
        (
            vec![
                "air",
                "lung",
                "adipose",
                "muscle",
                "bone_cortical",
                "iodine10_water",
                "aluminium",
                "tungsten",
            ],
            vec![0.1, 4.0, 10.0, 20.0, 6.0, 2.0, 0.5, 0.05],
        ),
    ] {
        let model = model(Spectrum::DEFAULT, "ideal", &materials);
        assert_bounded(&model, &limits, 0.25, 1e-3, &format!("{materials:?}"));
    }
}

#[test]
fn errors_stay_below_the_bound_behind_lead() {
    let water = MassAttenuation::named(&["water"], GRID).unwrap().coefficients(0).to_vec();
    let table = MassAttenuation::new(GRID, vec!["lead".into(), "water".into()], [lead(GRID), water].concat())
        .unwrap();
    let model = SpectralModel::new(&Spectrum::named(Spectrum::DEFAULT, GRID).unwrap(), &table).unwrap();
    assert_bounded(&model, &[3.0, 30.0], 0.25, 1e-4, "lead and water");
}

#[test]
fn thousands_of_energies_are_reduced_as_well() {
    let grid = EnergyGrid::new(20.0, 0.025, 4001).unwrap();
    let weights = grid.energies().map(|kev| (kev - 19.0) * (121.0 - kev)).collect();
    let table = MassAttenuation::new(grid, vec!["lead".into()], lead(grid)).unwrap();
    let model = SpectralModel::new(&Spectrum::new("parabola", grid, weights).unwrap(), &table).unwrap();
    assert_bounded(&model, &[2.0], 0.25, 1e-3, "fine grid");
}

#[test]
fn five_digits_take_a_tenth_of_the_energies() {
    let model = body();
    let count = |tolerance: f64| Quadrature::new(&model, &BODY, 0.25, tolerance).unwrap().nodes().len();
    assert!((5..=12).contains(&count(1e-5)), "{} nodes", count(1e-5));
    assert!(count(1e-5) > count(1e-3) && count(1e-3) > count(0.05));
}

#[test]
fn an_empty_path_is_exact() {
    for detector in DetectorResponse::names() {
        let model = model(Spectrum::DEFAULT, detector, &MassAttenuation::SPECIFICATION);
        let reduced = Quadrature::new(&model, &BODY, 0.25, 1e-4).unwrap().model(&model);
        assert_eq!(reduced.intensity(&[0.0; 4]), model.i0());
        assert_eq!(reduced.line_integral(&[0.0; 4]), 0.0);
    }
}

#[test]
fn the_reduced_model_has_the_energies_and_materials_of_its_nodes() {
    let model = body();
    let quadrature = Quadrature::new(&model, &BODY, 0.25, 1e-4).unwrap();
    let reduced = quadrature.model(&model);
    for (k, node) in quadrature.nodes().iter().enumerate() {
        assert_eq!((reduced.energies()[k], reduced.weights()[k]), (node.kev, node.weight));
        let table =
            MassAttenuation::named(&["bone_cortical"], EnergyGrid::single(node.kev).unwrap()).unwrap();
        assert_eq!(reduced.coefficients(3)[k], table.coefficients(0)[0]);
    }
    for m in 0..4 {
        // Of all bins: the hardest, 120 keV, need not be a node.
        assert_eq!(reduced.least_attenuation(m), model.least_attenuation(m));
    }
}

/// The bound is not a property of how nodes are chosen.
#[test]
fn bad_quadratures_are_not_certified() {
    let model = body();
    let quadrature = Quadrature::new(&model, &BODY, 0.25, 1e-4).unwrap();
    let alloy = Alloy::new(&model, &BODY);
    let bins: Vec<usize> = quadrature.nodes().iter().map(|node| node.bin).collect();
    for (from, part) in [(0, 0.5), (1, 1e-3), (2, 1e-2), (3, 0.9), (4, 1e-4), (5, 0.1)] {
        let mut weights: Vec<f64> = quadrature.nodes().iter().map(|node| node.weight).collect();
        let moved = part * weights[from];
        weights[from] -= moved;
        weights[from + 1] += moved;
        let error = largest_error(&model, &model.of_bins(&bins, weights.clone()), &BODY, 0.25);
        let bound = |tolerance| Bound::new(&alloy, (&bins, &weights), 0.25, tolerance).over_all();
        assert_eq!(bound(0.98 * error), None, "{from}, {part}");
        let bound =
            bound(2.0 * error).unwrap_or_else(|| panic!("{from}, {part}: none at twice the error {error}"));
        assert!(bound >= error, "{from}, {part}: {bound} below {error}");
    }
}

#[test]
fn the_bound_holds_up_to_the_limits() {
    let quadrature = Quadrature::new(&body(), &[0.1, 0.0, 45.0, 12.0], 0.25, 1e-3).unwrap();
    assert!(quadrature.holds(&[0.0; 4]) && quadrature.holds(&[0.1, 0.0, 45.0, 12.0]));
    for m in 0..4 {
        let mut path = [0.1, 0.0, 45.0, 12.0];
        path[m] += 1e-9;
        assert!(!quadrature.holds(&path), "material {m}");
        path[m] = f64::NAN;
        assert!(!quadrature.holds(&path), "material {m}");
    }
    assert!(!quadrature.holds(&[0.0; 3]));
}

#[test]
fn one_energy_is_not_reduced_and_two_hardly() {
    let mono = model_of(&Spectrum::monoenergetic(60.0).unwrap(), &["water"]);
    assert_eq!(Quadrature::new(&mono, &[40.0], 0.25, 1e-3), None);
    let grid = EnergyGrid::new(40.0, 60.0, 2).unwrap();
    let two = model_of(&Spectrum::new("two", grid, vec![1.0, 1.0]).unwrap(), &["water"]);
    assert_eq!(Quadrature::new(&two, &[40.0], 0.25, 1e-3), None);
    assert_eq!(Quadrature::new(&two, &[40.0], 0.25, 0.8).unwrap().nodes().len(), 1);
}

#[test]
fn an_empty_box_needs_one_energy() {
    assert_eq!(Quadrature::new(&body(), &[0.0; 4], 0.25, 1e-5).unwrap().nodes().len(), 1);
}

#[test]
fn what_makes_no_sense_has_no_quadrature() {
    let model = body();
    let none = |limits: &[f64], floor, tolerance| {
        assert_eq!(
            Quadrature::new(&model, limits, floor, tolerance),
            None,
            "{limits:?}, {floor}, {tolerance}"
        );
    };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        none(&BODY, bad, 1e-3);
        none(&BODY, 0.25, bad);
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1e308] {
        none(&[0.1, 8.0, bad, 12.0], 0.25, 1e-3);
    }
    none(&BODY[..3], 0.25, 1e-3);
    none(&BODY, 0.25, 1e-15);
    none(&BODY, 1e-300, 1e-3);
    none(&[1e300; 4], 0.25, 1e-3);
    // Out of the way, but neither a panic nor for ever.
    for (scale, floor, tolerance) in
        [(1e5, 0.25, 1e-4), (1e-9, 1e-9, 1e-3), (1.0, 1e-6, 1e-4), (1.0, 1e9, 1e-3), (1.0, 1.0, 1e9)]
    {
        if let Some(quadrature) = Quadrature::new(&model, &BODY.map(|limit| scale * limit), floor, tolerance)
        {
            assert!(quadrature.bound() <= tolerance);
        }
    }
}
