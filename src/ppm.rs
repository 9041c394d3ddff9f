//! The image file, a binary PPM: reserve, map, publish.
//!
//! ```text
//! P6\nWIDTH HEIGHT\n255\n      then 3 bytes a pixel, rows from the top
//! ```
//!
//! There are three ways to an image, and all of them take their rows from one
//! closure, a group of whole rows at a time:
//!
//! | | draws into | appears |
//! | --- | --- | --- |
//! | [`MappedImage`] | a mapped file without a name | under its name, whole, in one step |
//! | [`SharedImage`] | the file itself, some of its rows | at once; several processes may share it |
//! | [`write_image`] | a buffer that is written to a stream | as it is drawn |
//!
//! A file is mapped a window at a time, so neither the addresses nor the memory
//! that a picture takes grow with it. Its blocks are reserved first: a full disk
//! is an error to report, not a signal to die of.

#[cfg(feature = "program")]
use std::ffi::CString;
use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    ops::Range,
    os::{
        fd::AsRawFd,
        unix::{
            ffi::OsStrExt,
            fs::{FileExt, MetadataExt, OpenOptionsExt, PermissionsExt},
        },
    },
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant},
};

use rustix::{
    fs::{Access, AtFlags, CWD, FallocateFlags, Mode, OFlags},
    io::Errno,
};
use tempfile::TempPath;

use crate::camera::ImageSize;

/// The header of a binary PPM of this size.
#[must_use]
pub fn header(size: ImageSize) -> String {
    format!("P6\n{} {}\n255\n", size.width(), size.height())
}

/// Bytes of the whole file.
fn file_bytes(size: ImageSize) -> u64 {
    (header(size).len() + size.pixel_bytes()) as u64
}

/// Bytes of a mapping: enough that its making is not felt, little beside the
/// memory of any machine.
const WINDOW_BYTES: usize = 64 << 20;

/// What a huge page holds.
const HUGE_PAGE: u64 = 2 << 20;

/// Bytes of the buffer of a stream.
const BUFFER_BYTES: usize = 16 << 20;

/// Why an image can't be written. The message names the file and what would
/// mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The name is that of a directory.
    #[error("{}: this is a directory; name a file in it", path.display())]
    Directory {
        /// The name asked for.
        path: PathBuf,
    },
    /// The name is that of a device, a socket or another thing that can't be
    /// mapped or replaced.
    #[error("{}: this is neither a file nor a stream; name another file", path.display())]
    NotAFile {
        /// The name asked for.
        path: PathBuf,
    },
    /// An image is there already, and may not be written.
    #[error(
        "{}: this file is write-protected, and is left as it is; name another file, or allow it with chmod u+w",
        path.display()
    )]
    WriteProtected {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file whose rows were to be drawn is not a picture of this size.
    #[error(
        "{}: this file is not a {} x {} picture ({found}), and is left as it is; name another file, or move it away",
        path.display(), size.width(), size.height()
    )]
    OtherPicture {
        /// The file.
        path: PathBuf,
        /// The size asked for.
        size: ImageSize,
        /// What it is instead.
        found: String,
    },
    /// The operating system refused.
    #[error("{}: can't {action}: {}{}", path.display(), reason(source), remedy(source))]
    System {
        /// The file.
        path: PathBuf,
        /// What was refused.
        action: &'static str,
        /// Why.
        source: io::Error,
    },
}

/// The words of the operating system, without the number of the error.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((words, _)) => words.to_lowercase(),
        None => text,
    }
}

/// What a user can do about an error of the operating system.
fn remedy(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::NOSPC | Errno::DQUOT) => {
            "; free some space, or name a file on another file system"
        }
        Some(Errno::FBIG) => {
            "; raise the limit on file sizes (ulimit -f), or name a file on a file system without one"
        }
        Some(Errno::NOMEM) => "; raise the limit on addresses (ulimit -v), or free some memory",
        Some(Errno::NOENT) => "; make the directory first, or name another",
        Some(Errno::NOTDIR) => "; a part of the path is not a directory",
        Some(Errno::ACCESS | Errno::PERM) => {
            "; ask for permission to write there, or name a file in another directory"
        }
        Some(Errno::ROFS) => "; name a file on a file system that can be written",
        Some(Errno::NAMETOOLONG) => "; choose a shorter name",
        Some(Errno::LOOP) => "; the symbolic links run in a circle",
        Some(Errno::MFILE | Errno::NFILE) => "; raise the limit on open files (ulimit -n)",
        _ => "",
    }
}

