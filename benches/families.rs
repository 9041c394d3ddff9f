//! Writes every family of scenes to a folder: `make families`; or one uniform
//! cloud to a file: `cargo bench --bench families -- cloud COUNT FILE`.

use std::{error::Error, fmt::Write, fs, path::PathBuf};

use sfera::{
    families::{FAMILIES, cloud},
    scene::Scene,
};

const SEEDS: u64 = 8;

const CLOUD_SEED: u64 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo passes options of its own, such as --bench.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    if let [word, count, file] = arguments.as_slice()
        && word == "cloud"
    {
        fs::write(file, text(&cloud(count.parse()?, CLOUD_SEED)))?;
        return Ok(());
    }
    let folder = PathBuf::from(arguments.first().map_or("target/families", String::as_str));
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
