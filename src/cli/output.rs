//! Where the picture goes.

use std::{
    fs::{self, File, Metadata, OpenOptions},
    io,
    ops::Range,
    path::{Path, PathBuf},
};

use sfera::{
    camera::ImageSize,
    ppm::{self, ImageError, MappedImage, NewFile, SharedImage},
};

use super::{
    Failure, png,
    signals::{self, Interrupts},
    system,
};

/// The IMAGE of the command line, before anything is touched.
#[derive(Debug)]
pub(crate) struct Destination {
    path: PathBuf,
    stream: Option<File>,
}

impl Destination {
    /// Standard output for `-`; a pipe or a character device is written as a
    /// stream; everything else is a file to make or replace.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        let stream = if path == Path::new("-") {
            let stdout = system::stdout().map_err(|error| format!("standard output: {error}"))?;
            Some(stdout)
        } else {
            match fs::metadata(path) {
                Ok(metadata) if system::is_stream(&metadata) => Some(
                    OpenOptions::new()
                        .write(true)
                        .open(path)
                        .map_err(|error| format!("{}: can't open it: {error}", path.display()))?,
                ),
                _ => None,
            }
        };
        Ok(Self {
            path: path.to_owned(),
            stream,
        })
    }

    /// Refuses an image that would overwrite the scene it is drawn from.
    pub(crate) fn refuse_to_replace(&self, scene: &Path) -> Result<(), Failure> {
        let image = match &self.stream {
            Some(stream) => stream.metadata(),
            None => fs::metadata(&self.path),
        };
        match (metadata_of_input(scene), image) {
            (Ok(scene_file), Ok(image)) if is_same(&scene_file, &image) => Err(format!(
                "{}: this is the scene itself ({}); give the image another name",
                self.path.display(),
                scene.display()
            )
            .into()),
            _ => Ok(()),
        }
    }

    /// Refuses to mark in the very picture that is judged what is wrong with it.
    pub(crate) fn refuse_to_replace_picture(&self, picture: &Path) -> Result<(), Failure> {
        match (metadata_of_input(picture), fs::metadata(&self.path)) {
            (Ok(picture), Ok(image)) if is_same(&picture, &image) => Err(format!(
                "{}: this is the picture that is judged; give the one of --diff another name",
                self.path.display()
            )
            .into()),
            _ => Ok(()),
        }
    }
}

/// Of a file that is read, or of standard input for `-`.
fn metadata_of_input(path: &Path) -> io::Result<Metadata> {
    if path == Path::new("-") {
        system::stdin()?.metadata()
    } else {
        fs::metadata(path)
    }
}

/// Whether a file that is read is the one to be replaced.
fn is_same(read: &Metadata, replaced: &Metadata) -> bool {
    replaced.is_file() && system::is_same(read, replaced)
}

/// The picture being drawn.
#[derive(Debug)]
pub(crate) enum Output {
    Whole(MappedImage),
    InPlace(SharedImage),
    Stream(File, PathBuf, ImageSize),
    Png(NewFile, PathBuf, ImageSize),
}

impl Output {
    pub(crate) fn open(
        destination: &Destination,
        size: ImageSize,
        in_place: bool,
        interrupts: &Interrupts,
    ) -> Result<Self, Failure> {
        let path = &destination.path;
        if let Some(stream) = &destination.stream {
            if in_place {
                return Err(format!(
                    "{}: this is a stream, and --rows needs a file to draw them in; name a file, or leave --rows out",
                    path.display()
                )
                .into());
            }
            return Ok(Self::Stream(stream.try_clone()?, path.clone(), size));
        }
        let (output, temporary) = if png::is_name_of_png(path) {
            let new = NewFile::create(path)?;
            let temporary = new.temporary_name().map(Path::to_owned);
            (Self::Png(new, path.clone(), size), temporary)
        } else if in_place {
            (Self::InPlace(SharedImage::open(path, size)?), None)
        } else {
            let image = MappedImage::create(path, size)?;
            let temporary = image.temporary_name().map(Path::to_owned);
            (Self::Whole(image), temporary)
        };
        if let Some(temporary) = &temporary {
            interrupts.remove(temporary)?;
        }
        signals::exit_when_lost(
            format!(
                "sfera: {}: the file was shortened or its disk failed while it was drawn; draw it again\n",
                path.display()
            ),
            temporary.as_deref(),
        )?;
        Ok(output)
    }

    pub(crate) fn draw(
        &mut self,
        rows: Range<u32>,
        draw: impl FnMut(Range<u32>, &mut [u8]),
    ) -> Result<(), Failure> {
        match self {
            Self::Whole(image) => Ok(image.draw(draw)?),
            Self::InPlace(image) => Ok(image.draw(rows, draw)?),
            Self::Png(new, path, size) => {
                png::write(new.file(), *size, draw).map_err(|error| lost(path, error))
            }
            Self::Stream(stream, path, size) if png::is_name_of_png(path) => {
                png::write(stream, *size, draw).map_err(|error| lost(path, error))
            }
            Self::Stream(stream, path, size) => {
                ppm::write_image(stream, *size, draw).map_err(|error| lost(path, error))
            }
        }
    }

    /// Gives the image its name; what was drawn in place or written is there already.
    pub(crate) fn publish(self, interrupts: &Interrupts) -> Result<(), Failure> {
        match self {
            Self::Whole(image) => {
                interrupts.hold();
                image.publish()?;
            }
            Self::Png(new, ..) => {
                interrupts.hold();
                new.publish()?;
            }
            Self::InPlace(_) | Self::Stream(..) => {}
        }
        Ok(())
    }
}

/// A stream that takes no more.
pub(crate) fn lost(path: &Path, error: io::Error) -> Failure {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return Failure::NobodyReads;
    }
    let error = ImageError::System {
        path: if path == Path::new("-") {
            "standard output".into()
        } else {
            path.to_owned()
        },
        action: "write to it",
        source: error,
    };
    error.into()
}
