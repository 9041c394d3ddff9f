//! Finds the common mistake that explains a wrong picture.
//!
//! The engine can draw the picture that a mistake produces. Another rule for the rays is
//! the right rule at another size: the rays through the centres of `n` pixels are every
//! second one of the `2n + 1` rays from edge to edge. A program that shows spheres behind
//! the camera shows their reflections in the origin.

use std::{
    ops::Range,
    time::{Duration, Instant},
};

use rayon::prelude::*;
use sfera::{
    camera::{BYTES_PER_PIXEL, Camera, ImageSize},
    render::{Method, Renderer},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

use super::tally::Sample;

/// A combination of mistakes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Guess {
    pub(super) orientation: Orientation,
    pub(super) columns: Rule,
    pub(super) rows: Rule,
    pub(super) depth: Depth,
}

/// A guess, and how many pixels of the sample it leaves unexplained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fit {
    pub(super) guess: Guess,
    pub(super) wrong: u64,
    pub(super) of: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Orientation {
    Right,
    UpsideDown,
    Mirrored,
    Turned,
}

/// Where pixel `i` of `n` looks through the viewport, as a fraction of its side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// `i/(n - 1)`, the right one.
    Edges,
    /// `(i + 1/2)/n`
    Centres,
    /// `i/n`
    Low,
    /// `(i + 1)/n`
    High,
    /// `(i - 1/2)/(n - 1)`
    HalfBefore,
    /// `(i + 1/2)/(n - 1)`
    HalfAfter,
}

/// Which hit along a ray is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// The nearest with t > 0.
    Nearest,
    /// The nearest on either side of the camera.
    EitherSide,
    /// The one of least t along the whole line, even behind the camera.
    Least,
    /// The nearest with t > 0, of the spheres that do not contain the camera.
    Outside,
}

impl Guess {
    const RIGHT: Self = Self {
        orientation: Orientation::Right,
        columns: Rule::Edges,
        rows: Rule::Edges,
        depth: Depth::Nearest,
    };

    /// This guess with one mistake changed.
    fn neighbours(self) -> impl Iterator<Item = Self> {
        use Orientation::{Mirrored, Right, Turned, UpsideDown};
        let orientations =
            [Right, UpsideDown, Mirrored, Turned]
                .into_iter()
                .map(move |orientation| Self {
                    orientation,
                    ..self
                });
        let rules = Rule::ALL.into_iter().flat_map(move |rule| {
            [
                Self {
                    columns: rule,
                    rows: rule,
                    ..self
                },
                Self {
                    columns: rule,
                    ..self
                },
                Self { rows: rule, ..self },
            ]
        });
        let depths = [
            Depth::Nearest,
            Depth::EitherSide,
            Depth::Least,
            Depth::Outside,
        ]
        .into_iter()
        .map(move |depth| Self { depth, ..self });
        orientations
            .chain(depths)
            .chain(rules)
            .filter(move |&guess| guess != self)
    }
}

/// A rule expressed by the right rule at another size: pixel `i` is pixel
/// `step i + first` of `side` pixels, of a viewport `stretch` times as large.
#[derive(Clone, Copy, Debug)]
struct Grid {
    side: u32,
    step: u32,
    first: u32,
    stretch: f64,
}

impl Rule {
    const ALL: [Self; 6] = [
        Self::Edges,
        Self::Centres,
        Self::Low,
        Self::High,
        Self::HalfBefore,
        Self::HalfAfter,
    ];

    fn grid(self, pixels: u32) -> Option<Grid> {
        let (side, step, first) = match self {
            Self::Edges => (Some(pixels), 1, 0),
            Self::Low => (pixels.checked_add(1), 1, 0),
            Self::High => (pixels.checked_add(1), 1, 1),
            Self::HalfBefore => (double(pixels), 2, 0),
            Self::Centres => (double(pixels), 2, 1),
            Self::HalfAfter => (double(pixels), 2, 2),
        };
        let stretch = match self {
            Self::HalfBefore | Self::HalfAfter => f64::from(pixels) / f64::from(pixels - 1),
            _ => 1.0,
        };
        Some(Grid {
            side: side?,
            step,
            first,
            stretch,
        })
        .filter(|grid| grid.stretch.is_finite())
    }
}

fn double(pixels: u32) -> Option<u32> {
    pixels.checked_mul(2)?.checked_add(1)
}

/// A guess fits if it leaves at most one of this many wrong pixels unexplained.
const UNEXPLAINED: u64 = 10;

