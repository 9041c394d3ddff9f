//! What the tests of bounds share: hard cases by the number of the trial, and what
//! is true of them, in dyadic rationals.
//!
//! Columns and rows may be any doubles here: what holds for every real point of a
//! picture holds for its pixels, and can be asked right beside an edge.
//!
//! What is true is computed here, and shares no code with [`integers`](super::integers), which decide
//! the order of hits. Those are tested against the [`reference`](mod@crate::reference), and the reference
//! against `tests/oracle.py`.

use std::cmp::Ordering;

use dashu::float::FBig;
use wide::f64x8;

use super::{
    bins::Record,
    boxes::PixelBox,
    coverage::Tile,
    depths::Rectangles,
    grid::{EightSpheres, Grid, SIDE},
};
pub(super) use crate::random::Random;
use crate::{
    camera::{Camera, ImageSize},
    scene::Viewport,
    spheres::{LANES, Sphere},
};

/// A dyadic rational of unlimited precision.
pub(super) type Dyadic = FBig;

/// A finite double as it stands, at unlimited precision.
pub(super) fn dyadic(value: f64) -> Dyadic {
    let exact = Dyadic::try_from(value).expect("a finite double");
    exact.with_precision(0).value()
}

/// What a ray has to do with a sphere, exactly; `V` is scaled so that it is dyadic.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    /// `B = C.V`
    pub(super) b: Dyadic,
    /// `c = C.C - r^2`
    pub(super) c: Dyadic,
    /// `D = B^2 - A c`
    pub(super) d: Dyadic,
    /// The z of `V`.
    pub(super) z: Dyadic,
    hit: Option<Hit>,
}

/// A hit at the inverse depth `(p + sqrt d)/q`, `q > 0`, in units of `V`: `1/z` is this over the z of
/// `V`.
#[derive(Clone, Debug)]
struct Hit {
    p: Dyadic,
    d: Dyadic,
    q: Dyadic,
}

impl Truth {
    pub(super) fn new(camera: &Camera, sphere: &Sphere, column: f64, row: f64) -> Self {
        let viewport = camera.viewport();
        let along = |side: u32, extent: f32, at: f64, sign: f64| {
            let last = f64::from(side - 1);
            if last == 0.0 {
                (dyadic(0.0), dyadic(1.0))
            } else {
                let twice = dyadic(2.0) * dyadic(at) - dyadic(last);
                (dyadic(sign * f64::from(extent)) * twice, dyadic(2.0 * last))
            }
        };
        let size = camera.size();
        let (x, x_unit) = along(size.width(), viewport.width, column, 1.0);
        let (y, y_unit) = along(size.height(), viewport.height, row, -1.0);
        let z = dyadic(f64::from(viewport.distance)) * &x_unit * &y_unit;
        let v = [x * y_unit, y * x_unit, z.clone()];
        let centre = sphere.centre.map(|length| dyadic(f64::from(length)));
        let radius = dyadic(f64::from(sphere.radius));
        let dot = |a: &[Dyadic; 3], b: &[Dyadic; 3]| &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2];
        let (a, b) = (dot(&v, &v), dot(&centre, &v));
        let c = dot(&centre, &centre) - &radius * &radius;
        let d = &b * &b - &a * &c;
        let hit = |p: Dyadic, d: &Dyadic, q: Dyadic| Hit { p, d: d.clone(), q };
        let ahead = b > Dyadic::ZERO;
        let hit = match c.cmp(&Dyadic::ZERO) {
            Ordering::Greater => {
                (ahead && d >= Dyadic::ZERO).then(|| hit(b.clone(), &d, c.clone()))
            }
            Ordering::Less => Some(hit(-b.clone(), &d, -c.clone())),
            Ordering::Equal => ahead.then(|| hit(a, &Dyadic::ZERO, &b + &b)),
        };
        Self { b, c, d, z, hit }
    }

    pub(super) fn hit(&self) -> bool {
        self.hit.is_some()
    }

    /// How `1/z` of the hit, times `scale`, compares with a bound: `(p + sqrt d) scale/q` with
    /// `bound z`.
    fn compared(&self, bound: &Dyadic, scale: f64) -> Option<Ordering> {
        let Hit { p, d, q } = self.hit.as_ref()?;
        let scale = dyadic(scale);
        let rest = bound * &self.z * q - p * &scale;
        Some(if rest < Dyadic::ZERO {
            Ordering::Greater
        } else {
            (d * &scale * &scale).cmp(&(&rest * &rest))
        })
    }

    /// Whether there is a hit, and its `1/z`, times `scale`, is at most `bound`.
    pub(super) fn at_most(&self, bound: f64, scale: f64) -> bool {
        bound == f64::INFINITY || self.at_most_dyadic(&dyadic(bound), scale)
    }

    pub(super) fn at_most_dyadic(&self, bound: &Dyadic, scale: f64) -> bool {
        self.compared(bound, scale).is_some_and(Ordering::is_le)
    }

    /// Whether there is a hit, and its `1/z`, times `scale`, is at least `bound`.
    pub(super) fn at_least(&self, bound: f64, scale: f64) -> bool {
        if bound == f64::NEG_INFINITY {
            return true;
        }
        // An infinite bound says: more than any float.
        let bound = if bound == f64::INFINITY {
            f64::from(f32::MAX)
        } else {
            bound
        };
        self.at_least_dyadic(&dyadic(bound), scale)
    }

    pub(super) fn at_least_dyadic(&self, bound: &Dyadic, scale: f64) -> bool {
        self.compared(bound, scale).is_some_and(Ordering::is_ge)
    }
}

