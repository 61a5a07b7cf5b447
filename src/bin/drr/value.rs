//! Values on the command line: sizes, triples, lengths; and numbers as people read them.

use drr::{FEW_ENERGIES_RANGE, MAX_DETECTOR, MAX_SUPERSAMPLING, STEP_RANGE};
use glam::DVec3;

fn numbers<T: std::str::FromStr, const N: usize>(text: &str, separator: char) -> Option<[T; N]> {
    let parts: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    parts?.try_into().ok()
}

/// `nx,ny,nz`.
pub(crate) fn dimensions(text: &str) -> Result<[usize; 3], String> {
    numbers(text, ',').ok_or_else(|| "expected nx,ny,nz: three whole numbers".into())
}

/// `x,y,z`.
pub(crate) fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Option<[f64; 3]> = numbers(text, ',');
    let finite = numbers.map(DVec3::from_array).filter(|v| v.is_finite());
    finite.ok_or_else(|| "expected x,y,z: three finite numbers, mm".into())
}

/// `sx,sy,sz`, all above 0.
pub(crate) fn spacing(text: &str) -> Result<DVec3, String> {
    let positive = vector(text).ok().filter(|v| v.min_element() > 0.0);
    positive.ok_or_else(|| "expected sx,sy,sz: three numbers above 0, mm".into())
}

/// Width x height, pixels.
pub(crate) fn size(text: &str) -> Result<[usize; 2], String> {
    match numbers(&text.to_lowercase(), 'x') {
        Some(size) if size.iter().all(|n| (1..=MAX_DETECTOR).contains(n)) => Ok(size),
        _ => Err(format!("expected WIDTHxHEIGHT, such as 720x720, each 1 to {MAX_DETECTOR}")),
    }
}

/// Voxels and pixels per side, and views, up to which something grows.
pub(crate) fn growth(text: &str) -> Result<[usize; 3], String> {
    match numbers(text, ',') {
        Some(most @ [8..=1024, 8..=4096, 1..=1024]) => Ok(most),
        _ => Err("expected VOXELS,PIXELS,VIEWS, such as 720,1440,32: 8 to 1024, 8 to 4096, 1 to 1024".into()),
    }
}

/// Rays per side of a pixel.
pub(crate) fn supersampling(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MAX_SUPERSAMPLING).contains(&n) => Ok(n),
        _ => Err(format!("expected 1 to {MAX_SUPERSAMPLING}")),
    }
}

/// A step of the march, voxels.
pub(crate) fn step(text: &str) -> Result<f64, String> {
    let [least, most] = STEP_RANGE;
    match text.parse() {
        Ok(step) if (least..=most).contains(&step) => Ok(step),
        _ => Err(format!("expected {least} to {most} voxels")),
    }
}

/// A bound of the error of few energies, HU.
pub(crate) fn few_energies(text: &str) -> Result<f64, String> {
    within(text, FEW_ENERGIES_RANGE)
}

/// An error that is allowed, HU.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    within(text, [f64::MIN_POSITIVE, 1000.0]).map_err(|_| "expected above 0, at most 1000 HU".into())
}

fn within(text: &str, [least, most]: [f64; 2]) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("expected {least:e} to {most} HU")),
    }
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a number above 0".into()),
    }
}

/// A number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("expected a finite number".into()),
    }
}

/// A large number with a prefix: 1.2 M.
pub(crate) fn prefixed(value: f64) -> String {
    let (scale, prefix) = match value {
        v if v >= 1e9 => (1e9, " G"),
        v if v >= 1e6 => (1e6, " M"),
        v if v >= 1e3 => (1e3, " k"),
        _ => (1.0, " "),
    };
    format!("{:.1}{prefix}", value / scale)
}

/// A duration in seconds or ms.
pub(crate) fn seconds(seconds: f64) -> String {
    match seconds {
        ..1e-4 => format!("{:.1} µs", 1e6 * seconds),
        ..1.0 => format!("{:.2} ms", 1e3 * seconds),
        _ => format!("{seconds:.3} s"),
    }
}