/// Turns an error into one about a file: `.map_err(refused(path, "open it"))`.
fn refused<E: Into<io::Error>>(path: &Path, action: &'static str) -> impl FnOnce(E) -> ImageError {
    move |error| ImageError::System {
        path: path.to_owned(),
        action,
        source: error.into(),
    }
}

/// A new image: a file without a name until it is complete.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::MappedImage, render::{Form, Method, Renderer}, scene::Scene};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("ball.ppm");
/// let scene = Scene::parse(b"VP 1 1 1 BG 255 255 255 OBJ_N 1 S 0 0 5 1 200 0 0")?;
/// let size = ImageSize::new(64, 48)?;
/// let renderer = Renderer::new(&scene, size, Method::default(), Form::default());
///
/// let mut image = MappedImage::create(&path, size)?;
/// image.draw(|rows, pixels| {
///     renderer.draw(rows, pixels, &|_| ());
/// })?;
/// assert!(!path.exists());
/// image.publish()?;
/// assert!(std::fs::read(&path)?.starts_with(b"P6\n64 48\n255\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MappedImage {
    rows: Rows,
    draft: Draft,
}

impl MappedImage {
    /// Reserves the blocks of an image that is to appear at `path`. Where `path`
    /// is a symbolic link, its target is what will be made or replaced.
    ///
    /// # Errors
    ///
    /// If the image could not be made or replaced there, or there is no room.
    pub fn create(path: &Path, size: ImageSize) -> Result<Self, ImageError> {
        let target = follow(path)?;
        may_replace(&target)?;
        let (file, draft) = Draft::create(&target)?;
        reserve(&file, file_bytes(size)).map_err(refused(&target, RESERVE))?;
        Ok(Self {
            rows: Rows {
                file,
                path: target,
                size,
                mapped: true,
                whole: true,
            },
            draft,
        })
    }

    /// The name under which the unfinished image can be seen, where the file
    /// system has no files without one. It is removed when this is dropped, and
    /// left behind when the process is killed.
    #[must_use]
    pub fn temporary_name(&self) -> Option<&Path> {
        match &self.draft {
            Draft::Unnamed => None,
            Draft::Named(name) => Some(name),
        }
    }

    /// Hands all rows to `draw`, a group at a time, with the bytes of their pixels.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped.
    pub fn draw(&mut self, draw: impl FnMut(Range<u32>, &mut [u8])) -> Result<(), ImageError> {
        self.rows.draw(0..self.rows.size.height(), draw)
    }

    /// Makes the image appear under its name, in one step. A file that was there
    /// is replaced, and hands on its permissions.
    ///
    /// # Errors
    ///
    /// If the file can't be given its name; what was there before is untouched.
    pub fn publish(self) -> Result<(), ImageError> {
        let Rows {
            file, path, size, ..
        } = self.rows;
        // The header comes last: written first, its small page would keep the
        // file's beginning from being had as a huge one.
        file.write_all_at(header(size).as_bytes(), 0)
            .map_err(refused(&path, "write it"))?;
        if let Ok(before) = fs::metadata(&path) {
            keep_permissions(&file, &before).map_err(refused(&path, "keep its permissions"))?;
        }
        self.draft.publish(&file, &path)
    }
}

/// An image of which some rows are drawn in place, by any number of processes
/// in any order.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::{self, ImageError, SharedImage}};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("halves.ppm");
/// let size = ImageSize::new(2, 2)?;
/// for (rows, colour) in [(1..2, 30), (0..1, 10)] {
///     SharedImage::open(&path, size)?.draw(rows, |_, pixels| pixels.fill(colour))?;
/// }
/// ppm::read_rows(&path, size, 0..2, |_, pixels| {
///     assert_eq!(pixels, [10, 10, 10, 10, 10, 10, 30, 30, 30, 30, 30, 30]);
///     Ok::<(), ImageError>(())
/// })?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SharedImage {
    rows: Rows,
}

