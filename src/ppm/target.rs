//! The file that an image is to become: which one that is, and whether it may be
//! replaced.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{
    errors::{ImageError, WRITE, refused},
    system,
};

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file that a path of symbolic links ends at, whether it is there or not.
pub(super) fn follow(path: &Path) -> Result<PathBuf, ImageError> {
    /// As many as Linux follows.
    const MOST_LINKS: u32 = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            // Not a link, or not there.
            Err(_) => return Ok(target),
        }
    }
    Err(refused(path, "follow it")(system::too_many_links()))
}

/// Refuses what must not be replaced: all but plain files that their permissions
/// allow to be written.
pub(super) fn may_replace(target: &Path) -> Result<(), ImageError> {
    let path = target.to_owned();
    let Ok(metadata) = fs::metadata(target) else {
        return if system::names_directory(target) {
            Err(ImageError::Directory { path })
        } else {
            Ok(())
        };
    };
    if metadata.is_dir() {
        return Err(ImageError::Directory { path });
    }
    if !metadata.is_file() {
        return Err(ImageError::NotAFile { path });
    }
    match system::may_write(target, &metadata) {
        Ok(true) => Ok(()),
        Ok(false) => Err(ImageError::WriteProtected { path }),
        Err(error) => Err(refused(target, WRITE)(error)),
    }
}
