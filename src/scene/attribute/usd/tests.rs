//! Attributes → USD → attributes, bit by bit; what USD can't mean is refused.

use super::layout::known;
use super::*;
use crate::attribute::{Form, ROWS, arbitrary};
use crate::value::{Data, Value};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Whether both say the same to the last bit (0 and −0 differ).
fn identical(a: &Value, b: &Value) -> bool {
    match (&a.data, &b.data) {
        (Data::Number(a), Data::Number(b)) => a.to_bits() == b.to_bits(),
        (Data::List(a), Data::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| identical(a, b)),
        (Data::Table(a), Data::Table(other)) => {
            a.len() == other.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| identical(a, b)))
        }
        (a, b) => a == b,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 700, ..ProptestConfig::default() })]

    #[test]
    fn every_value_survives(value in arbitrary::prim()) {
        let properties = flatten(&value).unwrap();
        let names: BTreeSet<&str> = properties.iter().map(|property| property.name.as_str()).collect();
        prop_assert_eq!(names.len(), properties.len(), "a name twice");
        let back = gather(&properties).unwrap().unwrap();
        prop_assert!(identical(&value, &back), "{value}\n{back}\n{properties:?}");
    }

    #[test]
    fn properties_are_those_of_the_schema(value in arbitrary::prim()) {
        let all: Vec<Property> = Noun::ALL.into_iter().flat_map(super::properties).collect();
        for property in flatten(&value).unwrap() {
            let name = layout::bare(property.name.strip_prefix("eyebox:").unwrap());
            match all.iter().find(|known| known.name == name) {
                Some(known) => {
                    prop_assert_eq!(known.ty, property.value.ty(), "{}", name);
                    if let (false, UsdValue::Token(token)) = (known.tokens.is_empty(), &property.value) {
                        prop_assert!(known.tokens.contains(&token.as_str()), "{name} {token}");
                    }
                }
                None => prop_assert!(matches!(name, "faces" | "normal"), "{}", property.name),
            }
        }
    }

    #[test]
    fn one_changed_letter_is_no_property(value in arbitrary::prim(), which in any::<prop::sample::Index>()) {
        let mut properties = flatten(&value).unwrap();
        let chosen = which.index(properties.len());
        properties[chosen].name.push('x');
        let fault = gather(&properties).unwrap_err().to_string();
        prop_assert!(fault.contains("unknown property") || fault.contains("means nothing here"), "{}", fault);
    }
}

#[test]
fn every_row_has_a_place_in_usd() {
    let all: Vec<Property> = Noun::ALL.into_iter().flat_map(super::properties).collect();
    for row in ROWS {
        // The sidecar's own head; a table has no property of its own.
        let elsewhere = row.noun == Noun::Asset && ["schema", "asset"].contains(&row.name);
        let spread = matches!(row.form, Form::Record(_) | Form::Records(_));
        let found = all.iter().any(|property| property.row == row);
        assert_eq!(found, !elsewhere && !spread, "{} {}", row.noun, row.name);
    }
    let names = known();
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "a name twice");
    // Columns fit the USD types.
    for row in ROWS {
        if let Form::Rows(columns) = row.form {
            assert!(matches!(columns.len(), 2 | 3), "{}", row.name);
        }
        if let Form::NumberOrRows(columns) = row.form {
            assert_eq!(columns.len(), 2, "{}", row.name);
        }
        if let Form::Records(fields) = row.form {
            for field in fields.iter().filter_map(|name| super::row(row.noun, name)) {
                // What stands for "unsaid" can't be said.
                assert!(field.form != Form::Number || !field.range.holds(unsaid(field)), "{}", field.name);
            }
        }
    }
}

fn property(name: &str, value: UsdValue) -> UsdProperty {
    UsdProperty { name: name.to_owned(), value, at: Where::Nowhere }
}

fn token(name: &str, text: &str) -> UsdProperty {
    property(name, UsdValue::Token(text.to_owned()))
}

fn said(properties: &[UsdProperty]) -> String {
    match gather(properties) {
        Ok(value) => value.map_or_else(String::new, |value| value.to_string()),
        Err(fault) => fault.to_string(),
    }
}