/// The limit of pixels times spheres for intersecting every line with every sphere.
const MAX_TESTS: u64 = 200_000_000;

/// After this time no more guesses are tried; only scenes made to be hard take so long.
const PATIENCE: Duration = Duration::from_secs(30);

/// The guess that explains the sample best, if it explains nearly all of it. The search is
/// greedy: each step makes the one change that explains most.
pub(super) fn best_fit(scene: &Scene, size: ImageSize, sample: &Sample) -> Option<Fit> {
    let reaches_behind = |sphere: Sphere| sphere.centre()[2] < sphere.radius();
    let trial = Trial {
        scene,
        size,
        sample,
        behind: scene.spheres().iter().any(reaches_behind),
        inside: scene
            .spheres()
            .iter()
            .any(|sphere| contains_camera(&sphere)),
        start: Instant::now(),
    };
    let all = trial.wrong(Guess::RIGHT)?;
    let mut best = (Guess::RIGHT, all);
    loop {
        let trials = best.0.neighbours();
        let next = trials
            .filter_map(|guess| Some((guess, trial.wrong(guess)?)))
            .min_by_key(|&(_, wrong)| wrong);
        match next {
            Some(next) if next.1 < best.1 => best = next,
            _ => break,
        }
    }
    let (guess, wrong) = best;
    (wrong <= all / UNEXPLAINED && guess != Guess::RIGHT).then_some(Fit {
        guess,
        wrong,
        of: sample.pixels(),
    })
}

struct Trial<'a> {
    scene: &'a Scene,
    size: ImageSize,
    sample: &'a Sample,
    /// Whether a sphere is partly behind the camera, and whether one contains the camera.
    /// If not, the guesses about that draw the right picture.
    behind: bool,
    inside: bool,
    start: Instant,
}

impl Trial<'_> {
    /// The number of pixels of the sample that a guess leaves unexplained; `None` if it
    /// can't be tried.
    fn wrong(&self, guess: Guess) -> Option<u64> {
        let columns = guess.columns.grid(self.size.width())?;
        let rows = guess.rows.grid(self.size.height())?;
        let size = ImageSize::new(columns.side, rows.side).ok()?;
        let possible = match guess.depth {
            Depth::Nearest => true,
            Depth::EitherSide => self.behind,
            Depth::Outside => self.inside,
            Depth::Least => {
                let tests = size.pixels().checked_mul(self.scene.spheres().len() as u64);
                let share = self.size.pixels() / self.sample.pixels().max(1);
                self.behind && tests? / share.max(1) <= MAX_TESTS
            }
        };
        if !possible || self.start.elapsed() > PATIENCE {
            return None;
        }
        let altered;
        let scene = if guess.depth == Depth::Nearest && columns.stretch * rows.stretch == 1.0 {
            self.scene
        } else {
            altered = altered_scene(self.scene, guess.depth, [columns.stretch, rows.stretch])?;
            &altered
        };
        let lines = (guess.depth == Depth::Least).then(|| Lines::new(scene, size));
        let engine = Renderer::new(scene, size, Method::Exact);
        let mut drawn = Vec::new();
        let mut wrong = 0;
        for (piece, found) in &self.sample.pieces {
            let source = guess.orientation.rows(piece, self.size.height());
            let first = rows.step * source.start + rows.first;
            let source = first..rows.step * (source.end - 1) + rows.first + 1;
            drawn.resize(source.len() * size.row_bytes(), 0);
            match &lines {
                Some(lines) => lines.draw(source, &mut drawn),
                None => {
                    engine.draw(source, &mut drawn);
                }
            }
            wrong += self.differing(guess.orientation, [columns, rows], found, &drawn);
        }
        Some(wrong)
    }

    /// The number of pixels of a piece of the sample that differ from those drawn.
    fn differing(
        &self,
        orientation: Orientation,
        [columns, rows]: [Grid; 2],
        found: &[u8],
        drawn: &[u8],
    ) -> u64 {
        let (found, _) = found.as_chunks::<BYTES_PER_PIXEL>();
        let (drawn, _) = drawn.as_chunks::<BYTES_PER_PIXEL>();
        let width = self.size.width() as usize;
        let height = found.len() / width;
        let mut differing = 0;
        for (index, row) in found.chunks_exact(width).enumerate() {
            let index = if orientation.is_upside_down() {
                height - 1 - index
            } else {
                index
            };
            let begin = index * rows.step as usize * columns.side as usize;
            let picture = drawn[begin + columns.first as usize..]
                .iter()
                .step_by(columns.step as usize);
            differing += if orientation.is_mirrored() {
                count_differing(row.iter().rev(), picture)
            } else {
                count_differing(row.iter(), picture)
            };
        }
        differing
    }
}

