//! Which densities stand for all of a volume's where there is room for few.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;
use crate::volume::Voxel;
use crate::volume::partition::{Partition, Point};

/// As many as a byte can tell apart.
const COUNT: usize = 256;

/// At most 256 densities with their labels, and which of them stands for each 16-bit code.
#[derive(Debug)]
pub(super) struct Levels {
    pub voxels: Vec<Voxel>,
    pub of_code: Vec<u8>,
}

/// Codes with one label, all of vacuum or none.
struct Class<'a> {
    label: u8,
    /// Their densities.
    points: Vec<Point>,
    /// The codes of each density.
    codes: Vec<&'a [usize]>,
}

impl<'a> Class<'a> {
    /// Of codes in order of their density.
    fn new(codes: &'a [usize], counts: &[u64], table: &[Voxel]) -> Self {
        let codes: Vec<_> = codes.chunk_by(|&a, &b| table[a].density == table[b].density).collect();
        let point = |codes: &&[usize]| Point {
            value: table[codes[0]].density,
            weight: codes.iter().map(|&code| counts[code] as f64).sum(),
        };
        Self { label: table[codes[0][0]].label, points: codes.iter().map(point).collect(), codes }
    }
}

impl Levels {
    /// Those with the least squared error of density, over all voxels; `counts` of them have each code. Labels are kept,
    /// vacuum stays vacuum, and a level is the mean density of its voxels, so that each label keeps its mass.
    pub(super) fn choose(counts: &[u64], table: &[Voxel]) -> Result<Self> {
        let mut codes: Vec<usize> = (0..table.len()).filter(|&code| counts[code] > 0).collect();
        let key = |code: usize| (table[code].label, table[code].density);
        codes.sort_by(|&a, &b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        let kind = |code: usize| (table[code].label, table[code].density == 0.0);
        let classes: Vec<_> = codes
            .chunk_by(|&a, &b| kind(a) == kind(b))
            .map(|codes| Class::new(codes, counts, table))
            .collect();
        let partitions: Vec<_> =
            classes.par_iter().map(|class| Partition::new(&class.points, COUNT)).collect::<Result<_>>()?;
        let mut levels = Self { voxels: Vec::new(), of_code: filled(table.len(), 0, "the codes' levels")? };
        for ((class, partition), share) in classes.iter().zip(&partitions).zip(shares(&partitions)) {
            for run in partition.runs(share) {
                let level = levels.voxels.len() as u8;
                class.codes[run.clone()].iter().copied().flatten().for_each(|&c| levels.of_code[c] = level);
                levels.voxels.push(Voxel { density: Point::mean(&class.points[run]), label: class.label });
            }
        }
        Ok(levels)
    }
}

/// How many levels each class gets: one by one they go where they save the most, which is best because each saves less
/// than the one before.
fn shares(partitions: &[Partition]) -> Vec<usize> {
    let mut shares = vec![1; partitions.len()];
    for _ in partitions.len()..COUNT {
        let saved = |&class: &usize| {
            let (partition, share): (&Partition, usize) = (&partitions[class], shares[class]);
            partition.error(share) - partition.error(share + 1)
        };
        let can_grow = (0..shares.len()).filter(|&class| shares[class] < partitions[class].most());
        let Some(next) = can_grow.max_by(|a, b| saved(a).total_cmp(&saved(b))) else { break };
        shares[next] += 1;
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One code per HU from −1000 on, four labels, as many voxels each as a smooth histogram with two peaks has.
    fn scan() -> (Vec<u64>, Vec<Voxel>) {
        let density = |hu: f64| (1.0 + hu / 1000.0).max(0.0);
        let label = |hu: f64| [-950.0, -300.0, 200.0].iter().filter(|&&above| hu > above).count() as u8;
        let peak = |hu: f64, at: f64, width: f64| (-((hu - at) / width).powi(2)).exp();
        let hu = |code: usize| code as f64 - 1024.0;
        let voxels = |hu: f64| (1e5 * (peak(hu, -800.0, 80.0) + 2.0 * peak(hu, 40.0, 60.0))) as u64 + 3;
        let within = |code: &usize| *code < 4000;
        let counts = (0..1 << 16).map(|code| if within(&code) { voxels(hu(code)) } else { 0 }).collect();
        let meaning = |code| Voxel { density: density(hu(code)), label: label(hu(code)) };
        let table = (0..1 << 16).map(|code| if within(&code) { meaning(code) } else { Voxel::default() });
        (counts, table.collect())
    }

    fn squared_error(counts: &[u64], table: &[Voxel], level: impl Fn(usize) -> f64) -> f64 {
        let error = |code: usize| counts[code] as f64 * (table[code].density - level(code)).powi(2);
        (0..table.len()).map(error).sum()
    }

    #[test]
    fn few_voxels_are_exact() {
        let (mut counts, table) = scan();
        counts.iter_mut().enumerate().for_each(|(code, count)| *count *= u64::from(code % 17 == 0));
        let levels = Levels::choose(&counts, &table).expect("memory");
        assert!(levels.voxels.len() > 200 && levels.voxels.len() <= COUNT);
        for code in (0..table.len()).filter(|&code| counts[code] > 0) {
            assert_eq!(levels.voxels[usize::from(levels.of_code[code])], table[code]);
        }
    }

    #[test]
    fn labels_vacuum_and_the_mass_of_each_label_are_kept() {
        let (counts, table) = scan();
        let levels = Levels::choose(&counts, &table).expect("memory");
        assert_eq!(levels.voxels.len(), COUNT);
        let mut masses = [[0.0; 2]; 4];
        for code in (0..table.len()).filter(|&code| counts[code] > 0) {
            let (exact, level) = (table[code], levels.voxels[usize::from(levels.of_code[code])]);
            assert_eq!(exact.label, level.label);
            assert_eq!(exact.density == 0.0, level.density == 0.0);
            for (mass, voxel) in masses[usize::from(exact.label)].iter_mut().zip([exact, level]) {
                *mass += counts[code] as f64 * voxel.density;
            }
        }
        for [exact, levels] in masses {
            assert!((levels / exact - 1.0).abs() < 1e-13, "{levels} for {exact}");
        }
    }

    #[test]
    fn the_error_is_below_that_of_equal_steps() {
        let (counts, table) = scan();
        let levels = Levels::choose(&counts, &table).expect("memory");
        let chosen =
            squared_error(&counts, &table, |code| levels.voxels[usize::from(levels.of_code[code])].density);
        let step = 2.976 / 256.0;
        let even = squared_error(&counts, &table, |code| ((table[code].density / step).floor() + 0.5) * step);
        assert!(chosen < 0.5 * even, "{chosen} for {even}");
    }
}