/// A sphere, a camera, and a pixel where something is close.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    pub(super) camera: Camera,
    pub(super) sphere: Sphere,
    pub(super) column: u32,
    pub(super) row: u32,
}

impl Trial {
    /// The case of this number.
    pub(super) fn new(number: u64) -> Self {
        let mut random = Random::new(number);
        let random = &mut random;
        // Through a telescope, a tile is so small a part of an outline that what doubles
        // round is all that floats are given.
        let telescope = random.below(4) == 0;
        let (size, viewport) = if telescope {
            telescope_view(random)
        } else {
            (image_size(random), viewport(random))
        };
        let camera = Camera::new(viewport, size);
        let mut at = |side: u32| match random.below(8) {
            0 => 0,
            1 => side - 1,
            2 => side / 2,
            _ => random.below(u64::from(side)) as u32,
        };
        let (column, row) = (at(size.width()), at(size.height()));
        let sphere = sphere(random, &camera, column, row);
        let mut trial = Self {
            camera,
            sphere,
            column,
            row,
        };
        if telescope || random.below(2) == 0 {
            trial.row = trial.row_through(random);
        }
        if telescope || random.below(4) != 0 {
            trial.column = trial.edge(random.below(2) == 0);
        }
        trial
    }

    /// A row of the picture that passes through the sphere, if its centre is in view.
    fn row_through(&self, random: &mut Random) -> u32 {
        let [_, y, z] = self.sphere.centre.map(f64::from);
        let slope = (y + random.between(-1.0, 1.0) * f64::from(self.sphere.radius)) / z;
        let last = f64::from(self.camera.size().height() - 1);
        let row = (0.5 - slope / self.camera.y_extent()) * last;
        if (0.0..=last).contains(&row) {
            row.round() as u32
        } else {
            self.row
        }
    }

    /// A column of the row where the sphere's outline is, as well as doubles can say.
    fn edge(&self, left: bool) -> u32 {
        let [x, y, z] = self.sphere.centre.map(f64::from);
        let r = f64::from(self.sphere.radius);
        let slope = y_slope(&self.camera, self.row);
        let k = y * y + z * z - r * r;
        let n = y - z * slope;
        let e = r * r * (slope * slope + 1.0) - n * n;
        let root = ((x * x + k) * e).max(0.0).sqrt();
        let side = if left { -root } else { root };
        let slope = (x * (y * slope + z) + side) / k;
        let last = f64::from(self.camera.size().width() - 1);
        let column = (slope / self.camera.x_extent() + 0.5) * last;
        if (0.0..=last).contains(&column) {
            column.round() as u32
        } else {
            self.column
        }
    }

