//! The program: arguments, `run()`, one error line.

use std::{path::PathBuf, process::ExitCode};

use clap::Parser;
use sfera::{
    camera::ImageSize,
    ppm::MappedImage,
    render::{Form, Method, Renderer},
    scene::Scene,
};

/// Renders a scene of flat-coloured spheres to a binary PPM.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    scene: PathBuf,
    image: PathBuf,
    width: u32,
    height: u32,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("sfera: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::read(&arguments.scene)?;
    let size = ImageSize::new(arguments.width, arguments.height)?;
    let mut image = MappedImage::create(&arguments.image, size)?;
    let renderer = Renderer::new(&scene, size, Method::default(), Form::default());
    renderer.draw(0..size.height(), image.pixels_mut(), &|_| ());
    image.publish()?;
    Ok(())
}