impl SharedImage {
    /// Opens the picture of this size at `path`; makes and reserves a black one
    /// where there is none. Of several processes that find none, one makes it.
    ///
    /// # Errors
    ///
    /// If there is something else at `path`, or no room.
    pub fn open(path: &Path, size: ImageSize) -> Result<Self, ImageError> {
        let target = follow(path)?;
        may_replace(&target)?;
        let open = || OpenOptions::new().read(true).write(true).open(&target);
        let opened = match open() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Self::make(&target, size)?;
                open()
            }
            opened => opened,
        };
        let file = opened.map_err(refused(&target, "open it"))?;
        check_picture(&file, &target, size)?;
        // It may have come from elsewhere and have holes.
        match retried(|| rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, file_bytes(size)))
        {
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => {}
            Err(error) => return Err(refused(&target, RESERVE)(error)),
        }
        let mapped = shares_pages(&file);
        Ok(Self {
            rows: Rows {
                file,
                path: target,
                size,
                mapped,
                whole: false,
            },
        })
    }

    /// Makes a black picture appear whole at `path`, unless something else
    /// does meanwhile.
    fn make(path: &Path, size: ImageSize) -> Result<(), ImageError> {
        let _turn = turn_to_make(path);
        if path.exists() {
            return Ok(());
        }
        let (file, draft) = Draft::create(path)?;
        reserve(&file, file_bytes(size)).map_err(refused(path, RESERVE))?;
        file.write_all_at(header(size).as_bytes(), 0)
            .map_err(refused(path, "write it"))?;
        draft.publish_if_absent(&file, path)
    }

    /// Hands `rows` to `draw`, a group at a time, with the bytes of their pixels.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written.
    pub fn draw(
        &mut self,
        rows: Range<u32>,
        draw: impl FnMut(Range<u32>, &mut [u8]),
    ) -> Result<(), ImageError> {
        self.rows.draw(rows, draw)
    }
}

/// Reads the pixels of `rows` from the picture at `path`, a group at a time.
///
/// # Errors
///
/// If the file can't be read or is not a picture of this size, or at the first
/// error of `look`.
pub fn read_rows<E: From<ImageError>>(
    path: &Path,
    size: ImageSize,
    rows: Range<u32>,
    mut look: impl FnMut(Range<u32>, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let file = File::open(path).map_err(refused(path, "open it"))?;
    check_picture(&file, path, size)?;
    let mut buffer = Vec::new();
    for group in groups(size, rows, BUFFER_BYTES) {
        buffer.resize(group.len() * size.row_bytes(), 0);
        file.read_exact_at(&mut buffer, offset(size, group.start))
            .map_err(refused(path, "read it"))?;
        look(group, &buffer)?;
    }
    Ok(())
}

/// Writes a whole image to a stream, a group of rows at a time.
///
/// ```
/// use sfera::{camera::ImageSize, ppm};
///
/// let mut stream = Vec::new();
/// ppm::write_image(&mut stream, ImageSize::new(2, 1)?, |_rows, pixels| pixels.fill(9))?;
/// assert_eq!(stream, b"P6\n2 1\n255\n\t\t\t\t\t\t");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// If the stream can't be written.
pub fn write_image(
    stream: &mut impl Write,
    size: ImageSize,
    mut draw: impl FnMut(Range<u32>, &mut [u8]),
) -> io::Result<()> {
    stream.write_all(header(size).as_bytes())?;
    let mut buffer = Vec::new();
    for group in groups(size, 0..size.height(), BUFFER_BYTES) {
        buffer.resize(group.len() * size.row_bytes(), 0);
        draw(group, &mut buffer);
        stream.write_all(&buffer)?;
    }
    stream.flush()
}

/// A file of reserved blocks, and how its rows are had.
#[derive(Debug)]
struct Rows {
    file: File,
    path: PathBuf,
    size: ImageSize,
    /// Mapped, or else written byte by byte.
    mapped: bool,
    /// All of the file is drawn by this process, so what lies about some rows
    /// may be mapped with them.
    whole: bool,
}

impl Rows {
    fn draw(
        &self,
        rows: Range<u32>,
        mut draw: impl FnMut(Range<u32>, &mut [u8]),
    ) -> Result<(), ImageError> {
        let mut buffer = Vec::new();
        let bytes = if self.mapped {
            WINDOW_BYTES
        } else {
            BUFFER_BYTES
        };
        for group in groups(self.size, rows, bytes) {
            let (start, length) = (
                offset(self.size, group.start),
                group.len() * self.size.row_bytes(),
            );
            if self.mapped {
                let window = if self.whole {
                    // Pages at the ends of a window that is cut through a huge one are had
                    // one by one, and each time all of the huge one is gone through.
                    let first = start - start % HUGE_PAGE;
                    let last = (start + length as u64).next_multiple_of(HUGE_PAGE);
                    first..last.min(file_bytes(self.size))
                } else {
                    start..start + length as u64
                };
                let before = (start - window.start) as usize;
                let mut window = map(&self.file, window).map_err(refused(&self.path, "map it"))?;
                draw(group, &mut window[before..before + length]);
            } else {
                buffer.resize(length, 0);
                draw(group, &mut buffer);
                self.file
                    .write_all_at(&buffer, start)
                    .map_err(refused(&self.path, "write it"))?;
            }
        }
        Ok(())
    }
}

#[expect(unsafe_code, reason = "a mapped image is what this module is for")]
fn map(file: &File, window: Range<u64>) -> io::Result<memmap2::MmapMut> {
    // SAFETY: nobody else may change these bytes or take them away.
    // - A new image has no name (or one made up for it), so no other process
    //   knows it; this one maps a window at a time, and nothing else of it.
    // - A shared image is mapped for rows that the user gave to this process.
    //   One that is given the same rows stores the same bytes, and the drawing
    //   only stores bytes, never asks what they are.
    // - The blocks are reserved, so no store finds the disk full. Whoever
    //   shortens the file all the same ends this process with SIGBUS, which is
    //   defined, and which `exit_when_lost` turns into a message.
    let window = unsafe {
        memmap2::MmapOptions::new()
            .offset(window.start)
            .len((window.end - window.start) as usize)
            .map_mut(file)
    }?;
    // Only advice: a kernel without huge pages draws the same picture.
    let _ = window.advise(memmap2::Advice::HugePage);
    Ok(window)
}

/// Ends the process with `message` and exit code 1 if a mapped image is taken
/// away under it: shortened by another process, or its disk gone. `temporary`
/// is removed first. For programs, not libraries: it is the process's handler
/// of `SIGBUS` from then on.
///
/// # Errors
///
/// If there can be no such handler.
#[cfg(feature = "program")]
#[expect(
    unsafe_code,
    reason = "a signal is how the system tells of a lost page"
)]
pub fn exit_when_lost(message: String, temporary: Option<&Path>) -> io::Result<()> {
    let temporary = temporary.and_then(|path| CString::new(path.as_os_str().as_bytes()).ok());
    let action = move || {
        if let Some(name) = &temporary {
            let _ = rustix::fs::unlink(name.as_c_str());
        }
        let _ = rustix::io::write(rustix::stdio::stderr(), message.as_bytes());
        signal_hook::low_level::exit(1);
    };
    // SAFETY: the action does three system calls on memory made beforehand;
    // it takes no lock and allocates nothing.
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGBUS, action) }?;
    Ok(())
}

