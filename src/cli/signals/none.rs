//! Systems without signals: an interrupt ends the program where it is, and a temporary
//! file stays behind.

use std::{
    io::{self, Write},
    path::Path,
    process,
};

use sfera::ppm::Event;

/// Nothing is done about interrupts.
pub(crate) fn prepare() {}

/// Nobody would remove what was noted.
pub(crate) fn watch(_event: Event<'_>) {}

/// As `watch`, in silence.
pub(crate) fn watch_quietly(_event: Event<'_>) {}

/// Nobody can shorten a file that is mapped here.
pub(crate) fn draws(_index: usize, _path: &Path) {}

/// There is nothing to hold.
pub(crate) fn hold() {}

/// It stays where it is.
pub(crate) fn bar(_shown: bool) {}

/// Ends the program with a message and an exit code.
pub(crate) fn end_with(message: &[u8], code: i32) -> ! {
    let _ = io::stderr().write_all(message);
    process::exit(code)
}
