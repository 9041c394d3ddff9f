//! Helpers of several test programs.

#![allow(dead_code, reason = "each test program uses its part of this")]

use sfera::{
    camera::ImageSize,
    render::{Method, Renderer},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

pub(crate) fn size(width: u32, height: u32) -> ImageSize {
    ImageSize::new(width, height).expect("a size with pixels")
}

/// A scene of spheres `(x, y, z, radius)`, each of its own colour.
pub(crate) fn scene(viewport: [f32; 3], spheres: &[[f32; 4]]) -> Scene {
    let [width, height, distance] = viewport;
    let viewport = Viewport::new(width, height, distance).expect("a viewport");
    let spheres = spheres.iter().enumerate();
    let spheres = spheres.map(|(index, &[x, y, z, radius])| {
        let colour = [index as u8, (index >> 8) as u8, 255];
        Sphere::new([x, y, z], radius, colour).expect("a sphere")
    });
    Scene::new(viewport, [0; 3], spheres).expect("a scene")
}

/// The bytes of a picture, without the header.
pub(crate) fn draw(scene: &Scene, size: ImageSize, method: Method) -> Vec<u8> {
    let mut pixels = vec![0; size.pixel_bytes()];
    Renderer::new(scene, size, method).draw(0..size.height(), &mut pixels);
    pixels
}
