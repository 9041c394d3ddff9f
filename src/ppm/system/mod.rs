//! Functions of the operating system that the modules of `ppm` need and `std` does not
//! offer. Only the modules of this folder depend on the kind of system.

mod attributes;
#[cfg(unix)]
mod extended;
#[cfg(target_os = "linux")]
mod linux;
#[cfg(not(target_os = "linux"))]
mod named;
#[cfg(not(unix))]
mod other;
#[cfg(unix)]
mod permissions;
pub(super) mod remedy;
#[cfg(unix)]
mod unix;

use std::{
    fs::File,
    io::{self, Write},
    path::{self, Path},
};

pub(super) use self::attributes::Attributes;
#[cfg(target_os = "linux")]
pub(super) use self::linux::{attributes, link, settle, short_name, unnamed_file};
#[cfg(not(target_os = "linux"))]
pub(super) use self::named::{attributes, link, settle, short_name, unnamed_file};
#[cfg(not(unix))]
use self::other as kind;
#[cfg(not(unix))]
pub(super) use self::other::Permissions;
#[cfg(unix)]
pub(super) use self::permissions::Permissions;
#[cfg(unix)]
use self::unix as kind;

pub(super) use kind::{
    Identity, identity, is_same, lacks_inodes, make_writable, may_write, new_file,
    only_owner_replaces, read_at, reserve, too_many_links, write_at,
};

/// Whether a name ends with a separator, as only that of a directory may.
pub(super) fn names_directory(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| path::is_separator(char::from(byte)))
}

/// Fills a new file with zeros.
pub(super) fn write_zeros(mut file: &File, bytes: u64) -> io::Result<()> {
    let zeros = vec![0; 1 << 20];
    let mut left = bytes;
    while left > 0 {
        let piece = left.min(zeros.len() as u64);
        file.write_all(&zeros[..piece as usize])?;
        left -= piece;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_fill_a_file_of_any_length() -> io::Result<()> {
        for bytes in [0, 1, 1 << 20, (2 << 20) + 5] {
            let file = tempfile::NamedTempFile::new()?;
            write_zeros(file.as_file(), bytes)?;
            let written = std::fs::read(file.path())?;
            assert_eq!(written, vec![0; bytes as usize]);
        }
        Ok(())
    }
}
