//! `eyebox glass`: the catalogue of glasses, liquids, films and metals that attributes name.

use super::{Format, print};
use crate::base::error::{Error, Result, Where};
use crate::import::agf;
use crate::scene::glass::{FDC_NM, Glass, all, find, names};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::process::ExitCode;

/// List the glasses, films and metals that are known by name, with their indices.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
A body is what `glass` of an attribute names, a film or metal what `material` of a coating's layer does. n_d and V_d are of \
the lines F, d and C (486.1327, 587.5618, 656.2725 nm); `-` stands where the law was not made for them. An index beyond the \
wavelengths of its law is printed and said to be extrapolated, as a render does.

Without NAME and --like the table is that of chosen materials. Behind it is the whole refractiveindex.info database (public \
domain, CC0; air counts as 1, as in the rest of the program): `SCHOTT N-LAK9` with its maker, `N-LAK9` without (of makers with \
the same name the one that the database lists first), `main/Ag/Johnson` by shelf, book and page, `Ag Johnson` by book and page. \
A name of the table means its row: `N-BK7` has no absorption, `SCHOTT N-BK7` the one of its data sheet. FILE.agf#NAME is a glass \
of a catalogue file.

Examples:
  eyebox glass
  eyebox glass N-BK7 PMMA --nm 450,550,650
  eyebox glass \"OHARA S-LAH79\" \"Ag Johnson\" vendor.agf#K8
  eyebox glass --like lah
  eyebox glass --format json")]
pub struct GlassArgs {
    /// The ones to show with their indices; upper and lower case, `-`, `_` and spaces make no difference [default: all,
    /// as a table]
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Those whose names hold this text, of the table and of the whole database
    #[arg(long, value_name = "TEXT", conflicts_with = "names")]
    pub like: Option<String>,
    /// Indices at these wavelengths, nm [default with NAME: the lines F, d, C]
    #[arg(long, value_name = "NM,…", value_delimiter = ',', value_parser = parse_nm)]
    pub nm: Vec<f64>,
    /// How to print the results
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

fn parse_nm(text: &str) -> std::result::Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(nm) if nm.is_finite() && nm > 0.0 => Ok(nm),
        Ok(_) | Err(_) => Err(format!("`{text}` is not a wavelength; write nanometres above 0, e.g. 550 or 587.5618")),
    }
}

/// Runs the command.
pub fn run(args: &GlassArgs) -> Result<ExitCode> {
    let (rows, nm) = asked(args)?;
    let text = || {
        if nm.is_empty() { table(&rows) } else { rows.iter().map(|row| block(row, &nm)).collect::<Vec<_>>().join("\n") }
    };
    print(args.format, text, || document(&rows, &nm))?;
    Ok(ExitCode::SUCCESS)
}

/// The rows that are asked for, and the wavelengths at which their indices are.
fn asked(args: &GlassArgs) -> Result<(Vec<Cow<'static, Glass>>, Vec<f64>)> {
    let row = |name: &String| -> Result<Cow<'static, Glass>> {
        if let Some(from) = agf::Reference::of(name) {
            let (glass, doubt) = from.compared(&Where::Nowhere)?;
            doubt.into_iter().for_each(|doubt| tell!("warning: {doubt}"));
            return Ok(Cow::Owned(glass));
        }
        find(name).map(Cow::Borrowed).ok_or_else(|| {
            Error::new(Where::Nowhere, format!("unknown glass `{name}`"))
                .expected("a name of the catalogue, which `eyebox glass` lists")
                .nearest(name, names())
        })
    };
    let rows = match &args.like {
        Some(text) => like(text)?,
        None if args.names.is_empty() => all().iter().map(Cow::Borrowed).collect(),
        None => args.names.iter().map(row).collect::<Result<Vec<_>>>()?,
    };
    let nm = if args.nm.is_empty() && !args.names.is_empty() { FDC_NM.to_vec() } else { args.nm.clone() };
    Ok((rows, nm))
}

