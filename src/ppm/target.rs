//! The file that an image is to become: which file it is, and whether it may be replaced.

use std::{
    ffi::OsString,
    fs::{self, Metadata},
    io,
    path::{Path, PathBuf},
};

use super::{
    errors::{FOLLOW, ImageError, LOOK, WRITE, refused},
    system::{self, Attributes},
};

/// The name of a file, and what has that name.
#[derive(Debug)]
pub(super) struct Target {
    /// With all symbolic links followed.
    pub(super) path: PathBuf,
    pub(super) found: Option<Metadata>,
}

impl Target {
    /// The file that `path` names, or the target if that is a symbolic link. It is absent,
    /// or a plain file that may be written.
    pub(super) fn find(path: &Path) -> Result<Self, ImageError> {
        let target = follow(path)?;
        if let Some(found) = &target.found {
            may_write(&target.path, found)?;
        } else if system::names_directory(&target.path) {
            return Err(ImageError::Directory {
                path: path.to_owned(),
            });
        }
        Ok(target)
    }

    /// Refuses a file that can't be replaced, although it may be written.
    pub(super) fn may_be_replaced(&self) -> Result<(), ImageError> {
        match &self.found {
            Some(found) => may_replace(&self.path, found),
            None => Ok(()),
        }
    }

    /// What has the name now; an error if that must not be replaced. No system call closes
    /// the gap between this check and the rename.
    pub(super) fn look_again(&self) -> Result<Option<Metadata>, ImageError> {
        let path = &self.path;
        let found = if_there(fs::symlink_metadata(path)).map_err(refused(path, LOOK))?;
        match &found {
            Some(found) if found.is_file() => {
                may_write(path, found)?;
                may_replace(path, found)?;
            }
            Some(_) => {
                return Err(ImageError::Changed {
                    path: path.clone(),
                    what: "something that is not a file took its name",
                });
            }
            None => {}
        }
        Ok(found)
    }
}

/// Only the error "not found" means that a file is absent.
pub(super) fn if_there<T>(found: io::Result<T>) -> io::Result<Option<T>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file at the end of a chain of symbolic links, whether it exists or not: the file that
/// the operating system would find, or an error.
fn follow(path: &Path) -> Result<Target, ImageError> {
    /// How often the name is looked up: another process may replace the file meanwhile.
    const LOOKS: u32 = 16;
    for _ in 0..LOOKS {
        if let Some(target) = follow_once(path)? {
            return Ok(target);
        }
    }
    Err(ImageError::NoSuchName {
        path: path.to_owned(),
    })
}

/// The file at the end of a chain of symbolic links, if the operating system finds the same one.
fn follow_once(path: &Path) -> Result<Option<Target>, ImageError> {
    /// The limit of Linux.
    const MAX_LINKS: u32 = 40;
    let mut target = path.to_owned();
    for _ in 0..=MAX_LINKS {
        let found = if_there(fs::symlink_metadata(&target)).map_err(|error| {
            let bare = path.components().as_path();
            if system::names_directory(path) && fs::metadata(bare).is_ok_and(|file| file.is_file())
            {
                ImageError::TrailingSlash {
                    path: path.to_owned(),
                }
            } else {
                refused(path, LOOK)(error)
            }
        })?;
        if found.as_ref().is_some_and(Metadata::is_symlink) {
            let next = fs::read_link(&target).map_err(refused(path, FOLLOW))?;
            target = folder_of(&target).join(next);
        } else {
            let right = if_there(fs::metadata(path)).map_err(refused(path, FOLLOW))?;
            let [own, right] = [&found, &right].map(|found| found.as_ref().map(system::identity));
            return Ok((own == right).then_some(Target {
                path: target,
                found,
            }));
        }
    }
    Err(refused(path, FOLLOW)(system::too_many_links()))
}

/// Refuses everything except plain files that their permissions allow to be written.
fn may_write(path: &Path, found: &Metadata) -> Result<(), ImageError> {
    let path = path.to_owned();
    if found.is_dir() {
        return Err(ImageError::Directory { path });
    }
    if !found.is_file() {
        return Err(ImageError::NotAFile { path });
    }
    if let Some(attribute) = system::attributes(&path).lock() {
        return Err(ImageError::Locked { path, attribute });
    }
    match system::may_write(&path, found) {
        Ok(true) => Ok(()),
        Ok(false) => Err(ImageError::WriteProtected { path }),
        Err(error) => Err(refused(&path, WRITE)(error)),
    }
}

/// Refuses a file that the operating system would not allow to be replaced. This happens
/// before anything is drawn.
fn may_replace(path: &Path, found: &Metadata) -> Result<(), ImageError> {
    let folder = folder_of(path);
    let Attributes { mount_root, .. } = system::attributes(path);
    let path = path.to_owned();
    if mount_root {
        return Err(ImageError::Mounted { path });
    }
    if let Some(attribute) = system::attributes(folder).lock() {
        return Err(ImageError::LockedDirectory { path, attribute });
    }
    let folder = fs::metadata(folder).map_err(refused(&path, "look at its directory"))?;
    if system::only_owner_replaces(&folder, found) {
        return Err(ImageError::OthersFile { path });
    }
    Ok(())
}

/// The file that a name refers to, whether it exists or not: two names of one file have
/// equal places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place(Reference);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Reference {
    Existing(system::Identity),
    Absent(system::Identity, OsString),
}

impl Place {
    /// The place of the file that would be made or replaced under this name. If it is a
    /// symbolic link, that is its target.
    ///
    /// # Errors
    ///
    /// If the operating system refuses to look it up.
    pub fn of(path: impl AsRef<Path>) -> Result<Self, ImageError> {
        let path = path.as_ref();
        let target = follow(path)?;
        if let Some(found) = &target.found {
            return Ok(Self::of_file(found));
        }
        let folder = folder_of(&target.path);
        let folder = fs::metadata(folder).map_err(refused(path, "look at its directory"))?;
        let name = target.path.file_name().unwrap_or_default();
        Ok(Self(Reference::Absent(
            system::identity(&folder),
            name.to_owned(),
        )))
    }

    /// The place of an existing file.
    #[must_use]
    pub fn of_file(metadata: &Metadata) -> Self {
        Self(Reference::Existing(system::identity(metadata)))
    }
}
