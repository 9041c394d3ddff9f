//! The driver: bands of rows -> pixels -> bytes.

use std::ops::Range;

use rayon::prelude::*;
use wide::f32x8;

use crate::{
    camera::{BYTES_PER_PIXEL, Camera, DOUBLE_LANES, ImageSize},
    methods::{NONE, Seen, double, geometric, textbook},
    scene::Scene,
    spheres::{LANES, Rgb},
};

/// How the colour of a pixel is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// f32, the formula as taught.
    #[default]
    Textbook,
    /// f32, the stable form.
    Geometric,
    /// f64, the formula as taught.
    Double,
}

/// How a float method runs through the pixels; the bytes are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Form {
    /// One pixel at a time.
    Scalar,
    /// 8 pixels of a row at a time (4 in doubles).
    #[default]
    Packets,
}

/// A scene ready to be drawn at one size by one method.
#[derive(Debug)]
pub struct Renderer<'scene> {
    scene: &'scene Scene,
    camera: Camera,
    method: Method,
    form: Form,
}

impl<'scene> Renderer<'scene> {
    /// Prepares what the method needs to know before the first pixel.
    #[must_use]
    pub fn new(scene: &'scene Scene, size: ImageSize, method: Method, form: Form) -> Self {
        Self {
            scene,
            camera: Camera::new(scene.viewport, size),
            method,
            form,
        }
    }

    /// Draws `rows` of the picture into `pixels`, their bytes in RGB, in bands
    /// on the current rayon thread pool. `drawn` is told the rows of each
    /// finished band.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image or `pixels` is not exactly their bytes.
    pub fn draw(&self, rows: Range<u32>, pixels: &mut [u8], drawn: &(dyn Fn(u32) + Sync)) {
        let size = self.camera.size();
        assert!(
            rows.end <= size.height(),
            "rows {rows:?} of an image of {}",
            size.height()
        );
        assert_eq!(
            pixels.len(),
            rows.len() * size.row_bytes(),
            "bytes of rows {rows:?}"
        );
        pixels
            .par_chunks_mut(size.row_bytes() * BAND_ROWS as usize)
            .enumerate()
            .for_each(|(band, bytes)| {
                let first = rows.start + band as u32 * BAND_ROWS;
                for (row, row_bytes) in bytes.chunks_exact_mut(size.row_bytes()).enumerate() {
                    self.draw_row(first + row as u32, row_bytes);
                }
                drawn((bytes.len() / size.row_bytes()) as u32);
            });
    }

    fn draw_row(&self, row: u32, bytes: &mut [u8]) {
        let spheres = &self.scene.spheres;
        let camera = &self.camera;
        let (y, z) = (camera.y_float(row), camera.z_float());
        let (y_double, z_double) = (camera.y_double(row), camera.z_double());
        let by_float = |kernel: fn(&_, f32x8, f32, f32) -> [Seen; LANES], bytes| {
            self.fill_packets(bytes, |column| {
                kernel(spheres, camera.x_floats(column), y, z)
            });
        };
        let by_ray = |kernel: fn(&_, [f32; 3]) -> Seen, bytes| {
            self.fill_packets(bytes, |column| {
                [kernel(spheres, [camera.x_float(column), y, z])]
            });
        };
        match (self.method, self.form) {
            (Method::Textbook, Form::Scalar) => by_ray(textbook::scalar, bytes),
            (Method::Textbook, Form::Packets) => by_float(textbook::packet, bytes),
            (Method::Geometric, Form::Scalar) => by_ray(geometric::scalar, bytes),
            (Method::Geometric, Form::Packets) => by_float(geometric::packet, bytes),
            (Method::Double, Form::Scalar) => self.fill_packets(bytes, |column| {
                [double::scalar(
                    spheres,
                    [camera.x_double(column), y_double, z_double],
                )]
            }),
            (Method::Double, Form::Packets) => self.fill_packets::<DOUBLE_LANES>(bytes, |column| {
                double::packet(spheres, camera.x_doubles(column), y_double, z_double)
            }),
        }
    }

    /// Colours a row, `N` pixels at a time; lanes past its end are dropped.
    fn fill_packets<const N: usize>(&self, row: &mut [u8], seen: impl Fn(u32) -> [Seen; N]) {
        for (packet, bytes) in row.chunks_mut(N * BYTES_PER_PIXEL).enumerate() {
            let seen = seen((packet * N) as u32);
            for (pixel, seen) in bytes.chunks_exact_mut(BYTES_PER_PIXEL).zip(seen) {
                pixel.copy_from_slice(&self.colour(seen));
            }
        }
    }

    fn colour(&self, seen: Seen) -> Rgb {
        if seen == NONE {
            self.scene.background
        } else {
            self.scene.spheres.colour()[seen as usize]
        }
    }
}

/// Rows of a band: enough to be worth a task, few enough to share out evenly.
const BAND_ROWS: u32 = 16;
