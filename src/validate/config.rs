//! `eyebox.toml`: which rules hold, how grave they are, and where.

use super::rules;
use eyebox_base::{Error, Result, Where};
use eyebox_check::finding::Level;
use eyebox_check::rule::Rule;
use eyebox_import::select::glob;
use eyebox_import::toml;
use eyebox_scene::value::Value;
use std::path::{Path, PathBuf};

/// The file that is taken where `--config` is not given.
pub const FILE: &str = "eyebox.toml";

/// `[validate]` of a configuration.
#[derive(Debug, Clone, Default)]
pub struct Config {
    /// Codes that are not reported.
    ignore: Vec<&'static str>,
    /// If not empty, the only codes that are reported.
    only: Vec<&'static str>,
    /// Levels that replace the rules' own; none is off.
    levels: Vec<(&'static str, Option<Level>)>,
    /// `[[validate.path]]`, in order: the last that matches a file counts.
    paths: Vec<ForPath>,
    pub baseline: Option<PathBuf>,
    pub max_findings: Option<usize>,
    pub exit_zero: bool,
}

/// What holds for files that a pattern matches.
#[derive(Debug, Clone)]
struct ForPath {
    glob: String,
    ignore: Vec<&'static str>,
    levels: Vec<(&'static str, Option<Level>)>,
}

impl Config {
    /// Reads a configuration. Faults: it can't be read, is not TOML, or says something that has no meaning: with the line.
    pub fn read(path: &Path) -> Result<Config> {
        Config::of(&toml::read_as(path, "configuration")?, path)
    }

    /// The configuration in the working directory, if there is one.
    pub fn beside() -> Result<Config> {
        let path = Path::new(FILE);
        if path.is_file() { Config::read(path) } else { Ok(Config::default()) }
    }

    fn of(root: &Value, path: &Path) -> Result<Config> {
        // Other commands may have tables of their own.
        let Some(table) = root.get("validate") else { return Ok(Config::default()) };
        const KEYS: [&str; 7] = ["ignore", "only", "level", "path", "baseline", "max_findings", "exit_zero"];
        let mut out = Config::default();
        for (key, value) in entries(table, "`validate`")? {
            match key.as_str() {
                "ignore" => out.ignore = codes(value)?,
                "only" => out.only = codes(value)?,
                "level" => out.levels = levels(value)?,
                "path" => {
                    let rows = value.list().ok_or_else(|| value.wrong("`path`", "[[validate.path]] tables"))?;
                    out.paths = rows.iter().map(for_path).collect::<Result<_>>()?;
                }
                "baseline" => {
                    let name = value.text().ok_or_else(|| value.wrong("`baseline`", "a file name"))?;
                    out.baseline = Some(path.parent().unwrap_or(Path::new("")).join(name));
                }
                "max_findings" => {
                    let number = value.number().filter(|n| *n >= 0.0 && n.fract() == 0.0 && *n <= 1e9);
                    out.max_findings =
                        Some(number.ok_or_else(|| value.wrong("`max_findings`", "a whole number"))? as usize);
                }
                "exit_zero" => {
                    out.exit_zero = match value.data {
                        eyebox_scene::value::Data::Bool(flag) => flag,
                        _ => return Err(value.wrong("`exit_zero`", "true or false")),
                    }
                }
                _ => return Err(value.unknown_key(key, "`[validate]`", &KEYS)),
            }
        }
        Ok(out)
    }

    /// The level of a finding in `file` (as reports name it) whose rule made it `own`; none if it is not reported.
    pub fn level(&self, rule: &Rule, file: &str, own: Level) -> Option<Level> {
        if self.ignore.contains(&rule.code) || !(self.only.is_empty() || self.only.contains(&rule.code)) {
            return None;
        }
        let said = |levels: &[(&'static str, Option<Level>)]| {
            levels.iter().rev().find(|(code, _)| *code == rule.code).map(|(_, level)| *level)
        };
        for path in self.paths.iter().rev().filter(|path| glob(&path.glob, file)) {
            if path.ignore.contains(&rule.code) {
                return None;
            }
            if let Some(level) = said(&path.levels) {
                return level;
            }
        }
        said(&self.levels).unwrap_or(Some(own))
    }
}

fn entries<'a>(value: &'a Value, what: &str) -> Result<&'a [(String, Value)]> {
    value.table().ok_or_else(|| value.wrong(what, "a table"))
}

fn code(word: &str, at: &Where) -> Result<&'static str> {
    let fault = || {
        let known = rules::words();
        Error::new(at.clone(), format!("there is no rule `{word}`"))
            .expected("a code like EB0102, or a rule's name")
            .nearest(word, known)
    };
    Ok(rules::find(word).ok_or_else(fault)?.code)
}

