//! Texts by name as a JSON object of ASCII, for places in files that hold one text.

use std::collections::BTreeMap;

use crate::error::{Error, Result};

/// A JSON object, sorted by name, whose characters beyond ASCII are escaped: they stand in texts alone.
///
/// # Errors
/// `InvalidArgument` for a name that is there twice.
pub(super) fn to_json(texts: &[(String, String)]) -> Result<String> {
    let by_name: BTreeMap<_, _> = texts.iter().map(|(name, value)| (name, value)).collect();
    if by_name.len() < texts.len() {
        let mut names: Vec<_> = texts.iter().map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        let twice = names.windows(2).find(|pair| pair[0] == pair[1]).map_or("", |pair| pair[0]);
        return Err(Error::invalid("description", twice, "names that differ"));
    }
    let json = serde_json::json!(by_name).to_string();
    let mut ascii = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            ascii.push(c);
        } else {
            for unit in c.encode_utf16(&mut [0; 2]) {
                ascii.extend(["\\u", &format!("{unit:04x}")]);
            }
        }
    }
    Ok(ascii)
}

/// The texts of such an object, in the order of their names.
pub(super) fn from_json(json: &str) -> serde_json::Result<Vec<(String, String)>> {
    Ok(serde_json::from_str::<BTreeMap<_, _>>(json)?.into_iter().collect())
}
