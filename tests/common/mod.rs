//! What several test programs need.

use sfera::{
    camera::ImageSize,
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
                colour: [index as u8 + 1, (index / 256) as u8, 255],
            })
            .collect(),
    }
}
