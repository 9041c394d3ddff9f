//! The files and streams that images are written to.

use std::{
    fs::{self, File, OpenOptions},
    io,
    ops::Range,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::Duration,
};

use sfera::{
    camera::ImageSize,
    name::shown,
    ppm::{self, MappedImage, NewFile, Place, SharedImage},
};

use super::{
    arguments::{Job, Mode},
    failure::{Failure, look_up_failed, write_failed},
    messages::tell,
    png, signals, system,
};

/// The files of the command line, checked so that none overwrites another.
#[derive(Debug)]
pub(crate) struct Places {
    /// Files that are read, and their names in messages.
    inputs: Vec<(PathBuf, &'static str)>,
    /// The image to be made; `None` if an existing picture is judged.
    pub(crate) image: Option<Destination>,
    /// The image of `--diff`.
    pub(crate) marks: Option<Destination>,
}

impl Places {
    /// Finds where the images go, and makes sure that they overwrite nothing else.
    pub(crate) fn of(job: &Job) -> Result<Self, Failure> {
        let judged = job.mode() == Mode::Verify;
        let mut inputs = vec![(job.scene.clone(), "the scene itself")];
        if judged {
            inputs.push((job.image.clone(), "the picture that is judged"));
        }
        let destination = |path, index| Destination::of(path, index).map(Some);
        let places = Self {
            inputs,
            image: if judged {
                None
            } else {
                destination(&*job.image, 0)?
            },
            marks: match &job.diff {
                Some(path) => destination(path, 1)?,
                None => None,
            },
        };
        places.check()?;
        Ok(places)
    }

    /// Opens the image to be made.
    pub(crate) fn open_image(&self, job: &Job) -> Result<Output, Failure> {
        match &self.image {
            Some(image) => Output::open(image, job),
            None => Err(Failure::Message("--verify makes no image".into())),
        }
    }

    /// Refuses images that would overwrite an input or one another.
    fn check(&self) -> Result<(), Failure> {
        let mut taken = Vec::new();
        for (path, what) in &self.inputs {
            taken.extend(place_of_input(path)?.map(|place| (place, *what)));
        }
        for destination in [&self.image, &self.marks].into_iter().flatten() {
            let Some(place) = destination.place()? else {
                continue;
            };
            if let Some((_, what)) = taken.iter().find(|(other, _)| *other == place) {
                return Err(Failure::Message(format!(
                    "{}: this is {what}; give the image another name",
                    shown(&destination.path)
                )));
            }
            taken.push((place, "the other image too"));
        }
        Ok(())
    }
}

/// An image of the command line, before anything is touched.
#[derive(Debug)]
pub(crate) struct Destination {
    path: PathBuf,
    kind: Kind,
    /// Its number among the images of this run.
    index: usize,
}

#[derive(Debug)]
enum Kind {
    /// A file to make or replace, or to draw in.
    File,
    /// A pipe or a character device: opened when there is something to write.
    Stream,
    /// Already open: standard output, or what `/dev/fd/N` names.
    Descriptor(File),
}

impl Destination {
    fn of(path: &Path, index: usize) -> Result<Self, Failure> {
        let number = if path == Path::new("-") {
            Some(1)
        } else {
            system::own_descriptor(path)
        };
        let kind = match (number, fs::metadata(path)) {
            (Some(number), _) => Kind::Descriptor(
                system::descriptor(number).map_err(|error| write_failed(path, error))?,
            ),
            (None, Ok(metadata)) if system::is_stream(&metadata) => {
                system::may_write(path).map_err(|error| write_failed(path, error))?;
                Kind::Stream
            }
            // An error here is reported when the file can't be made.
            _ => Kind::File,
        };
        Ok(Self {
            path: path.to_owned(),
            kind,
            index,
        })
    }

