//! The engine draws what the reference says, in every pixel, of scenes made to be
//! hard: tangent rays, ties, floats of every size, crowds and copies.

mod common;

use std::ops::Range;

use common::{draw, scene, size};
use proptest::prelude::*;
use sfera::{
    camera::{BYTES_PER_PIXEL, Camera, ImageSize},
    reference::Reference,
    render::{Form, Method, Renderer, differing_pixels},
    scene::{Scene, Viewport},
    testing::families::{FAMILIES, cloud},
};

fn wrong(scene: &Scene, size: ImageSize) -> u64 {
    let exact = draw(scene, size, Method::Exact);
    let meaning = draw(scene, size, Method::Reference);
    differing_pixels(&exact, &meaning)
}

#[test]
fn every_family() {
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            for (seed, (width, height)) in [(0, (257, 193)), (1, (65, 49)), (2, (8, 200))] {
                let scene = family.scene(difficulty, seed);
                // The reference tests every sphere for every pixel.
                let size = match scene.spheres().len() {
                    0..100 => size(width, height),
                    100..1000 => size(width / 4 + 1, height / 4 + 1),
                    _ => size(width / 12 + 1, height / 12 + 1),
                };
                assert_eq!(
                    wrong(&scene, size),
                    0,
                    "{}, difficulty {difficulty:e}, seed {seed}, {size:?}",
                    family.name,
                );
            }
        }
    }
}

#[test]
fn every_scene_of_the_folder() {
    let mut scenes = 0;
    for entry in std::fs::read_dir("scenes").expect("the folder of scenes") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|extension| extension == "txt") {
            let scene = Scene::read(&path).expect("a scene");
            assert_eq!(wrong(&scene, size(641, 481)), 0, "{}", path.display());
            scenes += 1;
        }
    }
    assert!(scenes >= 5);
}

#[test]
fn images_of_one_row_and_of_one_column() {
    let example = Scene::read("scenes/example.txt").expect("the example");
    let crowd = cloud(300, 5);
    for scene in [&example, &crowd] {
        for (width, height) in [(1, 1), (1, 777), (777, 1), (2, 333), (333, 2), (2, 2)] {
            assert_eq!(wrong(scene, size(width, height)), 0, "{width} x {height}");
        }
    }
}

/// Rows of a picture that this machine can address.
fn most_rows(width: u32) -> u32 {
    let header = 64;
    let most = (isize::MAX as usize - header) / (BYTES_PER_PIXEL * width as usize);
    most.try_into().unwrap_or(u32::MAX)
}

/// Rows at the ends of pictures that are too large for any memory.
#[test]
fn images_of_extreme_sizes() {
    const LAST: u32 = u32::MAX;
    type Rows = fn(u32) -> Range<u32>;
    let cases: [(u32, u32, Rows); 6] = [
        (1, LAST, |height| height - 70..height),
        (1, LAST, |height| height / 2 - 40..height / 2 + 40),
        (3, LAST - 1, |_| 0..70),
        (3, LAST - 1, |height| height - 1..height),
        (4_000_000, 4_000_000, |height| {
            height / 2 - 1..height / 2 + 1
        }),
        (4_000_000, 700_000_000, |height| height - 1..height),
    ];
    for (width, height, rows) in cases {
        let height = height.min(most_rows(width));
        let rows = rows(height);
        // Small spheres along both axes, and two that extend beyond the edges.
        let mut spheres: Vec<[f32; 4]> = (0..80)
            .map(|index| match index as f32 / 79.0 - 0.5 {
                at if index % 3 == 0 => [at, 0.0, 1.0, 1e-6],
                at => [0.0, at, 1.0, 1e-8],
            })
            .collect();
        spheres.extend([[0.5, 0.5, 2.0, 0.2], [-0.5, -0.5, 2.0, 0.7]]);
        let size = size(width, height);
        let scene = scene([1.0; 3], &spheres);
        let reference = Reference::new(&scene, size);
        let mut pixels = vec![0; rows.len() * size.row_bytes()];
        if width <= 3 {
            for method in [Method::Textbook, Method::Geometric, Method::Double] {
                let renderer = Renderer::new(&scene, size, method(Form::Packets));
                renderer.draw(rows.clone(), &mut pixels);
            }
        }
        let renderer = Renderer::new(&scene, size, Method::Exact);
        renderer.draw(rows.clone(), &mut pixels);
        let (pixels, _) = pixels.as_chunks::<BYTES_PER_PIXEL>();
        for at in (0..pixels.len()).step_by(pixels.len() / 200 + 1) {
            let (row, column) = (rows.start + at as u32 / width, at as u32 % width);
            let seen = reference.seen(column, row);
            let right = seen.map_or(scene.background(), |index| scene.spheres().colour()[index]);
            assert_eq!(pixels[at], right, "({column}, {row}) of {size:?}");
        }
    }
}

