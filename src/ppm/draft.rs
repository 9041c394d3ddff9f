//! Where an image is until it has its name.

use std::{fs::File, io, path::Path};

use tempfile::TempPath;

use super::{
    errors::{ImageError, NAME, refused},
    system,
    target::folder_of,
};

/// Where an image is until it has its name.
#[derive(Debug)]
pub(super) enum Draft {
    Unnamed,
    Named(TempPath),
}

impl Draft {
    pub(super) fn create(target: &Path) -> Result<(File, Self), ImageError> {
        let folder = folder_of(target);
        if let Some(file) = system::unnamed_file(folder) {
            return Ok((file, Self::Unnamed));
        }
        let (file, name) = under_temporary_name(folder, system::new_file)
            .map_err(refused(target, "make a file in its directory"))?;
        Ok((file, Self::Named(name)))
    }

    pub(super) fn temporary_name(&self) -> Option<&Path> {
        match self {
            Self::Unnamed => None,
            Self::Named(name) => Some(name),
        }
    }

    pub(super) fn publish(self, file: &File, target: &Path) -> Result<(), ImageError> {
        let name = match self {
            Self::Named(name) => name,
            Self::Unnamed => match system::link(file, target) {
                Ok(()) => return Ok(()),
                // Only a rename replaces, and only a name can be renamed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    under_temporary_name(folder_of(target), |path| system::link(file, path))
                        .map_err(refused(target, NAME))?
                        .1
                }
                Err(error) => return Err(refused(target, NAME)(error)),
            },
        };
        name.persist(target)
            .map_err(|error| refused(target, NAME)(error.error))
    }

    pub(super) fn publish_if_absent(self, file: &File, target: &Path) -> Result<(), ImageError> {
        let published = match self {
            Self::Named(name) => name.persist_noclobber(target).map_err(|error| error.error),
            Self::Unnamed => system::link(file, target),
        };
        match published {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                Err(refused(target, NAME)(error))
            }
            _ => Ok(()),
        }
    }
}

/// Makes a file under a name of its own that lives as long as a render, or less.
fn under_temporary_name<F>(
    folder: &Path,
    mut make: impl FnMut(&Path) -> io::Result<F>,
) -> io::Result<(F, TempPath)> {
    // The system's own error: tempfile's would name the temporary file.
    let mut refusal = None;
    tempfile::Builder::new()
        .prefix(".sfera-")
        .suffix(".part")
        .make_in(folder, |path| {
            make(path).inspect_err(|error| refusal = error.raw_os_error())
        })
        .map(tempfile::NamedTempFile::into_parts)
        .map_err(|error| refusal.map_or(error, io::Error::from_raw_os_error))
}