    /// What fails is shown by the number of the trial, and by its bits.
    pub(super) fn describe(&self) -> String {
        let Viewport {
            width,
            height,
            distance,
        } = self.camera.viewport();
        let [x, y, z] = self.sphere.centre;
        let bits = |floats: &[f32]| {
            let words = floats
                .iter()
                .map(|float| format!("{:08x} ({float:e})", float.to_bits()));
            words.collect::<Vec<_>>().join(" ")
        };
        format!(
            "viewport {} sphere {} of {:?} at ({}, {})",
            bits(&[width, height, distance]),
            bits(&[x, y, z, self.sphere.radius]),
            self.camera.size(),
            self.column,
            self.row,
        )
    }

    pub(super) fn lengths(&self) -> [f32; 4] {
        let [x, y, z] = self.sphere.centre;
        [x, y, z, self.sphere.radius]
    }

    /// The sphere in every lane.
    pub(super) fn eight(&self) -> EightSpheres {
        EightSpheres::of(std::iter::once(self.lengths()))
    }

    /// The grid of its camera, with a scale that suits the sphere.
    pub(super) fn grid(&self, random: &mut Random) -> Grid {
        let mut grid = Grid::new(self.camera);
        let its_box = PixelBox::new(&grid, &self.sphere);
        grid.scale = scale(its_box.map_or(0.0, |its_box| its_box.upper), random);
        grid
    }

    /// The tile that holds the pixel.
    pub(super) fn tile(&self) -> Tile {
        let size = self.camera.size();
        let side = SIDE as u32;
        let (column, row) = (self.column / side * side, self.row / side * side);
        Tile {
            column,
            row,
            width: (size.width() - column).min(side) as usize,
            first: 0,
            last: (size.height() - row).min(side) as usize,
        }
    }

    /// The sphere in that tile, if it can be seen there.
    pub(super) fn record(&self, grid: &Grid) -> Option<Record> {
        let PixelBox { sides, upper } = PixelBox::new(grid, &self.sphere)?;
        let tile = self.tile();
        let size = self.camera.size();
        let within = |first: u32, last: u32, origin: u32, side: u32| {
            let end = (u64::from(origin) + SIDE as u64).min(u64::from(side)) - 1;
            let met = first <= end as u32 && last >= origin;
            let first = first.max(origin) - origin;
            met.then(|| (first as u8, (last.min(end as u32) - origin) as u8))
        };
        let [left, right, top, bottom] = sides;
        let (left, right) = within(left, right, tile.column, size.width())?;
        let (top, bottom) = within(top, bottom, tile.row, size.height())?;
        Some(Record {
            sphere: self.lengths(),
            upper,
            sides: [left, right, top, bottom],
            ..Record::default()
        })
    }

    pub(super) fn truth(&self) -> Truth {
        self.truth_at(f64::from(self.column), f64::from(self.row))
    }

    pub(super) fn truth_at(&self, column: f64, row: f64) -> Truth {
        Truth::new(&self.camera, &self.sphere, column, row)
    }
}

/// Runs `check` on trials `0..count`; it says what is wrong, if anything.
pub(super) fn each_trial(
    count: u64,
    mut check: impl FnMut(&Trial, &mut Random) -> Result<(), String>,
) {
    for number in 0..count {
        let trial = Trial::new(number);
        let mut random = Random::new(!number);
        if let Err(wrong) = check(&trial, &mut random) {
            panic!("trial {number}: {wrong}; {}", trial.describe());
        }
    }
}

/// A rectangle that holds the trial's pixel, eight times.
pub(super) fn rectangles(trial: &Trial, random: &mut Random) -> Rectangles {
    let mut side = |at: u32, least: u64| {
        let most = [1, 4, 32][random.below(3) as usize];
        let half = least + random.below(most);
        let middle = f64::from(at) - half as f64 + random.below(2 * half + 1) as f64;
        (f64x8::splat(middle), f64x8::splat(half as f64))
    };
    let (columns, across) = side(trial.column, LANES as u64 / 2);
    let (rows, down) = side(trial.row, 1);
    Rectangles {
        columns,
        rows,
        across,
        down,
    }
}

