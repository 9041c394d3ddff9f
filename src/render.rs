//! The driver: draws bands of rows on all threads, by any method.

use std::{fmt, ops::Range, str::FromStr};

use rayon::prelude::*;
use wide::{f32x8, f64x4};

pub use crate::exact::{Counts, Workspace};
use crate::{
    camera::{BYTES_PER_PIXEL, Camera, DOUBLE_LANES, ImageSize},
    exact::{Engine, tuning::Tuning},
    methods::{NONE, Seen, double, geometric, textbook},
    reference::Reference,
    scene::Scene,
    spheres::{LANES, Rgb, Spheres},
};

/// How the colour of a pixel is computed.
///
/// Read from a name, a float method has the form [`Form::Packets`].
///
/// ```
/// use sfera::render::{Form, Method};
///
/// assert_eq!("textbook".parse(), Ok(Method::Textbook(Form::Packets)));
/// assert_eq!(Method::Textbook(Form::Scalar).to_string(), "textbook");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Method {
    /// f32, the textbook formula.
    Textbook(Form),
    /// f32, the stable form.
    Geometric(Form),
    /// f64, the textbook formula.
    Double(Form),
    /// The engine: every pixel proven right.
    #[default]
    Exact,
    /// The definition of the picture in integers, one pixel at a time: slow.
    Reference,
}

/// How many pixels a float method computes at a time; the bytes are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Form {
    /// One pixel at a time.
    Scalar,
    /// 8 pixels of a row at a time (4 in doubles).
    #[default]
    Packets,
}

impl Method {
    /// The form of a float method.
    #[must_use]
    pub fn form(self) -> Option<Form> {
        match self {
            Self::Textbook(form) | Self::Geometric(form) | Self::Double(form) => Some(form),
            Self::Exact | Self::Reference => None,
        }
    }
}

/// The name that `--method` takes.
impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Textbook(_) => "textbook",
            Self::Geometric(_) => "geometric",
            Self::Double(_) => "double",
            Self::Exact => "exact",
            Self::Reference => "reference",
        })
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Scalar => "scalar",
            Self::Packets => "packets",
        })
    }
}

/// The error for a name that no method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {0:?}; there are textbook, geometric, double, exact and reference")]
pub struct UnknownMethod(String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let form = Form::default();
        [
            Self::Textbook(form),
            Self::Geometric(form),
            Self::Double(form),
            Self::Exact,
            Self::Reference,
        ]
        .into_iter()
        .find(|method| method.to_string() == name)
        .ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

impl Scene {
    /// The exact picture of the scene, on the current rayon thread pool: 3 bytes a pixel,
    /// red, green and blue, rows from the top, pixels from the left.
    ///
    /// ```
    /// use sfera::{camera::ImageSize, scene::Scene};
    ///
    /// let scene: Scene = "VP 1 1 1  BG 255 255 255  OBJ_N 1  S 0 0 5 1 200 0 0".parse()?;
    /// let pixels = scene.render(ImageSize::new(3, 1)?);
    /// assert_eq!(pixels, [255, 255, 255, 200, 0, 0, 255, 255, 255]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn render(&self, size: ImageSize) -> Vec<u8> {
        let mut pixels = vec![0; size.pixel_bytes()];
        Renderer::new(self, size, Method::Exact).draw(0..size.height(), &mut pixels);
        pixels
    }
}

/// The number of pixels that differ between two pictures, or between the same rows of them.
/// If one is longer, its additional pixels are not counted.
///
/// ```
/// assert_eq!(sfera::render::differing_pixels(&[1, 2, 3, 4, 5, 6], &[1, 2, 3, 0, 0, 0]), 1);
/// ```
#[must_use]
pub fn differing_pixels(one: &[u8], other: &[u8]) -> u64 {
    let (one, _) = one.as_chunks::<BYTES_PER_PIXEL>();
    let (other, _) = other.as_chunks::<BYTES_PER_PIXEL>();
    one.iter().zip(other).filter(|(a, b)| a != b).count() as u64
}

/// A scene ready to be drawn at one size by one method.
#[derive(Debug)]
pub struct Renderer<'scene> {
    scene: &'scene Scene,
    camera: Camera,
    painter: Painter<'scene>,
}

/// What a method has prepared before the first pixel.
#[derive(Debug)]
enum Painter<'scene> {
    Textbook(Form),
    Geometric(Form),
    Double(Form),
    Exact(Engine<'scene>),
    Reference(Reference),
}

impl<'scene> Renderer<'scene> {
    /// Prepares everything that the method needs before the first pixel.
    #[must_use]
    pub fn new(scene: &'scene Scene, size: ImageSize, method: Method) -> Self {
        Self::new_in(Workspace::default(), scene, size, method)
    }

