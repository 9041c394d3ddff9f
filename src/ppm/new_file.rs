//! A file of any format that appears whole under its name.

use std::{fs::File, path::Path};

use super::{
    draft::Draft,
    errors::{ImageError, WRITE, refused},
    event::Watch,
    system::{self, Permissions},
    target::Target,
};

/// A file that has no name until it is complete, for images of another format.
///
/// ```
/// use std::io::Write;
/// use sfera::ppm::NewFile;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("image.xyz");
/// let new = NewFile::create(&path)?;
/// new.file().write_all(b"all of it")?;
/// assert!(!path.exists());
/// new.publish()?;
/// assert_eq!(std::fs::read(&path)?, b"all of it");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct NewFile {
    pub(super) file: File,
    pub(super) becoming: Becoming,
}

/// The name that a file is to get, and the permissions.
#[derive(Debug)]
pub(super) struct Becoming {
    draft: Draft,
    pub(super) target: Target,
    /// Those of the file that is to be replaced.
    permissions: Option<Permissions>,
}

impl NewFile {
    /// Makes a file that is to appear at `path`. If `path` is a symbolic link, its target
    /// will be made or replaced.
    ///
    /// # Errors
    ///
    /// If the file can't be made or replaced there.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, ImageError> {
        Self::create_watched(path, |_| ())
    }

    /// Like [`create`](Self::create), and calls `watch` with each temporary name of the
    /// file. It has one where the file system has no files without a name, or while it
    /// replaces another file.
    ///
    /// # Errors
    ///
    /// If the file can't be made or replaced there.
    pub fn create_watched(path: impl AsRef<Path>, watch: Watch) -> Result<Self, ImageError> {
        let target = Target::find(path.as_ref())?;
        target.may_be_replaced()?;
        let permissions = match &target.found {
            Some(found) => Some(Permissions::of(&target.path, found)?),
            None => None,
        };
        let (file, draft) = Draft::create(&target.path, permissions.is_some(), watch)?;
        Ok(Self {
            file,
            becoming: Becoming {
                draft,
                target,
                permissions,
            },
        })
    }

    /// The file, to be written.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Waits until the disk can no longer refuse what was written. That takes time only if
    /// it is not a local disk. [`publish`](Self::publish) does so first.
    ///
    /// # Errors
    ///
    /// If the disk refused it.
    pub fn settle(&self) -> Result<(), ImageError> {
        let path = &self.becoming.target.path;
        system::settle(&self.file).map_err(refused(path, WRITE))
    }

    /// Makes the file appear under its name, in one step. It replaces an existing file and
    /// takes over its permissions.
    ///
    /// # Errors
    ///
    /// If the file can't be given its name, or something has got that name meanwhile that
    /// must not be replaced. Whatever has the name is left untouched.
    pub fn publish(self) -> Result<(), ImageError> {
        self.settle()?;
        let Self { file, becoming } = self;
        let Becoming {
            draft,
            target,
            permissions,
        } = becoming;
        draft.publish(&file, &target, || {
            let there = target.look_again()?;
            let now = match &there {
                Some(found) => Some(&Permissions::of(&target.path, found)?),
                None => permissions.as_ref(),
            };
            if let Some(permissions) = now {
                let kept = permissions.pass_on(&file);
                kept.map_err(refused(&target.path, "keep its permissions"))?;
            }
            Ok(there.is_some())
        })
    }
}