/// Where an image is until it has its name.
#[derive(Debug)]
enum Draft {
    Unnamed,
    Named(TempPath),
}

impl Draft {
    fn create(target: &Path) -> Result<(File, Self), ImageError> {
        let folder = folder_of(target);
        let unnamed = rustix::fs::open(
            folder,
            OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC,
            Mode::from_raw_mode(0o666),
        );
        if let Ok(file) = unnamed {
            let file = File::from(file);
            // Without /proc there would be no way to give it a name.
            if rustix::fs::access(descriptor_path(&file), Access::EXISTS).is_ok() {
                return Ok((file, Self::Unnamed));
            }
        }
        let (file, name) = under_temporary_name(folder, |path| {
            OpenOptions::new()
                .read(true)
                .write(true)
                .create_new(true)
                .mode(0o666)
                .open(path)
        })
        .map_err(refused(target, "make a file in its directory"))?;
        Ok((file, Self::Named(name)))
    }

    fn publish(self, file: &File, target: &Path) -> Result<(), ImageError> {
        let name = match self {
            Self::Named(name) => name,
            Self::Unnamed => match link(file, target) {
                Ok(()) => return Ok(()),
                // Only a rename replaces, and only a name can be renamed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    under_temporary_name(folder_of(target), |path| link(file, path))
                        .map_err(refused(target, NAME))?
                        .1
                }
                Err(error) => return Err(refused(target, NAME)(error)),
            },
        };
        name.persist(target)
            .map_err(|error| refused(target, NAME)(error.error))
    }

    fn publish_if_absent(self, file: &File, target: &Path) -> Result<(), ImageError> {
        let published = match self {
            Self::Named(name) => name.persist_noclobber(target).map_err(|error| error.error),
            Self::Unnamed => link(file, target),
        };
        match published {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                Err(refused(target, NAME)(error))
            }
            _ => Ok(()),
        }
    }
}

