//! An image of which some rows are drawn in place.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    ops::Range,
    path::Path,
    thread,
    time::{Duration, Instant},
};

use super::{
    draft::Draft,
    errors::{ImageError, LOOK, OPEN, RESERVE, WRITE, refused},
    event::{Event, Watch},
    format::{check_picture, file_bytes, header},
    rows::Rows,
    system,
    target::{Target, folder_of, if_there},
};
use crate::camera::ImageSize;

/// An image of which some rows are drawn in place, by any number of processes
/// in any order.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::{Picture, SharedImage}};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("halves.ppm");
/// let size = ImageSize::new(2, 2)?;
/// for (rows, colour) in [(1..2, 30), (0..1, 10)] {
///     SharedImage::open(&path, size)?.draw(rows, |_, pixels| pixels.fill(colour))?;
/// }
/// let mut pixels = [0; 12];
/// Picture::open(&path, size, 0)?.read(&mut pixels)?;
/// assert_eq!(pixels, [10, 10, 10, 10, 10, 10, 30, 30, 30, 30, 30, 30]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SharedImage {
    rows: Rows,
}

impl SharedImage {
    /// Opens the picture of this size at `path`. If there is none, makes a black one and
    /// reserves its blocks. If several processes find none, one of them makes it.
    ///
    /// # Errors
    ///
    /// If there is something else at `path`, or no room.
    pub fn open(path: impl AsRef<Path>, size: ImageSize) -> Result<Self, ImageError> {
        Self::open_watched(path, size, |_| ())
    }

    /// Like [`open`](Self::open), and calls `watch` while it waits for another process, and
    /// with the temporary name of a new picture.
    ///
    /// # Errors
    ///
    /// If there is something else at `path`, or no room.
    pub fn open_watched(
        path: impl AsRef<Path>,
        size: ImageSize,
        watch: Watch,
    ) -> Result<Self, ImageError> {
        let path = path.as_ref();
        let mut target = Target::find(path)?;
        if target.found.is_none() {
            Self::make(&target.path, size, watch)?;
            target = Target::find(path)?;
        }
        let path = target.path;
        let file = OpenOptions::new().read(true).write(true).open(&path);
        let file = file.map_err(refused(&path, OPEN))?;
        check_picture(&file, &path, size)?;
        let rows = Rows::reserve(file, &path, size, false)?;
        Ok(Self { rows })
    }

    /// Makes a black picture appear whole at `path`, unless something else appears there
    /// meanwhile.
    fn make(path: &Path, size: ImageSize, watch: Watch) -> Result<(), ImageError> {
        let _lock = lock_folder(path, watch);
        if is_there(path) {
            return Ok(());
        }
        let (file, draft) = Draft::create(path, false, watch)?;
        let bytes = file_bytes(size);
        if !system::reserve(&file, bytes).map_err(refused(path, RESERVE))? {
            system::write_zeros(&file, bytes).map_err(refused(path, RESERVE))?;
        }
        system::write_at(&file, header(size).as_bytes(), 0).map_err(refused(path, WRITE))?;
        // The next process must be able to draw in it.
        system::make_writable(&file).map_err(refused(path, "make it writable"))?;
        draft.publish_if_absent(&file, path)
    }

    /// Calls `draw` with each group of `rows` and the bytes of their pixels.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written, or was removed or replaced meanwhile.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image.
    pub fn draw(
        &mut self,
        rows: Range<u32>,
        mut draw: impl FnMut(Range<u32>, &mut [u8]),
    ) -> Result<(), ImageError> {
        self.try_draw(rows, |rows, pixels| {
            draw(rows, pixels);
            Ok(())
        })
    }

    /// Like [`draw`](Self::draw), and ends with the first error of `draw`. Rows that were
    /// handed to it have changed by then.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written, or has lost its name meanwhile, or `draw`
    /// fails.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image.
    pub fn try_draw<E: From<ImageError>>(
        &mut self,
        rows: Range<u32>,
        draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.rows.draw(rows, draw)?;
        let Rows { file, path, .. } = &self.rows;
        system::settle(file).map_err(refused(path, WRITE))?;
        Ok(self.still_has_its_name()?)
    }

