//! The command line.

use std::{
    env,
    io::{self, Write},
    ops::Range,
    path::{Path, PathBuf},
    process,
    str::FromStr,
};

use clap::{ArgAction, CommandFactory, Parser, ValueEnum, error::ErrorKind};
use sfera::{
    camera::ImageSize,
    name::{printable, shown},
    render::{Form, Method},
};

use super::{
    failure::{Failure, write_failed},
    png,
};

/// Endings of picture formats that are not written. Without this list a `.jpg` would hold
/// a PPM without any warning.
const OTHER_PICTURES: [&str; 32] = [
    "avif", "bmp", "dds", "dng", "emf", "eps", "exr", "ff", "gif", "hdr", "heic", "heif", "ico",
    "jp2", "jpe", "jpeg", "jpg", "jxl", "pam", "pbm", "pcx", "pdf", "pfm", "pgm", "ps", "psd",
    "qoi", "svg", "tga", "tif", "tiff", "webp",
];

/// Renders a scene of flat-coloured spheres, every pixel provably right.
#[derive(Debug, Parser)]
#[command(version, long_about = LONG_ABOUT, after_long_help = LONG_HELP)]
#[command(help_template = HELP, after_help = EXIT_CODES, disable_help_flag = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: Option<Job>,

    /// Print this page
    #[arg(short, long, action = ArgAction::HelpShort)]
    help: Option<bool>,

    /// Print completions for a shell, or the manual page
    #[arg(long, value_enum, value_name = "PAGE", exclusive = true)]
    pub(crate) generate: Option<Page>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Job {
    /// The scene, a text file; - for standard input
    pub(crate) scene: PathBuf,

    /// The image, PNG or PPM by its name; - for standard output
    pub(crate) image: PathBuf,

    /// Pixels in a row
    #[arg(value_parser = side, allow_negative_numbers = true)]
    width: u32,

    /// Rows
    #[arg(value_parser = side, allow_negative_numbers = true)]
    height: u32,

    /// How the colour of a pixel is computed
    #[arg(long, value_enum, default_value_t)]
    method: MethodName,

    /// Run a float method pixel by pixel: same bytes, slower
    #[arg(long)]
    scalar: bool,

    /// Threads to draw with [default: one for each CPU]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// Draw only these rows, in place: from 0, B not included
    #[arg(long, value_name = "A..B")]
    pub(crate) rows: Option<RowRange>,

    /// Check an existing image, whoever drew it
    #[arg(long)]
    verify: bool,

    /// Draw with every method, print speed and wrong pixels
    #[arg(long, conflicts_with_all = ["method", "scalar", "rows", "verify", "diff", "stats", "quiet"])]
    compare: bool,

    /// Make a second image: red where the first is wrong
    #[arg(long, value_name = "FILE", conflicts_with = "rows")]
    pub(crate) diff: Option<PathBuf>,

    /// Print times and counts on standard error, or as JSON
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true,
          default_missing_value = "text", conflicts_with = "quiet")]
    pub(crate) stats: Option<Style>,

    /// Print only errors: no progress bar, no remarks
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// f32, the textbook formula
    Textbook,
    /// f32, the stable form of the formula
    Geometric,
    /// f64, the textbook formula
    Double,
    /// Every pixel proven right, and the fastest
    #[default]
    Exact,
    /// The definition of the picture in integers, slow: checks the others
    Reference,
}

/// What `--generate` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Page {
    /// Completions for bash
    Bash,
    /// Completions for zsh
    Zsh,
    /// Completions for fish
    Fish,
    /// The manual page
    Man,
}

/// The format of `--stats`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Style {
    Text,
    Json,
}

/// The job that the command line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Render,
    Verify,
    Compare,
}

