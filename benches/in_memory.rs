//! Not a criterion bench, but the harness of `make peers` and of measurements by hand. It
//! times drawing from spheres in memory to RGB in memory, and reading a scene. It prints one
//! line of JSON: times in milliseconds, first the medians, then every sample.
//!
//! ```text
//! cargo bench --bench in_memory -- draw SCENE WIDTH HEIGHT [--threads N] [--runs N] [--method M] [--ignore-bounds] [--image FILE]
//! cargo bench --bench in_memory -- read SCENE [--threads N] [--runs N]
//! ```
//!
//! `draw` times preparing, drawing, both, and as a lower bound filling the same buffer with
//! one value. `read` times the reader of sfera, and for comparison reading the text and
//! parsing its numbers with the standard library on all threads.

use std::{fs, hint::black_box, io::Write, path::PathBuf, time::Instant};

use clap::Parser;
use rayon::prelude::*;
use sfera::{
    camera::ImageSize,
    ppm,
    render::{Method, Workspace},
    scene::Scene,
    testing::{Bounds, Tuning, tuned_in},
};

type Failure = Box<dyn std::error::Error + Send + Sync>;

#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: Option<What>,
    /// `cargo bench` passes this to every bench.
    #[arg(long, hide = true, global = true)]
    bench: bool,
}

#[derive(clap::Subcommand)]
enum What {
    /// Times drawing from spheres in memory to RGB in memory.
    Draw {
        scene: PathBuf,
        width: u32,
        height: u32,
        #[arg(long, default_value_t = 1)]
        threads: usize,
        #[arg(long, default_value_t = 9)]
        runs: usize,
        /// One of `textbook`, `geometric`, `double` (in packets);
        /// without it the method that sfera uses by default.
        #[arg(long)]
        method: Option<String>,
        /// Ignores the engine's error bounds, as if nothing were rounded: shows the cost of
        /// certainty in time and in wrong pixels.
        #[arg(long, conflicts_with = "method")]
        ignore_bounds: bool,
        /// Writes the picture to this file, as a binary PPM.
        #[arg(long)]
        image: Option<PathBuf>,
    },
    /// Times the reader, and merely parsing the numbers.
    Read {
        scene: PathBuf,
        #[arg(long, default_value_t = 1)]
        threads: usize,
        #[arg(long, default_value_t = 9)]
        runs: usize,
    },
    /// Parses the numbers of a scene once, to be timed from outside as a lower bound of a
    /// whole command.
    Numbers {
        scene: PathBuf,
        #[arg(long, default_value_t = 1)]
        threads: usize,
    },
}

fn main() -> Result<(), Failure> {
    let what = Arguments::parse().what.unwrap_or_else(|| What::Draw {
        scene: concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/example.txt").into(),
        width: 1920,
        height: 1080,
        threads: 1,
        runs: 9,
        method: None,
        ignore_bounds: false,
        image: None,
    });
    match what {
        What::Draw {
            scene,
            width,
            height,
            threads,
            runs,
            method,
            ignore_bounds,
            image,
        } => {
            let method = method.map_or(Ok(Method::default()), |name| name.parse())?;
            let bounds = if ignore_bounds {
                Bounds::Ignored
            } else {
                Bounds::Proven
            };
            let scene = Scene::read(&scene)?;
            let size = ImageSize::new(width, height)?;
            let mut pixels = vec![1; size.pixel_bytes()];
            pool(threads)?.install(|| draw(&scene, size, (method, bounds), runs, &mut pixels));
            if let Some(image) = image {
                let mut file = fs::File::create(image)?;
                file.write_all(ppm::header(size).as_bytes())?;
                file.write_all(&pixels)?;
            }
        }
        What::Read {
            scene,
            threads,
            runs,
        } => {
            let pool = pool(threads)?;
            let mut own = Vec::new();
            let mut numbers = Vec::new();
            for run in 0..=runs {
                let start = Instant::now();
                let read = pool.install(|| Scene::read(&scene))?;
                let after = milliseconds(start);
                drop(black_box(read));
                let start = Instant::now();
                black_box(pool.install(|| parse_numbers(&scene))?);
                if run > 0 {
                    own.push(after);
                    numbers.push(milliseconds(start));
                }
            }
            print(&[("reader", &own), ("numbers", &numbers)]);
        }
        What::Numbers { scene, threads } => {
            black_box(pool(threads)?.install(|| parse_numbers(&scene))?);
        }
    }
    Ok(())
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?)
}

/// The first run of the loop only wakes the threads.
fn draw(
    scene: &Scene,
    size: ImageSize,
    (method, bounds): (Method, Bounds),
    runs: usize,
    pixels: &mut [u8],
) {
    let tuning = Tuning {
        bounds,
        ..Tuning::default()
    };
    let [mut prepare, mut drawing, mut total, mut fill] = [const { Vec::new() }; 4];
    let piece = pixels
        .len()
        .div_ceil(rayon::current_num_threads())
        .next_multiple_of(64);
    let mut workspace = Workspace::default();
    for run in 0..=runs {
        let start = Instant::now();
        pixels
            .par_chunks_mut(piece)
            .for_each(|bytes| bytes.fill(run as u8));
        black_box(&mut *pixels);
        let filled = milliseconds(start);

        let start = Instant::now();
        let renderer = tuned_in(workspace, scene, size, method, tuning);
        let prepared = milliseconds(start);
        renderer.draw(0..size.height(), pixels);
        black_box(&mut *pixels);
        let drawn = milliseconds(start);
        workspace = renderer.into_workspace();
        if run > 0 {
            fill.push(filled);
            prepare.push(prepared);
            drawing.push(drawn - prepared);
            total.push(drawn);
        }
    }
    print(&[
        ("prepare", &prepare),
        ("draw", &drawing),
        ("total", &total),
        ("fill", &fill),
    ]);
}

/// Reads the text and parses every number in it, one piece on each thread.
fn parse_numbers(scene: &PathBuf) -> Result<Vec<Vec<f32>>, Failure> {
    let text = fs::read(scene)?;
    let threads = rayon::current_num_threads();
    let mut pieces = Vec::with_capacity(threads);
    let mut rest = text.as_slice();
    for left in (1..=threads).rev() {
        let middle = rest.len() / left;
        let line = rest[middle..].iter().position(|&byte| byte == b'\n');
        let (piece, after) = rest.split_at(line.map_or(rest.len(), |line| middle + line));
        pieces.push(piece);
        rest = after;
    }
    pieces
        .into_par_iter()
        .map(|piece| {
            let words = str::from_utf8(piece)?.split_ascii_whitespace();
            Ok(words.filter_map(|word| word.parse().ok()).collect())
        })
        .collect()
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Prints the medians, then the samples, of each named series.
fn print(series: &[(&str, &[f64])]) {
    let medians = series.iter().map(|(name, samples)| {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted
            .get(sorted.len() / 2)
            .map_or_else(|| "null".to_owned(), |m| format!("{m:.4}"));
        format!("\"{name}_ms\": {middle}")
    });
    let samples = series.iter().map(|(name, samples)| {
        let samples: Vec<_> = samples.iter().map(|s| format!("{s:.4}")).collect();
        format!("\"{name}\": [{}]", samples.join(", "))
    });
    println!(
        "{{{}}}",
        medians.chain(samples).collect::<Vec<_>>().join(", ")
    );
}
