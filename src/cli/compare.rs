//! `--compare`: every method on the user's scene, with its speed and its accuracy.

use std::{
    ops::Range,
    time::{Duration, Instant},
};

use sfera::{
    camera::ImageSize,
    render::{Form, Method, Renderer, differing_pixels},
    scene::Scene,
};

use super::{arguments::Job, failure::Failure, input::read_scene, messages::print, output::Places};

/// `--compare`: draws the exact image, and prints a table of every method.
pub(crate) fn compare(job: &Job) -> Result<(), Failure> {
    let places = Places::of(job)?;
    let scene = read_scene(job)?;
    let mut output = places.open_image(job)?;
    let mut comparison = Comparison::new(&scene, job.size());
    output.draw(job.rows(), |rows, pixels| {
        comparison.draw(&rows, pixels);
        Ok(())
    })?;
    output.publish(&places)?;
    print(comparison.table().as_bytes())
}

/// One line of the table.
#[derive(Debug)]
struct Entrant<'scene> {
    method: Method,
    renderer: Renderer<'scene>,
    time: Duration,
    wrong: u64,
}

/// All methods over the same rows.
#[derive(Debug)]
struct Comparison<'scene> {
    size: ImageSize,
    exact: Entrant<'scene>,
    others: Vec<Entrant<'scene>>,
    /// Whether the reference is drawn too.
    affordable: bool,
    pixels: Vec<u8>,
}

/// The limit of pixels times spheres for the reference: some seconds of work.
const MAX_REFERENCE_TESTS: u64 = 40_000_000;

/// A picture that takes less than this is drawn again, for a median.
const SHORT: Duration = Duration::from_millis(100);

/// How many times such a picture is drawn.
const RUNS: usize = 5;

impl<'scene> Comparison<'scene> {
    fn new(scene: &'scene Scene, size: ImageSize) -> Self {
        let entrant = |method| Entrant {
            method,
            renderer: Renderer::new(scene, size, method),
            time: Duration::ZERO,
            wrong: 0,
        };
        let affordable =
            size.pixels().saturating_mul(scene.spheres().len() as u64) <= MAX_REFERENCE_TESTS;
        let mut others = Vec::new();
        for method in [Method::Textbook, Method::Geometric, Method::Double] {
            others.push(entrant(method(Form::Scalar)));
            others.push(entrant(method(Form::Packets)));
        }
        if affordable {
            others.push(entrant(Method::Reference));
        }
        Self {
            size,
            exact: entrant(Method::Exact),
            others,
            affordable,
            pixels: Vec::new(),
        }
    }

    /// Draws `rows` with every method, and leaves the exact ones in `right`.
    fn draw(&mut self, rows: &Range<u32>, right: &mut [u8]) {
        self.exact.draw(rows, right);
        self.pixels.resize(right.len(), 0);
        for entrant in &mut self.others {
            entrant.draw(rows, &mut self.pixels);
            entrant.wrong += differing_pixels(&self.pixels, right);
        }
    }

    fn table(&self) -> String {
        let mut table =
            "method     form     milliseconds  million pixels/s  wrong pixels  wrong per million\n"
                .to_string();
        let pixels = self.size.pixels() as f64;
        for entrant in self.others.iter().chain([&self.exact]) {
            let seconds = entrant.time.as_secs_f64();
            table += &format!(
                "{:<10} {:<8} {:>12.2} {:>17.1} {:>13} {:>18.2}\n",
                entrant.method,
                entrant
                    .method
                    .form()
                    .map_or_else(String::new, |form| form.to_string()),
                seconds * 1e3,
                pixels / seconds / 1e6,
                entrant.wrong,
                entrant.wrong as f64 / pixels * 1e6,
            );
        }
        if !self.affordable {
            table += "(left out: reference, which would take too long at this size; exact is proven equal to it)\n";
        }
        table
    }
}

impl Entrant<'_> {
    /// Draws once or, if that is quick, several times, and adds the median time.
    fn draw(&mut self, rows: &Range<u32>, pixels: &mut [u8]) {
        let mut times = Vec::with_capacity(RUNS);
        loop {
            let start = Instant::now();
            self.renderer.draw(rows.clone(), pixels);
            times.push(start.elapsed());
            if times.len() == RUNS || times[0] > SHORT {
                break;
            }
        }
        times.sort_unstable();
        self.time += times[times.len() / 2];
    }
}
