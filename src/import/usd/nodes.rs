//! Nodes of MaterialX' standard library that textured assets use, each as the arithmetic that it is. Source: the MaterialX
//! Specification 1.39, Standard Nodes.

use super::fold::{Folded, Lanes};
use super::network::{Node, lane, lanes, number, text};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;

impl Node<'_> {
    pub fn lanes_of(&mut self, kind: &str, output: &str) -> Result<Option<Folded>> {
        if kind.starts_with("combine") {
            let count = kind.chars().last().and_then(|digit| digit.to_digit(10)).unwrap_or(2) as usize;
            // color3 and a number, or two vectors: only the first lane of each is looked at.
            if self.id.contains("CF") || self.id.contains("VF") || self.id.contains("VV") {
                let first = self.input("in1", 0.0)?;
                return Ok(self.alone("in1", first));
            }
            let parts = ["in1", "in2", "in3", "in4"].iter().take(count);
            let parts = parts.map(|name| self.input(name, 0.0)).collect::<Result<Vec<_>>>()?;
            let first = parts.first().cloned();
            return Ok(match (Folded::joined(&parts), first) {
                (Some(found), _) => Some(found),
                (None, Some(first)) => self.alone("in1", first),
                (None, None) => None,
            });
        }
        let found = self.input("in", 0.0)?;
        let from = match kind {
            "extract" => {
                let index = number(self.reader, self.view, "index", 0.0)?;
                [(index.max(0.0) as usize).min(3); 4]
            }
            "swizzle" => {
                let channels = text(self.reader, self.view, "channels")?.unwrap_or_default();
                let places: Vec<usize> = channels.chars().filter_map(place).collect();
                match places[..] {
                    [one] => [one; 4],
                    [a, b] => [a, b, 4, 5],
                    [a, b, c] => [a, b, c, 5],
                    [a, b, c, d] => [a, b, c, d],
                    _ => return Ok(self.alone("in", found)),
                }
            }
            "separate2" | "separate3" | "separate4" => [lane(output.trim_start_matches("out")).unwrap_or(0); 4],
            // A number is in all lanes already.
            _ => return Ok(Some(found)),
        };
        Ok(match found.clone().picked(from) {
            Some(found) => Some(found),
            None => self.alone("in", found),
        })
    }

    /// Which of the inputs a constant chooses.
    pub fn choice(&mut self, kind: &str) -> Result<Option<Folded>> {
        let name = if kind == "switch" {
            let which = number(self.reader, self.view, "which", 0.0)?;
            format!("in{}", which.max(0.0) as usize + 1)
        } else {
            let left = self.input("value1", if kind == "ifequal" { 0.0 } else { 1.0 })?;
            let right = self.input("value2", 0.0)?;
            let (Some([a, ..]), Some([b, ..])) = (left.lanes(), right.lanes()) else {
                let first = self.input("in1", 0.0)?;
                return Ok(self.alone("in1", first));
            };
            let holds = match kind {
                "ifgreater" => a > b,
                "ifgreatereq" => a >= b,
                _ => a == b,
            };
            if holds { "in1".to_owned() } else { "in2".to_owned() }
        };
        Ok(Some(self.input(&name, 0.0)?))
    }

    pub fn arithmetic(&mut self, kind: &str) -> Result<Option<Folded>> {
        let (name, found) = match kind {
            "multiply" => {
                let (a, b) = (self.input("in1", 0.0)?, self.input("in2", 1.0)?);
                ("in1", (a.clone(), a.times(b)))
            }
            "divide" => {
                let (a, b) = (self.input("in1", 0.0)?, self.input("in2", 1.0)?);
                let by = b.lanes().map(|by| by.map(f64::recip)).filter(|by| by.iter().all(|x| x.is_finite()));
                ("in1", (a.clone(), by.map(|by| a.scaled(by))))
            }
            "add" => {
                let (a, b) = (self.input("in1", 0.0)?, self.input("in2", 0.0)?);
                ("in1", (a.clone(), a.plus(b)))
            }
            "subtract" => {
                let (a, b) = (self.input("in1", 0.0)?, self.input("in2", 0.0)?);
                ("in1", (a.clone(), a.plus(b.scaled([-1.0; 4]))))
            }
            "invert" => {
                let (amount, found) = (self.input("amount", 1.0)?, self.input("in", 0.0)?);
                ("in", (found.clone(), found.scaled([-1.0; 4]).plus(amount)))
            }
            "mix" => {
                let (fg, bg, share) = (self.input("fg", 0.0)?, self.input("bg", 0.0)?, self.input("mix", 0.0)?);
                // What the larger share is of, goes on.
                let most = share.lanes().is_none_or(|share| share[0] >= 0.5);
                let (name, one) = if most { ("fg", fg.clone()) } else { ("bg", bg.clone()) };
                (name, (one, fg.over(bg, share)))
            }
            "remap" => {
                let found = self.input("in", 0.0)?;
                let ends = [("inlow", 0.0), ("inhigh", 1.0), ("outlow", 0.0), ("outhigh", 1.0)];
                let ends = ends.map(|(name, default)| lanes(self.reader, self.view, name, [default; 4]));
                let [a, b, c, d] = ends;
                let (a, b, c, d) = (a?, b?, c?, d?);
                let slope: Lanes = std::array::from_fn(|lane| (d[lane] - c[lane]) / (b[lane] - a[lane]));
                let start: Lanes = std::array::from_fn(|lane| c[lane] - slope[lane] * a[lane]);
                let is_line = slope.iter().chain(&start).all(|x| x.is_finite());
                let line = if is_line { found.clone().scaled(slope).moved(start) } else { None };
                ("in", (found, line))
            }
            "clamp" => {
                let found = self.input("in", 0.0)?;
                let low = lanes(self.reader, self.view, "low", [0.0; 4])?;
                let high = lanes(self.reader, self.view, "high", [1.0; 4])?;
                let clamped = match found.lanes() {
                    Some(own) => Some(Folded::constant(std::array::from_fn(|i| own[i].max(low[i]).min(high[i])))),
                    // Shares of a surface end at 0 and 1 by themselves.
                    None if low.iter().all(|x| *x <= 0.0) && high.iter().all(|x| *x >= 1.0) => Some(found.clone()),
                    None => None,
                };
                ("in", (found, clamped))
            }
            "normalmap" => {
                let found = self.input("in", 0.5)?;
                ("in", (found.clone(), found.scaled([2.0; 4]).moved([-1.0; 4])))
            }
            _ => return self.constants(kind),
        };
        Ok(match found {
            (_, Some(found)) => Some(found),
            (one, None) => self.alone(name, one),
        })
    }

    /// Functions that are known of constants alone.
    fn constants(&mut self, kind: &str) -> Result<Option<Folded>> {
        let two = |kind: &str| -> Option<fn(f64, f64) -> f64> {
            Some(match kind {
                "power" => f64::powf,
                "min" => f64::min,
                "max" => f64::max,
                _ => return None,
            })
        };
        if let Some(op) = two(kind) {
            let (a, b) = (self.input("in1", 0.0)?, self.input("in2", if kind == "power" { 1.0 } else { 0.0 })?);
            return Ok(match (a.lanes(), b.lanes()) {
                (Some(a), Some(b)) => Some(Folded::constant(std::array::from_fn(|lane| op(a[lane], b[lane])))),
                _ => self.alone("in1", a),
            });
        }
        let input = ["in", "in1", "fg"].into_iter().find(|name| self.view.has(&format!("inputs:{name}")));
        let Some(input) = input else {
            let what = if self.id.is_empty() {
                "a node without `info:id`".to_owned()
            } else {
                format!("the node `{}`", self.id)
            };
            self.reader.ledger.warn(self.view.at(), format!("{what} is not used: what reads it has its default"));
            return Ok(None);
        };
        let found = self.input(input, 0.0)?;
        let one: Option<fn(f64) -> f64> = match kind {
            "absval" => Some(f64::abs),
            "sqrt" => Some(f64::sqrt),
            "floor" => Some(f64::floor),
            "ceil" => Some(f64::ceil),
            "round" => Some(f64::round),
            _ => None,
        };
        Ok(match (found.lanes(), one) {
            (Some(lanes), Some(op)) => Some(Folded::constant(lanes.map(op))),
            (Some([r, g, b, _]), None) if kind == "luminance" => Some(Folded::number(luminance([r, g, b]))),
            _ => self.alone(input, found),
        })
    }
}

/// A letter of a swizzle; see [`Folded::picked`].
fn place(letter: char) -> Option<usize> {
    match letter {
        '0' => Some(4),
        '1' => Some(5),
        _ => lane(letter.encode_utf8(&mut [0; 4])),
    }
}