/// A scale as if of a scene with an ordinary sphere that is as near, or far nearer.
pub(super) fn scale(upper: f32, random: &mut Random) -> f64 {
    let greatest = if upper.is_finite() { upper } else { f32::MAX };
    let exponent = f64::from(greatest.max(f32::MIN_POSITIVE)).log2().floor();
    let nearer = [0.0, 0.0, 0.0, 5.0, 20.0, 60.0][random.below(6) as usize];
    (-(exponent + nearer).min(127.0)).exp2()
}

/// `x/z` of a column, `y/z` of a row, as well as doubles can say.
fn x_slope(camera: &Camera, column: u32) -> f64 {
    slope(camera.x_extent(), camera.size().width(), column)
}

fn y_slope(camera: &Camera, row: u32) -> f64 {
    -slope(camera.y_extent(), camera.size().height(), row)
}

fn slope(extent: f64, side: u32, at: u32) -> f64 {
    let last = f64::from(side - 1);
    extent * (f64::from(at) / last.max(1.0) - 0.5 * last.min(1.0))
}

fn image_size(random: &mut Random) -> ImageSize {
    const MOST: u32 = u32::MAX;
    let sizes = [
        (1, 1),
        (1, 9),
        (2, 2),
        (9, 1),
        (9, 7),
        (33, 33),
        (64, 48),
        (257, 193),
        (1920, 1080),
        (7680, 4320),
        (65_536, 65),
        (MOST, 1),
        (MOST, 3),
        (MOST, 33),
        (MOST - 1, 1 << 29),
        (1 << 30, 1 << 30),
        (33, MOST),
        (2, MOST),
    ];
    let (width, height) = sizes[random.below(sizes.len() as u64) as usize];
    ImageSize::of_sides(width, height)
}

fn telescope_view(random: &mut Random) -> (ImageSize, Viewport) {
    let size = ImageSize::of_sides(1 << 30, 1 << 30);
    let narrow = random.power(10.0, -9.0, 0.0) as f32;
    let viewport = Viewport {
        width: narrow,
        height: narrow * 0.75,
        distance: 1.0,
    };
    (size, viewport)
}

fn viewport(random: &mut Random) -> Viewport {
    let [width, height, distance] = match random.below(8) {
        // Through a keyhole, so that a tile is a very small part of an outline.
        0 | 1 => {
            let narrow = random.power(10.0, -9.0, -1.0);
            [narrow * random.between(0.5, 2.0), narrow, 1.0]
        }
        2 => [
            random.power(10.0, 0.0, 4.0),
            random.power(10.0, 0.0, 4.0),
            1.0,
        ],
        3 => [0.0; 3].map(|_| random.power(2.0, -149.0, 127.9)),
        4 => [0.0; 3].map(|_| random.below(1 << 20) as f64 + 1.0),
        _ => [0.0; 3].map(|_| random.between(0.3, 3.0)),
    };
    let positive = |length: f64| (length as f32).clamp(f32::from_bits(1), f32::MAX);
    Viewport {
        width: positive(width),
        height: positive(height),
        distance: positive(distance),
    }
}

