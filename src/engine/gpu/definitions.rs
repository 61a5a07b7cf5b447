//! What of the kernel text is compiled: definitions that the plan, the volume and the job decide. What is off is not in
//! the kernel that runs.

use crate::engine::Layers;
use crate::engine::gpu::voxels::{Density, DeviceVoxels};
use crate::method::Algorithm;
use crate::plan::Plan;

/// Definitions by name. Equal definitions make equal kernels.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Definitions(Vec<(&'static str, u32)>);

impl Definitions {
    /// What the plan and the volume decide.
    pub(super) fn of(plan: &Plan, materials: usize, voxels: &DeviceVoxels) -> Self {
        let algorithm = match plan.method.algorithm {
            Algorithm::Joseph => 0,
            Algorithm::March { .. } => 1,
            Algorithm::Siddon => 2,
            Algorithm::DistanceDriven | Algorithm::Exact => unreachable!("the plan refuses it"),
        };
        let density = match voxels.density() {
            None | Some(Density::Line { .. }) => 0,
            Some(Density::Kink { .. }) => 1,
            Some(Density::Table(_)) => 2,
        };
        let mut all = vec![
            ("DRR_ALGORITHM", algorithm),
            ("DRR_LABELS", plan.materials.iter().fold(0, |labels, material| labels | 1 << material.label)),
            ("DRR_MATERIALS", materials as u32),
            ("DRR_SUPERSAMPLING", plan.supersampling as u32),
            ("DRR_VOXELS", voxels.layout() as u32),
            ("DRR_DENSITY", density),
        ];
        all.extend(voxels.one_label.then_some(("DRR_ONE_LABEL", 1)));
        Self(all)
    }

    /// And what a job decides: its layers, the label of bone if its path is wanted, whether any ray may stop early
    /// and whether any may be summed over few energies, and the driving axis of all rays.
    pub(super) fn for_job(
        &self,
        layers: Layers,
        bone: Option<u8>,
        (early_exit, few): (bool, bool),
        axis: Option<usize>,
    ) -> Self {
        let mut all = self.0.clone();
        let flags = [
            ("DRR_INTENSITY", layers.intensity),
            ("DRR_LINE_INTEGRAL", layers.line_integral),
            ("DRR_AREAL_DENSITY", layers.areal_density),
            ("DRR_EARLY_EXIT", early_exit),
            // Without a signal there is no sum.
            ("DRR_FEW_ENERGIES", few && (layers.intensity || layers.line_integral)),
        ];
        all.extend(flags.into_iter().filter(|(_, on)| *on).map(|(name, _)| (name, 1)));
        all.extend(bone.map(|label| ("DRR_BONE_PATH", u32::from(label))));
        all.extend(axis.map(|axis| ("DRR_AXIS", axis as u32)));
        Self(all)
    }

    /// And with sums by so many rows of weights instead of one, behind so many materials before the volume; `open`: and those
    /// of the open field.
    pub(super) fn with_signals(&self, rows: usize, before: usize, open: bool) -> Self {
        let mut all = self.0.clone();
        all.push(("DRR_SIGNALS", rows as u32));
        all.extend((before > 0).then_some(("DRR_BEFORE", before as u32)));
        all.extend(open.then_some(("DRR_OPEN", 1)));
        Self(all)
    }

    /// And with the specification's own loop.
    #[cfg(any(test, feature = "cuda", target_vendor = "apple"))]
    pub(crate) fn with_specification_loop(&self) -> Self {
        let mut all = self.0.clone();
        all.push(("DRR_SPECIFICATION_LOOP", 1));
        Self(all)
    }

    /// Names that are on, as 1.
    pub(crate) fn flags(flags: impl IntoIterator<Item = (&'static str, bool)>) -> Self {
        Self(flags.into_iter().filter(|(_, on)| *on).map(|(name, _)| (name, 1)).collect())
    }

    /// Names and values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&'static str, u32)> {
        self.0.iter().copied()
    }
}