/// The parts of a scene: a viewport, an image size, spheres.
type Parts = ([f32; 3], (u32, u32), Vec<[f32; 4]>);

fn assert_exact(cases: u32, parts: impl Strategy<Value = Parts>) {
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    proptest!(config, |((viewport, (width, height), spheres) in parts)| {
        let scene = scene(viewport, &spheres);
        prop_assert_eq!(wrong(&scene, size(width, height)), 0);
    });
}

fn sizes() -> impl Strategy<Value = (u32, u32)> {
    let side = prop_oneof![Just(1_u32), 2_u32..10, Just(9), Just(17), 10_u32..50];
    (side.clone(), side)
}

/// Few values, so that tangents, ties and cameras on surfaces are frequent.
#[test]
fn degenerate_scenes() {
    let coordinate = (-5..=5).prop_map(|n| n as f32);
    let radius = (1..=6).prop_map(|n| n as f32);
    let sphere = (coordinate.clone(), coordinate.clone(), coordinate, radius)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let viewports = vec![
        [2.0, 2.0, 1.0],
        [4.0, 6.0, 6.0],
        [8.0, 8.0, 2.0],
        [2.0, 2.0, 8.0],
    ];
    let viewport = prop::sample::select(viewports);
    assert_exact(
        1_000,
        (viewport, sizes(), prop::collection::vec(sphere, 0..9)),
    );
}

/// Any bits of a finite float, so that all magnitudes occur together.
#[test]
fn any_floats() {
    fn number() -> impl Strategy<Value = f32> + Clone {
        let finite = |number: &f32| number.is_finite();
        any::<u32>()
            .prop_map(f32::from_bits)
            .prop_filter("finite", finite)
    }
    let positive = || number().prop_map(|number| number.abs().max(f32::from_bits(1)));
    let sphere = [
        number().boxed(),
        number().boxed(),
        number().boxed(),
        positive().boxed(),
    ];
    let viewport = [positive(), positive(), positive()];
    assert_exact(
        1_000,
        (viewport, sizes(), prop::collection::vec(sphere, 1..8)),
    );
}

/// A scene whose spheres are all placed for one ray of the picture: some touch it, up
/// to the last digits, and some meet it at the same point.
fn aimed() -> impl Strategy<Value = Parts> {
    let aim = (0.0..1.0, 0.0..1.0);
    let viewport = [0.5_f32..3.0, 0.5_f32..3.0, 0.2_f32..5.0];
    let magnitude = prop_oneof![
        3 => Just(0.0_f32),
        1 => -1.0_f32..4.0,
        1 => -30.0_f32..30.0,
    ];
    // Direction and length of the offset from a point of the ray, steps of the radius
    // in last digits, and whether the sphere touches the ray or meets it at the point.
    let sphere = (
        [-1.0..1.0, -1.0..1.0, -1.0..1.0],
        0.01..3.0,
        -2_i32..=2,
        any::<bool>(),
    );
    let spheres = prop::collection::vec(sphere, 1..8);
    (viewport, sizes(), aim, magnitude, 1.0..30.0, spheres).prop_map(
        |(viewport, (width, height), (across, down), magnitude, depth, spheres)| {
            let [vx, vy, vz] = viewport;
            let camera = Camera::new(
                Viewport::new(vx, vy, vz).expect("a viewport"),
                size(width, height),
            );
            let column = (across * f64::from(width)) as u32;
            let row = (down * f64::from(height)) as u32;
            let ray = [
                camera.x_double(column),
                camera.y_double(row),
                camera.z_double(),
            ];
            let factor = 10_f64.powf(f64::from(magnitude));
            let meet: [f64; 3] = ray.map(|component| component * depth * factor);
            let aimed = |(offset, length, steps, touch): ([f64; 3], f64, i32, bool)| {
                let along: f64 = (0..3).map(|i| offset[i] * ray[i]).sum();
                let squared: f64 = ray.iter().map(|component| component * component).sum();
                // Perpendicular to the ray if the sphere is to touch it.
                let offset: [f64; 3] = std::array::from_fn(|i| {
                    let aside = if touch { along / squared * ray[i] } else { 0.0 };
                    (offset[i] - aside) * length * factor
                });
                let centre: [f32; 3] = std::array::from_fn(|i| (meet[i] + offset[i]) as f32);
                let radius: f64 = (0..3)
                    .map(|i: usize| (f64::from(centre[i]) - meet[i]).powi(2))
                    .sum::<f64>()
                    .sqrt();
                let mut radius = (radius as f32).max(f32::MIN_POSITIVE);
                for _ in 0..steps.abs() {
                    radius = if steps > 0 {
                        radius.next_up()
                    } else {
                        radius.next_down()
                    };
                }
                [centre[0], centre[1], centre[2], radius]
            };
            (
                viewport,
                (width, height),
                spheres.into_iter().map(aimed).collect(),
            )
        },
    )
}

