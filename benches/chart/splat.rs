//! The fastest inexact rasteriser that we could write, in C: `benches/peers/splat.c`, built by
//! `make splat`.

use std::{fs, path::Path, process::Command};

use plotters::style::RGBColor;
use sfera::{camera::ImageSize, ppm, scene::Scene};

use crate::plot::Drawn;

/// Its colour, besides those of [`plot::colour`](crate::plot::colour).
pub(crate) const COLOUR: RGBColor = RGBColor(204, 121, 167);

/// The programs, the one with the most lanes first; those that the CPU can't run are not built.
const BUILT: [&str; 2] = ["target/peers/splat-16", "target/peers/splat-8"];
const RUNS: &str = "25";

/// The milliseconds and the bytes of a frame, drawn by the fastest program that is built.
pub(crate) fn measure(name: &str, scene: &Scene, size: ImageSize) -> Drawn<Option<(f64, Vec<u8>)>> {
    let folder = Path::new("target/charts");
    fs::create_dir_all(folder)?;
    let text = folder.join(format!("{name}.txt"));
    let image = folder.join(format!("{name}.ppm"));
    fs::write(&text, scene.to_string())?;
    let mut best: Option<(f64, Vec<u8>)> = None;
    for program in BUILT.into_iter().filter(|path| Path::new(path).exists()) {
        let output = Command::new(program)
            .arg(&text)
            .args([size.width().to_string(), size.height().to_string()])
            .args([&rayon::current_num_threads().to_string(), RUNS])
            .arg(&image)
            .output()?;
        let line = String::from_utf8(output.stdout)?;
        let (bins, tiles) = (samples(&line, "bins"), samples(&line, "tiles"));
        let mut times: Vec<f64> = bins.iter().zip(&tiles).map(|(a, b)| a + b).collect();
        times.sort_by(f64::total_cmp);
        let Some(&milliseconds) = times.get(times.len() / 2) else {
            return Err(format!("{program} failed on {}", text.display()).into());
        };
        if best.as_ref().is_none_or(|(least, _)| milliseconds < *least) {
            let pixels = fs::read(&image)?.split_off(ppm::header(size).len());
            best = Some((milliseconds, pixels));
        }
    }
    if best.is_none() {
        println!("splat is not drawn: make splat builds it where gcc and AVX2 are");
    }
    Ok(best)
}

/// The numbers of a phase in a line of JSON.
fn samples(line: &str, stage: &str) -> Vec<f64> {
    let after = line.split(&format!("\"{stage}\": [")).nth(1);
    let numbers = after.and_then(|rest| rest.split(']').next());
    let numbers = numbers.unwrap_or_default().split(", ");
    numbers.filter_map(|number| number.parse().ok()).collect()
}
