//! The layers that an asset asks for (USD RenderVars), in terms of ours.

use super::picture::possible_layers;
use eyebox_film::cryptomatte::Matte;
use eyebox_film::frame::{Channel, Frame};
use eyebox_scene::assembly::RequestedLayer;
use eyebox_scene::{Group, Note};

/// One of our layers, and the name that it is written under.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Named {
    /// Empty: the default image.
    pub layer: String,
    pub name: String,
}

/// Other names that renderers give to what we have.
const SYNONYMS: [(&str, &str); 13] = [
    ("Ci", "hybrid"),
    ("beauty", "hybrid"),
    ("color", "hybrid"),
    ("rgba", "hybrid"),
    ("depth", "Z"),
    ("z", "Z"),
    ("N", "normal"),
    ("Nn", "normal"),
    ("Ng", "normal_geometric"),
    ("st", "uv"),
    ("A", "opacity"),
    ("P", "position"),
    ("diffuse_albedo", "albedo"),
];

/// What of `wishes` can be had, and a warning for each that cannot; light path expressions are `aov`'s.
pub fn granted(wishes: &[RequestedLayer], (groups, slides): (&[Group], &[String])) -> (Vec<Named>, Vec<Note>) {
    let possible = possible_layers(groups, slides);
    let (mut all, mut notes) = (Vec::<Named>::new(), Vec::new());
    for wish in wishes.iter().filter(|wish| !wish.expression) {
        let source: String = wish.source.chars().filter(|c| !c.is_whitespace()).collect();
        let other = SYNONYMS.iter().find(|(name, _)| *name == source).map(|(_, layer)| (*layer).to_owned());
        let own = possible.contains(&source).then_some(source);
        let Some(layer) = own.or(other) else {
            let text = format!("the render variable `{}` is no layer of ours: not written", wish.source);
            notes.push(Note::warning(wish.at.clone(), text));
            continue;
        };
        // A matte's name is in the header, too.
        let name = if Matte::of_layer(&layer).is_some() { layer.clone() } else { plain(&wish.name) };
        let named = Named { layer, name };
        if let Some(other) = all.iter().find(|other| other.name == named.name) {
            if other.layer != named.layer {
                let text = format!(
                    "`{}` and `{}` ask for the name `{}`: the first has it",
                    other.layer, named.layer, named.name
                );
                notes.push(Note::warning(wish.at.clone(), text));
            }
            continue;
        }
        all.push(named);
    }
    (all, notes)
}

/// A layer name that Nuke and Blender split alike: `[A-Za-z][A-Za-z0-9_]*`.
pub(super) fn plain(name: &str) -> String {
    let kept: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if kept.starts_with(|c: char| c.is_ascii_alphabetic()) { kept } else { format!("layer_{kept}") }
}

/// Keeps the layers of `named` under their names, and the default image. A layer without light is not there. Without any,
/// and where nothing `else_asked` for is written instead, all are kept.
pub fn rename(frame: &mut Frame, named: &[Named], else_asked: bool) {
    if named.is_empty() && !else_asked {
        return;
    }
    let all = std::mem::take(&mut frame.channels);
    for wish in named {
        if let Some(matte) = Matte::of_layer(&wish.layer) {
            frame.channels.extend(all.iter().filter(|c| Matte::of_layer(c.layer()) == Some(matte)).cloned());
            continue;
        }
        // A lone channel such as `Z` has no layer before its dot.
        let own = |channel: &&Channel| channel.layer() == wish.layer || channel.name == wish.layer;
        for channel in all.iter().filter(own) {
            let name = format!("{}.{}", wish.name, channel.component());
            frame.channels.push(Channel { name, data: channel.data.clone() });
        }
    }
    frame.channels.extend(all.into_iter().filter(|channel| ["R", "G", "B"].contains(&channel.name.as_str())));
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::Where;

    fn wish(source: &str, expression: bool, name: &str) -> RequestedLayer {
        RequestedLayer { source: source.into(), expression, name: name.into(), at: Where::Nowhere }
    }

    #[test]
    fn wishes_become_layers_under_their_names() {
        let groups = [Group { name: "led".into() }];
        let wishes = [
            wish("direct", false, "vision"),
            wish("Ci", false, "1 beauty"),
            wish("caustic", false, "caustics"),
            wish("caustic_led", false, "caustics"),
            wish("C<RD>L", true, "other"),
            wish("CryptoRole", false, "roles"),
            wish("forward_sun", false, "x"),
            wish("depth", false, "far"),
        ];
        let (named, notes) = granted(&wishes, (&groups, &[]));
        let pairs: Vec<_> = named.iter().map(|n| (n.layer.as_str(), n.name.as_str())).collect();
        assert_eq!(
            pairs,
            [
                ("direct", "vision"),
                ("hybrid", "layer_1_beauty"),
                ("caustic", "caustics"),
                ("CryptoRole", "CryptoRole"),
                ("Z", "far")
            ]
        );
        assert_eq!(notes.len(), 2);
        let mut frame = Frame::new(1, 1);
        for name in ["R", "direct.R", "hybrid.R", "caustic_led.R", "CryptoRole01.r", "Z"] {
            frame.push(name, vec![0.0]);
        }
        rename(&mut frame, &named, false);
        let names: Vec<_> = frame.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["vision.R", "layer_1_beauty.R", "CryptoRole01.r", "far.Z", "R"]);
    }
}
