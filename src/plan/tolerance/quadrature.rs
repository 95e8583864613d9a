//! The variance that each parameter makes by itself, by Gauss's quadrature: designs in which only that one is off. Exact where a
//! figure is a polynomial up to the fourth order in the parameter, and without noise.

use super::parameter::{Law, Parameter};
use super::statistics::Share;

/// Nodes and weights beside the middle one, of five, for a normal variable of variance 1 (Abramowitz and Stegun, table
/// 25.10 with x√2) and for an even one over −1 … 1 (table 25.4, halved). The middle node has the rest of the weight.
const NORMAL: [[f64; 2]; 2] =
    [[1.355_626_179_974_266, 0.222_075_922_005_612_65], [2.856_970_013_872_805_7, 0.011_257_411_327_720_69]];
const UNIFORM: [[f64; 2]; 2] =
    [[0.538_469_310_105_683_1, 0.239_314_335_249_683_25], [0.906_179_845_938_664, 0.118_463_442_528_094_55]];

/// A design with one parameter off.
pub struct Node {
    pub parameter: usize,
    pub weight: f64,
    pub value: f64,
}

impl Node {
    /// The values of all of `count` parameters.
    pub fn values(&self, count: usize) -> Vec<f64> {
        let mut values = vec![0.0; count];
        if let Some(own) = values.get_mut(self.parameter) {
            *own = self.value;
        }
        values
    }
}

/// All of them; the middle node of each is the nominal design.
pub fn nodes(parameters: &[Parameter]) -> Vec<Node> {
    let mut out = Vec::new();
    for (parameter, row) in parameters.iter().enumerate() {
        let rule = match row.law {
            Law::Normal => NORMAL,
            Law::Uniform => UNIFORM,
        };
        for ([node, weight], side) in rule.into_iter().flat_map(|pair| [(pair, 1.0), (pair, -1.0)]) {
            out.push(Node { parameter, weight, value: side * node * row.size });
        }
    }
    out
}

/// What each parameter makes of a figure by itself, largest first: `found` at the nodes, `nominal` without any. Not known where a
/// node has no figure, which comes first: the face is missed or hidden there.
pub fn shares(parameters: &[Parameter], nodes: &[Node], found: &[f64], nominal: f64) -> Vec<Share> {
    let mut out: Vec<Share> = parameters
        .iter()
        .enumerate()
        .map(|(index, parameter)| {
            // Differences from the nominal design: a large figure takes no digits from a small variance.
            let own = || nodes.iter().zip(found).filter(move |(node, _)| node.parameter == index);
            let moment =
                |power: i32| own().map(|(node, value)| node.weight * (value - nominal).powi(power)).sum::<f64>();
            let variance = moment(2) - moment(1).powi(2);
            Share { name: parameter.name.clone(), variance: variance.is_finite().then_some(variance.max(0.0)) }
        })
        .collect();
    let rank = |share: &Share| share.variance.unwrap_or(f64::INFINITY);
    out.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
    out
}

#[cfg(test)]
mod tests {
    use super::super::parameter::Change;
    use super::*;
    use eyebox_base::Where;

    /// E x² = σ², Var x² = 2σ⁴ of a normal variable; a²/3 and 4a⁴/45 of an even one.
    #[test]
    fn polynomials_are_exact() {
        let of = |law, size| Parameter {
            name: format!("{law:?}"),
            parts: vec![0],
            change: Change::Index,
            law,
            size,
            at: Where::Nowhere,
        };
        let parameters = [of(Law::Normal, 0.7), of(Law::Uniform, 0.3)];
        let nodes = nodes(&parameters);
        let found: Vec<f64> = nodes
            .iter()
            .map(|node| node.values(2))
            .map(|v| 5.0 + 2.0 * v[0] + v[0].powi(2) + 3.0 * v[1] - v[1].powi(2))
            .collect();
        let shares = shares(&parameters, &nodes, &found, 5.0);
        let normal = 4.0 * 0.7f64.powi(2) + 2.0 * 0.7f64.powi(4);
        let even = 9.0 * 0.3f64.powi(2) / 3.0 + 4.0 * 0.3f64.powi(4) / 45.0;
        assert_eq!(shares[0].name, "Normal");
        let [first, second] = [0, 1].map(|index: usize| shares[index].variance.unwrap());
        assert!((first / normal - 1.0).abs() < 1e-12, "{first}");
        assert!((second / even - 1.0).abs() < 1e-12, "{second}");
        // A node without the figure: nobody knows, and that is told first.
        let mut torn = found;
        torn[4] = f64::NAN;
        let shares = super::shares(&parameters, &nodes, &torn, 5.0);
        assert_eq!((shares[0].name.as_str(), shares[0].variance), ("Uniform", None));
    }
}
