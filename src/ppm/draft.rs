//! The file that an image is drawn into until it is published.

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
};

use tempfile::TempPath;

use super::{
    errors::{ImageError, NAME, refused},
    event::{Event, Watch},
    system,
    target::{Target, folder_of},
};

/// A file without a name or, where the file system has no such files, one with a
/// temporary name.
#[derive(Debug)]
pub(super) struct Draft {
    name: Option<TemporaryName>,
    watch: Watch,
}

impl Draft {
    /// Makes a file for `target`. If `private`, only its owner can use it until it has
    /// the permissions of the file that it replaces.
    pub(super) fn create(
        target: &Path,
        private: bool,
        watch: Watch,
    ) -> Result<(File, Self), ImageError> {
        let folder = folder_of(target);
        let lock = system::attributes(folder).lock();
        if lock != Some('i')
            && let Some(file) = system::unnamed_file(folder, private)
        {
            return Ok((file, Self { name: None, watch }));
        }
        if let Some(attribute) = lock {
            return Err(ImageError::LockedDirectory {
                path: target.to_owned(),
                attribute,
            });
        }
        let (file, name) =
            TemporaryName::make(folder, watch, |path| system::new_file(path, private)).map_err(
                |error| {
                    if system::lacks_inodes(folder, &error) {
                        ImageError::NoInodes {
                            path: target.to_owned(),
                        }
                    } else {
                        refused(target, "make a file in its directory")(error)
                    }
                },
            )?;
        let name = Some(name);
        Ok((file, Self { name, watch }))
    }

    /// Gives the file the name of `target`, in one step. Before that, `pass_on` gives it
    /// the permissions of the file that has this name, and returns whether there is one.
    pub(super) fn publish(
        self,
        file: &File,
        target: &Target,
        pass_on: impl Fn() -> Result<bool, ImageError>,
    ) -> Result<(), ImageError> {
        let path = &target.path;
        let there = pass_on()?;
        if let Some(name) = self.name {
            return name.rename(path);
        }
        if !there {
            match system::link(file, path) {
                Ok(()) => return Ok(()),
                // Another process has made it meanwhile.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    pass_on()?;
                }
                Err(error) => return Err(refused(path, NAME)(error)),
            }
        }
        // Only a rename replaces a file, and only a file with a name can be renamed.
        let ((), name) =
            TemporaryName::make(folder_of(path), self.watch, |path| system::link(file, path))
                .map_err(refused(path, NAME))?;
        name.rename(path)
    }

    /// Gives the file the name of `target`, unless something has that name.
    pub(super) fn publish_if_absent(self, file: &File, target: &Path) -> Result<(), ImageError> {
        let published = match self.name {
            Some(name) => name.rename_if_absent(target),
            None => system::link(file, target),
        };
        match published {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                Err(refused(target, NAME)(error))
            }
            _ => Ok(()),
        }
    }
}

/// A name that the file has at most until it is published.
#[derive(Debug)]
struct TemporaryName {
    path: TempPath,
    /// Open as long as the path goes through its descriptor.
    _folder: Option<File>,
}

impl TemporaryName {
    /// Makes a file under a temporary name in `folder`.
    fn make<F>(
        folder: &Path,
        watch: Watch,
        mut make: impl FnMut(&Path) -> io::Result<F>,
    ) -> io::Result<(F, Self)> {
        let mut make = |path: &Path| {
            watch(Event::Temporary(path));
            make(path)
        };
        let made = temporary_name(folder, &mut make);
        let (made, folder) = match made {
            // The directory's own name may be so long that no name in it can be used.
            Err(error) if error.kind() == io::ErrorKind::InvalidFilename => {
                let Some((open, short)) = system::short_name(folder) else {
                    return Err(error);
                };
                (temporary_name(&short, &mut make)?, Some(open))
            }
            made => (made?, None),
        };
        let (file, path) = made;
        let name = Self {
            path,
            _folder: folder,
        };
        Ok((file, name))
    }