    /// Fails if the file was removed or replaced, because then its rows are lost.
    fn still_has_its_name(&self) -> Result<(), ImageError> {
        let Rows { file, path, .. } = &self.rows;
        let drawn = file.metadata().map_err(refused(path, LOOK))?;
        let named = if_there(fs::symlink_metadata(path)).map_err(refused(path, LOOK))?;
        if named.is_some_and(|named| system::is_same(&named, &drawn)) {
            return Ok(());
        }
        Err(ImageError::Changed {
            path: path.clone(),
            what: "the file was removed or replaced",
        })
    }
}

/// How long a process waits at most for another one to make a picture.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long it waits before it reports that.
const SILENCE: Duration = Duration::from_secs(1);

/// Whether no picture need be made. Errors are reported when it is opened.
fn is_there(path: &Path) -> bool {
    path.try_exists().unwrap_or(true)
}

/// Locks the directory while a shared image is made in it, so that processes that start
/// together don't each reserve a whole picture. The lock only saves room: without it, or
/// after waiting too long, the result is the same.
fn lock_folder(path: &Path, watch: Watch) -> Option<File> {
    let folder = folder_of(path);
    let lock = File::open(folder).ok()?;
    let start = Instant::now();
    let mut reported = false;
    loop {
        match lock.try_lock() {
            Ok(()) => return Some(lock),
            Err(TryLockError::WouldBlock) if start.elapsed() < PATIENCE && !is_there(path) => {
                if !reported && start.elapsed() > SILENCE {
                    watch(Event::Waiting(folder));
                    reported = true;
                }
                thread::sleep(Duration::from_millis(2));
            }
            Err(_) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[test]
    fn waiting_is_reported_once_after_a_second() -> Result<(), Box<dyn std::error::Error>> {
        static REPORTS: AtomicU32 = AtomicU32::new(0);
        fn watch(event: Event<'_>) {
            if matches!(event, Event::Waiting(_)) {
                REPORTS.fetch_add(1, Ordering::Relaxed);
            }
        }
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("absent.ppm");
        let lock = File::open(folder.path())?;
        lock.lock()?;
        let start = Instant::now();
        let waiting = thread::spawn(move || lock_folder(&path, watch).is_some());
        while REPORTS.load(Ordering::Relaxed) == 0 && !waiting.is_finished() {
            thread::sleep(Duration::from_millis(2));
        }
        assert!(start.elapsed() >= SILENCE);
        thread::sleep(Duration::from_millis(50));
        drop(lock);
        assert!(waiting.join().is_ok_and(|locked| locked));
        assert_eq!(REPORTS.load(Ordering::Relaxed), 1);
        Ok(())
    }

    #[test]
    fn nobody_waits_for_a_picture_that_is_there() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("there.ppm");
        File::create(&path)?;
        let lock = File::open(folder.path())?;
        lock.lock()?;
        let start = Instant::now();
        assert!(lock_folder(&path, |_| ()).is_none());
        assert!(start.elapsed() < PATIENCE);
        Ok(())
    }

    /// As on a network file system, where rows are written instead of mapped.
    #[test]
    fn written_rows_are_the_bytes_of_mapped_ones() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let size = ImageSize::new(7, 5)?;
        let bytes = [true, false].map(|mapped| {
            let path = folder.path().join(format!("{mapped}.ppm"));
            let mut image = SharedImage::open(&path, size)?;
            image.rows.mapped = mapped;
            image.draw(1..4, |rows, pixels| pixels.fill(rows.start as u8 + 1))?;
            std::fs::read(&path).map_err(refused(&path, "read it"))
        });
        let [mapped, written] = bytes;
        assert_eq!(mapped?, written?);
        Ok(())
    }
}
