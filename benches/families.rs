//! Not a bench, but the program that writes scenes of the families to files, for `make
//! families`, `make peers` and measurements by hand:
//!
//! ```text
//! cargo bench --bench families -- FOLDER             every family, difficulty and seed
//! cargo bench --bench families -- cloud 1e6 FILE     one scene
//! ```
//!
//! Without arguments it writes nothing.

use std::{error::Error, fs, path::PathBuf};

use sfera::testing::families::{FAMILIES, Family};

const SEEDS: u64 = 8;

/// The seed of a single scene.
const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo passes options of its own, such as --bench.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with("--"))
        .collect();
    if let [name, difficulty, file] = arguments.as_slice() {
        let named = |family: &&Family| family.name.replace(' ', "-") == *name;
        let family = FAMILIES.iter().find(named);
        let family = family.ok_or_else(|| format!("no such family: {name}"))?;
        fs::write(file, family.scene(difficulty.parse()?, SEED).to_string())?;
        return Ok(());
    }
    let [folder] = arguments.as_slice() else {
        println!("no scene is written: use make families, or -- FOLDER");
        return Ok(());
    };
    let folder = PathBuf::from(folder);
    let mut written = 0;
    for family in FAMILIES {
        let folder = folder.join(family.name.replace(' ', "-"));
        fs::create_dir_all(&folder)?;
        for &difficulty in family.difficulties {
            for seed in 0..SEEDS {
                let path = folder.join(format!("{difficulty:e}-{seed}.txt"));
                fs::write(path, family.scene(difficulty, seed).to_string())?;
                written += 1;
            }
        }
    }
    println!("{written} scenes: {}", folder.display());
    Ok(())
}