    /// The file that writing there would change; `None` if it is a device.
    fn place(&self) -> Result<Option<Place>, Failure> {
        let metadata = match &self.kind {
            Kind::File => return Ok(Some(Place::of(&self.path)?)),
            Kind::Stream => fs::metadata(&self.path),
            Kind::Descriptor(file) => file.metadata(),
        };
        let metadata = metadata.map_err(|error| look_up_failed(&self.path, error))?;
        Ok((!system::is_device(&metadata)).then(|| Place::of_file(&metadata)))
    }
}

/// The file that is read; `None` if it is a stream, or absent, which is reported when it is
/// read. `-` is standard input.
fn place_of_input(path: &Path) -> Result<Option<Place>, Failure> {
    let metadata = if path == Path::new("-") {
        system::stdin().and_then(|stdin| stdin.metadata())
    } else {
        fs::metadata(path)
    };
    match metadata {
        Ok(metadata) => Ok(metadata.is_file().then(|| Place::of_file(&metadata))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(look_up_failed(path, error)),
    }
}

/// The picture being drawn.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    index: usize,
    target: Target,
}

#[derive(Debug)]
enum Target {
    Whole(Box<MappedImage>),
    InPlace(SharedImage),
    Png(Box<NewFile>, ImageSize),
    /// Opened when it is drawn: nobody may be reading it yet.
    Stream(Option<File>, ImageSize),
}

/// Why a stream ends before the picture does.
enum StreamError {
    Writing(io::Error),
    Drawing(Failure),
}

impl From<io::Error> for StreamError {
    fn from(error: io::Error) -> Self {
        Self::Writing(error)
    }
}

impl Output {
    pub(crate) fn open(destination: &Destination, job: &Job) -> Result<Self, Failure> {
        let Destination { path, kind, index } = destination;
        let size = job.size();
        let some_rows = job.rows.is_some() && job.mode() == Mode::Render;
        let watch = if job.quiet {
            signals::watch_quietly
        } else {
            signals::watch
        };
        let target = match kind {
            Kind::File if some_rows => {
                Target::InPlace(SharedImage::open_watched(path, size, watch)?)
            }
            Kind::File if png::is_name_of_png(path) => {
                let new = NewFile::create_watched(path, watch)?;
                Target::Png(Box::new(new), size)
            }
            Kind::File => {
                let image = MappedImage::create_watched(path, size, watch)?;
                Target::Whole(Box::new(image))
            }
            _ if some_rows => {
                return Err(Failure::Message(format!(
                    "{}: this is a stream, and --rows needs a file to draw them in; name a file, or leave --rows out",
                    shown(path)
                )));
            }
            Kind::Stream => Target::Stream(None, size),
            Kind::Descriptor(file) => {
                let file = file
                    .try_clone()
                    .map_err(|error| write_failed(path, error))?;
                Target::Stream(Some(file), size)
            }
        };
        Ok(Self {
            path: path.clone(),
            index: *index,
            target,
        })
    }

    pub(crate) fn draw(
        &mut self,
        rows: Range<u32>,
        mut draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let path = &self.path;
        signals::draws(self.index, path);
        let into_stream =
            |rows, pixels: &mut [u8]| draw(rows, pixels).map_err(StreamError::Drawing);
        let failed = |error| match error {
            StreamError::Drawing(failure) => failure,
            StreamError::Writing(error) => write_failed(path, error),
        };
        match &mut self.target {
            Target::Whole(image) => image.try_draw(draw),
            Target::InPlace(image) => image.try_draw(rows, draw),
            Target::Png(new, size) => png::write(new.file(), *size, into_stream).map_err(failed),
            Target::Stream(open, size) => {
                let mut stream = match open.take() {
                    Some(stream) => stream,
                    None => open_waiting(path, OpenOptions::new().write(true), "read it")
                        .map_err(|error| write_failed(path, error))?,
                };
                if png::is_name_of_png(path) {
                    png::write(&mut stream, *size, into_stream)
                } else {
                    ppm::try_write_image(&mut stream, *size, into_stream)
                }
                .map_err(failed)
            }
        }
    }

    /// Gives the image its name. An image drawn in place or written to a stream is complete
    /// already.
    pub(crate) fn publish(self, places: &Places) -> Result<(), Failure> {
        // This may take long, so it can still be interrupted.
        match &self.target {
            Target::Whole(image) => image.settle()?,
            Target::Png(new, _) => new.settle()?,
            Target::InPlace(_) | Target::Stream(..) => return Ok(()),
        }
        // The scene may have got this name while the image was drawn.
        places.check()?;
        signals::hold();
        match self.target {
            Target::Whole(image) => image.publish()?,
            Target::Png(new, _) => new.publish()?,
            Target::InPlace(_) | Target::Stream(..) => {}
        }
        Ok(())
    }
}

/// Opens a file that may be a pipe. Opening a pipe waits for another program to do `other`
/// at its other end; after a while a message says so.
pub(crate) fn open_waiting(
    path: &Path,
    options: &OpenOptions,
    other: &'static str,
) -> io::Result<File> {
    const PATIENCE: Duration = Duration::from_secs(1);
    let done = Arc::new(AtomicBool::new(false));
    if system::is_pipe(path) {
        let (done, path) = (Arc::clone(&done), path.to_owned());
        // Without the thread it waits without a message.
        let _ = thread::Builder::new().spawn(move || {
            thread::sleep(PATIENCE);
            if !done.load(Ordering::SeqCst) {
                tell(format_args!(
                    "sfera: {}: this is a pipe; waiting for another program to {other}",
                    shown(&path)
                ));
            }
        });
    }
    let file = options.open(path);
    done.store(true, Ordering::SeqCst);
    file
}
