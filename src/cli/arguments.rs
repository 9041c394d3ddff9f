//! The command line.

use std::{ops::Range, path::PathBuf, str::FromStr};

use clap::{CommandFactory, Parser, ValueEnum, error::ErrorKind};
use sfera::{
    camera::ImageSize,
    render::{Form, Method},
};

use super::statistics;

/// Renders a scene of flat-coloured spheres to a binary PPM, every pixel provably right.
#[derive(Debug, Parser)]
#[command(version, long_about = LONG_ABOUT, after_long_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: Option<Job>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Job {
    /// The scene, a text file
    pub(crate) scene: PathBuf,

    /// The image to make or replace; - for standard output
    pub(crate) image: PathBuf,

    /// Pixels of a row
    #[arg(value_parser = side, allow_negative_numbers = true)]
    width: u32,

    /// Rows
    #[arg(value_parser = side, allow_negative_numbers = true)]
    height: u32,

    /// How the colour of a pixel is computed
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,

    /// Draw one pixel at a time: the same picture, slower; for textbook, geometric and double
    #[arg(long)]
    scalar: bool,

    /// Threads to draw with [default: one for each CPU]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// Draw only these rows (from 0, the last not included), in place in an image that may be there
    #[arg(long, value_name = "A..B")]
    pub(crate) rows: Option<RowRange>,

    /// Tell on standard error how long each phase took, as text or as JSON
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true,
          default_missing_value = "text")]
    pub(crate) stats: Option<statistics::Style>,

    /// Show no progress bar
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// f32, the formula as taught
    Textbook,
    /// f32, the stable form of it
    Geometric,
    /// f64, the formula as taught
    Double,
    /// Every pixel proven right, and the fastest
    #[default]
    Exact,
    /// The meaning of the picture in integers, slow: the judge of the others
    Reference,
}

/// The words of `--rows A..B`.
#[derive(Clone, Debug)]
pub(crate) struct RowRange(Range<u32>);

impl FromStr for RowRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends = text
            .split_once("..")
            .and_then(|(first, end)| Some((first.parse().ok()?, end.parse().ok()?)));
        match ends {
            Some((first, end)) if first < end => Ok(Self(first..end)),
            Some(_) => Err("there is no row in it: A must be less than B".into()),
            None => Err("write it as A..B, two whole numbers, like 0..540".into()),
        }
    }
}

/// A width or height.
fn side(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(0) => Err("an image needs at least one row and one column".into()),
        Ok(side) => Ok(side),
        Err(error) if *error.kind() == std::num::IntErrorKind::PosOverflow => {
            Err(format!("at most {}", u32::MAX))
        }
        Err(_) => Err("a whole number of pixels is needed, like 1920".into()),
    }
}

impl Arguments {
    /// Reads and checks the command line; ends the program with exit code 2 and
    /// a message when it is wrong.
    pub(crate) fn job(&self) -> &Job {
        let Some(job) = &self.job else {
            refuse(ErrorKind::MissingRequiredArgument, "no scene")
        };
        job.check();
        job
    }
}

/// Ends the program: the command line is wrong.
fn refuse(kind: ErrorKind, message: impl std::fmt::Display) -> ! {
    Arguments::command().error(kind, message).exit()
}

impl Job {
    /// What clap can't check: combinations, and values that depend on others.
    fn check(&self) {
        if let Err(error) = ImageSize::new(self.width, self.height) {
            refuse(ErrorKind::ValueValidation, error);
        }
        if self.scalar && matches!(self.method, MethodName::Exact | MethodName::Reference) {
            refuse(
                ErrorKind::ArgumentConflict,
                "--scalar is one of two forms of the methods textbook, geometric and double; add --method, or leave it out",
            );
        }
        if self.rows().end > self.height {
            refuse(
                ErrorKind::ValueValidation,
                format_args!(
                    "--rows {}..{}: an image of {} rows has rows 0..{}",
                    self.rows().start,
                    self.rows().end,
                    self.height,
                    self.height
                ),
            );
        }
    }

    pub(crate) fn size(&self) -> ImageSize {
        match ImageSize::new(self.width, self.height) {
            Ok(size) => size,
            Err(error) => refuse(ErrorKind::ValueValidation, error),
        }
    }

    /// The rows asked for, or all.
    pub(crate) fn rows(&self) -> Range<u32> {
        match &self.rows {
            Some(RowRange(rows)) => rows.clone(),
            None => 0..self.height,
        }
    }

    pub(crate) fn method(&self) -> Method {
        match self.method {
            MethodName::Textbook => Method::Textbook,
            MethodName::Geometric => Method::Geometric,
            MethodName::Double => Method::Double,
            MethodName::Exact => Method::Exact,
            MethodName::Reference => Method::Reference,
        }
    }

    pub(crate) fn form(&self) -> Form {
        if self.scalar {
            Form::Scalar
        } else {
            Form::Packets
        }
    }

    pub(crate) fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}

const LONG_ABOUT: &str = "\
Renders a scene of flat-coloured spheres to a binary PPM, every pixel provably right.

The image appears under its name when it is complete; whatever fails, an image that was there before stays as it was.";

const EXAMPLES: &str = "\
Examples:
  sfera scenes/example.txt example.ppm 1920 1080
  sfera scene.txt - 640 480 | pnmtopng > scene.png
  sfera scene.txt fast.ppm 1920 1080 --method geometric --stats

Exit codes: 0 the image is complete, 1 something failed (one line on standard error says what),
2 the command line is wrong, 130 and 143 interrupted and terminated, 141 nobody reads standard output.";
