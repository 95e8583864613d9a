//! The documentation of a rule, for `--explain` and `docs/rules/`, made from the rule itself.

use super::rules;
use eyebox_check::rule::{Example, Rule};

/// The page of a rule, Markdown.
pub fn page(rule: &Rule) -> String {
    let Rule { code, name, level, title, why, bad, good, .. } = rule;
    format!(
        "# {code}: {title}\n\n`{name}` · {level}\n\n{why}\n\n## Sets it off\n\n{}\n\n## Put right\n\n{}\n\n## Leave it out\n\n{}",
        example(bad),
        example(good),
        fenced(
            "toml",
            &format!("# eyebox.toml\n[validate]\nlevel = {{ {code} = \"off\" }}      # or note, warning, error")
        ),
    ) + "\n"
}

fn example(example: &Example) -> String {
    match example {
        Example::Code(language, text) => fenced(language, text),
        Example::Words(text) => (*text).to_owned(),
    }
}

fn fenced(language: &str, text: &str) -> String {
    format!("```{language}\n{text}\n```")
}

/// The table of all rules, Markdown; links lead to `folder`.
pub fn table(folder: &str) -> String {
    let row = |rule: &Rule| {
        let Rule { code, name, level, title, .. } = rule;
        format!("| [{code}]({folder}{code}.md) | `{name}` | {level} | {title} |\n")
    };
    let rows: String = rules::all().map(row).collect();
    format!("| code | name | level | what it finds |\n|---|---|---|---|\n{rows}")
}
