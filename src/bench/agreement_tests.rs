use super::*;
use eyebox_base::rng::{Rng, Stream};

fn never() -> bool {
    false
}

/// A row of normal deviates that are `shift` off.
fn row(seed: u64, shift: f64) -> Row {
    let mut rng = Rng::new(seed, Stream::Backward, 0, 0);
    let mut normal = || -> f64 { (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0 + shift };
    let blocks: Vec<f64> = (0..48).map(|_| normal()).collect();
    Row {
        seed,
        family: Family::Direct,
        runs: vec!["backward"],
        passes: [1; 3],
        energy: normal(),
        blocks,
        ratio: 1.0,
        witness: Vec::new(),
        again: None,
    }
}

/// Sound pictures are found sound; a bias of one standard error, which no picture alone shows, is found in a hundred; and so are
/// one picture that is far off, one that is no number, and a witness that objects.
#[test]
fn a_small_bias_shows_in_many() {
    let rows = |shift: f64| (0..100).map(|seed| row(seed, shift)).collect::<Vec<Row>>();
    let sound = Summary::new(&rows(0.0));
    assert!(sound.holds() && (sound.blocks.mean_square - 1.0).abs() < 0.1, "{sound:?}");
    assert!(sound.blocks.count == 4800 && sound.energies.count == 100);
    let biased = Summary::new(&rows(1.0));
    assert!(!biased.holds() && biased.energies.mean_z > 5.0 && biased.blocks.chi_square_z > 10.0, "{biased:?}");
    for off in [8.0, -8.0, f64::NAN] {
        let mut one = rows(0.0);
        one[7].blocks[3] = off;
        assert!(!Summary::new(&one).holds(), "{off}");
        one[7].blocks.clear();
        assert!(Summary::new(&one).holds() && Summary::new(&one).too_rough == 1);
        one[7].witness.push("witness: led is off".to_owned());
        assert!(!Summary::new(&one).holds());
    }
}

/// A few seeds of both lists of families, as short as can be.
#[test]
fn generated_scenes_agree_with_plain_sampling() {
    let families = [Family::Both, Family::NoLens, Family::Birdbath, Family::TwoSlides];
    let rows: Vec<Row> = families
        .into_iter()
        .zip(40..)
        .map(|(family, seed)| agreement(family, seed, 0.2, &never).expect("a sound scene"))
        .collect();
    let found = Summary::new(&rows);
    assert!(found.too_rough < rows.len(), "{rows:?}");
    // How many passes there is time for is not known: what sound pictures never are.
    let limit = 8.0;
    let off = found.blocks.largest.abs().max(found.energies.largest.abs());
    assert!(off < limit, "{}\n{}", summary(&found), rows.iter().map(line).collect::<Vec<_>>().join("\n"));
}
