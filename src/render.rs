//! The driver: bands of rows -> pixels -> bytes.

use std::{fmt, ops::Range};

use rayon::prelude::*;
use wide::f32x8;

pub use crate::exact::{Bounds, Counts, Tuning};
use crate::{
    camera::{BYTES_PER_PIXEL, Camera, ImageSize},
    exact::{Engine, Scratch},
    methods::{NONE, Seen, double, geometric, textbook},
    reference::Reference,
    scene::Scene,
    spheres::{LANES, Rgb, Spheres},
};

/// How the colour of a pixel is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Method {
    /// f32, the formula as taught.
    Textbook,
    /// f32, the stable form.
    Geometric,
    /// f64, the formula as taught.
    Double,
    /// The engine: every pixel proven right.
    #[default]
    Exact,
    /// The meaning of the picture in integers, one pixel at a time: slow.
    Reference,
}

/// The name that `--method` knows it by.
impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Textbook => "textbook",
            Self::Geometric => "geometric",
            Self::Double => "double",
            Self::Exact => "exact",
            Self::Reference => "reference",
        })
    }
}

/// How a float method runs through the pixels; the bytes are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
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
    painter: Painter<'scene>,
}

/// What a method prepares before the first pixel.
#[derive(Debug)]
enum Painter<'scene> {
    Textbook(Form),
    Geometric(Form),
    Double(Form),
    Exact(Engine<'scene>),
    Reference(Reference),
}

impl<'scene> Renderer<'scene> {
    /// Prepares what the method needs to know before the first pixel. `form` is
    /// for the float methods; the others have one.
    #[must_use]
    pub fn new(scene: &'scene Scene, size: ImageSize, method: Method, form: Form) -> Self {
        Self::tuned(scene, size, method, form, Tuning::default())
    }

    /// As [`new`](Self::new), with the engine's knobs in hand, for tests and benches.
    #[doc(hidden)]
    #[must_use]
    pub fn tuned(
        scene: &'scene Scene,
        size: ImageSize,
        method: Method,
        form: Form,
        tuning: Tuning,
    ) -> Self {
        let camera = Camera::new(scene.viewport, size);
        let painter = match method {
            Method::Textbook => Painter::Textbook(form),
            Method::Geometric => Painter::Geometric(form),
            Method::Double => Painter::Double(form),
            Method::Exact => Painter::Exact(Engine::new(scene, camera, tuning)),
            Method::Reference => Painter::Reference(Reference::new(scene, size)),
        };
        Self {
            scene,
            camera,
            painter,
        }
    }

    /// Draws `rows` of the picture into `pixels`, their bytes in RGB, in bands
    /// on the current rayon thread pool. `drawn` is told the rows of each
    /// finished band. The counts are those of [`Method::Exact`]; other methods
    /// leave them at zero.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image or `pixels` is not exactly their bytes.
    pub fn draw(
        &self,
        rows: Range<u32>,
        pixels: &mut [u8],
        drawn: &(dyn Fn(u32) + Sync),
    ) -> Counts {
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
        let band_rows = match &self.painter {
            Painter::Exact(engine) => engine.band_rows(),
            _ => BAND_ROWS,
        };
        let draw = |scratch: &mut Scratch, band: Range<u32>, bytes: &mut [u8]| {
            let counts = self.draw_band(band.clone(), bytes, scratch);
            drawn(band.len() as u32);
            counts
        };
        let sum = |mut sum: Counts, counts| {
            sum += counts;
            sum
        };
        // Bands are whole rows of the engine's tiles but for the first and the last.
        let start = rows.start.checked_next_multiple_of(band_rows);
        let start = start.map_or(rows.end, |start| start.min(rows.end));
        let head = rows.start..start;
        let (head_bytes, rest) = pixels.split_at_mut(head.len() * size.row_bytes());
        let mut counts = Counts::default();
        if !head.is_empty() {
            counts += draw(&mut Scratch::default(), head, head_bytes);
        }
        counts += rest
            .par_chunks_mut(size.row_bytes() * band_rows as usize)
            .enumerate()
            .map_init(Scratch::default, |scratch, (band, bytes)| {
                let first = start + band as u32 * band_rows;
                draw(
                    scratch,
                    first..first.saturating_add(band_rows).min(rows.end),
                    bytes,
                )
            })
            .reduce(Counts::default, sum);
        counts
    }

    fn draw_band(&self, band: Range<u32>, bytes: &mut [u8], scratch: &mut Scratch) -> Counts {
        if let Painter::Exact(engine) = &self.painter {
            return engine.draw_band(band, bytes, scratch);
        }
        for (row, bytes) in band.zip(bytes.chunks_exact_mut(self.camera.size().row_bytes())) {
            match &self.painter {
                Painter::Textbook(Form::Scalar) => self.fill_rays(row, bytes, textbook::scalar),
                Painter::Textbook(Form::Packets) => self.fill_packets(row, bytes, textbook::packet),
                Painter::Geometric(Form::Scalar) => self.fill_rays(row, bytes, geometric::scalar),
                Painter::Geometric(Form::Packets) => {
                    self.fill_packets(row, bytes, geometric::packet);
                }
                Painter::Double(form) => self.fill_doubles(row, bytes, *form),
                Painter::Exact(_) => unreachable!("drawn by the band"),
                Painter::Reference(reference) => self.fill(bytes, |column| {
                    [reference
                        .seen(column, row)
                        .map_or(NONE, |index| index as Seen)]
                }),
            }
        }
        Counts::default()
    }

    fn fill_rays(&self, row: u32, bytes: &mut [u8], kernel: fn(&Spheres, [f32; 3]) -> Seen) {
        let (y, z) = (self.camera.y_float(row), self.camera.z_float());
        self.fill(bytes, |column| {
            [kernel(
                &self.scene.spheres,
                [self.camera.x_float(column), y, z],
            )]
        });
    }

    fn fill_packets(
        &self,
        row: u32,
        bytes: &mut [u8],
        kernel: fn(&Spheres, f32x8, f32, f32) -> [Seen; LANES],
    ) {
        let (y, z) = (self.camera.y_float(row), self.camera.z_float());
        self.fill(bytes, |column| {
            kernel(&self.scene.spheres, self.camera.x_floats(column), y, z)
        });
    }

    fn fill_doubles(&self, row: u32, bytes: &mut [u8], form: Form) {
        let (y, z) = (self.camera.y_double(row), self.camera.z_double());
        let spheres = &self.scene.spheres;
        match form {
            Form::Scalar => {
                self.fill(bytes, |column| {
                    [double::scalar(
                        spheres,
                        [self.camera.x_double(column), y, z],
                    )]
                });
            }
            Form::Packets => {
                self.fill(bytes, |column| {
                    double::packet(spheres, self.camera.x_doubles(column), y, z)
                });
            }
        }
    }

    /// Colours a row, `N` pixels at a time; lanes past its end are dropped.
    fn fill<const N: usize>(&self, row: &mut [u8], seen: impl Fn(u32) -> [Seen; N]) {
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
