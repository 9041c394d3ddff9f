//! `--generate`: what shells and `man` want to know of the command line.

use std::io::{self, Write};

use clap::{CommandFactory, ValueEnum};
use clap_complete::Shell;

use super::arguments::Arguments;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Page {
    /// Completions for bash
    Bash,
    /// Completions for zsh
    Zsh,
    /// Completions for fish
    Fish,
    /// The manual page
    Man,
}

/// Writes a page to standard output.
pub(crate) fn generate(page: Page) -> io::Result<()> {
    let mut command = Arguments::command();
    let mut text = Vec::new();
    let mut complete =
        |shell: Shell| clap_complete::generate(shell, &mut command, "sfera", &mut text);
    match page {
        Page::Bash => complete(Shell::Bash),
        Page::Zsh => complete(Shell::Zsh),
        Page::Fish => complete(Shell::Fish),
        Page::Man => clap_mangen::Man::new(command).render(&mut text)?,
    }
    io::stdout().write_all(&text)
}
