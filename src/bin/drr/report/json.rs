//! What serialises, as lists and tables.

use serde_json::{Map, Value};

use super::html::Html;

/// Columns that come first in tables; the others follow by name.
const FIRST: [&str; 4] = ["name", "what", "reason", "setting"];

/// Everything that a value states.
pub(super) fn shown(value: &Value) -> Html {
    match value {
        Value::Object(object) => Html::list(object.iter().map(|(name, value)| (spoken(name), shown(value)))),
        Value::Array(rows) if !rows.is_empty() && rows.iter().all(Value::is_object) => table(rows),
        Value::Array(values) => {
            let comma = |(n, value)| [Html::text(if n == 0 { "" } else { ", " }), shown(value)];
            values.iter().enumerate().flat_map(comma).collect()
        }
        Value::String(text) => Html::text(text),
        Value::Null => Html::text("none"),
        Value::Bool(_) | Value::Number(_) => Html::text(value),
    }
}

fn table(rows: &[Value]) -> Html {
    let objects: Vec<&Map<String, Value>> = rows.iter().filter_map(Value::as_object).collect();
    let mut columns: Vec<&str> = objects.iter().flat_map(|row| row.keys()).map(String::as_str).collect();
    let place = |column: &str| FIRST.iter().position(|first| *first == column).unwrap_or(FIRST.len());
    columns.sort_by_key(|column| (place(column), *column));
    columns.dedup();
    let heads: Vec<String> = columns.iter().map(|column| spoken(column)).collect();
    let cells = |row: &Map<String, Value>| {
        columns.iter().map(|column| row.get(*column).map(shown).unwrap_or_default()).collect()
    };
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    Html::table(&heads, objects.into_iter().map(cells))
}

fn spoken(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_value_is_shown() {
        let value = json!({
            "method": {"algorithm": "siddon", "few_energies": null},
            "detector": [720, 719],
            "stages": [{"what": "march", "name": "ray", "cost": 1.5}, {"name": "signal", "extra": true}],
            "none": [],
        });
        let html = format!("{:?}", shown(&value));
        for text in ["siddon", "720", "719", "march", "ray", "1.5", "signal", "true", "few energies"] {
            assert!(html.contains(text), "{text}: {html}");
        }
        let head = |name| html.find(&format!(">{name}</th>")).expect(name);
        assert!(head("name") < head("what") && head("what") < head("cost") && head("cost") < head("extra"));
    }
}
