//! Messages on standard error, and text on standard output.

use std::{
    fmt,
    io::{self, Write},
};

use sfera::name::printable;

use super::failure::{Failure, write_failed};

/// Writes a line to standard error in one piece, since other programs may write there too.
/// Failing to write it changes nothing.
pub(crate) fn tell(text: fmt::Arguments<'_>) {
    let text = text.to_string();
    let mut lines: Vec<_> = text
        .split('\n')
        .map(|line| printable(line.as_bytes()))
        .collect();
    lines.push(String::new());
    let _ = io::stderr().write_all(lines.join("\n").as_bytes());
}

/// Writes all of a text to standard output.
pub(crate) fn print(text: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout();
    stdout
        .write_all(text)
        .and_then(|()| stdout.flush())
        .map_err(|error| write_failed("-".as_ref(), error))
}
