//! CT numbers to materials.

use std::sync::LazyLock;

use crate::error::{Error, Result};
use crate::physics::attenuation::check_material_count;
use crate::physics::tables::{number, records, unknown};

static SCHEMES: LazyLock<Vec<Thresholds>> = LazyLock::new(|| {
    let mut schemes: Vec<Thresholds> = Vec::new();
    for row in records(include_str!("tables/hu_material_thresholds.csv")).skip(1) {
        match schemes.last_mut().filter(|scheme| scheme.name == row[0]) {
            Some(scheme) => {
                scheme.materials.push(row[1].into());
                scheme.edges.push(number(row[2]));
            }
            None => schemes.push(Thresholds {
                name: row[0].into(),
                materials: vec![row[1].into()],
                edges: Vec::new(),
            }),
        }
    }
    schemes
});

/// Classes of CT numbers: class i holds edge i−1 ≤ HU < edge i, the first and the last class are open-ended.
///
/// | name | materials and edges in HU |
/// |---|---|
/// | `four_class_mcgpu_like` | air −950 lung −200 soft tissue 200 cortical bone |
/// | `deepdrr_thresholds` | air −799 soft tissue 351 cortical bone |
/// | `schneider2000_merged` | air −950 lung −120 adipose −53 soft tissue 120 cortical bone |
/// | `six_class` | air −950 lung −200 adipose −20 soft tissue 200 cortical bone 2995 titanium |
///
/// 200 HU calls contrast-enhanced blood bone; 351 HU does not, and calls spongy bone soft tissue.
#[derive(Debug, Clone, PartialEq)]
pub struct Thresholds {
    name: String,
    materials: Vec<String>,
    edges: Vec<f64>,
}

impl Thresholds {
    /// Name of the default scheme: the four materials of the specification.
    pub const DEFAULT: &'static str = "four_class_mcgpu_like";

    /// A scheme of one's own: `edges` in HU, strictly ascending, one fewer than the materials.
    ///
    /// # Errors
    /// `InvalidArgument` unless there are 1 … [`MAX_MATERIALS`](super::MAX_MATERIALS) materials and their edges are
    /// finite and ascending (the first that is not is named).
    pub fn new(name: impl Into<String>, materials: Vec<String>, edges: Vec<f64>) -> Result<Self> {
        check_material_count("thresholds.materials", materials.len())?;
        if edges.len() + 1 != materials.len() {
            let valid = format!("{}, one fewer than the materials", materials.len() - 1);
            return Err(Error::invalid("thresholds.edges", format!("{} edges", edges.len()), valid));
        }
        let mut previous = f64::NEG_INFINITY;
        for (i, &edge) in edges.iter().enumerate() {
            if !(edge.is_finite() && edge > previous) {
                let argument = format!("thresholds.edges[{i}]");
                return Err(Error::invalid(argument, edge, format!("finite, above {previous} HU")));
            }
            previous = edge;
        }
        Ok(Self { name: name.into(), materials, edges })
    }

    /// A built-in scheme.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name.
    pub fn named(name: &str) -> Result<Self> {
        let scheme = SCHEMES.iter().find(|scheme| scheme.name == name);
        scheme.cloned().ok_or_else(|| unknown("thresholds", name, &Self::names()))
    }

    /// Names of the built-in schemes.
    pub fn names() -> Vec<&'static str> {
        SCHEMES.iter().map(|scheme| scheme.name.as_str()).collect()
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The materials; the index of one is its class.
    pub fn materials(&self) -> &[String] {
        &self.materials
    }

    /// The edges between the classes, HU, ascending.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// The class of a CT number: an index into `materials()`. NaN, which no volume may hold, is of the first class.
    pub fn class(&self, hu: f64) -> u8 {
        self.edges.partition_point(|&edge| hu >= edge) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{MAX_MATERIALS, MassAttenuation};

    #[test]
    fn edges_belong_to_the_class_above() {
        let scheme = Thresholds::named(Thresholds::DEFAULT).unwrap();
        for (hu, class) in [
            (-32768.0, 0),
            (-2048.0, 0),
            (-950.000_001, 0),
            (-950.0, 1),
            (-200.5, 1),
            (-200.0, 2),
            (0.0, 2),
            (199.999, 2),
            (200.0, 3),
            (32767.0, 3),
            (f64::INFINITY, 3),
            (f64::NAN, 0),
        ] {
            assert_eq!(scheme.class(hu), class, "{hu} HU");
        }
    }

    #[test]
    fn the_default_has_the_materials_of_the_specification() {
        let scheme = Thresholds::named(Thresholds::DEFAULT).unwrap();
        assert_eq!(scheme.materials(), MassAttenuation::SPECIFICATION);
    }

    #[test]
    fn schemes_disagree_where_they_should() {
        // Contrast-enhanced blood at 300 HU, fat at -80 HU, a titanium screw.
        for (hu, classes) in [
            (300.0, ["bone_cortical", "soft_tissue", "bone_cortical", "bone_cortical"]),
            (-80.0, ["soft_tissue", "soft_tissue", "adipose", "adipose"]),
            (3071.0, ["bone_cortical", "bone_cortical", "bone_cortical", "titanium"]),
        ] {
            for (name, expected) in Thresholds::names().into_iter().zip(classes) {
                let scheme = Thresholds::named(name).unwrap();
                assert_eq!(scheme.materials()[usize::from(scheme.class(hu))], expected, "{name} at {hu} HU");
            }
        }
    }

    #[test]
    fn the_table_has_no_gaps_and_only_known_materials() {
        let mut previous: Option<(&str, i64)> = None;
        for row in records(include_str!("tables/hu_material_thresholds.csv")).skip(1) {
            let [first, end] = [2, 3].map(|column| number::<i64>(row[column]));
            let begins =
                previous.filter(|(scheme, _)| *scheme == row[0]).map_or(i64::from(i32::MIN), |p| p.1);
            assert_eq!(first, begins, "{row:?}");
            previous = Some((row[0], end));
        }
        for name in Thresholds::names() {
            let scheme = Thresholds::named(name).unwrap();
            assert!(scheme.materials().len() <= MAX_MATERIALS);
            let known = |m: &String| MassAttenuation::material_names().contains(&m.as_str());
            assert!(scheme.materials().iter().all(known), "{name}");
            let again = Thresholds::new(name, scheme.materials().to_vec(), scheme.edges().to_vec());
            assert_eq!(again, Ok(scheme));
        }
    }

    #[test]
    fn refusals_name_the_edge() {
        let materials = |n: usize| vec!["water".to_string(); n];
        assert_eq!(Thresholds::new("one", materials(1), vec![]).unwrap().class(1e9), 0);
        for (count, edges, part) in [
            (0, vec![], "1 … 8"),
            (9, vec![0.0; 8], "1 … 8"),
            (3, vec![0.0], "1 edges"),
            (3, vec![10.0, 10.0], "thresholds.edges[1] is 10; valid: finite, above 10 HU"),
            (3, vec![10.0, -10.0], "thresholds.edges[1] is -10"),
            (2, vec![f64::NAN], "thresholds.edges[0] is NaN"),
            (2, vec![f64::INFINITY], "thresholds.edges[0] is inf"),
        ] {
            let message = Thresholds::new("own", materials(count), edges).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        let message = Thresholds::named("four_class").unwrap_err().to_string();
        assert!(message.contains("deepdrr_thresholds"), "{message}");
    }
}
