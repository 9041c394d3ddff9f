//! The message of an error of the operating system, and what a user can do about it.

use std::io::{self, ErrorKind};

/// The message of the operating system, without the number of the error.
pub(in crate::ppm) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((words, _)) => words.to_lowercase(),
        None => text,
    }
}

/// What a user can do about an error of the operating system.
pub(in crate::ppm) fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space, or name a file on another file system"
        }
        ErrorKind::NotFound => "; make the directory first, or name another",
        ErrorKind::NotADirectory => "; a part of the path is not a directory",
        ErrorKind::PermissionDenied => {
            "; ask for permission to write there, or name a file in another directory"
        }
        ErrorKind::ReadOnlyFilesystem => "; name a file on a file system that can be written",
        ErrorKind::InvalidFilename => "; choose a shorter name",
        _ => remedy_of_kind(error),
    }
}

/// What a user can do about an error that only Unix has.
#[cfg(unix)]
fn remedy_of_kind(error: &io::Error) -> &'static str {
    use rustix::io::Errno;
    match Errno::from_io_error(error) {
        Some(Errno::FBIG) => {
            "; raise the limit on file sizes (ulimit -f), or name a file on a file system without one"
        }
        Some(Errno::NOMEM) => "; raise the limit on addresses (ulimit -v), or free some memory",
        Some(Errno::XDEV) => {
            "; the directory refuses files from elsewhere (a quota of a project, or a mount): name a file in another directory"
        }
        Some(Errno::BUSY) => {
            "; it is in use, as a file that is mounted by itself: name another file, or write into it with - as the image and > to redirect"
        }
        Some(Errno::STALE) => "; the network file system has lost it: check whether it is mounted",
        Some(Errno::IO) => "; the disk or the network failed: see the system's log (dmesg)",
        Some(Errno::BADF) => "; the descriptor is closed, or not open for writing",
        Some(Errno::LOOP) => {
            "; the symbolic links run in a circle, are too many, or are on a file system where none are followed: name the file itself"
        }
        Some(Errno::MFILE | Errno::NFILE) => {
            "; raise the limit on open files (ulimit -n), or close some"
        }
        _ => "",
    }
}

/// No advice beyond that for every system.
#[cfg(not(unix))]
fn remedy_of_kind(_error: &io::Error) -> &'static str {
    ""
}

#[cfg(all(test, unix))]
mod tests {
    use rustix::io::Errno;

    use super::*;

    #[test]
    fn errors_of_the_system_come_with_what_can_be_done() {
        for (errno, words) in [
            (Errno::NOSPC, "free some space"),
            (Errno::DQUOT, "free some space"),
            (Errno::NOENT, "make the directory first"),
            (Errno::NOTDIR, "is not a directory"),
            (Errno::ACCESS, "ask for permission"),
            (Errno::PERM, "ask for permission"),
            (Errno::ROFS, "that can be written"),
            (Errno::NAMETOOLONG, "a shorter name"),
            (Errno::FBIG, "ulimit -f"),
            (Errno::NOMEM, "ulimit -v"),
            (Errno::XDEV, "files from elsewhere"),
            (Errno::BUSY, "it is in use"),
            (Errno::STALE, "network file system"),
            (Errno::IO, "dmesg"),
            (Errno::BADF, "descriptor"),
            (Errno::LOOP, "symbolic links"),
            (Errno::MFILE, "ulimit -n"),
            (Errno::NFILE, "ulimit -n"),
        ] {
            let advice = remedy(&errno.into());
            assert!(
                advice.starts_with("; ") && advice.contains(words),
                "{advice}"
            );
        }
        assert_eq!(remedy(&Errno::PIPE.into()), "");
    }

    #[test]
    fn the_reason_is_that_of_the_system_without_its_number() {
        let full = io::Error::from(Errno::NOSPC);
        assert!(full.to_string().contains("(os error 28)"));
        assert_eq!(reason(&full), "no space left on device");
        assert_eq!(reason(&io::Error::other("Torn Paper")), "Torn Paper");
    }
}
