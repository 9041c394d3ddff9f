//! A file of any kind that appears whole under its name.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
};

use super::{
    draft::Draft,
    errors::{ImageError, refused},
    system,
    target::{follow, may_replace},
};

/// A file without a name until it is complete, for images of another format.
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
    pub(super) path: PathBuf,
    pub(super) draft: Draft,
}

impl NewFile {
    /// Makes a file that is to appear at `path`. Where `path` is a symbolic link,
    /// its target is what will be made or replaced.
    ///
    /// # Errors
    ///
    /// If the file could not be made or replaced there.
    pub fn create(path: &Path) -> Result<Self, ImageError> {
        let path = follow(path)?;
        may_replace(&path)?;
        let (file, draft) = Draft::create(&path)?;
        Ok(Self { file, path, draft })
    }

    /// The file, to be written.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.file
    }

    /// The name under which the unfinished file can be seen, where the file
    /// system has no files without one. It is removed when this is dropped, and
    /// left behind when the process is killed.
    #[must_use]
    pub fn temporary_name(&self) -> Option<&Path> {
        self.draft.temporary_name()
    }

    /// Makes the file appear under its name, in one step. A file that was there
    /// is replaced, and hands on its permissions.
    ///
    /// # Errors
    ///
    /// If the file can't be given its name; what was there before is untouched.
    pub fn publish(self) -> Result<(), ImageError> {
        let Self { file, path, draft } = self;
        if let Ok(before) = fs::metadata(&path) {
            system::keep_permissions(&file, &before)
                .map_err(refused(&path, "keep its permissions"))?;
        }
        draft.publish(&file, &path)
    }
}