#[test]
fn tangents_and_ties() {
    assert_exact(2_000, aimed());
}

/// Whole numbers of up to `bits` bits; most have nearly all of them.
fn whole(bits: u32) -> impl Strategy<Value = f64> + Clone {
    (1_u32..1 << bits).prop_map(f64::from)
}

/// Orthogonal vectors, each of length 7.
const FRAME: [[f64; 3]; 3] = [[2.0, 3.0, 6.0], [3.0, -6.0, 2.0], [6.0, 2.0, -3.0]];

fn sphere_of([x, y, z]: [f64; 3], radius: f64) -> [f32; 4] {
    let sphere = [x, y, z, radius].map(|length| length as f32);
    assert!(
        sphere
            .iter()
            .zip([x, y, z, radius])
            .all(|(&rounded, exact)| f64::from(rounded) == exact),
        "a length that is not a float",
    );
    sphere
}

/// `D = 0` for the corner ray, with numbers so long that doubles round in between.
#[test]
fn tangents_that_doubles_round() {
    let spheres = prop::collection::vec((whole(17), whole(17), 0..4_usize), 1..6);
    let parts = (whole(19), spheres).prop_map(|(unit, spheres)| {
        let [x, y, z] = FRAME[0].map(|component| component * unit);
        let touching = |(along, across, side): (f64, f64, usize)| {
            let across = if side % 2 == 0 { across } else { -across };
            let offset = FRAME[1 + side / 2];
            let centre = std::array::from_fn(|i| along * FRAME[0][i] + across * offset[i]);
            sphere_of(centre, 7.0 * across.abs())
        };
        let viewport = [2.0 * x, 2.0 * y, z].map(|length| length as f32);
        (
            viewport,
            (3, 3),
            spheres.into_iter().map(touching).collect(),
        )
    });
    assert_exact(10_000, parts);
}

/// `D = 0` for rays of the middle row whose x is no binary fraction.
#[test]
fn tangents_along_rays_that_doubles_round() {
    let spheres = prop::collection::vec((0_u32..8, whole(4), whole(23), any::<bool>()), 1..6);
    let viewport = (whole(14), whole(14), whole(14));
    let parts = (viewport, spheres).prop_map(|((width, height, distance), spheres)| {
        // Of 8 columns: x = width (2i - 7)/14.
        let touching = |(column, along, radius, above): (u32, f64, f64, bool)| {
            let x = along * width * f64::from(2 * column as i32 - 7);
            let side = if above { 1.0 } else { -1.0 };
            sphere_of([x, side * radius, 14.0 * along * distance], radius)
        };
        let viewport = [width, height, distance].map(|length| length as f32);
        (
            viewport,
            (8, 3),
            spheres.into_iter().map(touching).collect(),
        )
    });
    assert_exact(10_000, parts);
}