    /// Like [`new`](Self::new), in the memory of another renderer.
    ///
    /// ```
    /// use sfera::{camera::ImageSize, render::{Method, Renderer, Workspace}, scene::Scene};
    ///
    /// let size = ImageSize::new(16, 9)?;
    /// let mut pixels = vec![0; size.pixel_bytes()];
    /// let mut workspace = Workspace::default();
    /// for x in [-1, 0, 1] {
    ///     let scene: Scene = format!("VP 16 9 9 BG 0 0 0 OBJ_N 1 S {x} 0 5 1 9 9 9").parse()?;
    ///     let renderer = Renderer::new_in(workspace, &scene, size, Method::Exact);
    ///     renderer.draw(0..size.height(), &mut pixels);
    ///     workspace = renderer.into_workspace();
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new_in(
        workspace: Workspace,
        scene: &'scene Scene,
        size: ImageSize,
        method: Method,
    ) -> Self {
        Self::tuned(workspace, scene, size, method, Tuning::default())
    }

    /// Like [`new_in`](Self::new_in), with settings of the engine for tests and benches.
    pub(crate) fn tuned(
        workspace: Workspace,
        scene: &'scene Scene,
        size: ImageSize,
        method: Method,
        tuning: Tuning,
    ) -> Self {
        let camera = Camera::new(scene.viewport, size);
        let painter = match method {
            Method::Textbook(form) => Painter::Textbook(form),
            Method::Geometric(form) => Painter::Geometric(form),
            Method::Double(form) => Painter::Double(form),
            Method::Exact => Painter::Exact(Engine::new(scene, camera, tuning, workspace)),
            Method::Reference => Painter::Reference(Reference::new(scene, size)),
        };
        Self {
            scene,
            camera,
            painter,
        }
    }

    /// Returns its memory, for another renderer.
    #[must_use]
    pub fn into_workspace(self) -> Workspace {
        match self.painter {
            Painter::Exact(engine) => engine.into_workspace(),
            _ => Workspace::default(),
        }
    }

    /// Draws `rows` of the picture into `pixels`, their bytes in RGB, in bands
    /// on the current rayon thread pool. The counts are those of [`Method::Exact`];
    /// other methods leave them at zero.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image, or `pixels` is not exactly as long as their bytes.
    pub fn draw(&self, rows: Range<u32>, pixels: &mut [u8]) -> Counts {
        self.draw_with_progress(rows, pixels, &|_| ())
    }

    /// Like [`draw`](Self::draw), and calls `drawn` with the number of rows of each finished
    /// band, on the thread that drew it.
    ///
    /// # Panics
    ///
    /// If `rows` reach past the image, or `pixels` is not exactly as long as their bytes.
    pub fn draw_with_progress(
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
        let draw = |band: Range<u32>, bytes: &mut [u8]| {
            let counts = self.draw_band(band.clone(), bytes);
            drawn(band.len() as u32);
            counts
        };
        let sum = |mut sum: Counts, counts| {
            sum += counts;
            sum
        };
        // Except for the first and the last, bands are whole rows of the engine's tiles.
        let start = rows.start.checked_next_multiple_of(band_rows);
        let start = start.map_or(rows.end, |start| start.min(rows.end));
        let head = rows.start..start;
        let (head_bytes, rest) = pixels.split_at_mut(head.len() * size.row_bytes());
        let mut counts = Counts::default();
        if !head.is_empty() {
            counts += draw(head, head_bytes);
        }
        counts += rest
            .par_chunks_mut(size.row_bytes() * band_rows as usize)
            .enumerate()
            .map(|(band, bytes)| {
                let first = start + band as u32 * band_rows;
                draw(first..first.saturating_add(band_rows).min(rows.end), bytes)
            })
            .reduce(Counts::default, sum);
        counts
    }

    fn draw_band(&self, band: Range<u32>, bytes: &mut [u8]) -> Counts {
        if let Painter::Exact(engine) = &self.painter {
            return engine.draw_band(band, bytes);
        }
        for (row, bytes) in band.zip(bytes.chunks_exact_mut(self.camera.size().row_bytes())) {
            match &self.painter {
                Painter::Textbook(Form::Scalar) => self.fill_rays(row, bytes, textbook::scalar),
                Painter::Textbook(Form::Packets) => self.fill_packets(row, bytes, textbook::packet),
                Painter::Geometric(Form::Scalar) => self.fill_rays(row, bytes, geometric::scalar),
                Painter::Geometric(Form::Packets) => {
                    self.fill_packets(row, bytes, geometric::packet);
                }
                Painter::Double(Form::Scalar) => self.fill_double_rays(row, bytes, double::scalar),
                Painter::Double(Form::Packets) => {
                    self.fill_double_packets(row, bytes, double::packet);
                }
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

    fn fill_double_rays(&self, row: u32, bytes: &mut [u8], kernel: fn(&Spheres, [f64; 3]) -> Seen) {
        let (y, z) = (self.camera.y_double(row), self.camera.z_double());
        self.fill(bytes, |column| {
            [kernel(
                &self.scene.spheres,
                [self.camera.x_double(column), y, z],
            )]
        });
    }

    fn fill_double_packets(
        &self,
        row: u32,
        bytes: &mut [u8],
        kernel: fn(&Spheres, f64x4, f64, f64) -> [Seen; DOUBLE_LANES],
    ) {
        let (y, z) = (self.camera.y_double(row), self.camera.z_double());
        self.fill(bytes, |column| {
            kernel(&self.scene.spheres, self.camera.x_doubles(column), y, z)
        });
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

/// Rows of a band: enough to be worth a task, and few enough to distribute them evenly.
const BAND_ROWS: u32 = 16;
