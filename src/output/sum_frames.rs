//! Renderings of different lamps of one assembly, added up: light is linear.

use super::light_shares::{PLATE, Rendering, groups_of};
use super::mix::set_layer;
use crate::exr::WHITE_LUMINANCE;
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::aov;
use eyebox_film::colours::Colours;
use eyebox_film::finish::slides;
use eyebox_film::frame::{Frame, Meta};
use eyebox_film::layer::Layer;
use eyebox_film::names::STATED_ERROR;
use eyebox_film::variance;
use serde_json::Value;

/// Adds up frames that were rendered with different light groups on. Layers are summed, errors are independent, data
/// layers and the header are those of the first frame; the lists of groups and splits are joined, and so are the shares of
/// layers by the same light path expression. One that another frame does not have is left out.
///
/// Errors: frames that differ in size, colour space, eye or contrast; two with light of the same group in the same layer,
/// which would count it twice; frames whose shares are not complete.
pub fn join(frames: &[Frame]) -> Result<Frame> {
    let Some((first, rest)) = frames.split_first() else {
        return Err(Error::new(Where::Nowhere, "no frame to mix"));
    };
    let mut sum = first.clone();
    for (number, frame) in rest.iter().enumerate() {
        comparable(&sum, frame, number + 2)?;
        sum = add(sum, frame, number + 2)?;
    }
    if !rest.is_empty() {
        aov::refresh(&mut sum);
        variance::refresh(&mut sum);
        // Of several runs nobody has stated one.
        sum.meta.remove(STATED_ERROR);
    }
    Ok(sum)
}

/// Takes over the shares of layers by light path expression that part classes.
fn join_aovs(sum: &mut Frame, other: &Frame) {
    let theirs = aov::listed(other);
    for mut own in aov::listed(sum).into_iter().filter(|own| own.part.is_some()) {
        let key = format!("{}{}", aov::KEY, own.name);
        let same = theirs.iter().find(|its| its.part.is_some() && (&its.name, &its.lpe) == (&own.name, &own.lpe));
        let Some(its) = same else {
            let names: Vec<String> = own.layers().collect();
            sum.channels.retain(|channel| !names.iter().any(|name| name == channel.layer()));
            sum.meta.remove(&key);
            continue;
        };
        for share in &its.shares {
            let own_layers = aov::OF_SHARE.iter().map(|suffix| format!("{share}{suffix}"));
            let layers: Vec<String> = own_layers.chain(aov::layers_by_slide(share, &its.slides)).collect();
            let is_new = sum.rgb(share).is_none();
            let channels = other.channels.iter().filter(|c| is_new && layers.iter().any(|layer| layer == c.layer()));
            sum.channels.extend(channels.cloned());
            if !own.shares.contains(share) {
                own.shares.push(share.clone());
            }
        }
        let error = format!("{}_stderr", own.name);
        match (sum.rgb(&error), other.rgb(&error)) {
            (Some(a), Some(b)) => {
                let data = [0, 1, 2].map(|c| a[c].iter().zip(b[c]).map(|(a, b)| a.hypot(*b)).collect());
                set_layer(sum, &error, &data);
            }
            (_, _) => sum.channels.retain(|channel| channel.layer() != error),
        }
        sum.meta.insert(key, Meta::Text(serde_json::to_string(&own).unwrap_or_default()));
    }
}

