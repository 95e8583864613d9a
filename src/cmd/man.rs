//! `eyebox man`: manual pages from the definitions that parse the command line.

use std::path::PathBuf;
use std::process::ExitCode;

use super::Cli;
use crate::base::atomic::write_atomic;
use crate::base::error::{Error, Result, Where};
use clap::CommandFactory;
use clap_mangen::Man;

/// Print the manual page, or write one for every command.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  eyebox man | man -l -
  eyebox man -o ~/.local/share/man/man1")]
pub struct ManArgs {
    /// The folder for eyebox.1, eyebox-render.1, …; made if it is not there [default: eyebox.1 on stdout]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ManArgs) -> Result<ExitCode> {
    let pages = pages()?;
    let Some(folder) = &args.output else {
        let (_, page) = pages.into_iter().next().unwrap_or_default();
        super::print_text(page)?;
        return Ok(ExitCode::SUCCESS);
    };
    std::fs::create_dir_all(folder)
        .map_err(|error| Error::new(Where::file(folder), format!("cannot be made: {error}")).expected("a folder"))?;
    let mut written = Vec::new();
    for (name, page) in pages {
        let path = folder.join(name);
        write_atomic(&path, page.as_bytes())?;
        written.push(path.display().to_string());
    }
    super::print_text(written.join("\n"))?;
    Ok(ExitCode::SUCCESS)
}

/// File name and page, the program's own first.
fn pages() -> Result<Vec<(String, String)>> {
    let mut program = Cli::command();
    // Names each command `eyebox-…` and gives it the options that all have.
    program.build();
    let commands = program.get_subcommands().filter(|command| command.get_name() != "help");
    let named = commands.map(|command| (format!("eyebox-{}.1", command.get_name()), command.clone()));
    let all = std::iter::once(("eyebox.1".to_owned(), program.clone())).chain(named);
    all.map(|(file, command)| {
        let mut out = Vec::new();
        // The date of a page is left out: the same program writes the same bytes.
        let page = Man::new(command).title(file.trim_end_matches(".1").to_uppercase()).date("");
        page.render(&mut out).map_err(|error| Error::new(Where::Nowhere, format!("{file}: {error}")))?;
        Ok((file, String::from_utf8_lossy(&out).into_owned()))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_its_page() {
        let pages = pages().unwrap();
        assert_eq!(pages[0].0, "eyebox.1");
        let commands: Vec<String> = Cli::command().get_subcommands().map(|c| c.get_name().to_owned()).collect();
        assert_eq!(pages.len(), commands.len() + 1);
        for name in &commands {
            let page = &pages.iter().find(|(file, _)| *file == format!("eyebox-{name}.1")).expect("its page").1;
            assert!(pages[0].1.contains(&format!("eyebox\\-{name}(1)")), "{name} in eyebox.1");
            // man(7): a title, and the sections that every page has.
            assert!(
                page.contains(".TH EYEBOX") && page.contains(".SH NAME") && page.contains(".SH SYNOPSIS"),
                "{name}"
            );
            for option in Cli::command().find_subcommand(name).unwrap().get_opts().filter_map(|o| o.get_long()) {
                assert!(page.contains(&option.replace('-', "\\-")), "--{option} in the page of {name}");
            }
        }
        // What roff would take for a request or its escapes: a line that begins with a dot or quote is one of ours.
        const REQUESTS: [&str; 12] =
            [".TH", ".SH", ".SS", ".TP", ".RS", ".RE", ".ie", ".el", ".IP", ".PP", ".br", ".nf"];
        for (file, page) in &pages {
            for line in page.lines().filter(|line| line.starts_with(['.', '\''])) {
                let known = REQUESTS.iter().chain([&".fi", &".B", &".I", &".R", &".ad", &".hy", &".nh"]);
                assert!(known.into_iter().any(|request| line.starts_with(request)), "{file}: {line}");
            }
        }
    }
}
