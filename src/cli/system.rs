//! Functions of the operating system that the program needs and `std` does not offer.
//! Signals have a module of their own.

use std::{
    fs::{File, Metadata},
    io,
};

pub(crate) use self::kind::{descriptor, is_device, is_pipe, is_stream, may_write, own_descriptor};

/// Standard input as a file with a descriptor of its own.
pub(crate) fn stdin() -> io::Result<File> {
    kind::file_of(&io::stdin())
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
    use std::{
        fs,
        os::{fd::AsFd, unix::fs::FileTypeExt},
        path::Path,
    };

    use rustix::fs::{Access, AtFlags, CWD};

    use super::{File, Metadata, io};

    pub(super) fn file_of(stream: &impl AsFd) -> io::Result<File> {
        Ok(stream.as_fd().try_clone_to_owned()?.into())
    }

    /// Whether a file is a stream: a pipe or a character device.
    pub(crate) fn is_stream(metadata: &Metadata) -> bool {
        metadata.file_type().is_char_device() || metadata.file_type().is_fifo()
    }

    /// Whether writing to a file overwrites nothing.
    pub(crate) fn is_device(metadata: &Metadata) -> bool {
        metadata.file_type().is_char_device()
    }

    /// Whether opening a file waits for another program.
    pub(crate) fn is_pipe(path: &Path) -> bool {
        fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo())
    }

    /// Checks that a stream may be written, without opening it.
    pub(crate) fn may_write(path: &Path) -> io::Result<()> {
        Ok(rustix::fs::accessat(
            CWD,
            path,
            Access::WRITE_OK,
            AtFlags::EACCESS,
        )?)
    }

    /// The descriptor of this process that a path names, as `/dev/stdout` and `/dev/fd/3`
    /// do. The file must be written through this descriptor: it may have lost its name, and
    /// hold bytes that are to stay.
    pub(crate) fn own_descriptor(path: &Path) -> Option<i32> {
        const MAX_LINKS: u32 = 40;
        let mut path = path.to_owned();
        for _ in 0..MAX_LINKS {
            let next = fs::read_link(&path).ok();
            if next.is_none() && !(path.starts_with("/dev") || path.starts_with("/proc")) {
                return None;
            }
            let folder = match path.parent()? {
                folder if folder.as_os_str().is_empty() => Path::new("."),
                folder => folder,
            };
            let folder = fs::canonicalize(folder).ok()?;
            if holds_own_descriptors(&folder) {
                return path.file_name()?.to_str()?.parse().ok();
            }
            path = folder.join(next?);
        }
        None
    }

    /// Whether the names in a directory are descriptors of this process.
    fn holds_own_descriptors(folder: &Path) -> bool {
        let Ok(own) = fs::canonicalize("/proc/self") else {
            return folder == Path::new("/dev/fd");
        };
        folder == own.join("fd") || folder.starts_with(own.join("task")) && folder.ends_with("fd")
    }

    /// A duplicate of a descriptor of this process.
    pub(crate) fn descriptor(number: i32) -> io::Result<File> {
        match number {
            0 => file_of(&io::stdin()),
            1 => file_of(&io::stdout()),
            2 => file_of(&io::stderr()),
            _ => other_descriptor(number),
        }
    }

    #[cfg(target_os = "linux")]
    fn other_descriptor(number: i32) -> io::Result<File> {
        use rustix::{
            io::Errno,
            process::{PidfdFlags, PidfdGetfdFlags, getpid, pidfd_getfd, pidfd_open},
        };
        let copy = pidfd_open(getpid(), PidfdFlags::empty())
            .and_then(|this| pidfd_getfd(this, number, PidfdGetfdFlags::empty()));
        match copy {
            Ok(copy) => return Ok(copy.into()),
            Err(error @ (Errno::BADF | Errno::MFILE | Errno::NFILE)) => return Err(error.into()),
            Err(_) => {}
        }
        // Duplicating is forbidden, as in some containers. Opening a pipe again has the same
        // effect; a file would be written from its beginning.
        let name = format!("/proc/self/fd/{number}");
        if fs::metadata(&name).is_ok_and(|metadata| is_stream(&metadata)) {
            return fs::OpenOptions::new().write(true).open(name);
        }
        Err(io::Error::other(format!(
            "this system forbids copying descriptors; give the image the name - and redirect standard output to it (>&{number})"
        )))
    }

    /// On these systems, opening the name duplicates the descriptor.
    #[cfg(not(target_os = "linux"))]
    fn other_descriptor(number: i32) -> io::Result<File> {
        fs::OpenOptions::new()
            .write(true)
            .open(format!("/dev/fd/{number}"))
    }
}

#[cfg(windows)]
mod kind {
    use std::{os::windows::io::AsHandle, path::Path};

    use super::{File, Metadata, io};

    pub(super) fn file_of(stream: &impl AsHandle) -> io::Result<File> {
        Ok(stream.as_handle().try_clone_to_owned()?.into())
    }

    /// Whether a file is a stream: no stream has a name.
    pub(crate) fn is_stream(_metadata: &Metadata) -> bool {
        false
    }

    /// Whether writing to a file overwrites nothing.
    pub(crate) fn is_device(_metadata: &Metadata) -> bool {
        false
    }

    /// No pipe or descriptor has a name.
    pub(crate) fn is_pipe(_path: &Path) -> bool {
        false
    }

    /// Reported when it is written.
    pub(crate) fn may_write(_path: &Path) -> io::Result<()> {
        Ok(())
    }

    /// No pipe or descriptor has a name.
    pub(crate) fn own_descriptor(_path: &Path) -> Option<i32> {
        None
    }

    /// Only standard output.
    pub(crate) fn descriptor(_number: i32) -> io::Result<File> {
        file_of(&io::stdout())
    }
}