pub(super) fn sphere(random: &mut Random, camera: &Camera, column: u32, row: u32) -> Sphere {
    let ray = [x_slope(camera, column), y_slope(camera, row), 1.0];
    let length = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let ray = ray.map(|component| component / length(ray));
    let depth = random.power(10.0, -2.0, 4.0);
    let radius = depth * random.power(10.0, -6.0, 3.0);
    let direction = random.direction();
    let plus = |a: [f64; 3], factor: f64, b: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| a[i] + factor * b[i])
    };
    let across = {
        let along = (0..3).map(|i| direction[i] * ray[i]).sum::<f64>();
        let across = plus(direction, -along, ray);
        across.map(|component| component / length(across).max(1e-9))
    };
    let near_one = 1.0 + random.sign() * random.power(10.0, -17.0, -1.0);
    let ahead = ray.map(|component| component * depth);
    let (centre, radius) = match random.below(10) {
        // The ray touches it, or almost.
        0..=2 => (plus(ahead, radius * near_one, across), radius),
        // Touching rays of the middle row or column, by whole numbers.
        3 => {
            let [x, y, z] = whole_touching(random, camera, column, row);
            let radius = length([x, y, z]);
            (plus([0.0; 3], 1.0, [x, y, z]), radius * near_one)
        }
        // The ray meets it there.
        4 | 5 => (plus(ahead, radius, direction), radius),
        // The camera is close to its surface.
        6 => (
            direction.map(|component| component * radius * near_one),
            radius,
        ),
        // It touches the plane of the camera, or almost.
        7 => {
            let [x, y, _] = plus([0.0; 3], depth, direction);
            ([x, y, radius * near_one], radius)
        }
        8 => {
            let digit = |random: &mut Random| random.below(15) as f64 - 7.0;
            ([0.0; 3].map(|_| digit(random)), digit(random).abs() + 1.0)
        }
        _ => {
            let any = |random: &mut Random| loop {
                let float = f32::from_bits(random.bits() as u32);
                if float.is_finite() {
                    return f64::from(float);
                }
            };
            ([0.0; 3].map(|_| any(random)), any(random).abs())
        }
    };
    let scale = match random.below(8) {
        0 => random.power(2.0, -140.0, -60.0),
        1 => random.power(2.0, 60.0, 126.0),
        _ => 1.0,
    };
    let float = |length: f64| ((length * scale) as f32).clamp(-f32::MAX, f32::MAX);
    let mut sphere = Sphere {
        centre: centre.map(float),
        radius: float(radius).max(f32::from_bits(1)),
        colour: [0; 3],
    };
    match random.below(6) {
        0 => sphere.radius = sphere.radius.next_up().min(f32::MAX),
        1 => sphere.radius = sphere.radius.next_down().max(f32::from_bits(1)),
        _ => {}
    }
    sphere
}

/// Another sphere that is near the trial's own, or seen near it.
pub(super) fn partner(trial: &Trial, random: &mut Random) -> Sphere {
    let mut other = trial.sphere;
    let [x, y, z] = other.centre;
    let radius = other.radius;
    let nudge = |length: f32, random: &mut Random| {
        let steps = random.below(5) as i32 - 2;
        f32::from_bits(length.to_bits().wrapping_add_signed(steps))
    };
    match random.below(8) {
        0 => return sphere(random, &trial.camera, trial.column, trial.row),
        1 => other.radius *= random.between(0.5, 1.5) as f32,
        2 => {
            let moved = |length: f32| length + random.between(-1.5, 1.5) as f32 * radius;
            other.centre = [x, y, z].map(moved);
        }
        3 => {
            other.centre = [x, y, z].map(|length| nudge(length, random));
            other.radius = nudge(radius, random);
        }
        // The same power, so that the camera is in the radical plane.
        4 => other.centre = [-x, y, z],
        5 => other.centre = [y, x, z],
        6 => return on_the_surface(random),
        // Almost the same power.
        _ => other.centre = [-x, nudge(y, random), nudge(z, random)],
    }
    other
}

/// A sphere on whose surface the camera is, exactly.
pub(super) fn on_the_surface(random: &mut Random) -> Sphere {
    let lengths = [[3, 4, 12, 13], [1, 2, 2, 3], [2, 3, 6, 7], [8, 9, 12, 17]];
    let [x, y, z, radius] = lengths[random.below(4) as usize];
    let turned = [[x, y, z], [y, z, x], [z, x, y]][random.below(3) as usize];
    let times = (1 + random.below(4)) as f32;
    Sphere {
        centre: turned.map(|length| (random.sign() as f32) * times * length as f32),
        radius: times * radius as f32,
        colour: [0; 3],
    }
}

/// A centre somewhere about the ray, of few digits.
fn whole_touching(random: &mut Random, camera: &Camera, column: u32, row: u32) -> [f64; 3] {
    let depth = random.below(1 << 10) as f64 + 1.0;
    let x = (x_slope(camera, column) * depth * 16.0).round() / 16.0;
    let y = (y_slope(camera, row) * depth * 16.0).round() / 16.0;
    [x, y, depth]
}
