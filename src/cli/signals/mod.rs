//! Signals that would end the program: cleaning up, exit codes and messages.

#[cfg(not(unix))]
mod none;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(crate) use self::none::{bar, draws, end_with, hold, prepare, watch, watch_quietly};
#[cfg(unix)]
pub(crate) use self::unix::{bar, draws, end_with, hold, prepare, watch, watch_quietly};
