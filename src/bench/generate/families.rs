//! Which families the seeds take turns over.

use super::Family;
use eyebox_base::error::nearest_name;
use std::str::FromStr;

/// Of n families the one with number `seed mod n` is a seed's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Families(Vec<Family>);

/// Names of several families at once.
const FIRST: &str = "first";
const ASSEMBLIES: &str = "assemblies";
const EVERY: &str = "all";
/// How many are the first; the others are assemblies.
const SAMPLES: usize = 7;

impl Families {
    /// Those around the two samples: a seed has had the same scene since there were no others.
    pub fn first() -> Families {
        Families(Family::ALL[..SAMPLES].to_vec())
    }

    pub fn assemblies() -> Families {
        Families(Family::ALL[SAMPLES..].to_vec())
    }

    pub fn all() -> Families {
        Families(Family::ALL.to_vec())
    }

    pub fn of_seed(&self, seed: u64) -> Family {
        let turn = seed.checked_rem(self.0.len() as u64).unwrap_or(0);
        // There is at least one: names that name none are refused.
        self.0.get(turn as usize).copied().unwrap_or(Family::Direct)
    }

    /// Every name that [`Families::from_str`] knows.
    fn names() -> Vec<String> {
        [FIRST, ASSEMBLIES, EVERY].map(str::to_owned).into_iter().chain(Family::ALL.map(Family::key)).collect()
    }
}

impl Default for Families {
    fn default() -> Families {
        Families::first()
    }
}

impl FromStr for Families {
    type Err = String;

    /// Names with commas between them, each family once.
    fn from_str(text: &str) -> Result<Families, String> {
        let mut families: Vec<Family> = Vec::new();
        for name in text.split(',').map(str::trim) {
            let named = match name {
                FIRST => Families::first().0,
                ASSEMBLIES => Families::assemblies().0,
                EVERY => Families::all().0,
                single => Family::ALL.into_iter().filter(|family| family.key() == single).collect(),
            };
            if named.is_empty() {
                let names = Families::names();
                let nearest = nearest_name(name, names.iter().map(String::as_str));
                let nearest = nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"));
                return Err(format!("`{name}` is no family; expected {}{nearest}", names.join(", ")));
            }
            for family in named {
                if families.contains(&family) {
                    return Err(format!("`{}` is named twice; expected each family once", family.key()));
                }
                families.push(family);
            }
        }
        Ok(Families(families))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seeds of the first seven go by seed mod 7, as they did when there were no others.
    #[test]
    fn seeds_take_turns() {
        let names = |families: &Families, seeds: std::ops::Range<u64>| {
            seeds.map(|seed| families.of_seed(seed).key()).collect::<Vec<_>>().join(" ")
        };
        let first = Families::default();
        assert_eq!(names(&first, 0..8), "direct diffuser panorama both rough-glass no-lens room direct");
        assert_eq!(first.of_seed(u64::MAX), Family::Diffuser);
        assert_eq!(names(&Families::assemblies(), 6..9), "cabin windshield birdbath");
        assert_eq!(names(&Families::all(), 6..8), "room windshield");
        assert_eq!(names(&"cabin,direct".parse().unwrap(), 0..3), "cabin direct cabin");
        assert_eq!("first, assemblies".parse(), Ok(Families::all()));
    }

    #[test]
    fn names_that_name_none_are_refused() {
        let fault = |text: &str| text.parse::<Families>().unwrap_err();
        assert!(fault("windsheild").ends_with("did you mean `windshield`?"), "{}", fault("windsheild"));
        assert!(fault("").contains("expected first, assemblies, all, direct"), "{}", fault(""));
        assert!(fault("all,room").contains("`room` is named twice"), "{}", fault("all,room"));
    }
}
