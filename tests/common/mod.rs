//! What several test programs need.

#![allow(dead_code, reason = "each test program uses its part of this")]

use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    render::{Form, Method, Renderer},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

pub(crate) fn size(width: u32, height: u32) -> ImageSize {
    ImageSize::new(width, height).expect("a size with pixels")
}

/// A scene of spheres `(x, y, z, radius)`, each of its own colour.
pub(crate) fn scene(viewport: [f32; 3], spheres: &[[f32; 4]]) -> Scene {
    let [width, height, distance] = viewport;
    let spheres = spheres.iter().enumerate();
    Scene {
        viewport: Viewport {
            width,
            height,
            distance,
        },
        background: [0; 3],
        spheres: spheres
            .map(|(index, &[x, y, z, radius])| Sphere {
                centre: [x, y, z],
                radius,
                colour: [index as u8, (index >> 8) as u8, 255],
            })
            .collect(),
    }
}

/// The bytes of a picture, without the header.
pub(crate) fn draw(scene: &Scene, size: ImageSize, method: Method, form: Form) -> Vec<u8> {
    let mut pixels = vec![0; size.pixel_bytes()];
    Renderer::new(scene, size, method, form).draw(0..size.height(), &mut pixels, &|_| ());
    pixels
}

/// How many pixels of two pictures differ.
pub(crate) fn differing_pixels(one: &[u8], other: &[u8]) -> usize {
    assert_eq!(one.len(), other.len());
    let pixels = one.chunks_exact(BYTES_PER_PIXEL);
    pixels
        .zip(other.chunks_exact(BYTES_PER_PIXEL))
        .filter(|(one, other)| one != other)
        .count()
}
