//! The readers of tables over the photon energy: any text is finite numbers on a grid, or an error.

use drr::formats::{Table, read_detector, read_materials, read_spectrum};

use crate::file;

/// Whether the file is any of the tables.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let path = file::with_content("table.csv", bytes);
    let tables = [read_spectrum, read_detector, read_materials].map(|read| read(&path).ok());
    tables.iter().flatten().for_each(check_table);
    tables.iter().any(Option::is_some)
}

fn check_table(Table { energies, columns }: &Table) {
    assert!(energies.energies().all(|energy| energy.is_finite() && energy > 0.0), "{energies}");
    assert!(!columns.is_empty());
    for column in columns {
        assert_eq!(column.values.len(), energies.count(), "{}", column.name);
        assert!(column.values.iter().all(|&v| v.is_finite() && v >= 0.0), "{column:?}");
    }
}
