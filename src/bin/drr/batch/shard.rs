//! Parts of a table, for as many processes.

/// Every `count`th row, from `first` on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shard {
    first: usize,
    count: usize,
}

impl Shard {
    /// All of them.
    pub(crate) const WHOLE: Self = Self { first: 0, count: 1 };

    /// Its rows, of so many.
    pub(super) fn rows(self, rows: usize) -> impl ExactSizeIterator<Item = usize> {
        (self.first..rows.max(self.first)).step_by(self.count)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((shard, count)) if (1..=count).contains(&shard) => Ok(Self { first: shard - 1, count }),
            _ => Err("expected I/N, such as 1/2, with I from 1 to N".into()),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.first + 1, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_in_one_shard() {
        for count in 1..9 {
            let rows = |shard: usize| format!("{shard}/{count}").parse::<Shard>().unwrap().rows(7);
            let mut all: Vec<_> = (1..=count).flat_map(rows).collect();
            all.sort_unstable();
            assert_eq!(all, [0, 1, 2, 3, 4, 5, 6]);
            for shard in 1..=count {
                assert!(rows(shard).all(|row| row % count + 1 == shard));
            }
        }
        assert!(Shard::WHOLE.rows(3).eq(0..3));
    }

    #[test]
    fn others_are_refused() {
        for text in ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1.0/2", "1/99999999999999999999"]
        {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
