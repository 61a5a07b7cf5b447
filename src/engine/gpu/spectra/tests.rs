use super::*;
use crate::engine::{Layers, Progress, SILENT};
use crate::physics::Quadrature;

/// A chest's, g/cm². The last one as a float32 is more.
const LIMITS: [f64; 4] = [0.0, 8.0, 45.0, 12.3];

fn tables() -> (Scene, Arc<SpectralModel>, Quadrature, Few) {
    let scene = Scene::new([8, 8]).expect("valid");
    let model = Arc::new(scene.spectral_model().expect("valid"));
    let quadrature = Quadrature::new(&model, &LIMITS, 0.25, 1e-3).expect("there are few");
    let few = Few::of(&quadrature, &model);
    (scene, model, quadrature, few)
}

/// What the kernel reads at a table's places is the model.
fn holds(spectra: &Spectra, table: Table, model: &SpectralModel) {
    let (bins, padded) = (model.bins(), table.bins as usize);
    assert!(padded % TOGETHER == 0 && padded < bins + TOGETHER, "{padded} for {bins}");
    assert_eq!([table.first_weight % 4, table.first_attenuation % 4], [0, 0], "read by fours");
    let [weights, logarithms] =
        [0, padded].map(|offset| &spectra.weights[table.first_weight as usize + offset..][..padded]);
    let rounded: Vec<f32> = model.weights().iter().map(|&weight| weight as f32).collect();
    assert_eq!(weights[..bins], rounded);
    assert!(weights[bins..].iter().all(|&weight| weight == 0.0));
    assert!(logarithms[..bins].iter().zip(&rounded).all(|(log, weight)| (log - weight.ln()).abs() < 1e-5));
    assert_eq!(table.weight_sum, rounded.iter().map(|&weight| f64::from(weight)).sum::<f64>().into());
    for m in 0..model.materials() {
        let row = &spectra.attenuation[table.first_attenuation as usize + m * padded..][..padded];
        let coefficients: Vec<f32> = model.coefficients(m).iter().map(|&mu| mu as f32).collect();
        assert_eq!(row[..bins], coefficients);
        assert!(row[bins..].iter().all(|&mu| mu == coefficients[bins - 1]));
    }
}

#[test]
fn few_energies_lie_beside_all_of_them() {
    let (_, model, quadrature, few) = tables();
    let (mut spectra, mut beam) = (Spectra::default(), Beam::default());
    spectra.set(&model, &mut beam);
    spectra.set_few(&few, &mut beam);
    holds(&spectra, beam.all, &model);
    holds(&spectra, beam.few, &quadrature.model(&model));
    assert!(beam.few.bins < beam.all.bins);
    assert_eq!(beam.i0, model.i0() as f32);
    let least = [0, 1, 2, 3].map(|m| model.least_attenuation(m) as f32);
    assert_eq!(beam.least_attenuation[..4], least, "of all energies");
}

#[test]
fn views_share_the_tables_of_few_energies() {
    let (_, model, _, few) = tables();
    let (mut spectra, mut beams) = (Spectra::default(), [Beam::default(); 2]);
    let mut lengths = Vec::new();
    for beam in &mut beams {
        spectra.set(&model, beam);
        spectra.set_few(&few, beam);
        lengths.push([spectra.weights.len(), spectra.attenuation.len()]);
    }
    assert_eq!(beams[0], beams[1]);
    assert_eq!(lengths[0], lengths[1]);
}

#[test]
fn limits_are_rounded_down() {
    let (_, _, _, few) = tables();
    assert_eq!(few.up_to[..3], [0.0, 8.0, 45.0]);
    assert!(f64::from(LIMITS[3] as f32) > LIMITS[3], "the case that matters");
    assert!(f64::from(few.up_to[3]) < LIMITS[3] && f64::from(few.up_to[3].next_up()) > LIMITS[3]);
}

#[test]
fn nothing_stands_for_a_view_s_own_tables() {
    let (scene, model, _, few) = tables();
    // As a launch before may have left it.
    let mut spectra = Spectra::default();
    for own in [false, true] {
        let mut beam = Beam { few_up_to: few.up_to, ..Beam::default() };
        if own {
            spectra.make_room(&WholeTables::of(&scene).expect("valid"), &mut beam);
        } else {
            spectra.set(&model, &mut beam);
        }
        assert!(beam.few_up_to.iter().all(|&limit| limit < 0.0), "{:?}", beam.few_up_to);
    }
}

/// Two rows over nine energies, behind two materials and a third before the volume.
#[test]
fn rows_share_their_energies_and_follow_other_tables() {
    let rows = [vec![1.0; 9], (0..9).map(f64::from).collect::<Vec<_>>()];
    let coefficients = [0.5, 0.25, 8.0].map(|least| (0..9).map(|k| least + f64::from(8 - k)).collect());
    let (_, model, ..) = tables();
    let (mut spectra, mut beam) = (Spectra::default(), Beam::default());
    spectra.set(&model, &mut beam);
    let job = SignalsJob {
        views: &[],
        rows: &rows,
        coefficients: &coefficients,
        before: &[],
        open: false,
        layers: Layers::default(),
        progress: Progress::new(SILENT),
    };
    let channels = spectra.set_rows(&job, 2);
    holds(&spectra, beam.all, &model);
    assert_eq!([channels.first_weight % 4, channels.first_attenuation % 4, channels.bins], [0, 0, 16]);
    let weights = &spectra.weights[channels.first_weight as usize..];
    assert_eq!(weights.len(), 4 * 16, "rows, then their logarithms");
    for (r, row) in rows.iter().enumerate() {
        let total: f64 = row.iter().sum();
        let (linear, logarithm) = (&weights[16 * r..][..16], &weights[16 * (2 + r)..][..16]);
        for (k, weight) in row.iter().enumerate() {
            assert_eq!(linear[k], (weight / total) as f32);
            let expected = if *weight > 0.0 { (weight / total).ln() } else { NO_WEIGHT };
            assert_eq!(logarithm[k], expected as f32);
        }
        assert!(linear[9..].iter().all(|&weight| weight == 0.0));
        assert!(logarithm[9..].iter().all(|&weight| weight == NO_WEIGHT as f32));
        let rounded: f64 = linear.iter().map(|&weight| f64::from(weight)).sum();
        assert_eq!(channels.weight_sum[r], rounded.into());
    }
    let attenuation = &spectra.attenuation[channels.first_attenuation as usize..];
    assert_eq!([attenuation[0], attenuation[16 + 8], attenuation[32 + 15]], [8.5, 0.25, 8.0]);
    assert_eq!(channels.least_attenuation[..3], [0.5, 0.25, 0.0], "by label");
    assert_eq!(channels.least_attenuation[8..10], [8.0, 0.0], "before the volume");
}
