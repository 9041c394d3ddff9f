//! Writes every family of scenes to a folder: `make families`.

use std::{error::Error, fmt::Write, fs, path::PathBuf};

use sfera::{families::FAMILIES, scene::Scene};

const SEEDS: u64 = 8;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo passes options of its own, such as --bench.
    let folder = std::env::args_os()
        .skip(1)
        .find(|argument| !argument.to_string_lossy().starts_with("--"))
        .map_or_else(|| PathBuf::from("target/families"), PathBuf::from);
    let mut written = 0;
    for family in FAMILIES {
        let folder = folder.join(family.name.replace(' ', "-"));
        fs::create_dir_all(&folder)?;
        for &difficulty in family.difficulties {
            for seed in 0..SEEDS {
                let path = folder.join(format!("{difficulty:e}-{seed}.txt"));
                fs::write(path, text(&family.scene(difficulty, seed)))?;
                written += 1;
            }
        }
    }
    println!("{written} scenes: {}", folder.display());
    Ok(())
}

fn text(scene: &Scene) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "VP {} {} {}",
        scene.viewport.width, scene.viewport.height, scene.viewport.distance
    );
    let [r, g, b] = scene.background;
    let _ = writeln!(text, "BG {r} {g} {b}\nOBJ_N {}", scene.spheres.len());
    for sphere in scene.spheres.iter() {
        let [x, y, z] = sphere.centre;
        let [r, g, b] = sphere.colour;
        let _ = writeln!(text, "S {x} {y} {z} {} {r} {g} {b}", sphere.radius);
    }
    text
}
