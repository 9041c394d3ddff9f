//! Draws scenes by every method and prints what came of it, a line a picture, for
//! `make everywhere` to compare between machines:
//!
//! ```text
//! everywhere WIDTH HEIGHT SCENE...
//! 9f0e... exact scenes/example.txt, 0 wrong pixels
//! ```
//!
//! Ends with 1 if a picture of the engine differs from the reference.

use std::{
    env,
    error::Error,
    hash::{DefaultHasher, Hasher},
    process::ExitCode,
};

use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    render::{Form, Method, Renderer},
    scene::Scene,
};

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match draw_all(&arguments) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(wrong) => {
            eprintln!("everywhere: {wrong} wrong pixels");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("everywhere: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The wrong pixels of all pictures of the engine.
fn draw_all(arguments: &[String]) -> Result<usize, Box<dyn Error>> {
    let [width, height, scenes @ ..] = arguments else {
        return Err("usage: everywhere WIDTH HEIGHT SCENE...".into());
    };
    let size = ImageSize::new(width.parse()?, height.parse()?)?;
    let mut wrong_pixels = 0;
    for name in scenes {
        let scene = Scene::read(name.as_ref())?;
        let draw = |method| {
            let mut pixels = vec![0; size.pixel_bytes()];
            let renderer = Renderer::new(&scene, size, method, Form::Packets);
            renderer.draw(0..size.height(), &mut pixels, &|_| ());
            pixels
        };
        for method in [Method::Textbook, Method::Geometric, Method::Double] {
            println!("{:016x} {method} {name}", hash(&draw(method)));
        }
        let exact = draw(Method::Exact);
        let wrong = differing_pixels(&exact, &draw(Method::Reference));
        println!("{:016x} exact {name}, {wrong} wrong pixels", hash(&exact));
        wrong_pixels += wrong;
    }
    Ok(wrong_pixels)
}

fn hash(pixels: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(pixels);
    hasher.finish()
}

fn differing_pixels(one: &[u8], other: &[u8]) -> usize {
    let pixels = one.chunks_exact(BYTES_PER_PIXEL);
    pixels
        .zip(other.chunks_exact(BYTES_PER_PIXEL))
        .filter(|(one, other)| one != other)
        .count()
}
