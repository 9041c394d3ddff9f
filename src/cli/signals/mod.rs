//! What signals that would end the program do to it.

#[cfg(not(unix))]
mod none;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(crate) use self::none::{Interrupts, exit_when_lost, prepare};
#[cfg(unix)]
pub(crate) use self::unix::{Interrupts, exit_when_lost, prepare};