fn count_differing<'a>(
    found: impl Iterator<Item = &'a [u8; BYTES_PER_PIXEL]>,
    drawn: impl Iterator<Item = &'a [u8; BYTES_PER_PIXEL]>,
) -> u64 {
    found
        .zip(drawn)
        .filter(|(found, drawn)| found != drawn)
        .count() as u64
}

impl Orientation {
    fn is_upside_down(self) -> bool {
        matches!(self, Self::UpsideDown | Self::Turned)
    }

    fn is_mirrored(self) -> bool {
        matches!(self, Self::Mirrored | Self::Turned)
    }

    /// The rows of the right picture that these rows would show.
    fn rows(self, rows: &Range<u32>, height: u32) -> Range<u32> {
        if self.is_upside_down() {
            height - rows.end..height - rows.start
        } else {
            rows.clone()
        }
    }
}

/// The scene of which the engine draws what a program shows that chooses hits by `depth`, in
/// a viewport stretched by these factors; `None` if that is not a valid scene.
fn altered_scene(scene: &Scene, depth: Depth, [across, upright]: [f64; 2]) -> Option<Scene> {
    let viewport = scene.viewport();
    let viewport = Viewport::new(
        (f64::from(viewport.width()) * across) as f32,
        (f64::from(viewport.height()) * upright) as f32,
        viewport.distance(),
    );
    let (viewport, background) = (viewport.ok()?, scene.background());
    let spheres = scene.spheres().iter();
    match depth {
        Depth::Nearest | Depth::Least => Scene::new(viewport, background, spheres),
        Depth::EitherSide => {
            let with_reflected = spheres.flat_map(|sphere| [Some(sphere), reflected(sphere)]);
            Scene::new(viewport, background, with_reflected.flatten())
        }
        Depth::Outside => {
            let outside = spheres.filter(|sphere| !contains_camera(sphere));
            Scene::new(viewport, background, outside)
        }
    }
    .ok()
}

/// The sphere on the other side of the camera.
fn reflected(sphere: Sphere) -> Option<Sphere> {
    let centre = sphere.centre().map(|coordinate| -coordinate);
    Sphere::new(centre, sphere.radius(), sphere.colour()).ok()
}

fn contains_camera(sphere: &Sphere) -> bool {
    let squares = sphere
        .centre()
        .map(|coordinate| f64::from(coordinate).powi(2));
    squares.iter().sum::<f64>() <= f64::from(sphere.radius()).powi(2)
}

/// Intersects whole lines instead of rays, in doubles: the hit with the least t is seen.
struct Lines<'a> {
    scene: &'a Scene,
    camera: Camera,
}

impl<'a> Lines<'a> {
    fn new(scene: &'a Scene, size: ImageSize) -> Self {
        Self {
            scene,
            camera: Camera::new(scene.viewport(), size),
        }
    }

    fn draw(&self, rows: Range<u32>, pixels: &mut [u8]) {
        let row_bytes = self.camera.size().row_bytes();
        let lines = pixels.par_chunks_exact_mut(row_bytes);
        lines.zip(rows).for_each(|(bytes, row)| {
            let (pixels, _) = bytes.as_chunks_mut::<BYTES_PER_PIXEL>();
            for (column, pixel) in (0..).zip(pixels) {
                let direction = [
                    self.camera.x_double(column),
                    self.camera.y_double(row),
                    self.camera.z_double(),
                ];
                *pixel = self
                    .first(direction)
                    .map_or(self.scene.background(), |index| {
                        self.scene.spheres().colour()[index]
                    });
            }
        });
    }

    fn first(&self, [x, y, z]: [f64; 3]) -> Option<usize> {
        let a = x * x + y * y + z * z;
        let mut least = f64::INFINITY;
        let mut first = None;
        for (index, sphere) in self.scene.spheres().iter().enumerate() {
            let [cx, cy, cz] = sphere.centre().map(f64::from);
            let radius = f64::from(sphere.radius());
            let normal = [cy * z - cz * y, cz * x - cx * z, cx * y - cy * x];
            let squared = normal.iter().map(|component| component * component);
            let d = radius * radius * a - squared.sum::<f64>();
            let t = (cx * x + cy * y + cz * z - d.sqrt()) / a;
            // Without a hit t is NaN, and the comparison is false.
            if t < least {
                (least, first) = (t, Some(index));
            }
        }
        first
    }
}
