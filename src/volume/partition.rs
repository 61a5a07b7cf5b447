//! The best way to put numbers into groups that are each replaced by their mean.

use std::ops::Range;

use crate::allocation::filled;
use crate::error::Result;

/// A number and how often it occurs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub value: f64,
    pub weight: f64,
}

impl Point {
    /// The weighted mean; of one point, its value to the last bit.
    pub(super) fn mean(points: &[Self]) -> f64 {
        if let [point] = points {
            return point.value;
        }
        let weight: f64 = points.iter().map(|point| point.weight).sum();
        points.iter().map(|point| point.weight * point.value).sum::<f64>() / weight
    }
}

/// For every number of groups up to some, the partition of sorted points with the least squared error. By dynamic
/// programming (Fisher, JASA 53, 789, 1958); the last group starts no earlier where there are more points, which
/// divides the search (Wu, J Algorithms 12(4), 663, 1991).
pub(super) struct Partition {
    /// Points.
    points: usize,
    /// With 1, 2, … groups, the least squared error of all points.
    errors: Vec<f64>,
    /// With 1, 2, … groups of the first 1, 2, … points, where the last group starts.
    starts: Vec<u16>,
}

/// Sums over the first 0, 1, 2, … points; values are relative to the mean, against cancellation.
struct Sums(Vec<[f64; 3]>);

impl Sums {
    fn of(points: &[Point]) -> Self {
        let mean = Point::mean(points);
        let mut sums = [0.0; 3];
        let next = |point: &Point| {
            let value = point.value - mean;
            let terms = [1.0, value, value * value].map(|power| point.weight * power);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
            sums
        };
        Self(std::iter::once([0.0; 3]).chain(points.iter().map(next)).collect())
    }

    /// The squared error of one group, of the points `from` to one before `to`.
    fn error(&self, from: usize, to: usize) -> f64 {
        let [weight, sum, squares] = std::array::from_fn(|k| self.0[to][k] - self.0[from][k]);
        (squares - sum * sum / weight).max(0.0)
    }
}

/// One number of groups.
struct Row<'a> {
    sums: &'a Sums,
    /// Errors of the first 0, 1, 2, … points with one group less.
    fewer: &'a [f64],
    errors: &'a mut [f64],
    starts: &'a mut [u16],
}

impl Row<'_> {
    /// For the first `ends` points each, when the last group starts at one of `candidates`.
    fn fill(&mut self, ends: Range<usize>, candidates: Range<usize>) {
        if ends.is_empty() {
            return;
        }
        let end = ends.start.midpoint(ends.end);
        let (mut start, mut least) = (candidates.start, f64::INFINITY);
        for candidate in candidates.start..candidates.end.min(end) {
            let error = self.fewer[candidate] + self.sums.error(candidate, end);
            if error < least {
                (start, least) = (candidate, error);
            }
        }
        (self.errors[end], self.starts[end - 1]) = (least, start as u16);
        self.fill(ends.start..end, candidates.start..start + 1);
        self.fill(end + 1..ends.end, start..candidates.end);
    }
}

impl Partition {
    /// Of points in ascending order, at most 65536 of them, into at most `most` groups.
    pub(super) fn new(points: &[Point], most: usize) -> Result<Self> {
        let (n, most) = (points.len(), most.min(points.len()));
        let sums = Sums::of(points);
        let mut starts = filled(n * most, 0, "the search for densities")?;
        let mut fewer: Vec<f64> = (0..=n).map(|end| sums.error(0, end)).collect();
        let mut totals = vec![fewer[n]];
        for (groups, starts) in (1..=most).zip(starts.chunks_mut(n)).skip(1) {
            let mut errors = vec![0.0; n + 1];
            let mut row = Row { sums: &sums, fewer: &fewer, errors: &mut errors, starts };
            row.fill(groups..n + 1, groups - 1..n);
            totals.push(errors[n]);
            fewer = errors;
        }
        Ok(Self { points: n, errors: totals, starts })
    }

    /// Most groups.
    pub(super) fn most(&self) -> usize {
        self.errors.len()
    }

    /// The least squared error with this many groups.
    pub(super) fn error(&self, groups: usize) -> f64 {
        self.errors[groups - 1]
    }

    /// The groups, last one first.
    pub(super) fn runs(&self, groups: usize) -> impl Iterator<Item = Range<usize>> {
        let mut end = self.points;
        (0..groups).rev().map(move |row| {
            let start = usize::from(self.starts[row * self.points + end - 1]);
            let run = start..end;
            end = start;
            run
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squared_error(points: &[Point]) -> f64 {
        let mean = Point::mean(points);
        points.iter().map(|point| point.weight * (point.value - mean).powi(2)).sum()
    }

    /// The least squared error by trying everything.
    fn by_trial(points: &[Point], groups: usize) -> f64 {
        if groups == 1 {
            return squared_error(points);
        }
        let last_from =
            |start: usize| by_trial(&points[..start], groups - 1) + squared_error(&points[start..]);
        (groups - 1..points.len()).map(last_from).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn no_other_partition_is_better() {
        let point =
            |i: u32| Point { value: f64::from(i * i % 37 + 40 * i), weight: f64::from(1 + 7 * i % 11) };
        let points: Vec<_> = (0..12).map(point).collect();
        let partition = Partition::new(&points, 20).expect("memory");
        assert_eq!(partition.most(), 12);
        for groups in 1..=12 {
            let runs: Vec<_> = partition.runs(groups).collect();
            assert_eq!(runs.iter().rev().cloned().flatten().collect::<Vec<_>>(), (0..12).collect::<Vec<_>>());
            let error: f64 = runs.iter().map(|run| squared_error(&points[run.clone()])).sum();
            assert!((error - by_trial(&points, groups)).abs() < 1e-6, "{groups} groups: {error}");
            assert!((error - partition.error(groups)).abs() < 1e-6, "{groups} groups: {error}");
        }
    }
}
