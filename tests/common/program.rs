//! Runs the program as a process in a folder of its own.

#![allow(dead_code, reason = "each test program uses its part of this")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use tempfile::TempDir;

pub(crate) const SFERA: &str = env!("CARGO_BIN_EXE_sfera");

/// A sphere in front of a white background, and another one cut by an edge.
pub(crate) const BALLS: &str =
    "VP 1 1 1\nBG 255 255 255\nOBJ_N 2\nS 0 0 5 1 200 0 0\nS 2 1 6 1 0 0 90\n";

pub(crate) struct Workshop {
    folder: TempDir,
}

impl Workshop {
    /// A folder with the scene `balls.txt`.
    pub(crate) fn new() -> Self {
        Self::within(&std::env::temp_dir())
    }

    pub(crate) fn within(folder: &Path) -> Self {
        let folder = TempDir::new_in(folder).expect("a folder");
        fs::write(folder.path().join("balls.txt"), BALLS).expect("a scene");
        Self { folder }
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).expect("a file");
    }

    /// The program with the words of `line` as arguments, in the folder.
    pub(crate) fn sfera(&self, line: &str) -> Command {
        let mut command = Command::new(SFERA);
        command
            .args(line.split_whitespace())
            .current_dir(self.folder())
            .stdin(Stdio::null());
        command
    }

    /// A line of shell in which `$SFERA` is the program, in the folder.
    pub(crate) fn shell(&self, line: &str) -> Command {
        let mut command = Command::new("sh");
        command
            .args(["-c", line])
            .env("SFERA", SFERA)
            .current_dir(self.folder())
            .stdin(Stdio::null());
        command
    }

    pub(crate) fn run(&self, line: &str) -> Ran {
        Ran::of(&mut self.sfera(line))
    }

    pub(crate) fn run_shell(&self, line: &str) -> Ran {
        Ran::of(&mut self.shell(line))
    }

    /// The names in the folder, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder())
            .expect("the folder")
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// The exact picture of `balls.txt`, drawn by the library.
    pub(crate) fn balls(&self, width: u32, height: u32) -> Vec<u8> {
        let other = Self::new();
        other
            .run(&format!("balls.txt right.ppm {width} {height}"))
            .succeeds();
        other.read("right.ppm")
    }
}

/// A process that has ended.
pub(crate) struct Ran {
    /// The exit code; if negative, the signal that ended it.
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Ran {
    pub(crate) fn of(command: &mut Command) -> Self {
        command.output().expect("the program runs").into()
    }

    #[track_caller]
    pub(crate) fn succeeds(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        assert_eq!(self.stderr, "");
        self
    }

    /// Exit code 1 and one line that begins with the program's name and has all of `words`.
    #[track_caller]
    pub(crate) fn fails(self, words: &[&str]) -> Self {
        assert_eq!(self.code, 1, "{}", self.stderr);
        assert!(self.stderr.starts_with("sfera: "), "{}", self.stderr);
        assert_eq!(self.stderr.lines().count(), 1, "{}", self.stderr);
        self.says(words)
    }

    /// Exit code 2 and a message that has all of `words`.
    #[track_caller]
    pub(crate) fn refuses(self, words: &[&str]) -> Self {
        assert_eq!(self.code, 2, "{}", self.stderr);
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        self.says(words)
    }

    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(
                self.stderr.contains(word),
                "no {word:?} in: {}",
                self.stderr
            );
        }
        self
    }
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        use std::os::unix::process::ExitStatusExt;
        let status = output.status;
        Self {
            code: status
                .code()
                .unwrap_or_else(|| -status.signal().expect("a code or a signal")),
            stdout: output.stdout,
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

/// Waits until a condition holds; panics after a long time.
#[track_caller]
pub(crate) fn wait_until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "waited for: {what}"
        );
        thread::sleep(Duration::from_millis(2));
    }
}