/// Spheres that the corner ray meets at one point, or that differ from such a sphere by
/// the last digit of one number: seen from outside, from inside, and from the surface.
#[test]
fn ties_that_doubles_round() {
    let one = (whole(16), 0..6_usize, any::<bool>(), 0..3_usize);
    let spheres = prop::collection::vec(one, 2..7);
    let parts = (whole(19), whole(17), spheres).prop_map(|(unit, depth, spheres)| {
        let [x, y, z] = FRAME[0].map(|component| component * unit);
        let meeting = |(offset, direction, away, nudge): (f64, usize, bool, usize)| {
            let side = if direction % 2 == 0 { 1.0 } else { -1.0 };
            // The first direction is along the ray, so the point is on the near or far side.
            let centre = std::array::from_fn(|i| {
                depth * FRAME[0][i] + side * offset * FRAME[direction / 2][i]
            });
            let mut sphere = sphere_of(centre, 7.0 * offset);
            if away && nudge > 0 {
                let digit = &mut sphere[nudge];
                *digit = digit.next_up();
            }
            sphere
        };
        let on_the_surface = sphere_of(
            FRAME[0].map(|component| component * depth / 2.0),
            depth * 3.5,
        );
        let mut spheres: Vec<_> = spheres.into_iter().map(meeting).collect();
        spheres.push(on_the_surface);
        let viewport = [2.0 * x, 2.0 * y, z].map(|length| length as f32);
        (viewport, (3, 3), spheres)
    });
    assert_exact(10_000, parts);
}

/// So many that bins, tiles and the order of visits matter.
#[test]
fn crowds() {
    for seed in 0..3 {
        for count in [50, 500, 2_000] {
            assert_eq!(
                wrong(&cloud(count, seed), size(96, 54)),
                0,
                "{count}, seed {seed}"
            );
        }
    }
}

/// Many equal spheres among many others: the first of the file is seen, however the
/// engine sorts them.
#[test]
fn crowds_of_equals() {
    let crossing = [[-0.6, 0.2, 3.0, 0.8], [0.5, 0.2, 3.0, 0.8]];
    let around = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.25, 0.0, 1.25]];
    for (equal, count) in [(crossing, 90), (around, 90), (crossing, 200), (around, 200)] {
        let spheres: Vec<[f32; 4]> = (0..count)
            .map(|index| match index % 7 {
                0..3 => equal[0],
                3 | 4 => equal[1],
                _ => [
                    0.01 * index as f32 - 1.0,
                    -0.5,
                    2.0 + 0.1 * index as f32,
                    0.2,
                ],
            })
            .collect();
        for size in [size(42, 16), size(90, 20)] {
            let scene = scene([3.0, 2.0, 2.0], &spheres);
            assert_eq!(wrong(&scene, size), 0, "{equal:?} of {count}, {size:?}");
        }
    }
}

/// Spheres that differ in the sign of a zero are equal.
#[test]
fn spheres_that_differ_in_the_sign_of_zero_are_equal() {
    for (count, radius) in [(20, 0.5), (20, 3.0), (90, 0.5), (90, 3.0)] {
        for seed in 0..4 {
            let spheres: Vec<[f32; 4]> = (0..count)
                .map(|index| {
                    let zero = |bit: i32| {
                        if (index * 5 + seed) >> bit & 1 == 0 {
                            0.0
                        } else {
                            -0.0
                        }
                    };
                    match index % 3 {
                        0 => [zero(0), zero(1), 2.0, radius],
                        1 => [-1.0, zero(2), 2.0, radius],
                        _ => [zero(0), 1.0, 2.0, radius],
                    }
                })
                .collect();
            let scene = scene([3.0, 2.0, 2.0], &spheres);
            assert_eq!(wrong(&scene, size(42, 16)), 0, "{count}, seed {seed}");
        }
    }
}

/// A pixel is counted once, however many spheres leave it undecided.
#[test]
fn every_pixel_is_counted_once() {
    let far: Vec<[f32; 4]> = (0..24)
        .map(|index| [-4e-24, 1.6e-13 * index as f32, 3e35, 1.0])
        .collect();
    let touching: Vec<[f32; 4]> = (1..=20)
        .map(|index| [3.0, 0.0, 4.0, 3.0].map(|length| length * index as f32))
        .collect();
    for spheres in [far, touching] {
        let scene = scene([2.0, 2.0, 2.0], &spheres);
        let size = size(5, 13);
        let mut pixels = vec![0; size.pixel_bytes()];
        let renderer = Renderer::new(&scene, size, Method::Exact);
        let counts = renderer.draw(0..13, &mut pixels);
        assert_eq!(counts.pixels(), size.pixels(), "{counts:?}");
    }
}

