//! Events that a program may want to know about while an image is made.

use std::path::Path;

/// Something that happens before an image is complete.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A file is about to get this temporary name. A signal handler that ends the process
    /// should remove it. No other process uses this name.
    Temporary(&'a Path),
    /// Another process has locked this directory, perhaps to make the same image in it,
    /// and this process waits for it.
    Waiting(&'a Path),
}

/// A function that is called for each event.
pub type Watch = fn(Event<'_>);