    fn rename(self, target: &Path) -> Result<(), ImageError> {
        let Err(refusal) = self.path.persist(target) else {
            return Ok(());
        };
        let temporary: PathBuf = refusal.path.to_path_buf();
        Err(match refusal.path.close() {
            Ok(()) => refused(target, NAME)(refusal.error),
            Err(_) => ImageError::Stranded {
                path: target.to_owned(),
                temporary,
                source: refusal.error,
            },
        })
    }

    fn rename_if_absent(self, target: &Path) -> io::Result<()> {
        self.path
            .persist_noclobber(target)
            .map_err(|error| error.error)
    }
}

fn temporary_name<F>(
    folder: &Path,
    mut make: impl FnMut(&Path) -> io::Result<F>,
) -> io::Result<(F, TempPath)> {
    // The system's own error, because that of tempfile would name the temporary file.
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::{
        cell::Cell,
        sync::atomic::{AtomicU32, Ordering},
    };

    use super::*;

    #[test]
    fn a_file_that_is_there_is_not_replaced_and_other_errors_are_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let there = folder.path().join("there.ppm");
        std::fs::write(&there, "another process's").expect("a file");
        let publish_at = |target: &Path| {
            let (file, draft) = Draft::create(&there, false, |_| ()).expect("a draft");
            draft.publish_if_absent(&file, target)
        };
        publish_at(&there).expect("no error");
        assert_eq!(std::fs::read(&there).expect("it"), b"another process's");
        assert!(publish_at(&folder.path().join("no folder/image.ppm")).is_err());
        let absent = folder.path().join("absent.ppm");
        publish_at(&absent).expect("no error");
        assert!(absent.exists());
    }

    #[test]
    fn only_a_file_that_replaces_another_has_a_temporary_name() {
        static NAMES: AtomicU32 = AtomicU32::new(0);
        fn watch(_: Event<'_>) {
            NAMES.fetch_add(1, Ordering::Relaxed);
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("image.ppm");
        for names in 0..2 {
            let target = Target::find(&path).expect("a target");
            let (file, draft) = Draft::create(&path, false, watch).expect("a draft");
            if draft.name.is_some() {
                eprintln!("skipped: no files without a name here");
                return;
            }
            let published = draft.publish(&file, &target, || Ok(target.found.is_some()));
            published.expect("its name");
            assert_eq!(NAMES.load(Ordering::Relaxed), names);
        }
    }

    #[test]
    fn only_a_file_that_appeared_meanwhile_is_a_reason_to_look_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let there = folder.path().join("image.ppm");
        std::fs::write(&there, "another process's").expect("a file");
        for (path, is_published, expected) in [
            (there.clone(), true, 2),
            (folder.path().join("no folder/image.ppm"), false, 1),
        ] {
            let (file, draft) = Draft::create(&there, false, |_| ()).expect("a draft");
            if draft.name.is_some() {
                eprintln!("skipped: no files without a name here");
                return;
            }
            let target = Target { path, found: None };
            let looks = Cell::new(0);
            let published = draft.publish(&file, &target, || {
                looks.set(looks.get() + 1);
                Ok(false)
            });
            assert_eq!(published.is_ok(), is_published);
            assert_eq!(looks.get(), expected);
        }
        assert_eq!(std::fs::read(&there).expect("the new one"), b"");
    }

    #[test]
    fn only_a_name_that_is_too_long_is_made_shorter() {
        let folder = tempfile::tempdir().expect("a folder");
        for (kind, tries) in [
            (io::ErrorKind::StorageFull, 1),
            (io::ErrorKind::InvalidFilename, 2),
        ] {
            let mut paths = Vec::new();
            let made = TemporaryName::make(
                folder.path(),
                |_| (),
                |path| -> io::Result<()> {
                    paths.push(path.to_owned());
                    Err(kind.into())
                },
            );
            assert!(made.is_err_and(|error| error.kind() == kind));
            assert_eq!(paths.len(), tries, "{kind}");
            assert!(paths[0].starts_with(folder.path()));
            assert!(
                paths[1..]
                    .iter()
                    .all(|path| path.starts_with("/proc/self/fd"))
            );
        }
    }
}
