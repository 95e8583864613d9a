//! The specification of the glTF extension, in the form of Khronos' vendor extensions.

use super::face::{FACE, faces, holder, list, medium};
use eyebox_scene::attribute::{Form, Noun, Range, Row, Support, kinds, rows};

const HEAD: &str = r#"# EYEBOX\_optics

This page and the schemas beside it are generated from the attribute table in `src/scene/attribute/rows.rs`. Do not edit
them; run `EYEBOX_BLESS=1 cargo verify --test all schemas` after changing a row.

## Contributors

The authors of eyebox.

## Status

Vendor extension, version 1.

## Dependencies

Written against the glTF 2.0 specification. Independent of other extensions; where a material also has
`KHR_materials_ior`, `KHR_materials_dispersion`, `KHR_materials_volume` or `KHR_materials_emissive_strength`, what this
extension says wins.

## Overview

Optical properties of the parts of an assembly, as a designer of optics states them: the glass of a lens, the films of a
coating, the exact surface that a mesh approximates, the luminous flux of a lamp. They are measured quantities, for
calculations in absolute units. Programs that draw the asset lose nothing by ignoring them, so the extension is never
listed in `extensionsRequired`.

A part is a node with a mesh. Each primitive of its mesh is one face of the part. A medium fills a closed part; what else
there is belongs to faces.

Geometric lengths (in *mesh units* below) are in the units of the mesh and scale with the node and with `unit`. Optical
lengths (those with a unit in their name, and the columns of tables) and lengths given as text with a unit (`"4 mm"`) are
physical and never scale. JSON has no infinity: where it is allowed it is the text `"inf"`. Directions are in the axes of
the part.

## Extending the root

The object `EYEBOX_optics` in the `extensions` of the asset's root is required wherever the extension is used.

"#;

const BINDING: &str = r#"## Binding

Media, coatings, emitters and slides may stand in the root's lists, and are then referred to by their index or by their
`name`; or in place, as a table.

What holds for a face is what the nearest of these says, attribute by attribute: its primitive; an entry of `faces` of its
node; its node; an entry of `faces` of a node further up, that node, and so on; its material; `default`. A medium is
said by nodes, materials and `default` only. Where solids overlap or touch, the greater `priority` wins.

Two values of one attribute at the same place, an index or a name that leads nowhere, an unknown attribute, a number out
of its range: the asset is in error.

## Versions

`version` counts incompatible changes. A program must refuse an asset with a greater version than it knows.

## Example

```json
{
  "extensionsUsed": ["EYEBOX_optics"],
  "extensions": {
    "EYEBOX_optics": {
      "version": 1,
      "unit": 0.001,
      "wavelengths": { "mono_nm": 550 },
      "default": { "finish": "absorber" },
      "coatings": [{ "name": "ar", "stack": [{ "n": 1.38, "thickness_nm": 99.638 }] }]
    }
  },
  "nodes": [
    {
      "name": "LENS",
      "mesh": 0,
      "extensions": {
        "EYEBOX_optics": {
          "glass": "N-BK7",
          "faces": [{
            "faces": [0, 2],
            "finish": "polished",
            "coating": 0,
            "shape": { "kind": "fit", "tolerance_um": 0.05 }
          }]
        }
      }
    },
    {
      "name": "LED",
      "mesh": 1,
      "extensions": {
        "EYEBOX_optics": { "faces": [{ "normal": "+z", "emitter": { "group": "led", "flux_lm": 0.45 } }] }
      }
    }
  ]
}
```

## JSON Schema

- [glTF.EYEBOX_optics.schema.json](schema/glTF.EYEBOX_optics.schema.json)
- [node.EYEBOX_optics.schema.json](schema/node.EYEBOX_optics.schema.json)
- [mesh.primitive.EYEBOX_optics.schema.json](schema/mesh.primitive.EYEBOX_optics.schema.json)
- [material.EYEBOX_optics.schema.json](schema/material.EYEBOX_optics.schema.json)
"#;

