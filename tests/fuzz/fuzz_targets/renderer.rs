//! Draws scenes of any floats at any small size.
//!
//! - Nothing panics, and every pixel is counted once.
//! - Packets draw the bytes that one pixel at a time draws.
//! - The engine draws what the reference sees, in as many pixels as time allows, and the same
//!   bytes with tiles of every size and rows cut anywhere.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    reference::Reference,
    render::{Counts, Form, Method, Renderer},
    scene::{Scene, Viewport},
    spheres::{Rgb, Sphere},
    testing::{Bounds, Tuning, tuned},
};

/// The limit of pixels times spheres, so that an hour is enough for many scenes.
const TESTS: u32 = 6_000;

/// How many pixels are compared with the reference.
const REFERENCE_TESTS: usize = 200;

/// If more pixels than this are left to integers, the picture is drawn fewer times.
const SLOW_PIXELS: u64 = 100;

fuzz_target!(
    init: {
        // On this thread only, so that results are reproducible.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        pool.use_current_thread().build_global().expect("a thread pool");
    },
    |bytes: &[u8]| {
        let mut bytes = Bytes(bytes);
        let (width, height, cut) = (bytes.up_to(70), bytes.up_to(70), bytes.next());
        let scene = scene(&mut bytes);
        let affordable = TESTS / (width * scene.spheres().len().max(1) as u32);
        let size = ImageSize::new(width, height.min(affordable.max(1))).expect("a size");
        let cut = u32::from(cut) % (size.height() + 1);

        for method in [Method::Textbook, Method::Geometric, Method::Double] {
            let draw = |form| draw(&Renderer::new(&scene, size, method(form)), size, cut).0;
            assert!(draw(Form::Scalar) == draw(Form::Packets), "{}", method(Form::Scalar));
        }
        let exact = |tile, bounds, cut| {
            let tuning = Tuning { tile, bounds };
            let renderer = tuned(&scene, size, Method::Exact, tuning);
            draw(&renderer, size, cut)
        };
        let (picture, counts) = exact(64, Bounds::Proven, cut);
        hold_against_reference(&scene, size, &picture);
        let tiles: &[u32] = if counts.pixels_in_integers > SLOW_PIXELS { &[8] } else { &[8, 16, 32] };
        for &tile in tiles {
            let parts = exact(tile, Bounds::Proven, 0).0;
            assert!(parts == picture, "tiles of {tile}, cut at row {cut}");
        }
        if size.pixels() as usize * scene.spheres().len() <= REFERENCE_TESTS {
            let integers = exact(64, Bounds::Refused, cut).0;
            assert!(integers == picture, "bounds refused");
        }
        exact(64, Bounds::Ignored, cut);
    }
);

/// The picture in two parts, the lower one first.
fn draw(renderer: &Renderer<'_>, size: ImageSize, cut: u32) -> (Vec<u8>, Counts) {
    let mut pixels = vec![0xa5; size.pixel_bytes()];
    let (above, below) = pixels.split_at_mut(size.row_bytes() * cut as usize);
    let mut counts = renderer.draw(cut..size.height(), below);
    counts += renderer.draw(0..cut, above);
    let settled = counts.pixels();
    assert!(settled == size.pixels() || settled == 0, "{counts:?}");
    (pixels, counts)
}

fn hold_against_reference(scene: &Scene, size: ImageSize, picture: &[u8]) {
    let reference = Reference::new(scene, size);
    let pixels = size.pixels() as usize;
    let count = (REFERENCE_TESTS / scene.spheres().len().max(1)).clamp(1, pixels);
    // All pixels, or some evenly spread.
    for at in (0..count).map(|nth| nth * pixels / count) {
        let (column, row) = (at as u32 % size.width(), at as u32 / size.width());
        let seen = reference.seen(column, row);
        let right = seen.map_or(scene.background(), |index| scene.spheres().colour()[index]);
        let drawn = &picture[at * BYTES_PER_PIXEL..][..BYTES_PER_PIXEL];
        assert_eq!(drawn, right, "pixel ({column}, {row}), {seen:?}");
    }
}

/// The bytes of the fuzzer, then zeros.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or_default()
    }

    fn up_to(&mut self, limit: u8) -> u32 {
        u32::from(self.next() % limit) + 1
    }

    fn bits(&mut self) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|_| self.next()))
    }

    /// A finite float: any bits, or a value that is likely to make spheres meet or touch.
    fn float(&mut self, before: f32) -> f32 {
        const SPECIAL: [f32; 16] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            2.0,
            3.0,
            5.0,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            1e-45,
            1e19,
            1e-19,
            16_777_216.0,
            0.1,
        ];
        let kind = self.next();
        let value = match kind % 8 {
            0 => f32::from_bits(self.bits()),
            1 | 2 => f32::from(self.next() as i8) / 16.0,
            3 | 4 => f32::from(self.next() as i8),
            5 => SPECIAL[usize::from(kind / 8) % SPECIAL.len()],
            6 => before.next_up(),
            _ => -before,
        };
        if value.is_finite() { value } else { before }
    }

    fn length(&mut self, before: f32) -> f32 {
        let length = self.float(before).abs();
        if length > 0.0 { length } else { 1.0 }
    }
}

/// Up to 24 spheres, and up to 20 more in a line with each: enough for the bins.
fn scene(bytes: &mut Bytes<'_>) -> Scene {
    let lengths = [bytes.length(1.0), bytes.length(1.0), bytes.length(1.0)];
    let [width, height, distance] = lengths;
    let viewport = Viewport::new(width, height, distance).expect("a viewport");
    let mut spheres: Vec<Sphere> = Vec::new();
    let mut before = [0.0, 0.0, 5.0, 1.0];
    for _ in 0..bytes.next() % 25 {
        let [x, y, z, radius] = before;
        let centre = [bytes.float(x), bytes.float(y), bytes.float(z)];
        let radius = bytes.length(radius);
        before = [centre[0], centre[1], centre[2], radius];
        let copies = bytes.next();
        let (copies, axis) = (copies / 3 % 21, usize::from(copies % 3));
        let step = if copies > 0 { bytes.float(radius) } else { 0.0 };
        for copy in 0..=copies {
            let mut centre = centre;
            centre[axis] += step * f32::from(copy);
            // A line may leave the floats.
            spheres.extend(Sphere::new(centre, radius, colour(spheres.len())));
        }
    }
    Scene::new(viewport, [0; 3], spheres).expect("a scene")
}

/// A colour that no other sphere has.
fn colour(index: usize) -> Rgb {
    let [low, high, ..] = (index as u32 + 1).to_le_bytes();
    [low, high, low ^ 0x5a]
}
