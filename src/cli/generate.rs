//! `--generate`: completions for shells, and the manual page.

use clap::CommandFactory;
use clap_complete::Shell;

use super::arguments::{Arguments, Page};

/// The text of a page.
pub(crate) fn page(page: Page) -> Vec<u8> {
    let mut command = Arguments::command();
    let mut text = Vec::new();
    let mut complete =
        |shell: Shell| clap_complete::generate(shell, &mut command, "sfera", &mut text);
    match page {
        Page::Bash => complete(Shell::Bash),
        Page::Zsh => complete(Shell::Zsh),
        Page::Fish => complete(Shell::Fish),
        // Writing to memory does not fail.
        Page::Man => drop(clap_mangen::Man::new(command).render(&mut text)),
    }
    text
}