pub fn text() -> String {
    let mut out = HEAD.to_owned();
    out += HEADER;
    out += "| `version` | integer |  | **Required.** 1 |\n";
    rows(Noun::Asset).filter(|row| ["unit", "wavelengths"].contains(&row.name)).for_each(|row| out += &line(row));
    out += "| `default` | object |  | attributes of media and faces that hold where nothing else says anything |\n";
    for noun in [Noun::Medium, Noun::Coating, Noun::Emitter, Noun::Slide] {
        if let Some(list) = list(noun) {
            out += &format!("| `{list}` | array of {noun} |  | what `{noun}` refers to |\n");
        }
    }
    out += "| `sky` | sky |  | light from everywhere |\n| `sun` | sun |  | light from one direction |\n| `eye` | eye |  | who looks |\n";
    out += "\n## Extending nodes\n\nWhat a node says holds for itself and for all parts below it.\n\n";
    out += HEADER;
    medium().chain(faces()).for_each(|row| out += &line(row));
    out += "| `faces` | array of objects |  | attributes for some faces only: each object selects them with `faces` (numbers of \
        primitives) or `normal` (`\"+z\"`: the faces that look along this axis of the part, within 1°), and has any of \
        the attributes of faces |\n";
    let names = |nouns: &[Noun]| {
        let all: Vec<String> = nouns.iter().filter_map(|n| holder(*n)).map(|row| format!("`{}`", row.name)).collect();
        all.join(", ")
    };
    out += &format!("\n## Extending mesh primitives\n\nAttributes of faces: {}.\n", names(&FACE));
    out += &format!("\n## Extending materials\n\n{}.\n", names(&[Noun::Finish, Noun::Coating]));
    out += "\n## Attributes\n\nA kind is its name (`\"polished\"`), or an object with `kind` and the parameters (`{ \"kind\": \"gauss\", \
        \"sigma_deg\": 6 }`), or with the parameters under the kind's name (`{ \"gauss\": { \"sigma_deg\": 6 } }`), or with the \
        parameter alone if it has the kind's name.\n";
    for noun in Noun::ALL {
        out += &format!("\n### {noun}\n\n");
        out += HEADER;
        let shown = |row: &&Row| noun != Noun::Asset || !["schema", "version", "asset"].contains(&row.name);
        rows(noun).filter(shown).for_each(|row| out += &line(row));
        for row in rows(noun).filter(|row| row.form == Form::Kind) {
            out += &format!("\nKinds of `{}`:\n\n| kind | parameters | meaning |\n|---|---|---|\n", row.name);
            for kind in kinds(row.name) {
                let parameters: Vec<String> = kind.parameters.iter().map(|name| format!("`{name}`")).collect();
                out += &format!("| `{}` | {} | {} |\n", kind.name, parameters.join(", "), cell(kind.doc));
            }
        }
    }
    out.push('\n');
    out + BINDING
}

const HEADER: &str = "| property | value | default | meaning |\n|---|---|---|---|\n";

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;").replace('*', "\\*")
}

fn line(row: &Row) -> String {
    let range = if row.range == Range::Any { String::new() } else { format!(", each {}", row.range) };
    let value = match row.form {
        Form::Number => format!("number{}", range.replacen("each a number", "", 1).replacen(",  ", ", ", 1)),
        Form::Integer => "integer".to_owned(),
        Form::Text | Form::Word(_) => "string".to_owned(),
        Form::File => "string, a URI".to_owned(),
        Form::Length => "string, a length with its unit".to_owned(),
        Form::LengthOr(words) => format!("string, a length with its unit, or {}", words.join(", ")),
        Form::Numbers(count) => format!("array of {count} numbers{range}"),
        Form::Integers(count) => format!("array of {count} integers{range}"),
        Form::Place => "array of 3 lengths with units".to_owned(),
        Form::Coefficients { least, most } => format!("array of {least} to {most} numbers{range}"),
        Form::Rows(columns) => format!("array of [{}]{range}", columns.join(", ")),
        Form::NumberOrRows(columns) => format!("number, or array of [{}]{range}", columns.join(", ")),
        Form::Record(fields) => format!("object with {}", fields.join(", ")),
        Form::Records(fields) => format!("array of objects with {}", fields.join(", ")),
        Form::Thing(_) => "index, name or object".to_owned(),
        Form::Kind if list(row.noun).is_some() && row.name == row.noun.to_string() => "index, name or kind".to_owned(),
        Form::Kind => "kind".to_owned(),
    };
    let unit = if row.unit.is_empty() { String::new() } else { format!(", {}", row.unit) };
    let state = match row.support {
        Support::Rendered => "",
        Support::Kept => " (kept; changes no picture yet)",
        Support::NotYet => " (reserved: not implemented yet)",
    };
    format!(
        "| `{}` | {}{unit} | {} | {}{state} |\n",
        row.name,
        cell(&value),
        cell(row.default.unwrap_or("")),
        cell(row.doc)
    )
}
