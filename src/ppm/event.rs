//! What a program may want to know of while an image is made.

use std::path::Path;

/// Something that happens between the making of an image and its end.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A file is about to get this name, for a while: whoever ends the process by
    /// a signal should remove it. The name is this process's own.
    Temporary(&'a Path),
    /// Another process has locked this directory, perhaps to make the same image
    /// in it, and is waited for.
    Waiting(&'a Path),
}

/// Is told of events.
pub type Watch = fn(Event<'_>);