const RESERVE: &str = "reserve its blocks";
const NAME: &str = "give it its name";

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

fn descriptor_path(file: &File) -> String {
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

/// Gives a file without a name its first.
fn link(file: &File, name: &Path) -> io::Result<()> {
    rustix::fs::linkat(
        CWD,
        descriptor_path(file),
        CWD,
        name,
        AtFlags::SYMLINK_FOLLOW,
    )?;
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file that a path of symbolic links ends at, whether it is there or not.
fn follow(path: &Path) -> Result<PathBuf, ImageError> {
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
    Err(refused(path, "follow it")(Errno::LOOP))
}

/// Refuses what must not be replaced: all but plain files that their permissions
/// allow to be written. Asking the permissions and not only the system keeps
/// root, who may do everything, from replacing a file that is protected on purpose.
fn may_replace(target: &Path) -> Result<(), ImageError> {
    let path = target.to_owned();
    let Ok(metadata) = fs::metadata(target) else {
        return if target.as_os_str().as_bytes().ends_with(b"/") {
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
    let anybody_may = metadata.permissions().mode() & 0o222 != 0;
    match rustix::fs::accessat(CWD, target, Access::WRITE_OK, AtFlags::EACCESS) {
        Ok(()) if anybody_may => Ok(()),
        Ok(()) | Err(Errno::ACCESS | Errno::PERM) => Err(ImageError::WriteProtected { path }),
        Err(error) => Err(refused(target, "write it")(error)),
    }
}

/// The permissions and, where that is allowed, the owner of the file replaced.
fn keep_permissions(file: &File, before: &fs::Metadata) -> io::Result<()> {
    let now = file.metadata()?;
    if (now.uid(), now.gid()) != (before.uid(), before.gid()) {
        let _ = std::os::unix::fs::fchown(file, Some(before.uid()), Some(before.gid()));
    }
    let mode = before.permissions().mode() & 0o777;
    if now.permissions().mode() & 0o777 != mode {
        file.set_permissions(fs::Permissions::from_mode(mode))?;
    }
    Ok(())
}

/// Reserves every block of a new file: by asking for them or, where a file
/// system can't be asked, by writing zeros.
fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    match retried(|| rustix::fs::fallocate(file, FallocateFlags::empty(), 0, bytes)) {
        Err(Errno::OPNOTSUPP | Errno::NOSYS) => write_zeros(file, bytes),
        reserved => Ok(reserved?),
    }
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

/// Again, as long as a signal comes between.
fn retried<T>(mut call: impl FnMut() -> Result<T, Errno>) -> Result<T, Errno> {
    loop {
        match call() {
            Err(Errno::INTR) => {}
            result => return result,
        }
    }
}

/// That a file is the picture of this size, by its length and header.
fn check_picture(file: &File, path: &Path, size: ImageSize) -> Result<(), ImageError> {
    let other = |found: String| ImageError::OtherPicture {
        path: path.to_owned(),
        size,
        found,
    };
    let metadata = file.metadata().map_err(refused(path, "ask its size"))?;
    if !metadata.is_file() {
        return Err(ImageError::NotAFile {
            path: path.to_owned(),
        });
    }
    let (length, expected) = (metadata.len(), file_bytes(size));
    if length != expected {
        return Err(other(format!("{length} bytes instead of {expected}")));
    }
    let header = header(size);
    let mut start = vec![0; header.len()];
    file.read_exact_at(&mut start, 0)
        .map_err(refused(path, "read it"))?;
    if start != header.as_bytes() {
        return Err(other(format!(
            "it begins \"{}\" instead of \"{}\"",
            start.escape_ascii(),
            header.as_bytes().escape_ascii()
        )));
    }
    Ok(())
}

/// Whether all processes that map a file see the same pages of it. On network
/// file systems they may not: a machine that writes a page back overwrites what
/// another wrote into the rest of it. There rows are written, to the byte.
fn shares_pages(file: &File) -> bool {
    const LOCAL: [u32; 8] = [
        0xef53,      // ext2, ext3, ext4
        0x0102_1994, // tmpfs
        0x5846_5342, // xfs
        0x9123_683e, // btrfs
        0x794c_7630, // overlayfs
        0x2fc1_2fc1, // zfs
        0xf2f5_2010, // f2fs
        0xca45_1a4e, // bcachefs
    ];
    rustix::fs::fstatfs(file).is_ok_and(|system| LOCAL.contains(&(system.f_type as u32)))
}

/// A lock on the directory while a shared image is made in it, so that many
/// processes that start together don't each reserve a whole picture. It only
/// saves room: without it, or after waiting too long, nothing goes wrong.
fn turn_to_make(path: &Path) -> Option<File> {
    const PATIENCE: Duration = Duration::from_secs(10);
    let folder = File::open(folder_of(path)).ok()?;
    let start = Instant::now();
    loop {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) if start.elapsed() < PATIENCE && !path.exists() => {
                thread::sleep(Duration::from_millis(2));
            }
            Err(_) => return None,
        }
    }
}

/// Where the pixels of a row begin in the file.
fn offset(size: ImageSize, row: u32) -> u64 {
    header(size).len() as u64 + u64::from(row) * size.row_bytes() as u64
}

/// Rows that tiles of any size are whole in.
const WHOLE_TILES: usize = 64;

/// Splits `rows` evenly into groups of at most `bytes`, but at least one row;
/// where there is room for it, between rows of tiles.
fn groups(size: ImageSize, rows: Range<u32>, bytes: usize) -> impl Iterator<Item = Range<u32>> {
    let most = (bytes / size.row_bytes()).max(1);
    let count = rows.len().div_ceil(most).max(1);
    let mut each = rows.len().div_ceil(count).max(1);
    if count > 1 && most >= WHOLE_TILES {
        each = each
            .next_multiple_of(WHOLE_TILES)
            .min(most - most % WHOLE_TILES);
    }
    rows.clone()
        .step_by(each)
        .map(move |first| first..first.saturating_add(each as u32).min(rows.end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(width: u32, height: u32) -> ImageSize {
        ImageSize::new(width, height).expect("a size with pixels")
    }

    #[test]
    fn groups_are_all_rows_once_and_fit() {
        for (width, height) in [
            (1, 1),
            (1, 5000),
            (5000, 1),
            (640, 480),
            (99, 1031),
            (4000, 3),
        ] {
            let size = size(width, height);
            for bytes in [1, 3, 1000, 64 * size.row_bytes(), 200_000, usize::MAX] {
                let mut next = 0;
                for group in groups(size, 0..height, bytes) {
                    assert_eq!(group.start, next);
                    assert!(group.len() == 1 || group.len() * size.row_bytes() <= bytes);
                    next = group.end;
                }
                assert_eq!(next, height, "{width} x {height} by {bytes}");
            }
        }
        assert_eq!(groups(size(4, 4), 2..3, 1).last(), Some(2..3));
    }

    #[test]
    fn the_last_row_there_can_be_is_drawn() {
        let size = size(1, u32::MAX);
        let last = groups(size, u32::MAX - 5..u32::MAX, 6).last();
        assert_eq!(last.map(|group| group.end), Some(u32::MAX));
        assert_eq!(
            offset(size, u32::MAX - 1),
            20 + 3 * (u64::from(u32::MAX) - 1)
        );
    }

    /// As on a network file system, where rows are written and not mapped.
    #[test]
    fn written_rows_are_the_bytes_of_mapped_ones() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let size = size(7, 5);
        let bytes = [true, false].map(|mapped| {
            let path = folder.path().join(format!("{mapped}.ppm"));
            let mut image = SharedImage::open(&path, size)?;
            image.rows.mapped = mapped;
            image.draw(1..4, |rows, pixels| pixels.fill(rows.start as u8 + 1))?;
            fs::read(&path).map_err(refused(&path, "read it"))
        });
        let [mapped, written] = bytes;
        assert_eq!(mapped?, written?);
        Ok(())
    }

    /// Windows begin anywhere in the file, not only where pages do.
    #[test]
    fn windows_join_without_a_seam() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("image.ppm");
        // More than one window.
        let size = size(8191, 3000);
        let mut image = MappedImage::create(&path, size)?;
        let mut windows = 0;
        image.draw(|rows, pixels| {
            windows += 1;
            for (row, bytes) in rows.zip(pixels.chunks_exact_mut(size.row_bytes())) {
                bytes.fill(row as u8);
            }
        })?;
        image.publish()?;
        assert!(windows > 1);
        read_rows(&path, size, 0..3000, |rows, pixels| {
            for (row, bytes) in rows.zip(pixels.chunks_exact(size.row_bytes())) {
                assert!(bytes.iter().all(|&byte| byte == row as u8), "row {row}");
            }
            Ok::<(), ImageError>(())
        })?;
        Ok(())
    }
}