/// The value of `--rows A..B`.
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
            Some(_) => Err("this range has no rows: A must be less than B".into()),
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
    /// Reads the command line. Ends the program with exit code 2 and a message if it is
    /// wrong, and with 0 after printing help.
    pub(crate) fn read() -> Result<Self, Failure> {
        Self::try_parse().or_else(|answer| {
            if answer.use_stderr() {
                // The same mistake, without characters that control a terminal.
                let shown = env::args_os().map(|argument| printable(argument.as_encoded_bytes()));
                Self::try_parse_from(shown).err().unwrap_or(answer).exit()
            }
            answer
                .print()
                .and_then(|()| io::stdout().flush())
                .map_err(|error| write_failed("-".as_ref(), error))?;
            process::exit(0)
        })
    }

    /// Checks the command line. Ends the program with exit code 2 and a message if it is
    /// wrong.
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
    /// Checks what clap can't: combinations, and values that depend on others.
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
        self.check_endings();
        let standard_output = Path::new("-");
        if self.verify && self.scene_is_standard_input() && self.image == standard_output {
            refuse(
                ErrorKind::ArgumentConflict,
                "standard input can be the scene or the image that --verify judges, not both: give one of them a name",
            );
        }
        if self.image == standard_output {
            let wants_file = [
                (
                    self.rows.is_some() && !self.verify,
                    "--rows draws in a file",
                ),
                (
                    self.compare,
                    "--compare prints its table on standard output",
                ),
            ];
            if let Some((_, why)) = wants_file.into_iter().find(|(wanted, _)| *wanted) {
                refuse(
                    ErrorKind::ArgumentConflict,
                    format_args!("{why}: give the image a name, not -"),
                );
            }
        }
        if let Some(marks) = &self.diff {
            if self.method == MethodName::Exact && !self.verify {
                refuse(
                    ErrorKind::ArgumentConflict,
                    "--diff compares another method with exact: add --method, or --verify to judge an image that is there",
                );
            }
            if *marks == self.image {
                refuse(
                    ErrorKind::ArgumentConflict,
                    "--diff needs a name of its own, not that of the image",
                );
            }
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

    /// Checks that no image gets the name of another format.
    fn check_endings(&self) {
        let image = (!self.verify).then_some(&self.image);
        for path in image.into_iter().chain(&self.diff) {
            let Some(ending) = png::ending(path) else {
                continue;
            };
            if OTHER_PICTURES.contains(&&*ending) {
                refuse(
                    ErrorKind::ValueValidation,
                    format_args!(
                        "{}: images are written as PPM or PNG, not as {ending}; \
                         end the name in .png or .ppm, and convert it to {ending} with another program",
                        shown(path)
                    ),
                );
            }
            if ending == "png" && self.rows.is_some() {
                refuse(
                    ErrorKind::ArgumentConflict,
                    "--rows draws in place, which a PNG does not allow; end the name in .ppm, and convert it to PNG when it is complete (pnmtopng)",
                );
            }
            if ending == "png" && self.width.max(self.height) > png::LONGEST_SIDE {
                refuse(
                    ErrorKind::ValueValidation,
                    format_args!(
                        "a PNG has at most {} rows and columns; end the name in .ppm",
                        png::LONGEST_SIDE
                    ),
                );
            }
        }
    }

    pub(crate) fn scene_is_standard_input(&self) -> bool {
        self.scene == Path::new("-")
    }

    pub(crate) fn mode(&self) -> Mode {
        match (self.verify, self.compare) {
            (true, _) => Mode::Verify,
            (_, true) => Mode::Compare,
            _ => Mode::Render,
        }
    }

    pub(crate) fn size(&self) -> ImageSize {
        match ImageSize::new(self.width, self.height) {
            Ok(size) => size,
            Err(error) => refuse(ErrorKind::ValueValidation, error),
        }
    }

    /// The rows to draw: those asked for, or all.
    pub(crate) fn rows(&self) -> Range<u32> {
        match &self.rows {
            Some(RowRange(rows)) => rows.clone(),
            None => 0..self.height,
        }
    }

    /// The number of pixels to draw.
    pub(crate) fn pixels(&self) -> u64 {
        self.rows().len() as u64 * u64::from(self.width)
    }

    /// Whether the job takes long even for few pixels.
    pub(crate) fn is_laborious(&self) -> bool {
        self.method != MethodName::Exact || self.mode() != Mode::Render
    }

    pub(crate) fn method(&self) -> Method {
        let form = if self.scalar {
            Form::Scalar
        } else {
            Form::Packets
        };
        match self.method {
            MethodName::Textbook => Method::Textbook(form),
            MethodName::Geometric => Method::Geometric(form),
            MethodName::Double => Method::Double(form),
            MethodName::Exact => Method::Exact,
            MethodName::Reference => Method::Reference,
        }
    }

    pub(crate) fn threads(&self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}

const LONG_ABOUT: &str = "\
Renders a scene of flat-coloured spheres to a PPM or PNG, every pixel provably right.

The image appears under its name when it is complete. If anything fails, an earlier image stays as it was.";

/// What `--help` prints: two screens, with the usual commands first.
const HELP: &str = "\
{about}

{usage-heading} {usage}

Examples:
  sfera scene.txt picture.png 1920 1080              a picture
  make-scene | sfera - - 800 600 | show-ppm          in a pipe
  sfera scene.txt picture.ppm 1920 1080 --compare    speed against accuracy
  sfera scene.txt other.ppm 1920 1080 --verify       checks another picture
  sfera scene.txt large.ppm 32768 32768 --rows 0..4096    some of its rows
  sfera --generate man | man -l -                    more examples

{all-args}{after-help}";

const EXIT_CODES: &str = "\
Exit codes:
    0  the image is complete; with --verify, every pixel is right
    1  something failed; standard error says what, and how to fix it
    2  the command line is wrong
  128 + N  ended by signal N, as 130 by an interrupt; 141  nobody reads the output";

/// What the manual page has besides the options.
const LONG_HELP: &str = "\
Examples:
  The picture, 1920 x 1080; the same as PNG:
    sfera scenes/example.txt example.ppm 1920 1080
    sfera scenes/example.txt example.png 1920 1080
  From and to other programs:
    generate-scene | sfera - - 640 480 | pnmtojpeg > scene.jpg
  How long each phase takes; the same for scripts:
    sfera scene.txt scene.ppm 1920 1080 --stats
    sfera scene.txt scene.ppm 1920 1080 --stats=json 2> stats.json
  Speed against accuracy on a scene of your own:
    sfera scene.txt scene.ppm 1920 1080 --compare
  Where the textbook formula in floats is wrong:
    sfera scene.txt textbook.ppm 1920 1080 --method textbook --diff wrong.png
  Which pixels of another program's picture are wrong, and why:
    sfera scene.txt other.ppm 1920 1080 --verify
    my-renderer scene.txt | sfera scene.txt - 1920 1080 --verify --diff wrong.png
  A large picture in two parts, in any order, on one machine or two; then checked:
    sfera scene.txt large.ppm 32768 32768 --rows 0..16384
    sfera scene.txt large.ppm 32768 32768 --rows 16384..32768
    sfera scene.txt large.ppm 32768 32768 --verify
  Completions:
    sfera --generate bash > ~/.local/share/bash-completion/completions/sfera

Exit codes:
    0  the image is complete (with --verify: every pixel is right)
    1  something failed; one line on standard error says what, and how to fix it
    2  the command line is wrong
  128 + N  ended by signal N: 130 interrupted (SIGINT), 143 terminated (SIGTERM), 129 hung up (SIGHUP)
  141  nobody reads standard output any more

Only --rows changes an image in place. Otherwise the image appears under its name when it is complete,
and until then an earlier file stays as it was.";