/// One behind another along the axis, each touching the ray of the only pixel: as
/// many outlines pass through the pixel as there are spheres.
#[test]
fn a_pixel_on_the_outlines_of_many_spheres() {
    let spheres: Vec<[f32; 4]> = (0..20)
        .map(|at| [1.0, 0.0, 8.0 + 8.0 * at as f32, 1.0])
        .collect();
    assert_eq!(wrong(&scene([1.0, 1.0, 1.0], &spheres), size(1, 1)), 0);
}

/// Minus zero is zero: the first of two equal spheres is seen.
#[test]
fn equal_but_for_the_sign_of_zero() {
    let first = [-0.0, 0.0, 5.0, 1.0];
    let second = [0.0, -0.0, 5.0, 1.0];
    for spheres in [[first, second], [second, first]] {
        for copies in [1, 40] {
            let spheres = spheres.repeat(copies);
            assert_eq!(wrong(&scene([1.0, 1.0, 1.0], &spheres), size(9, 9)), 0);
        }
    }
}

/// Of equal small spheres in one tile, the first of the file is seen, although a tile
/// sorts them by distance.
#[test]
fn equal_small_spheres_in_any_order() {
    let place = |at: usize| {
        let (column, row) = (at % 6, at / 6);
        [
            column as f32 * 0.08 - 0.2,
            row as f32 * 0.08 - 0.2,
            2.0 + 0.01 * (at * 7 % 36) as f32,
            0.03,
        ]
    };
    for copies in [2, 3] {
        let mut spheres: Vec<[f32; 4]> = (0..30 * copies).map(|at| place(at * 11 % 30)).collect();
        // Out of view, so that there are enough to be sorted by tile.
        spheres.extend((0..64).map(|at| [9.0 + at as f32, 0.0, 4.0, 0.1]));
        let scene = scene([0.6, 0.6, 1.0], &spheres);
        assert_eq!(wrong(&scene, size(64, 64)), 0);
    }
}

/// In front of the camera, behind it, across its plane, around it.
#[test]
fn crowds_all_around() {
    let sphere = (-4.0_f32..4.0, -4.0_f32..4.0, -4.0_f32..4.0, 0.02_f32..0.6)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let around = (-0.5_f32..0.5, -0.5_f32..0.5, -0.5_f32..0.5, 3.0_f32..9.0)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let viewport = [0.2_f32..6.0, 0.2_f32..6.0, 0.2_f32..2.0];
    let spheres = prop::collection::vec(prop_oneof![30 => sphere, 1 => around], 50..200);
    assert_exact(12, (viewport, (40_u32..90, 30_u32..60), spheres));
}

/// Too large for the reference to draw, so only some pixels are compared: those beside
/// an edge, where a wrong one would be, and others anywhere.
#[test]
fn large_pictures_of_large_crowds() {
    for (count, seed) in [(1_000, 11)] {
        let scene = cloud(count, seed);
        let size = size(640, 360);
        let pixels = draw(&scene, size, Method::Exact);
        let (pixels, _) = pixels.as_chunks::<BYTES_PER_PIXEL>();
        let reference = Reference::new(&scene, size);
        let stride = pixels.len() / 4_000 + 1;
        let asked = 6_000_000 / count;
        let beside_an_edge = (1..pixels.len())
            .step_by(stride)
            .filter(|&at| pixels[at] != pixels[at - 1]);
        let anywhere = (0..pixels.len()).step_by(2 * stride);
        for at in beside_an_edge.take(asked).chain(anywhere.take(asked)) {
            let (row, column) = (at as u32 / size.width(), at as u32 % size.width());
            let meaning = match reference.seen(column, row) {
                Some(index) => scene.spheres().colour()[index],
                None => scene.background(),
            };
            assert_eq!(pixels[at], meaning, "({column}, {row}) of {count} spheres");
        }
    }
}