#[test]
fn readable_properties() {
    let double = |name: &str, x: f64| property(name, UsdValue::Double(x));
    assert_eq!(said(&[]), "");
    assert_eq!(said(&[double("eyebox:medium:ior", 1.49)]), "{ ior = 1.49 }");
    assert_eq!(said(&[property("eyebox:medium:ior", UsdValue::Int(2))]), "{ ior = 2 }");
    assert_eq!(
        said(&[token("eyebox:finish", "gauss"), double("eyebox:finish:sigma_deg", 6.0)]),
        "{ finish = { kind = \"gauss\", sigma_deg = 6 } }"
    );
    assert_eq!(
        said(&[
            token("eyebox:coating", "stack"),
            property("eyebox:coating:stack:thickness_nm", UsdValue::Doubles(vec![99.6, 50.0])),
            property("eyebox:coating:stack:n", UsdValue::Doubles(vec![1.38, -1.0])),
            property("eyebox:coating:stack:material", UsdValue::Tokens(vec![String::new(), "SiO2".into()])),
        ]),
        "{ coating = { kind = \"stack\", stack = [{ n = 1.38, thickness_nm = 99.6 }, { material = \"SiO2\", thickness_nm = 50 }] } }"
    );
    let instances = [
        property("eyebox:face:f10:faces", UsdValue::Ints(vec![4])),
        token("eyebox:face:f10:finish", "none"),
        token("eyebox:face:top:normal", "+z"),
        double("eyebox:face:top:emitter:flux_lm", 0.45),
        token("eyebox:face:f2:normal", "-z"),
        token("eyebox:face:f2:finish", "polished"),
    ];
    assert_eq!(
        said(&instances),
        "{ faces = [{ normal = \"-z\", finish = \"polished\" }, { faces = [4], finish = \"none\" }, \
         { normal = \"+z\", emitter = { flux_lm = 0.45 } }] }"
    );
}

#[test]
fn what_usd_cannot_mean_is_refused() {
    let double = |name: &str, x: f64| property(name, UsdValue::Double(x));
    assert_eq!(
        said(&[double("eyebox:medium:iro", 1.49)]),
        "unknown property `eyebox:medium:iro`; did you mean `eyebox:medium:ior`?"
    );
    assert_eq!(
        said(&[double("eyebox:face:a:emitter:flux_lum", 1.0)]),
        "unknown property `eyebox:face:a:emitter:flux_lum`; did you mean `eyebox:face:a:emitter:flux_lm`?"
    );
    assert_eq!(said(&[token("eyebox:medium:ior", "1.49")]), "`eyebox:medium:ior` is of type token; expected double");
    assert_eq!(
        said(&[token("eyebox:finish", "polished"), double("eyebox:finish:alpha", 0.1)]),
        "`eyebox:finish:alpha` means nothing here; expected a parameter of finish = \"polished\""
    );
    assert_eq!(
        said(&[double("eyebox:finish:alpha", 0.1)]),
        "`eyebox:finish:alpha` means nothing here; expected `eyebox:finish` beside it, of a kind that takes it"
    );
    assert_eq!(
        said(&[
            token("eyebox:coating", "stack"),
            property("eyebox:coating:stack:n", UsdValue::Doubles(vec![1.38])),
            property("eyebox:coating:stack:thickness_nm", UsdValue::Doubles(vec![99.6, 50.0])),
        ]),
        "`eyebox:coating:stack:n` has 1 entries and `eyebox:coating:stack:thickness_nm` has 2; expected arrays of one \
         length, an entry for each"
    );
    let table = |key: &str, data: Data| {
        Value::new(Data::Table(vec![(key.to_owned(), Value::new(data, Where::Nowhere))]), Where::Nowhere)
    };
    let refused = |value: &Value| flatten(value).unwrap_err().to_string();
    assert_eq!(
        refused(&table("coating", Data::Number(0.0))),
        "coating 0 is an index, and USD has no list of coatings; expected what it refers to, or a name"
    );
    assert!(refused(&table("finnish", Data::Number(0.0))).ends_with("did you mean `finish`?"));
    assert!(refused(&table("ior", Data::Text("x".into()))).starts_with("`ior` is a text"));
}