fn comparable(first: &Frame, other: &Frame, number: usize) -> Result<()> {
    let differs = |what: &str, own: String, its: String| {
        Err(Error::new(Where::Nowhere, format!("frame {number} has {what} {its}"))
            .expected(format!("{own}, as the first")))
    };
    let size = |frame: &Frame| format!("{} × {}", frame.width, frame.height);
    if size(first) != size(other) {
        return differs("the size", size(first), size(other));
    }
    let [own, its] = [first, other].map(Colours::of);
    if own != its {
        return differs("the colour space", own.name(first), its.name(other));
    }
    for (key, what) in
        [(WHITE_LUMINANCE, "the white"), ("eye", "the eye"), ("contrast", "the contrast"), (slides::KEY, "the slides")]
    {
        // A frame without slide light says no contrast, and goes with any.
        let (Some(own), Some(its)) = (first.meta.get(key), other.meta.get(key)) else { continue };
        if own != its {
            let said = |meta: &Meta| match meta {
                Meta::Text(text) => text.clone(),
                Meta::Number(number) => number.to_string(),
                Meta::Integer(number) => number.to_string(),
            };
            return differs(what, said(own), said(its));
        }
    }
    Ok(())
}

fn add(mut sum: Frame, other: &Frame, number: usize) -> Result<Frame> {
    let second = Rendering::of(other)?;
    let first_names: Vec<String> = {
        let first = Rendering::of(&sum)?;
        first.shares.iter().filter(|share| super::mix::is_lit(share)).map(|share| share.name.clone()).collect()
    };
    let twice = second.shares.iter().find(|share| super::mix::is_lit(share) && first_names.contains(&share.name));
    if let Some(twice) = twice {
        return Err(Error::new(
            Where::Nowhere,
            format!("frame {number} has light in `{}`, as another has", twice.name),
        )
        .expected("frames of different light groups: the same light would count twice"));
    }
    let shares: Vec<&str> = second.shares.iter().map(|share| share.name.as_str()).collect();
    let of_share = |layer: &str| {
        shares.iter().any(|name| layer.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('_')))
    };
    for layer in other.layer_names() {
        let summed = Layer::SUM_ORDER.iter().any(|own| own.name() == layer) || layer.is_empty() || layer == "hybrid";
        let error = layer == "stderr" || Layer::SUM_ORDER.iter().any(|own| format!("{}_stderr", own.name()) == layer);
        let Some(picture) = other.rgb(layer) else { continue };
        if summed && let Some(own) = sum.rgb(layer) {
            let data = [0, 1, 2].map(|c| own[c].iter().zip(picture[c]).map(|(a, b)| a + b).collect());
            set_layer(&mut sum, layer, &data);
        } else if error && let Some(own) = sum.rgb(layer) {
            let data = [0, 1, 2].map(|c| own[c].iter().zip(picture[c]).map(|(a, b)| a.hypot(*b)).collect());
            set_layer(&mut sum, layer, &data);
        } else if summed || error || of_share(layer) || layer == PLATE {
            sum.channels.retain(|channel| layer.is_empty() || channel.layer() != layer);
            sum.channels.extend(other.channels.iter().filter(|channel| channel.layer() == layer).cloned());
        }
    }
    // The error of a picture of two is known only if both are.
    for error in ["stderr".to_owned()].into_iter().chain(Layer::SUM_ORDER.map(|own| format!("{}_stderr", own.name()))) {
        let layer = if error == "stderr" { "" } else { error.trim_end_matches("_stderr") };
        if other.rgb(&error).is_none() && other.rgb(layer).is_some() {
            sum.channels.retain(|channel| channel.layer() != error);
        }
    }
    join_aovs(&mut sum, other);
    let mut groups = groups_of(&sum)?;
    let others = groups_of(other)?;
    let new: Vec<String> = others.into_iter().filter(|group| !groups.contains(group)).collect();
    groups.extend(new);
    sum.meta.insert("groups".to_owned(), Meta::Text(serde_json::json!(groups).to_string()));
    let list = |frame: &Frame| -> Vec<Value> {
        frame.text("splits").and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default()
    };
    let splits: Vec<Value> = list(&sum).into_iter().chain(list(other)).collect();
    sum.meta.insert("splits".to_owned(), Meta::Text(Value::from(splits).to_string()));
    for key in ["contrast", slides::KEY] {
        if let Some(said) = other.meta.get(key) {
            sum.meta.entry(key.to_owned()).or_insert_with(|| said.clone());
        }
    }
    Ok(sum)
}
