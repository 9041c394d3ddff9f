//! Measures the methods and draws the charts of the README and of `benches/charts`.
//!
//! ```text
//! make chart                         -- all: speed, stability, difference, growth, to benches/charts/
//! make growth                        -- growth: growth alone, to benches/charts/
//! make chart SCENES="one.txt ..."    -- one.txt ...: speed on scenes of your own, to target/charts/
//! ```
//!
//! Without arguments it draws nothing, so that plain `cargo bench` leaves the charts alone.

mod difference;
mod growth;
mod measure;
mod plot;
mod speed;
mod splat;
mod stability;

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use sfera::{scene::Scene, testing::families};

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo passes options of its own, such as --bench.
    let own: Vec<PathBuf> = std::env::args_os()
        .skip(1)
        .filter(|argument| !argument.to_string_lossy().starts_with("--"))
        .map(PathBuf::from)
        .collect();
    match own.as_slice() {
        [] => {
            println!("no chart is drawn: use make chart, or -- all");
            Ok(())
        }
        [all] if all == "all" => draw_all(Path::new("benches/charts")),
        [growth] if growth == "growth" => draw_growth(Path::new("benches/charts")),
        scenes => draw_own(scenes, Path::new("target/charts")),
    }
}

fn draw_all(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let example = read(Path::new("scenes/example.txt"))?;
    let far = read(Path::new("scenes/far.txt"))?;
    let scenes = ["cloud", "molecule", "floor", "among"].map(|name| {
        let family = families::FAMILIES.iter();
        let mut named = family.filter(|family| family.name == name);
        // A thousand spheres, or a floor a thousand times as large as the spheres on it.
        named
            .next()
            .map(|family| (name.to_owned(), family.scene(1e3, 1)))
    });
    draw_growth(folder)?;
    difference::draw(&far.1, folder)?;
    stability::draw(folder)?;
    let scenes: Vec<_> = [example, far]
        .into_iter()
        .chain(scenes.into_iter().flatten())
        .collect();
    speed::draw(&scenes, folder)?;
    println!("drawn: {}", folder.display());
    Ok(())
}

fn draw_growth(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    growth::draw(&read(Path::new("scenes/example.txt"))?.1, folder)
}

fn draw_own(paths: &[PathBuf], folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let scenes: Result<Vec<_>, _> = paths.iter().map(|path| read(path)).collect();
    speed::draw(&scenes?, folder)?;
    println!("drawn: {}", folder.join("speed.svg").display());
    Ok(())
}

/// A scene and its name.
fn read(path: &Path) -> Result<(String, Scene), Box<dyn Error>> {
    let scene = Scene::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), scene))
}