fn codes(value: &Value) -> Result<Vec<&'static str>> {
    let list = value.list().ok_or_else(|| value.wrong("a list of codes", "a list, e.g. [\"EB0207\"]"))?;
    list.iter().map(|item| code(item.text().ok_or_else(|| item.wrong("a code", "a text"))?, &item.at)).collect()
}

fn levels(value: &Value) -> Result<Vec<(&'static str, Option<Level>)>> {
    const WORDS: [&str; 4] = ["off", "note", "warning", "error"];
    let row = |(key, value): &(String, Value)| {
        let word = value.text().ok_or_else(|| value.wrong(&format!("the level of {key}"), "a text"))?;
        let level = match word {
            "off" => None,
            _ => Some(Level::ALL.into_iter().find(|level| level.name() == word).ok_or_else(|| {
                Error::new(value.at.clone(), format!("there is no level `{word}`"))
                    .expected(format!("one of {}", WORDS.join(", ")))
                    .nearest(word, WORDS)
            })?),
        };
        Ok((code(key, &value.at)?, level))
    };
    entries(value, "`level`")?.iter().map(row).collect()
}

fn for_path(value: &Value) -> Result<ForPath> {
    const KEYS: [&str; 3] = ["glob", "ignore", "level"];
    let mut out = ForPath { glob: String::new(), ignore: Vec::new(), levels: Vec::new() };
    for (key, value) in entries(value, "`[[validate.path]]`")? {
        match key.as_str() {
            "glob" => {
                out.glob = value.text().ok_or_else(|| value.wrong("`glob`", "a text, e.g. \"old/**\""))?.to_owned()
            }
            "ignore" => out.ignore = codes(value)?,
            "level" => out.levels = levels(value)?,
            _ => return Err(value.unknown_key(key, "`[[validate.path]]`", &KEYS)),
        }
    }
    if out.glob.is_empty() {
        return Err(
            Error::new(value.at.clone(), "this `[[validate.path]]` has no `glob`").expected("glob = \"old/**\"")
        );
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(text: &str) -> Result<Config> {
        Config::of(&toml::parse(text, Path::new("eyebox.toml"))?, Path::new("eyebox.toml"))
    }

    #[test]
    fn the_more_specific_wins() {
        let config = config(
            "[other]\nx = 1\n[validate]\nignore = [\"named-unused\"]\nlevel = { EB0109 = \"error\", material-unused = \"off\" }\n\
             [[validate.path]]\nglob = \"old/**\"\nignore = [\"EB0102\"]\nlevel = { EB0109 = \"note\" }\n",
        )
        .unwrap();
        let level = |code: &str, file: &str| {
            let rule = rules::find(code).unwrap();
            config.level(rule, file, rule.level)
        };
        assert_eq!((level("EB0207", "a.glb"), level("EB0208", "a.glb")), (None, None));
        assert_eq!((level("EB0109", "a.glb"), level("EB0109", "old/a.glb")), (Some(Level::Error), Some(Level::Note)));
        assert_eq!((level("EB0102", "a.glb"), level("EB0102", "old/x/a.glb")), (Some(Level::Error), None));
    }

    #[test]
    fn what_has_no_meaning_is_a_fault_with_its_line() {
        for (text, fault) in [
            (
                "[validate]\nignor = []\n",
                "eyebox.toml:2: unknown key `ignor` of `[validate]`; expected one of ignore, only, level, path, baseline, max_findings, exit_zero; did you mean `ignore`?",
            ),
            (
                "[validate]\nignore = [\"EB9999\"]\n",
                "eyebox.toml:2: there is no rule `EB9999`; expected a code like EB0102, or a rule's name",
            ),
            (
                "[validate]\nlevel = { EB0102 = \"fatal\" }\n",
                "eyebox.toml:2: there is no level `fatal`; expected one of off, note, warning, error",
            ),
            (
                "[validate]\nmax_findings = -1\n",
                "eyebox.toml:2: `max_findings` is a number (-1); expected a whole number",
            ),
            (
                "[[validate.path]]\nignore = []\n",
                "eyebox.toml:1: this `[[validate.path]]` has no `glob`; expected glob = \"old/**\"",
            ),
        ] {
            let got = config(text).unwrap_err().to_string();
            assert!(got.starts_with(fault), "{got}");
        }
    }
}
