//! One row of voxels of a phantom.

use glam::DVec3;

use super::coverage::Coverage;
use super::sweep::Sweep;
use super::thorax::noise;
use super::voxelise::Lattice;
use super::{BACKGROUND_HU, BACKGROUND_MATERIAL, Part, Phantom};

/// Lines per side of a voxel for shares without a closed form: 16² exact chords a voxel.
const LINES: u32 = 16;

/// What is known of a voxel while parts are painted over it.
#[derive(Debug, Clone, Copy, Default)]
struct Layers {
    /// The last part that covers the voxel wholly.
    base: Option<usize>,
    /// The last part that covers some of it, later than `base`.
    top: Option<usize>,
    /// The share of `top`, where it is the only such part and has a closed form.
    share: Option<f64>,
}

/// One row of voxels, and the buffers to fill it.
pub(super) struct Row<'a> {
    parts: &'a [Part],
    lattice: &'a Lattice,
    /// Indices j, k.
    at: [usize; 2],
    /// Parts that may meet the row, in painter's order.
    present: Vec<usize>,
    layers: Vec<Layers>,
    /// Parts of one voxel and their shares of it.
    shares: Vec<(usize, f64)>,
    sweep: Sweep,
}

impl<'a> Row<'a> {
    pub(super) fn new(phantom: &'a Phantom, lattice: &'a Lattice) -> Self {
        Self {
            parts: phantom.parts(),
            lattice,
            at: [0; 2],
            present: Vec::new(),
            layers: Vec::new(),
            shares: Vec::new(),
            sweep: Sweep::default(),
        }
    }

    pub(super) fn select(&mut self, present: &[usize], at: [usize; 2]) {
        self.at = at;
        self.present.clear();
        self.present
            .extend(present.iter().copied().filter(|&n| self.lattice.meets(1, at[0], &self.parts[n])));
    }

    fn centre(&self, i: usize) -> DVec3 {
        self.lattice.centre([i, self.at[0], self.at[1]])
    }

    pub(super) fn paint_centres(&self, hu: &mut [i16], labels: &mut [u8]) {
        for &index in &self.present {
            let part = &self.parts[index];
            for i in self.lattice.columns(part) {
                if part.shape.contains(self.centre(i)) {
                    hu[i] = part.hu;
                    labels[i] = part.material;
                }
            }
        }
    }

    pub(super) fn paint_shares(&mut self, hu: &mut [i16], labels: &mut [u8]) {
        self.layers.clear();
        self.layers.resize(hu.len(), Layers::default());
        for &index in &self.present {
            let part = &self.parts[index];
            for i in self.lattice.columns(part) {
                let centre = self.centre(i);
                let layers = &mut self.layers[i];
                match Coverage::of(&part.shape, centre - self.lattice.half, centre + self.lattice.half) {
                    Coverage::Outside => {}
                    Coverage::Inside => {
                        *layers = Layers { base: Some(index), ..Layers::default() };
                    }
                    Coverage::Share(share) => {
                        layers.share = layers.top.is_none().then_some(share);
                        layers.top = Some(index);
                    }
                    Coverage::Straddling => {
                        layers.share = None;
                        layers.top = Some(index);
                    }
                }
            }
        }
        for i in 0..hu.len() {
            match self.layers[i] {
                Layers { base: None, top: None, .. } => {}
                Layers { base: Some(base), top: None, .. } => {
                    hu[i] = self.parts[base].hu;
                    labels[i] = self.parts[base].material;
                }
                Layers { base, top: Some(top), share } => {
                    self.shares.clear();
                    match share {
                        Some(share) => {
                            self.shares.push((top, share));
                            self.shares.extend(base.map(|base| (base, 1.0 - share)));
                        }
                        None => self.measure_shares(i, base, top),
                    }
                    hu[i] = mean_hu(self.parts, &self.shares);
                    labels[i] = label(self.parts, &self.shares);
                }
            }
        }
    }

    /// Fills `shares` from chords of a voxel along the axis that is most nearly normal to the top part's surface.
    fn measure_shares(&mut self, i: usize, base: Option<usize>, top: usize) {
        let centre = self.centre(i);
        let half = self.lattice.half;
        let meets = |&&index: &&usize| {
            let [low, high] = self.parts[index].shape.bounds();
            low.cmple(centre + half).all() && high.cmpge(centre - half).all()
        };
        let from = base.unwrap_or(0);
        self.shares.extend(self.present.iter().filter(|&&n| n >= from).filter(meets).map(|&n| (n, 0.0)));

        let along = self.parts[top].shape.normal_axis(centre);
        let (u, v) = (DVec3::AXES[(along + 1) % 3] * half, DVec3::AXES[(along + 2) % 3] * half);
        let weight = 1.0 / (2.0 * half[along] * f64::from(LINES * LINES));
        let offset = |n: u32| f64::from(2 * n + 1) / f64::from(LINES) - 1.0;
        for line in 0..LINES * LINES {
            let origin = centre + offset(line % LINES) * u + offset(line / LINES) * v;
            let parts = self.shares.iter().map(|&(index, _)| index);
            let spans = self.sweep.run(
                parts.map(|index| (index, &self.parts[index])),
                origin,
                DVec3::AXES[along],
                [-half[along], half[along]],
            );
            for span in spans {
                if let Some((_, share)) = self.shares.iter_mut().find(|(index, _)| *index == span.part) {
                    *share += weight * span.visible;
                }
            }
        }
    }

    pub(super) fn add_noise(&self, [width, height, _]: [usize; 3], hu: &mut [i16]) {
        let Some(&body) = self.present.first().filter(|&&index| index == 0) else { return };
        let start = (self.at[1] * height + self.at[0]) * width;
        for i in self.lattice.columns(&self.parts[body]) {
            if self.parts[body].shape.contains(self.centre(i)) {
                hu[i] = hu[i].saturating_add(noise((start + i) as u32));
            }
        }
    }
}

/// The mean over the voxel, rounded half to even; what no part covers is background.
fn mean_hu(parts: &[Part], shares: &[(usize, f64)]) -> i16 {
    let background = f64::from(BACKGROUND_HU);
    let above: f64 = shares.iter().map(|&(n, share)| share * (f64::from(parts[n].hu) - background)).sum();
    (background + above).round_ties_even() as i16
}

/// The material other than air with the largest share; air if there is none.
fn label(parts: &[Part], shares: &[(usize, f64)]) -> u8 {
    let total = |material: u8| -> f64 {
        shares.iter().filter(|(n, _)| parts[*n].material == material).map(|(_, share)| share).sum()
    };
    let solid = shares.iter().filter(|&&(n, share)| parts[n].material != 0 && share > 0.0);
    solid
        .map(|&(n, _)| (parts[n].material, total(parts[n].material)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(BACKGROUND_MATERIAL, |(material, _)| material)
}
