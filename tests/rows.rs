//! One picture by many processes: bands of rows in any order, killed and drawn
//! again, are the picture that one process draws.

// Permissions, links and signals are those of Unix.
#![cfg(unix)]

use std::{
    fs,
    os::unix::process::ExitStatusExt,
    path::PathBuf,
    process::{Child, Command, Stdio},
    sync::Mutex,
    thread,
    time::{Duration, Instant},
};

use sfera::testing::Random;
use tempfile::TempDir;

const WIDTH: u32 = 193;
const HEIGHT: u32 = 331;
const BANDS: u32 = 64;
const PROCESSES: u64 = 4;
const SIGKILL: i32 = 9;

/// Slow enough on any machine that a process can be killed in the middle of a band.
const METHOD: [&str; 3] = ["--method", "textbook", "--scalar"];

#[test]
fn bands_in_random_order_by_four_processes_are_one_run() {
    let studio = Studio::new();
    studio.draw_bands(&shuffled(&mut Random::new(1)), 0);
    studio.expect_the_picture();
}

#[test]
fn bands_killed_in_the_middle_and_drawn_again_are_one_run() {
    let studio = Studio::new();
    studio.draw_bands(&shuffled(&mut Random::new(2)), 20);
    studio.expect_the_picture();
}

/// A folder with a scene, and its picture drawn in one piece.
struct Studio {
    folder: TempDir,
    band_time: Duration,
}

impl Studio {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("scene.txt"), scene()).expect("a scene");
        let mut studio = Self {
            folder,
            band_time: Duration::ZERO,
        };
        let start = Instant::now();
        let status = studio.start("one.ppm", &[]).wait().expect("its end");
        assert!(status.success(), "one run: {status}");
        studio.band_time = start.elapsed() / BANDS;
        studio
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn start(&self, image: &str, options: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_sfera"))
            .arg(self.path("scene.txt"))
            .arg(self.path(image))
            .args([WIDTH.to_string(), HEIGHT.to_string()])
            .args(METHOD)
            .args(["--threads", "1"])
            .args(options)
            .stdin(Stdio::null())
            .spawn()
            .expect("the program starts")
    }

    fn start_band(&self, band: u32) -> Child {
        let first_row = |band| HEIGHT * band / BANDS;
        let rows = format!("{}..{}", first_row(band), first_row(band + 1));
        self.start("bands.ppm", &["--rows", &rows])
    }

    /// Draws all `bands`, several at once, and kills `kills` of their processes at random
    /// moments.
    fn draw_bands(&self, bands: &[u32], kills: usize) {
        let work = Mutex::new(Work {
            bands: bands.to_vec(),
            kills,
        });
        thread::scope(|threads| {
            for seed in 0..PROCESSES {
                let work = &work;
                threads.spawn(move || self.draw_some(work, &mut Random::new(seed)));
            }
        });
        assert_eq!(work.into_inner().expect("no panic").kills, 0);
    }

    fn draw_some(&self, work: &Mutex<Work>, random: &mut Random) {
        loop {
            let (band, kill) = {
                let mut work = work.lock().expect("no panic");
                // If kills are left when all bands are done, draw some again, which is allowed.
                let band = match work.bands.pop() {
                    None if work.kills > 0 => random.below(BANDS.into()) as u32,
                    None => return,
                    Some(band) => band,
                };
                let kill = work.kills > 0;
                work.kills -= usize::from(kill);
                (band, kill)
            };
            let mut process = self.start_band(band);
            if kill {
                // Up to twice the time of a band, since starting takes time too.
                thread::sleep(self.band_time.mul_f64(random.below(201) as f64 / 100.0));
                process.kill().expect("it is ours");
            }
            let status = process.wait().expect("its end");
            let killed = status.signal() == Some(SIGKILL);
            assert!(status.success() || kill && killed, "band {band}: {status}");

            let mut work = work.lock().expect("no panic");
            if killed {
                work.bands.insert(0, band);
            } else if kill {
                // It ended before the kill; kill another one.
                work.kills += 1;
            }
        }
    }

    fn expect_the_picture(&self) {
        let read = |name| fs::read(self.path(name)).expect("an image");
        let (one, bands) = (read("one.ppm"), read("bands.ppm"));
        assert_eq!(one.len(), bands.len());
        let differing = one.iter().zip(&bands).position(|(one, band)| one != band);
        assert_eq!(differing, None, "first byte that differs");
        let names = || {
            fs::read_dir(self.folder.path())
                .expect("the folder")
                .count()
        };
        assert_eq!(names(), 3, "files in the folder: scene and two images");
    }
}

struct Work {
    bands: Vec<u32>,
    kills: usize,
}

fn shuffled(random: &mut Random) -> Vec<u32> {
    let mut bands: Vec<u32> = (0..BANDS).collect();
    random.shuffle(&mut bands);
    bands
}

fn scene() -> String {
    let mut random = Random::new(3);
    let mut text = String::from("VP 0.6 1 1\nBG 255 255 255\nOBJ_N 3000\n");
    for index in 0..3000 {
        let mut thousandths = || random.below(1001) as f64 / 1000.0;
        let (x, y, z) = (
            thousandths() - 0.5,
            thousandths() - 0.5,
            2.0 + thousandths(),
        );
        let (red, green) = (index % 256, index / 256);
        text += &format!("S {x} {y} {z} 0.05 {red} {green} 0\n");
    }
    text
}