/// The rows and entries with a name that holds `text`, each once.
fn like(text: &str) -> Result<Vec<Cow<'static, Glass>>> {
    let wanted = text.to_lowercase();
    let mut rows: Vec<&'static Glass> = Vec::new();
    let mut known = BTreeSet::new();
    for glass in names().filter(|name| name.to_lowercase().contains(&wanted)).filter_map(find) {
        if known.insert(glass.name) {
            rows.push(glass);
        }
    }
    if rows.is_empty() {
        return Err(Error::new(Where::Nowhere, format!("no glass has `{text}` in its name")).nearest(text, names()));
    }
    Ok(rows.into_iter().map(Cow::Borrowed).collect())
}

/// A number with `digits` decimals; `-` where there is none.
fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

fn range([low, high]: [f64; 2]) -> String {
    format!("{low}–{high}")
}

/// One line a row, in columns.
fn table(rows: &[Cow<'static, Glass>]) -> String {
    const HEAD: [&str; 7] = ["name", "other names", "n_d", "V_d", "nm", "kind", "source"];
    let cells = |glass: &Cow<'static, Glass>| {
        let also = if glass.also.is_empty() { "-".to_owned() } else { glass.also.join(", ") };
        let (n_d, v_d) = (number(glass.index_d().map(|index| index.re), 5), number(glass.abbe(), 2));
        let [name, kind, source] = [glass.name, glass.kind().name(), glass.source].map(str::to_owned);
        [name, also, n_d, v_d, range(glass.valid_nm), kind, source]
    };
    let lines: Vec<[String; 7]> = std::iter::once(HEAD.map(str::to_owned)).chain(rows.iter().map(cells)).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..HEAD.len()).map(width).collect();
    let line = |cells: &[String; 7]| {
        let padded = cells.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A row and its indices, one line a wavelength.
fn block(glass: &Glass, nm: &[f64]) -> String {
    let (n_d, v_d) = (number(glass.index_d().map(|index| index.re), 5), number(glass.abbe(), 2));
    let [range, kind] = [range(glass.valid_nm), glass.kind().name().to_owned()];
    let also: String = glass.also.iter().map(|name| format!(" ({name})")).collect();
    let head = format!("{}{also}: n_d {n_d}, V_d {v_d}, {range} nm, {kind}; {}", glass.name, glass.source);
    let line = |nm: &f64| {
        let index = glass.dispersion.index(*nm);
        let k = match index.im {
            0.0 => String::new(),
            k if k < 1e-3 => format!("  k {k:.4e}"),
            k => format!("  k {k:.6}"),
        };
        let beyond = if glass.beyond([*nm; 2]).is_some() { "  extrapolated" } else { "" };
        format!("  {nm} nm  n {:.6}{k}{beyond}", index.re)
    };
    std::iter::once(head).chain(nm.iter().map(line)).collect::<Vec<_>>().join("\n")
}

fn document(rows: &[Cow<'static, Glass>], nm: &[f64]) -> Value {
    let index = |glass: &Glass, nm: f64| {
        let index = glass.dispersion.index(nm);
        json!({ "nm": nm, "n": index.re, "k": index.im, "extrapolated": glass.beyond([nm; 2]).is_some() })
    };
    let row = |glass: &Cow<'static, Glass>| {
        json!({
            "name": glass.name,
            "also": glass.also,
            "n_d": glass.index_d().map(|index| index.re),
            "v_d": glass.abbe(),
            "valid_nm": glass.valid_nm,
            "kind": glass.kind(),
            "source": glass.source,
            "indices": nm.iter().map(|nm| index(glass, *nm)).collect::<Vec<_>>(),
        })
    };
    json!({ "glasses": rows.iter().map(row).collect::<Vec<_>>() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args, FromArgMatches};

    fn parse(words: &[&str]) -> std::result::Result<GlassArgs, clap::Error> {
        let command = GlassArgs::augment_args(clap::Command::new("glass"));
        command.try_get_matches_from(words).map(|matches| GlassArgs::from_arg_matches(&matches).unwrap())
    }

    fn asked_for(words: &[&str]) -> Result<(Vec<Cow<'static, Glass>>, Vec<f64>)> {
        asked(&parse(&[&["glass"], words].concat()).unwrap())
    }

    #[test]
    fn every_row_of_the_catalogue_is_listed() {
        let (rows, nm) = asked_for(&[]).unwrap();
        assert!(nm.is_empty());
        let text = table(&rows);
        assert_eq!(text.lines().count(), 1 + all().len());
        let listed = document(&rows, &nm);
        for (i, glass) in all().iter().enumerate() {
            let line = text.lines().nth(i + 1).unwrap();
            assert!(line.starts_with(glass.name) && line.ends_with(glass.source), "{line}");
            assert!(glass.also.iter().all(|name| line.contains(name)), "{line}");
            assert_eq!(listed["glasses"][i]["name"], glass.name);
        }
        let bk7 = text.lines().find(|line| line.starts_with("N-BK7")).unwrap();
        assert!(bk7.contains("1.51680  64.17") && bk7.contains("300–2500") && bk7.contains("body"), "{bk7}");
        let silver = text.lines().find(|line| line.starts_with("Ag ")).unwrap();
        assert!(silver.contains("  -  ") && silver.contains("metal"), "{silver}");
    }

    #[test]
    fn indices_of_the_named_ones_and_what_is_extrapolated() {
        let (rows, nm) = asked_for(&["nbk7", "sio2"]).unwrap();
        assert_eq!(
            (rows.iter().map(|row| row.name).collect::<Vec<_>>(), nm),
            (vec!["N-BK7", "fused silica"], FDC_NM.into())
        );
        let (rows, nm) = asked_for(&["PMMA", "Ag", "--nm", "400,550"]).unwrap();
        let text = rows.iter().map(|row| block(row, &nm)).collect::<Vec<_>>().join("\n");
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("PMMA (PMMA_Sultanova): n_d 1.49"), "{text}");
        assert!(lines[1].starts_with("  400 nm  n 1.5") && lines[1].ends_with("extrapolated"), "{text}");
        assert!(lines[2].starts_with("  550 nm  n 1.49") && !lines[2].contains("k "), "{text}");
        assert!(lines[3].starts_with("Ag: n_d 0.05") && lines[5].contains("  k 3.5"), "{text}");
        let said = document(&rows, &nm);
        let flags = [0, 1].map(|i| said["glasses"][0]["indices"][i]["extrapolated"].as_bool().unwrap());
        assert_eq!(flags, [true, false]);
        assert!(said["glasses"][1]["v_d"].is_null());
    }

    #[test]
    fn the_database_is_behind_the_table() {
        let (rows, nm) = asked_for(&["SCHOTT N-BK7", "Ag Johnson"]).unwrap();
        let text = rows.iter().map(|row| block(row, &nm)).collect::<Vec<_>>().join("\n");
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines[0].starts_with("SCHOTT N-BK7: n_d 1.51680, V_d 64.17, 300–2500 nm, body; SCHOTT Zemax"),
            "{text}"
        );
        assert!(
            lines[1].starts_with("  486.1327 nm  n 1.522") && lines[1].contains("  k 9.") && lines[1].ends_with("e-9"),
            "{text}"
        );
        assert!(
            lines[4].starts_with("main/Ag/Johnson: ") && lines[4].contains("metal; Johnson and Christy 1972"),
            "{text}"
        );
        let (rows, _) = asked_for(&["--like", "n-lak9"]).unwrap();
        assert_eq!(rows.iter().map(|row| row.name).collect::<Vec<_>>(), ["SCHOTT N-LAK9"]);
        assert!(
            asked_for(&["--like", "unheard of"])
                .unwrap_err()
                .to_string()
                .starts_with("no glass has `unheard of` in its name")
        );
    }

    #[test]
    fn a_misspelt_name_is_one_line_and_a_wavelength_is_above_zero() {
        let fault = asked_for(&["N-BK8"]).unwrap_err().to_string();
        assert_eq!(
            fault,
            "unknown glass `N-BK8`; expected a name of the catalogue, which `eyebox glass` lists; did you mean `N-BK7`?"
        );
        for bad in ["0", "-1", "inf", "nan", "blue"] {
            assert!(parse(&["glass", &format!("--nm={bad}")]).is_err(), "{bad}");
        }
    }
}
