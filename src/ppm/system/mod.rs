//! What the operating system is asked for, beside what `std` can ask. Nothing
//! else in this folder is of one kind of system.

#[cfg(target_os = "linux")]
mod linux;
#[cfg(not(target_os = "linux"))]
mod named;
#[cfg(not(unix))]
mod other;
#[cfg(unix)]
mod unix;

use std::{
    fs::File,
    io::{self, ErrorKind, Write},
    path::{self, Path},
};

#[cfg(target_os = "linux")]
pub(super) use self::linux::{link, shares_pages, unnamed_file};
#[cfg(not(target_os = "linux"))]
pub(super) use self::named::{link, shares_pages, unnamed_file};
#[cfg(not(unix))]
use self::other as kind;
#[cfg(unix)]
use self::unix as kind;

pub(super) use kind::{
    fill_holes, keep_permissions, may_write, new_file, read_at, reserve, too_many_links, write_at,
};

/// Whether files can be mapped.
pub(super) const MAPS_FILES: bool = cfg!(any(unix, windows));

/// Whether a name ends as only that of a directory can.
pub(super) fn names_directory(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| path::is_separator(char::from(byte)))
}

fn write_zeros(mut file: &File, bytes: u64) -> io::Result<()> {
    let zeros = vec![0; 1 << 20];
    let mut left = bytes;
    while left > 0 {
        let piece = left.min(zeros.len() as u64);
        file.write_all(&zeros[..piece as usize])?;
        left -= piece;
    }
    Ok(())
}

/// The words of the operating system, without the number of the error.
pub(super) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((words, _)) => words.to_lowercase(),
        None => text,
    }
}

/// What a user can do about an error of the operating system.
pub(super) fn remedy(error: &io::Error) -> &'static str {
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
        _ => kind::remedy(error),
    }
}
