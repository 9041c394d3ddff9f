//! What the program asks of the operating system beside `std`. Signals have a module
//! of their own.

use std::{
    fs::{File, Metadata},
    io,
};

pub(crate) use self::kind::{is_same, is_stream};

/// Standard input as a file of its own.
pub(crate) fn stdin() -> io::Result<File> {
    kind::file_of(&io::stdin())
}

/// Standard output as a file of its own.
pub(crate) fn stdout() -> io::Result<File> {
    kind::file_of(&io::stdout())
}

/// The CPUs that this process may run on; a quota may allow fewer.
pub(crate) fn processors() -> usize {
    #[cfg(target_os = "linux")]
    if let Ok(processors) = rustix::thread::sched_getaffinity(None) {
        return processors.count() as usize;
    }
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(unix)]
mod kind {
    use std::os::{
        fd::AsFd,
        unix::fs::{FileTypeExt, MetadataExt},
    };

    use super::{File, Metadata, io};

    pub(super) fn file_of(stream: &impl AsFd) -> io::Result<File> {
        Ok(stream.as_fd().try_clone_to_owned()?.into())
    }

    /// Whether what is written there is a stream: a pipe or a character device.
    pub(crate) fn is_stream(metadata: &Metadata) -> bool {
        metadata.file_type().is_char_device() || metadata.file_type().is_fifo()
    }

    /// Whether two files are one, whatever their names.
    pub(crate) fn is_same(one: &Metadata, other: &Metadata) -> bool {
        (one.dev(), one.ino()) == (other.dev(), other.ino())
    }
}

#[cfg(windows)]
mod kind {
    use std::os::windows::io::AsHandle;

    use super::{File, Metadata, io};

    pub(super) fn file_of(stream: &impl AsHandle) -> io::Result<File> {
        Ok(stream.as_handle().try_clone_to_owned()?.into())
    }

    /// Whether what is written there is a stream: none has a name.
    pub(crate) fn is_stream(_metadata: &Metadata) -> bool {
        false
    }

    /// Whether two files are one, by the times of their making and changing, which are
    /// told to a ten-millionth of a second: `std` knows no number of a file.
    pub(crate) fn is_same(one: &Metadata, other: &Metadata) -> bool {
        let marks =
            |file: &Metadata| Some((file.created().ok()?, file.modified().ok()?, file.len()));
        marks(one).is_some() && marks(one) == marks(other)
    }
}
