//! Systems without signals: an interrupt ends the program at once, and a temporary file is
//! left.

use std::{
    io::{self, Write},
    path::Path,
    process,
};

use sfera::ppm::Event;

/// Interrupts are not handled.
pub(crate) fn prepare() {}

/// Does nothing: no handler would remove the file.
pub(crate) fn watch(_event: Event<'_>) {}

/// Like `watch`, without messages.
pub(crate) fn watch_quietly(_event: Event<'_>) {}

/// Nobody can shorten a file that is mapped here.
pub(crate) fn draws(_index: usize, _path: &Path) {}

/// There are no interrupts to ignore.
pub(crate) fn hold() {}

/// The bar is not removed.
pub(crate) fn bar(_shown: bool) {}

/// Ends the program with a message and an exit code.
pub(crate) fn end_with(message: &[u8], code: i32) -> ! {
    let _ = io::stderr().write_all(message);
    process::exit(code)
}
