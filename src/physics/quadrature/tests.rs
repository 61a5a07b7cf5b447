use super::*;
use crate::physics::{EnergyGrid, MassAttenuation, Spectrum};
use std::time::Instant;

#[test]
fn scratch() {
    let spectrum = Spectrum::named(Spectrum::DEFAULT, EnergyGrid::SPECIFICATION).unwrap();
    let attenuation =
        MassAttenuation::named(&MassAttenuation::SPECIFICATION, EnergyGrid::SPECIFICATION).unwrap();
    let model = SpectralModel::new(&spectrum, &attenuation).unwrap();
    let limits = [0.1, 8.0, 45.0, 12.0];
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let start = Instant::now();
        let choice = Choice::new(&model, &limits, 0.25, tolerance);
        let setup = start.elapsed();
        let found = choice.nodes();
        println!(
            "{tolerance}: setup {setup:?} choice {:?} counts {:?}",
            start.elapsed(),
            found.iter().map(|f| f.0.len()).collect::<Vec<_>>()
        );
        for (bins, weights) in found.iter().rev().take(3) {
            let start = Instant::now();
            let bound = Bound::new(&model, (bins, weights), 0.25, tolerance).over(&limits);
            println!("   {} nodes bound {bound:?} {:?}", bins.len(), start.elapsed());
        }
        let start = Instant::now();
        let q = Quadrature::new(&model, &limits, 0.25, tolerance);
        println!("   total {:?} {:?}", start.elapsed(), q.map(|q| (q.nodes.len(), q.bound)));
    }
}