#[cfg(test)]
impl Definitions {
    /// Specialisations that have, between them, every definition on and off, every algorithm with every kind of voxels,
    /// and every algorithm along every axis.
    pub(crate) fn covering() -> Vec<Self> {
        let plain = |algorithm: u32| Specialisation { algorithm, ..Specialisation::default() };
        let mut all = Vec::new();
        for algorithm in 0..3 {
            let plain = plain(algorithm);
            all.extend([0, 1, 2].map(|density| Specialisation { density, ..plain }));
            all.push(Specialisation { voxels: 1, ..plain });
            all.push(Specialisation { voxels: 1, one_label: true, ..plain });
            all.extend([0, 1, 2].map(|axis| Specialisation { axis: Some(axis), ..plain }));
            all.push(Specialisation { one_label: true, labels: 0b100, axis: Some(1), ..plain });
            all.push(Specialisation { labels: 0, ..plain });
            all.push(Specialisation { labels: 0xff, materials: 8, axis: Some(2), ..plain });
            all.push(Specialisation { supersampling: 2, ..plain });
            all.push(Specialisation { supersampling: 3, axis: Some(1), ..plain });
            let silent = Layers::default();
            for (layers, bone, early_exit) in [
                (Layers { intensity: true, ..silent }, None, true),
                (Layers { intensity: true, bone_path: true, ..silent }, Some(3), true),
                (Layers { intensity: true, ..silent }, None, false),
                (Layers { line_integral: true, ..silent }, None, false),
                (Layers { areal_density: true, ..silent }, None, false),
                (Layers { bone_path: true, ..silent }, Some(0), false),
                (Layers { bone_path: true, ..silent }, None, false),
            ] {
                all.push(Specialisation { layers, bone, early_exit, axis: Some(1), ..plain });
            }
            all.push(Specialisation { few: true, ..plain });
            let layers = Layers { intensity: true, ..silent };
            all.push(Specialisation { layers, early_exit: true, few: true, axis: Some(1), ..plain });
        }
        let mut all: Vec<_> = all.into_iter().map(Specialisation::definitions).collect();
        all.extend(Self::covering_signals());
        all.push(all[0].with_specification_loop());
        all
    }
}

#[cfg(test)]
impl Definitions {
    /// Signals alone and beside layers, of every number of rows and some numbers of materials.
    fn covering_signals() -> Vec<Self> {
        let silent = Layers::default();
        let both = Layers { areal_density: true, bone_path: true, ..silent };
        let mut all = Vec::new();
        for algorithm in 0..3 {
            let plain = Specialisation { algorithm, layers: silent, bone: None, ..Specialisation::default() };
            let beside = Specialisation { layers: both, bone: Some(3), axis: Some(1), ..plain };
            let full = Specialisation { labels: 0xff, materials: 8, axis: Some(0), ..plain };
            let one_label = Specialisation { voxels: 1, one_label: true, labels: 0b100, ..plain };
            all.extend([
                plain.definitions().with_signals(1, 0, false),
                plain.definitions().with_signals(2, 1, true),
                plain.definitions().with_signals(3, 2, false),
                one_label.definitions().with_signals(5, 3, true),
                beside.definitions().with_signals(4, 0, false),
                Specialisation { labels: 0, ..beside }.definitions().with_signals(6, 2, true),
                Specialisation { density: 1, ..full }.definitions().with_signals(7, 1, false),
                Specialisation { density: 2, ..full }.definitions().with_signals(8, 8, true),
            ]);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names that only sums by several rows define.
    const OF_SIGNALS: [&str; 3] = ["DRR_SIGNALS", "DRR_BEFORE", "DRR_OPEN"];

    /// With them off, the preprocessor leaves nothing of them in the text: their names begin every line that has to do with them.
    #[test]
    fn plain_kernels_have_nothing_of_signals() {
        let plain = Specialisation::default().definitions();
        assert!(plain.iter().all(|(name, _)| !OF_SIGNALS.contains(&name)), "{plain:?}");
        let even = plain.with_signals(2, 0, false);
        let names = |all: &Definitions| all.iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names(&even)[names(&plain).len()..], ["DRR_SIGNALS"]);
        assert_eq!(names(&plain.with_signals(2, 1, true))[names(&plain).len()..], OF_SIGNALS);
    }
}

/// What definitions say, field by field.
#[cfg(test)]
#[derive(Clone, Copy)]
struct Specialisation {
    algorithm: u32,
    labels: u32,
    materials: u32,
    supersampling: u32,
    voxels: u32,
    density: u32,
    one_label: bool,
    layers: Layers,
    bone: Option<u8>,
    early_exit: bool,
    few: bool,
    axis: Option<usize>,
}

#[cfg(test)]
impl Default for Specialisation {
    fn default() -> Self {
        Self {
            algorithm: 0,
            labels: 0b1111,
            materials: 4,
            supersampling: 1,
            voxels: 0,
            density: 0,
            one_label: false,
            layers: Layers::ALL,
            bone: Some(3),
            early_exit: false,
            few: false,
            axis: None,
        }
    }
}

#[cfg(test)]
impl Specialisation {
    fn definitions(self) -> Definitions {
        let mut all = vec![
            ("DRR_ALGORITHM", self.algorithm),
            ("DRR_LABELS", self.labels),
            ("DRR_MATERIALS", self.materials),
            ("DRR_SUPERSAMPLING", self.supersampling),
            ("DRR_VOXELS", self.voxels),
            ("DRR_DENSITY", self.density),
        ];
        all.extend(self.one_label.then_some(("DRR_ONE_LABEL", 1)));
        Definitions(all).for_job(self.layers, self.bone, (self.early_exit, self.few), self.axis)
    }
}
