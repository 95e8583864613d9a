//! `<layer>_variance`: what denoisers ask for, the square of the standard errors that are stored.

use super::frame::{Channel, Frame, Samples};

/// The layer that holds the variance of what `error` (`stderr`, `<layer>_stderr`) is the standard error of.
fn name(error: &str) -> Option<String> {
    match error {
        "stderr" => Some("hybrid_variance".to_owned()),
        error => error.strip_suffix("_stderr").map(|layer| format!("{layer}_variance")),
    }
}

/// Adds the variance of every layer whose standard error is there, (cd/m²)², R = G = B; of `hybrid` from `stderr`.
pub fn add(frame: &mut Frame) {
    remove(frame);
    let mut squares: Vec<Channel> = Vec::new();
    // The channels of an error are mostly one memory, and then so are those of its square.
    let mut last: Option<(&Samples, Samples)> = None;
    for channel in &frame.channels {
        let Some(name) = name(channel.layer()) else { continue };
        let data = match &last {
            Some((error, square)) if error.is_shared_with(&channel.data) => square.clone(),
            Some(_) | None => channel.data.iter().map(|sigma| sigma * sigma).collect(),
        };
        last = Some((&channel.data, data.clone()));
        squares.push(Channel { name: format!("{name}.{}", channel.component()), data });
    }
    frame.channels.extend(squares);
}

/// Takes the variances away. A light group may be called `x_variance`: its share has an error of its own, a variance none.
fn remove(frame: &mut Frame) {
    let has_error: Vec<String> =
        frame.layer_names().into_iter().filter_map(|l| l.strip_suffix("_stderr").map(str::to_owned)).collect();
    frame.channels.retain(|channel| {
        let layer = channel.layer();
        !layer.ends_with("_variance") || has_error.iter().any(|own| own == layer)
    });
}

/// After the errors have changed: the variances again, where there are any. One whose error is not there goes.
pub fn refresh(frame: &mut Frame) {
    if frame.channels.iter().any(|channel| channel.layer().ends_with("_variance")) {
        add(frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_the_errors() {
        let mut frame = Frame::new(1, 1);
        for (name, value) in [("R", 1.0), ("stderr.R", 3.0), ("direct_led_stderr.G", 0.5), ("direct_covariance.R", 7.0)]
        {
            frame.push(name, vec![value]);
        }
        refresh(&mut frame);
        assert_eq!(frame.channels.len(), 4, "nobody asked");
        add(&mut frame);
        let value = |frame: &Frame, name: &str| frame.get(name).map(|channel| channel.data[0]);
        assert_eq!(value(&frame, "hybrid_variance.R"), Some(9.0));
        assert_eq!(value(&frame, "direct_led_variance.G"), Some(0.25));
        assert_eq!(frame.channels.len(), 6);
        frame.channels.retain(|channel| channel.layer() != "direct_led_stderr");
        frame.channels[1].data[0] = 4.0;
        refresh(&mut frame);
        assert_eq!(value(&frame, "hybrid_variance.R"), Some(16.0));
        assert_eq!(value(&frame, "direct_led_variance.G"), None);
        frame.push("direct_my_variance.R", vec![5.0]);
        frame.push("direct_my_variance_stderr.R", vec![2.0]);
        add(&mut frame);
        assert_eq!(value(&frame, "direct_my_variance.R"), Some(5.0), "the light of a group of this name");
        assert_eq!(value(&frame, "direct_my_variance_variance.R"), Some(4.0));
    }
}
