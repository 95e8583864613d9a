//! `eyebox completions`: what a shell may offer after `eyebox`, from the definitions that parse it.

use std::process::ExitCode;

use super::Cli;
use crate::base::error::Result;
use clap::CommandFactory;
use clap_complete::Shell;

/// Print a script that lets a shell complete `eyebox`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  eyebox completions bash > ~/.local/share/bash-completion/completions/eyebox
  eyebox completions zsh > ~/.zfunc/_eyebox
  eyebox completions fish > ~/.config/fish/completions/eyebox.fish")]
pub struct CompletionsArgs {
    /// For which shell
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Runs the command.
pub fn run(args: &CompletionsArgs) -> Result<ExitCode> {
    super::print_text(String::from_utf8_lossy(&script(args.shell)).into_owned())?;
    Ok(ExitCode::SUCCESS)
}

fn script(shell: Shell) -> Vec<u8> {
    let mut out = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "eyebox", &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn every_shell_knows_every_command() {
        for shell in Shell::value_variants() {
            let text = String::from_utf8(script(*shell)).unwrap();
            for command in Cli::command().get_subcommands() {
                assert!(text.contains(command.get_name()), "{shell}: {}", command.get_name());
            }
            assert!(text.contains("contact-sheet"), "{shell}: options of commands");
        }
    }
}
