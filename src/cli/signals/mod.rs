//! What signals that would end the program do to it.

#[cfg(not(unix))]
mod none;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(crate) use self::none::{bar, draws, end_with, hold, prepare, watch, watch_quietly};
#[cfg(unix)]
pub(crate) use self::unix::{bar, draws, end_with, hold, prepare, watch, watch_quietly};
