//! Systems without signals: an interrupt ends the program where it is, and a temporary
//! file stays behind.

use std::{io, path::Path};

/// Nothing is done about interrupts.
#[derive(Debug)]
pub(crate) struct Interrupts;

pub(crate) fn prepare() -> io::Result<Interrupts> {
    Ok(Interrupts)
}

impl Interrupts {
    pub(crate) fn remove(&self, _temporary: &Path) -> io::Result<()> {
        Ok(())
    }

    pub(crate) fn hold(&self) {}
}

/// Nobody can shorten a file that is mapped here.
pub(crate) fn exit_when_lost(_message: String, _temporary: Option<&Path>) -> io::Result<()> {
    Ok(())
}
