//! JSON documents as they are printed and written: each says which program made it.

use serde_json::{Value, json};

/// A JSON document; it says which program made it (`eyebox`: its version). A list, which can't, becomes its `items`.
pub fn document(json: Value) -> String {
    let mut json = if json.is_object() { json } else { json!({ "items": json }) };
    if let Value::Object(object) = &mut json {
        object.entry("eyebox").or_insert_with(|| env!("CARGO_PKG_VERSION").into());
    }
    // A value with texts for keys always has a form.
    serde_json::to_string_pretty(&json).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_says_who_made_it() {
        for json in [json!({ "a": 1 }), json!([1]), json!(null)] {
            let said: Value = serde_json::from_str(&document(json)).expect("JSON");
            assert_eq!(said["eyebox"], env!("CARGO_PKG_VERSION"));
        }
        let said: Value = serde_json::from_str(&document(json!([1]))).expect("JSON");
        assert_eq!(said["items"], json!([1]));
    }
}
