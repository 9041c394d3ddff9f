//! Draws scenes by every method and prints what came of it, a line a picture, for
//! `make everywhere` to compare between machines:
//!
//! ```text
//! everywhere make FOLDER                     a scene of every family and difficulty, if small
//! everywhere draw WIDTH HEIGHT SCENE...      of a folder all that are in it
//!
//! 2f563349eb8fb4bd exact scenes/example.txt, 0 wrong pixels
//! ```
//!
//! Ends with 1 if a picture of the engine differs from the reference.

use std::{
    env,
    error::Error,
    fs,
    hash::{DefaultHasher, Hasher},
    path::{Path, PathBuf},
    process::ExitCode,
};

use sfera::{
    camera::ImageSize,
    render::{Form, Method, Renderer, differing_pixels},
    scene::Scene,
    testing::families::FAMILIES,
};

/// No other test draws these.
const SEED: u64 = 77;

/// More of them take an emulated reference too long.
const MOST_SPHERES: usize = 1_500;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        ["make", folder] => make(Path::new(folder)),
        ["draw", width, height, scenes @ ..] => draw_all(width, height, scenes),
        _ => Err("usage: everywhere make FOLDER, or draw WIDTH HEIGHT SCENE...".into()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("everywhere: {error}");
            ExitCode::FAILURE
        }
    }
}

fn make(folder: &Path) -> Outcome<()> {
    for family in FAMILIES {
        for difficulty in family.difficulties {
            let name = format!("{} {difficulty:e}.txt", family.name).replace(' ', "-");
            let scene = family.scene(*difficulty, SEED);
            if scene.spheres().len() <= MOST_SPHERES {
                fs::write(folder.join(name), scene.to_string())?;
            }
        }
    }
    Ok(())
}

fn draw_all(width: &str, height: &str, scenes: &[&str]) -> Outcome<()> {
    let size = ImageSize::new(width.parse()?, height.parse()?)?;
    let mut wrong = 0;
    for name in scenes {
        for path in files(Path::new(name))? {
            wrong += draw_one(&path, size)?;
        }
    }
    if wrong > 0 {
        return Err(format!("{wrong} wrong pixels").into());
    }
    Ok(())
}

/// A file, or those of a folder.
fn files(path: &Path) -> Outcome<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = fs::read_dir(path)?;
    let mut files = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Outcome<Vec<_>>>()?;
    files.sort();
    Ok(files)
}

/// How many pixels of the engine's picture are wrong.
fn draw_one(path: &Path, size: ImageSize) -> Outcome<u64> {
    let scene = Scene::read(path)?;
    let draw = |method| {
        let mut pixels = vec![0; size.pixel_bytes()];
        let renderer = Renderer::new(&scene, size, method);
        renderer.draw(0..size.height(), &mut pixels);
        pixels
    };
    let name = path.file_name().unwrap_or_default().display();
    for method in [Method::Textbook, Method::Geometric, Method::Double] {
        let method = method(Form::Packets);
        println!("{:016x} {method} {name}", hash(&draw(method)));
    }
    let exact = draw(Method::Exact);
    let wrong = differing_pixels(&exact, &draw(Method::Reference));
    println!("{:016x} exact {name}, {wrong} wrong pixels", hash(&exact));
    Ok(wrong)
}

fn hash(pixels: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(pixels);
    hasher.finish()
}
