//! Whole pictures, drawn in every way that the engine has. Pixels are compared with the
//! decision of the last stages between all spheres.

use std::ops::Range;

use proptest::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};

use super::{
    Engine, Workspace,
    band::{CROWD, SMALL_CROWD, colour_of},
    bins::{FEW_SPHERES, MAX_RUN, MIN_TABLE, Room},
    decide::decide,
    may_show,
    prepared::{Prepared, power_of_two_below},
    rows::MAX_COLUMNS,
    trials::Random,
    tuning::{Bounds, Tuning},
};
use crate::{
    camera::{BYTES_PER_PIXEL, Camera, ImageSize},
    render::{Method, Renderer},
    scene::{Scene, Viewport},
    spheres::{LANES, Rgb, Sphere},
    testing::families::{FAMILIES, cloud},
};

const TILES: [u32; 4] = [8, 16, 32, 64];

fn size(width: u32, height: u32) -> ImageSize {
    ImageSize::new(width, height).expect("a size with pixels")
}

fn tuned(scene: &Scene, size: ImageSize, tile: u32, bounds: Bounds) -> Renderer<'_> {
    let tuning = Tuning { tile, bounds };
    Renderer::tuned(Workspace::default(), scene, size, Method::Exact, tuning)
}

fn draw(scene: &Scene, size: ImageSize, tile: u32, bounds: Bounds) -> Vec<u8> {
    let mut pixels = vec![0xa5; size.pixel_bytes()];
    let counts = tuned(scene, size, tile, bounds).draw(0..size.height(), &mut pixels);
    assert_eq!(counts.pixels(), size.pixels(), "{counts:?}");
    pixels
}

/// The colour of one pixel, decided between all spheres.
fn decided(scene: &Scene, camera: &Camera, column: u32, row: u32) -> Rgb {
    let spheres = (0..scene.spheres.len()).map(|at| {
        let Sphere { centre, radius, .. } = scene.spheres.get(at);
        (at as u32, [centre[0], centre[1], centre[2], radius])
    });
    let spheres: Vec<_> = spheres.collect();
    colour_of(scene, decide(camera, (column, row), &spheres, true).0)
}

fn assert_pixel(scene: &Scene, size: ImageSize, pixels: &[u8], at: usize, what: &str) {
    let camera = Camera::new(scene.viewport, size);
    let (row, column) = (at as u32 / size.width(), at as u32 % size.width());
    let drawn = &pixels[at * BYTES_PER_PIXEL..][..BYTES_PER_PIXEL];
    let meaning = decided(scene, &camera, column, row);
    assert!(
        drawn == meaning,
        "{drawn:?} instead of {meaning:?} at ({column}, {row}) of {size:?}, {what}"
    );
}

fn assert_every_pixel(scene: &Scene, size: ImageSize, pixels: &[u8], what: &str) {
    (0..size.pixels() as usize)
        .into_par_iter()
        .for_each(|at| assert_pixel(scene, size, pixels, at, what));
}

/// Pixels beside edges, where errors are likely, and pixels anywhere.
fn assert_some_pixels(scene: &Scene, size: ImageSize, pixels: &[u8], count: usize, what: &str) {
    let colour = |at: usize| &pixels[at * BYTES_PER_PIXEL..][..BYTES_PER_PIXEL];
    let edges = (1..size.pixels() as usize).filter(|&at| colour(at) != colour(at - 1));
    let edges: Vec<usize> = edges.collect();
    let mut random = Random::new(count as u64);
    let mut any = |of: usize| random.below(of as u64) as usize;
    let mut asked: Vec<usize> = (0..count).map(|_| any(size.pixels() as usize)).collect();
    if !edges.is_empty() {
        asked.extend((0..count).map(|_| edges[any(edges.len())]));
        asked.extend((0..count).map(|_| edges[any(edges.len())] - 1));
    }
    asked
        .into_par_iter()
        .for_each(|at| assert_pixel(scene, size, pixels, at, what));
}

/// With every size of tiles and every cut the picture is that of single pixels.
fn assert_drawn(scene: &Scene, size: ImageSize, what: &str) {
    let first = draw(scene, size, TILES[0], Bounds::Proven);
    assert_every_pixel(scene, size, &first, what);
    assert_alike(scene, size, &first, &TILES[1..], what);
}

fn assert_alike(scene: &Scene, size: ImageSize, first: &[u8], tiles: &[u32], what: &str) {
    for &tile in tiles {
        let again = draw(scene, size, tile, Bounds::Proven);
        assert!(first == again, "{size:?}, tile {tile}, {what}");
    }
    let mut random = Random::new(size.pixels());
    let cut = random.below(u64::from(size.height()) + 1) as u32;
    let mut parts = vec![0; size.pixel_bytes()];
    let (above, below) = parts.split_at_mut(size.row_bytes() * cut as usize);
    let renderer = tuned(scene, size, tiles[0], Bounds::Proven);
    let below = renderer.draw(cut..size.height(), below);
    let above = renderer.draw(0..cut, above);
    let pixels = [above.pixels(), below.pixels()];
    assert_eq!(
        pixels,
        [cut, size.height() - cut].map(|rows| u64::from(size.width() * rows))
    );
    assert!(first == parts, "{size:?}, cut at row {cut}, {what}");
}

fn assert_refused_alike(scene: &Scene, size: ImageSize, tile: u32, what: &str) {
    let proven = draw(scene, size, tile, Bounds::Proven);
    let refused = draw(scene, size, tile, Bounds::Refused);
    let renderer = tuned(scene, size, tile, Bounds::Refused);
    let counts = renderer.draw(0..size.height(), &mut vec![0; size.pixel_bytes()]);
    let rounded = counts.pixels_in_doubles;
    assert_eq!(rounded, 0, "{what}");
    assert!(proven == refused, "{size:?}, tile {tile}, refused, {what}");
}

fn every_family(mut check: impl FnMut(&Scene, &str)) {
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            let scene = family.scene(difficulty, 7);
            check(&scene, &format!("{} {difficulty:e}", family.name));
        }
    }
}

#[test]
fn families_at_sizes_up_to_33() {
    let mut turn = 0;
    every_family(|scene, what| {
        // All widths and heights for few spheres, some of them for many.
        let step = 1 + scene.spheres.len().ilog2() as usize * 2 / 3;
        turn += 1;
        for width in (1 + turn % step as u32..=33).step_by(step) {
            let height = 1 + (width * 7 + turn * 5) % 33;
            let size = size(width, height);
            let tile = TILES[(turn + width) as usize % TILES.len()];
            let pixels = draw(scene, size, tile, Bounds::Proven);
            if scene.spheres.len() < 1000 {
                assert_every_pixel(scene, size, &pixels, what);
            } else {
                assert_some_pixels(scene, size, &pixels, 30, what);
            }
            if width % 8 == turn % 8 && scene.spheres.len() < 1000 {
                assert_refused_alike(scene, size, tile, what);
            }
        }
    });
}

#[test]
fn families_at_full_hd() {
    let mut turn = 0;
    every_family(|scene, what| {
        turn += 1;
        let size = size(1920, 1080);
        let pixels = draw(scene, size, 64, Bounds::Proven);
        assert_some_pixels(
            scene,
            size,
            &pixels,
            400_000 / (100 + scene.spheres.len()),
            what,
        );
        let tile = TILES[turn % TILES.len()];
        assert_alike(scene, size, &pixels, &[tile], what);
    });
}

fn pools() -> [ThreadPool; 3] {
    [1, 2, 7].map(|count| {
        let pool = ThreadPoolBuilder::new().num_threads(count);
        pool.build().expect("a thread pool")
    })
}

#[test]
fn every_pixel_of_some_at_full_hd_on_1_2_and_7_threads() {
    let pools = pools();
    for (name, difficulty) in [(0, 3), (1, 5), (5, 5), (9, 6), (12, 0)] {
        let family = FAMILIES[name];
        let scene = family.scene(family.difficulties[difficulty], 1);
        let size = size(1920, 1080);
        let pixels = draw(&scene, size, 64, Bounds::Proven);
        assert_every_pixel(&scene, size, &pixels, family.name);
        for pool in &pools {
            let again = pool.install(|| draw(&scene, size, 64, Bounds::Proven));
            assert!(pixels == again, "{}: {pool:?}", family.name);
        }
    }
}

/// The kinds of spheres in a mixture. Lengths are in pixels of a picture 256 wide, through a
/// viewport of 256 by 256 at distance 256.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Smaller than a few pixels, some of them smaller than one.
    Dust,
    /// As large as some blocks.
    Small,
    /// Larger than tiles.
    Large,
    /// Many at one place, one in front of the other.
    Crowd,
    /// Large ones, one behind the other.
    Stack,
    /// Centres at the corners of tiles.
    Corner,
    /// A copy of an earlier one.
    Copy,
    /// A copy of an earlier one, except for the last digit of a number.
    Twin,
    /// Larger than the picture, in front of all others or behind them.
    Wall,
    /// Almost flat, below the camera.
    Floor,
    /// Containing the camera.
    Room,
    /// Beside the camera, across its plane, or touching it.
    Beside,
    /// Behind the camera.
    Behind,
}

const KINDS: [Kind; 13] = [
    Kind::Dust,
    Kind::Small,
    Kind::Large,
    Kind::Crowd,
    Kind::Stack,
    Kind::Corner,
    Kind::Copy,
    Kind::Twin,
    Kind::Wall,
    Kind::Floor,
    Kind::Room,
    Kind::Beside,
    Kind::Behind,
];

fn one(kind: Kind, before: &[[f32; 4]], random: &mut Random) -> [f32; 4] {
    let depth = random.between(256.0, 1024.0);
    // At a depth, so that it is seen at this place and of this size.
    let seen = |x: f64, y: f64, radius: f64| {
        let away = depth / 256.0;
        [x * away, y * away, depth, radius * away]
    };
    let (x, y) = (random.between(-140.0, 140.0), random.between(-140.0, 140.0));
    let lengths = match kind {
        Kind::Dust => seen(x, y, random.power(10.0, -1.0, 0.5)),
        Kind::Small => seen(x, y, random.between(2.0, 30.0)),
        Kind::Large => seen(x, y, random.between(30.0, 120.0)),
        Kind::Crowd => seen(
            random.between(-3.0, 20.0),
            random.between(-3.0, 20.0),
            random.between(1.0, 8.0),
        ),
        Kind::Stack => {
            let depth = 400.0 + 10.0 * before.len() as f64;
            [x / 4.0, y / 4.0, depth, random.between(60.0, 200.0)]
        }
        Kind::Corner => {
            let corner = |at: f64| (at / 64.0).round() * 64.0 + 0.5;
            seen(corner(x), corner(y), random.between(0.5, 40.0))
        }
        Kind::Copy | Kind::Twin if !before.is_empty() => {
            let mut same = before[random.below(before.len() as u64) as usize];
            if matches!(kind, Kind::Twin) {
                let digit = &mut same[random.below(4) as usize];
                *digit = digit.next_up();
            }
            return same;
        }
        Kind::Copy | Kind::Twin => seen(x, y, 5.0),
        Kind::Wall => {
            let radius = random.power(10.0, 3.0, 6.0);
            [x, y, radius + random.between(200.0, 1500.0), radius]
        }
        Kind::Floor => {
            let radius = random.power(10.0, 3.0, 7.0);
            let [x, y, z] = [0.1 * x / 140.0, -1.0, random.between(0.0, 0.2)];
            let length = (x * x + y * y + z * z).sqrt();
            let away = (radius + random.between(10.0, 100.0)) / length;
            [x * away, y * away, z * away, radius]
        }
        Kind::Room => {
            let radius = random.power(10.0, 2.0, 4.0);
            [
                x * radius / 300.0,
                y * radius / 300.0,
                random.between(-0.5, 0.5) * radius,
                radius,
            ]
        }
        Kind::Beside => {
            let radius = random.between(10.0, 300.0);
            let z = [random.between(-1.0, 1.0) * radius, radius, 0.0][random.below(3) as usize];
            [x * 2.0, y * 2.0, z, radius]
        }
        Kind::Behind => [x, y, -depth, random.between(1.0, 300.0)],
    };
    lengths.map(|length| length as f32)
}

fn colour(index: usize) -> Rgb {
    let [_, red, green, blue] = (index as u32 + 1).wrapping_mul(0x9e_37_79).to_be_bytes();
    [red, green, blue]
}

fn scene_of(spheres: &[[f32; 4]]) -> Scene {
    Scene {
        viewport: Viewport {
            width: 256.0,
            height: 256.0,
            distance: 256.0,
        },
        background: [0; 3],
        spheres: spheres
            .iter()
            .enumerate()
            .map(|(index, &[x, y, z, radius])| Sphere {
                centre: [x, y, z],
                radius,
                colour: colour(index),
            })
            .collect(),
    }
}

/// This many of each kind, in random order.
fn mixture(kinds: &[(Kind, usize)], seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let kinds = kinds
        .iter()
        .flat_map(|&(kind, count)| std::iter::repeat_n(kind, count));
    let mut kinds: Vec<Kind> = kinds.collect();
    for last in (1..kinds.len()).rev() {
        kinds.swap(last, random.below(last as u64 + 1) as usize);
    }
    let mut spheres = Vec::new();
    for kind in kinds {
        let sphere = one(kind, &spheres, &mut random);
        spheres.push(sphere);
    }
    scene_of(&spheres)
}

/// Whole tiles, and one pixel more or less.
const SIDES: [u32; 8] = [63, 64, 65, 127, 128, 129, 191, 193];

#[test]
fn every_way_through_a_picture() {
    use Kind::*;
    let mixtures: &[&[(Kind, usize)]] = &[
        &[(Crowd, 300), (Dust, 30)],
        &[(Stack, 65), (Dust, 100)],
        &[(Stack, 200), (Small, 50), (Crowd, 120)],
        &[(Large, 20), (Small, 200), (Dust, 200)],
        &[(Dust, 1500)],
        &[(Corner, 90), (Dust, 90)],
        &[(Corner, 40), (Copy, 80)],
        &[(Small, 40), (Copy, 400)],
        &[(Large, 5), (Copy, 100)],
        &[(Small, 60), (Twin, 60), (Large, 3), (Copy, 60)],
        &[(Wall, 1), (Small, 200), (Dust, 200)],
        &[(Wall, 3), (Crowd, 200), (Stack, 10)],
        &[(Floor, 2), (Small, 150), (Dust, 150)],
        &[(Room, 2), (Small, 150), (Dust, 150)],
        &[(Room, 2), (Floor, 1), (Wall, 1), (Large, 10), (Crowd, 150)],
        &[(Beside, 20), (Small, 100), (Dust, 20)],
        &[(Beside, 80)],
        &[(Room, 70), (Dust, 20)],
        &[(Floor, 70), (Dust, 20)],
    ];
    for (number, kinds) in mixtures.iter().enumerate() {
        for turn in 0..2 {
            let scene = mixture(kinds, number as u64 + 100 * turn);
            let side = |at: usize| SIDES[at % SIDES.len()];
            let at = number + turn as usize * 3;
            let size = size(side(at), side(5 * at + 3));
            assert_drawn(&scene, size, &format!("mixture {number}, turn {turn}"));
        }
    }
}

/// As many spheres as a limit between two ways of drawing, one less, and one more.
#[test]
fn counts_at_the_limits() {
    use Kind::*;
    // These are behind the camera; with them no scene has few spheres.
    let not_few = (Behind, FEW_SPHERES);
    for near in [-1, 0, 1] {
        let [crowd, small_crowd, few] =
            [CROWD, SMALL_CROWD, FEW_SPHERES].map(|limit| limit.saturating_add_signed(near));
        for (number, kinds) in [
            [(Crowd, crowd), not_few],
            [(Stack, crowd), not_few],
            [(Crowd, small_crowd), not_few],
            [(Stack, small_crowd), not_few],
            [(Stack, few), (Behind, 0)],
            [(Large, few), (Behind, 0)],
            [(Small, few), (Behind, 0)],
        ]
        .into_iter()
        .enumerate()
        {
            let scene = mixture(&kinds, number as u64);
            let what = format!("{kinds:?}");
            assert_drawn(&scene, size(65, 64), &what);
            assert_drawn(&scene, size(129, 130), &what);
        }
    }
}

/// Pictures with so many tiles or columns that a way of drawing is no longer used.
#[test]
fn sides_at_the_limits() {
    let tile = TILES[0];
    let square = tile * MIN_TABLE.isqrt() as u32;
    let spheres = FEW_SPHERES + 1;
    for (width, height, count) in [
        (square, square, spheres),
        (square + 1, square, spheres),
        (MAX_COLUMNS, 3, 3),
        (MAX_COLUMNS + 1, 3, 3),
    ] {
        let scene = mixture(&[(Kind::Large, 2), (Kind::Small, count - 2)], 1);
        let size = size(width, height);
        let pixels = draw(&scene, size, tile, Bounds::Proven);
        assert_some_pixels(&scene, size, &pixels, 200, "a side at its limit");
        assert_alike(&scene, size, &pixels, &TILES[3..], "a side at its limit");
    }
}

#[test]
fn refused_bounds_draw_the_same_mixtures() {
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let kinds = KINDS.map(|kind| (kind, random.below(9) as usize));
        let scene = mixture(&kinds, seed);
        assert_refused_alike(
            &scene,
            size(40, 33),
            TILES[seed as usize % 4],
            &format!("seed {seed}"),
        );
    }
}

#[test]
fn any_mixture() {
    let counts = prop::collection::vec(
        prop_oneof![4 => Just(0), 4 => 1..6_usize, 1 => 6..110_usize],
        KINDS.len(),
    );
    let side = || prop_oneof![1_u32..40, prop::sample::select(SIDES.to_vec())];
    let config = ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    proptest!(config, |(counts in counts, seed in any::<u64>(), width in side(), height in side())| {
        let kinds: Vec<_> = KINDS.into_iter().zip(counts.iter().copied()).collect();
        let scene = mixture(&kinds, seed);
        assert_drawn(&scene, size(width, height), &format!("{counts:?} by seed {seed}"));
    });
}

/// More spheres than two runs have.
#[test]
fn several_runs() {
    let scene = cloud(2 * MAX_RUN + 40_000, 3);
    let size = size(1000, 562);
    let pixels = draw(&scene, size, 64, Bounds::Proven);
    assert_some_pixels(&scene, size, &pixels, 60, "several runs");
    assert_alike(&scene, size, &pixels, &[8], "several runs");
}

/// Copies far apart in the file, in other runs: the first is seen.
#[test]
fn copies_by_the_thousand() {
    let mut random = Random::new(1);
    let mut originals: Vec<[f32; 4]> = Vec::new();
    for kind in [Kind::Small, Kind::Dust, Kind::Crowd] {
        for _ in 0..30 {
            originals.push(one(kind, &[], &mut random));
        }
    }
    originals.extend((0..5).map(|_| one(Kind::Large, &[], &mut random)));
    let copies: Vec<_> = (0..200_000)
        .map(|_| originals[random.below(originals.len() as u64) as usize])
        .collect();
    // Only the first of each, in the order of the file, is visible.
    let mut firsts: Vec<(usize, [f32; 4])> = Vec::new();
    for (index, sphere) in copies.iter().enumerate() {
        if !firsts.iter().any(|(_, first)| first == sphere) {
            firsts.push((index, *sphere));
        }
    }
    let mut seen = scene_of(&[]);
    for &(index, [x, y, z, radius]) in &firsts {
        seen.spheres.push(Sphere {
            centre: [x, y, z],
            radius,
            colour: colour(index),
        });
    }
    let size = size(256, 200);
    let pixels = draw(&scene_of(&copies), size, 64, Bounds::Proven);
    assert_every_pixel(&seen, size, &pixels, "the first of each");
    let scene = scene_of(&copies[..5_000]);
    let pixels = draw(&scene, size, 16, Bounds::Proven);
    assert_some_pixels(&scene, size, &pixels, 500, "5,000 copies");
}

/// A million spheres behind a wall, and a few in front of it.
#[test]
fn hidden_by_the_million() {
    let mut random = Random::new(2);
    let mut spheres = Vec::new();
    for at in 0..1_000_000 {
        let mut sphere = one(Kind::Dust, &[], &mut random);
        if at % 10_000 != 0 {
            // As far beyond the wall, seen at the same place.
            sphere = sphere.map(|length| length * 8.0);
        }
        spheres.push(sphere);
    }
    spheres.push([10.0, -20.0, 101_500.0, 100_000.0]);
    let scene = scene_of(&spheres);
    let size = size(700, 500);
    let pixels = draw(&scene, size, 64, Bounds::Proven);
    assert_some_pixels(&scene, size, &pixels, 25, "a million");
    assert_alike(&scene, size, &pixels, &[16], "a million");
}

/// Few spheres, one in front of the other, so that whole rows are painted without packets.
/// The first and the last row are anywhere in a tile.
#[test]
fn few_spheres_in_whole_rows() {
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let mut some = |most: u64| random.below(most + 1) as usize;
        let kinds = [
            (Kind::Large, some(2)),
            (Kind::Small, some(3)),
            (Kind::Wall, some(1)),
            (Kind::Beside, some(1)),
            (Kind::Floor, some(1)),
        ];
        let scene = mixture(&kinds, seed);
        let side = |at: u64| SIDES[(at % SIDES.len() as u64) as usize];
        let size = size(side(seed), side(3 * seed + 2));
        assert_drawn(&scene, size, &format!("{kinds:?}, seed {seed}"));
    }
}

/// In a wide view, the outline of a sphere that reaches the plane of the camera has a second
/// branch, behind the camera. The sphere is alone in its bands, so whole rows could be painted.
#[test]
fn no_branch_behind_the_camera_is_painted() {
    let sphere = [0.0, 5.0, 0.5, 1.0];
    let mut scene = scene_of(&[sphere]);
    scene.viewport = Viewport {
        width: 20.0,
        height: 20.0,
        distance: 1.0,
    };
    for side in [64, 200, 256] {
        assert_drawn(&scene, size(side, side), &format!("{side} rows"));
    }
}

/// The spheres that a crowd hides are found in the drawn rows only, wherever these begin.
#[test]
fn crowds_cut_at_any_row() {
    let size = size(64, 64);
    for kinds in [
        [(Kind::Crowd, 400), (Kind::Behind, FEW_SPHERES)],
        [(Kind::Stack, 200), (Kind::Small, 400)],
    ] {
        let scene = mixture(&kinds, 3);
        let whole = draw(&scene, size, 64, Bounds::Proven);
        let renderer = tuned(&scene, size, 64, Bounds::Proven);
        for first in 0..size.height() {
            let last = size.height().min(first + 21);
            let mut rows = vec![0; size.row_bytes() * (last - first) as usize];
            renderer.draw(first..last, &mut rows);
            let within = size.row_bytes() * first as usize;
            assert!(
                rows == whole[within..][..rows.len()],
                "{kinds:?}, from {first}"
            );
        }
    }
}

#[test]
fn what_shows_in_some_rows_may_show_there() {
    let size = size(65, 48);
    let mut left_out = 0;
    for seed in 0..10 {
        let kinds = KINDS.map(|kind| (kind, 6));
        let scene = mixture(&kinds, seed);
        let pixels = draw(&scene, size, 64, Bounds::Proven);
        for rows in [0..1, 0..20, 20..21, 30..48, 47..48] {
            let may_show = may_show(scene.viewport, size, rows.clone());
            let bytes =
                rows.start as usize * size.row_bytes()..rows.end as usize * size.row_bytes();
            let (drawn, _) = pixels[bytes].as_chunks::<BYTES_PER_PIXEL>();
            for at in 0..scene.spheres.len() {
                let sphere = scene.spheres.get(at);
                let kept = may_show(&sphere);
                let shows = drawn.contains(&sphere.colour);
                assert!(kept || !shows, "{sphere:?} in {rows:?}, seed {seed}");
                left_out += u32::from(!kept);
            }
        }
    }
    assert!(left_out > 1000, "only {left_out} are left out");
}

#[test]
fn scales_are_powers_of_two() {
    for value in [
        1.0,
        1.5,
        2.0,
        0.75,
        3.0e38,
        1.7e-38,
        f32::MAX,
        f32::MIN_POSITIVE,
    ] {
        let power = power_of_two_below(value);
        assert!(
            power <= f64::from(value) && f64::from(value) < 2.0 * power,
            "{value:e}"
        );
        assert_eq!(power.log2().fract(), 0.0, "{value:e}");
    }
}

/// A band is right in the memory of another one, whichever part of its tiles that one drew.
#[test]
fn a_band_leaves_nothing_behind() {
    let size = size(200, 64);
    for (few, many) in [(20, 0), (0, 400), (10, 100)] {
        let scene = mixture(&[(Kind::Large, few), (Kind::Small, many)], 5);
        let camera = Camera::new(scene.viewport, size);
        let engine = Engine::new(&scene, camera, Tuning::default(), Workspace::default());
        assert_eq!(engine.band_rows(), 64);
        let draw = |rows: Range<u32>| {
            let mut pixels = vec![0; rows.len() * size.row_bytes()];
            engine.draw_band(rows, &mut pixels);
            pixels
        };
        let whole = draw(0..64);
        for rows in [0..1, 20..30, 63..64, 0..40] {
            draw(rows);
            assert!(whole == draw(0..64), "{few} and {many} spheres");
        }
    }
}

/// Copies differ only in their places in the file, whichever spheres are in the lanes beside
/// them. The box of the first copy is computed in floats; the second copy is beside a sphere
/// whose box can't be computed in floats.
#[test]
fn copies_beside_others() {
    let copy = [14.0, 15.0, 450.0, 140.0];
    let huge = [0.0, 0.0, 4e6, 2e6];
    let far = [1e4, 0.0, 500.0, 1.0];
    for lone in 0..2 * LANES {
        for many in [0, FEW_SPHERES, 2 * CROWD] {
            let mut spheres = vec![far; 2 * LANES + many];
            spheres[lone] = copy;
            spheres[(lone + LANES) % (2 * LANES)] = copy;
            spheres[(lone + 1) % (2 * LANES)] = huge;
            for (at, sphere) in spheres.iter_mut().enumerate().skip(2 * LANES) {
                *sphere = [at as f32, 0.0, 300.0 + at as f32, 1.0];
            }
            let scene = scene_of(&spheres);
            for bounds in [Bounds::Proven, Bounds::Refused] {
                let pixels = draw(&scene, size(63, 9), 64, bounds);
                let what = format!("{lone}, {many} more, {bounds:?}");
                assert_every_pixel(&scene, size(63, 9), &pixels, &what);
            }
        }
    }
}

/// A renderer draws the same picture in the memory of another one, whatever that one drew.
#[test]
fn memory_of_another_picture_leaves_nothing_behind() {
    let size = size(200, 64);
    let mut workspace = Workspace::default();
    for (few, many) in [
        (20, 0),
        (0, 9_000),
        (10, 100),
        (1, 0),
        (0, 40_000),
        (3, 400),
    ] {
        let scene = mixture(&[(Kind::Large, few), (Kind::Small, many)], 7);
        let again = Renderer::new_in(workspace, &scene, size, Method::Exact);
        let mut pixels = vec![0; size.pixel_bytes()];
        again.draw(0..size.height(), &mut pixels);
        assert!(scene.render(size) == pixels, "{few} and {many} spheres");
        workspace = again.into_workspace();
    }
}

/// A sphere that shows in rows 10 to 12 of 48, and nearly in the rows beside them.
#[test]
fn what_is_beside_the_rows_is_left_out() {
    let size = size(48, 48);
    let viewport = Viewport {
        width: 47.0,
        height: 47.0,
        distance: 1000.0,
    };
    let sphere = Sphere {
        centre: [0.0, 12.5, 1000.0],
        radius: 1.49,
        colour: [0; 3],
    };
    let kept = |rows: Range<u32>| may_show(viewport, size, rows)(&sphere);
    assert!(!kept(0..10) && kept(0..11) && kept(10..11));
    assert!(!kept(13..48) && kept(12..48) && kept(12..13));
}

#[test]
fn backgrounds_of_any_colour() {
    for background in [[7, 7, 7], [7, 7, 200], [200, 7, 7], [7, 200, 7], [1, 2, 3]] {
        for count in [0, 1, 2 * CROWD] {
            let mut scene = mixture(&[(Kind::Small, count)], 3);
            scene.background = background;
            assert_drawn(&scene, size(65, 9), &format!("{background:?}"));
        }
    }
}

/// A picture, of which some rows are drawn, and the work that takes.
struct Work {
    kinds: &'static [(Kind, usize)],
    side: u32,
    rows: Range<u32>,
    /// Intersections, pixels in runs, in packets, and one by one.
    work: [u64; 4],
}

/// What no picture shows: how much work it is. A change that costs work fails here; one that saves
/// some, too, and then the numbers are to be replaced by those of the message.
#[test]
fn pictures_are_as_much_work_as_they_were() {
    use Kind::*;
    let work = |kinds, side, rows, work| Work {
        kinds,
        side,
        rows,
        work,
    };
    let pictures = [
        work(
            &[(Crowd, 300), (Dust, 30)],
            256,
            0..256,
            [5656, 53248, 12287, 1],
        ),
        work(
            &[(Stack, 65), (Dust, 100)],
            200,
            0..200,
            [5219, 31808, 8192, 0],
        ),
        work(
            &[(Stack, 200), (Small, 50), (Crowd, 120)],
            129,
            5..60,
            [8297, 55, 7039, 1],
        ),
        work(
            &[(Large, 20), (Small, 200), (Dust, 200)],
            256,
            0..256,
            [22271, 16384, 49140, 12],
        ),
        work(
            &[(Corner, 40), (Copy, 80)],
            200,
            0..200,
            [1749, 31808, 8192, 0],
        ),
        work(
            &[(Small, 60), (Twin, 60), (Large, 3), (Copy, 60)],
            129,
            5..60,
            [2935, 55, 6104, 936],
        ),
        work(
            &[(Wall, 1), (Small, 200), (Dust, 200)],
            256,
            0..256,
            [4141, 53247, 12285, 4],
        ),
        work(
            &[(Wall, 3), (Crowd, 200), (Stack, 10)],
            200,
            0..200,
            [823, 35904, 4096, 0],
        ),
        work(
            &[(Room, 2), (Floor, 1), (Wall, 1), (Large, 10), (Crowd, 150)],
            129,
            5..60,
            [1524, 55, 7038, 2],
        ),
        work(
            &[(Beside, 20), (Small, 100), (Dust, 20)],
            256,
            0..256,
            [20224, 0, 65527, 9],
        ),
        work(&[(Room, 70), (Dust, 20)], 200, 0..200, [7688, 0, 39984, 16]),
        work(
            &[(Large, 30), (Behind, 32)],
            129,
            5..60,
            [1210, 3575, 3518, 2],
        ),
        work(
            &[(Crowd, CROWD), (Behind, FEW_SPHERES)],
            256,
            0..256,
            [56, 65536, 0, 0],
        ),
        work(
            &[(Crowd, CROWD + 1), (Behind, FEW_SPHERES)],
            200,
            0..200,
            [402, 35904, 4096, 0],
        ),
        work(
            &[(Stack, SMALL_CROWD), (Behind, FEW_SPHERES)],
            129,
            0..129,
            [48, 16641, 0, 0],
        ),
        work(
            &[(Stack, SMALL_CROWD + 1), (Behind, FEW_SPHERES)],
            256,
            0..256,
            [2072, 49152, 16384, 0],
        ),
        work(&[(Small, 6)], 200, 0..200, [9, 40000, 0, 0]),
        work(&[(Small, 3), (Wall, 1)], 129, 0..129, [10, 16641, 0, 0]),
        work(&[(Dust, FEW_SPHERES)], 256, 0..256, [16, 65535, 0, 1]),
    ];
    let mut wrong = Vec::new();
    for (seed, picture) in pictures.into_iter().enumerate() {
        let Work {
            kinds,
            side,
            rows,
            work,
        } = picture;
        let scene = mixture(kinds, seed as u64);
        let size = size(side, side);
        let renderer = tuned(&scene, size, 64, Bounds::Proven);
        let mut pixels = vec![0; rows.len() * size.row_bytes()];
        let counts = renderer.draw(rows.clone(), &mut pixels);
        let one_by_one = counts.pixels_in_doubles + counts.pixels_in_integers;
        let found = [
            counts.sphere_tests,
            counts.pixels_in_runs,
            counts.pixels_in_packets,
            one_by_one,
        ];
        // What is in doubt depends on whether the machine has fused operations.
        let near = |(&found, expected): (&u64, u64)| found.abs_diff(expected) <= 4 + expected / 64;
        if !found.iter().zip(work).all(near) {
            wrong.push(format!(
                "{kinds:?}, {side}, {rows:?}: {found:?} instead of {work:?}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A sphere on whose surface the camera is has inverse depths beyond floats in its polynomials, and
/// is met in doubles, eight pixels at a time.
#[test]
fn spheres_that_floats_do_not_hold_are_met_in_packets() {
    let around = [512.0, 640.0, 768.0].map(|radius| [0.0, 0.0, radius, radius]);
    let (small, stack) = (Kind::Small, Kind::Stack);
    for (kind, count) in [(small, CROWD / 4), (small, 4 * CROWD), (stack, 4 * CROWD)] {
        let mut spheres = around.to_vec();
        let mut random = Random::new(4);
        for _ in 0..count {
            spheres.push(one(kind, &spheres, &mut random));
        }
        spheres.extend((0..FEW_SPHERES).map(|_| one(Kind::Behind, &[], &mut random)));
        let scene = scene_of(&spheres);
        let size = size(120, 120);
        let mut pixels = vec![0; size.pixel_bytes()];
        let counts = tuned(&scene, size, 64, Bounds::Proven).draw(0..120, &mut pixels);
        let packets = counts.pixels_in_packets + counts.pixels_in_runs;
        assert!(
            size.pixels() - packets < 50,
            "{kind:?}, {count}: {counts:?}"
        );
    }
}

/// Of large spheres that touch the camera's plane, few pixels go to packets. Of these and of spheres
/// that touch the camera, few are decided one by one.
#[test]
fn spheres_that_touch_the_camera_or_its_plane_are_painted_in_runs() {
    let plane = [
        [-61.19925, -2308.5164, 696_593.1, 696_593.1],
        [623.65295, -1707.4701, 611_051.44, 611_051.44],
        [-1241.984, -181.2785, 914_144.06, 914_144.06],
    ];
    // k = 0
    let rows = [
        [-244.92274, 4701.0, 6268.0, 7835.0],
        [-127.212685, -7512.0, 5634.0, 9390.0],
        [77.67542, 8409.0, 0.0, 8409.0],
    ];
    // c = 0
    let surface = [
        [2610.0, 3480.0, 10_440.0, 11_310.0],
        [-2896.0, -2172.0, 8688.0, 9412.0],
        [6348.0, 2116.0, 1587.0, 6877.0],
    ];
    for (spheres, packets, doubles) in [(plane, 10, 100), (rows, 10, 100), (surface, 1, 100)] {
        let mut scene = scene_of(&spheres);
        (scene.viewport.width, scene.viewport.height) = (1024.0, 1024.0);
        let size = size(640, 640);
        let mut pixels = vec![0; size.pixel_bytes()];
        let counts = tuned(&scene, size, 64, Bounds::Proven).draw(0..640, &mut pixels);
        let decided = size.pixels() - counts.pixels_in_packets - counts.pixels_in_runs;
        assert!(
            counts.pixels_in_packets < size.pixels() / packets && decided < size.pixels() / doubles,
            "{spheres:?}: {counts:?}"
        );
    }
}

/// In another unit of length that is a power of two the picture is the same, and as much work.
#[test]
fn the_unit_of_length_does_not_matter() {
    let mut random = Random::new(6);
    let mut spheres: Vec<[f32; 4]> = Vec::new();
    for _ in 0..6 {
        // Mirror images have the same power.
        let [x, y, z, r] = one(Kind::Large, &[], &mut random);
        spheres.extend([[x, y, z, r], [-x, y, z, r], [x, -y, z, r]]);
    }
    spheres.extend((0..FEW_SPHERES).map(|_| one(Kind::Behind, &[], &mut random)));
    let size = size(200, 150);
    let drawn = [0, -100, 100].map(|exponent| {
        let unit = (exponent as f32).exp2();
        let scaled: Vec<_> = spheres
            .iter()
            .map(|sphere| sphere.map(|length| length * unit))
            .collect();
        let mut pixels = vec![0; size.pixel_bytes()];
        let scene = scene_of(&scaled);
        let counts = tuned(&scene, size, 64, Bounds::Proven).draw(0..size.height(), &mut pixels);
        (pixels, counts)
    });
    let (pixels, counts) = &drawn[0];
    for (others, other) in &drawn[1..] {
        assert!(pixels == others);
        let near = |a: u64, b: u64| a.abs_diff(b) <= 4 + b / 64;
        assert!(
            near(other.sphere_tests, counts.sphere_tests),
            "{other:?} {counts:?}"
        );
        assert!(
            near(other.pixels_in_packets, counts.pixels_in_packets),
            "{other:?} {counts:?}"
        );
    }
    assert!(counts.pixels_in_runs > size.pixels() / 2, "{counts:?}");
}

/// So many spheres, in pairs of which one is in front of the other, meet each row of tiles once;
/// otherwise they meet each tile.
#[test]
fn few_spheres_that_are_apart_are_painted_in_whole_rows() {
    let tests = |spheres: &[[f32; 4]]| {
        let mut scene = scene_of(spheres);
        scene.viewport.width = 2048.0;
        let size = size(2049, 128);
        let mut pixels = vec![0; size.pixel_bytes()];
        let renderer = tuned(&scene, size, 64, Bounds::Proven);
        let counts = renderer.draw(0..size.height(), &mut pixels);
        assert_eq!(counts.pixels_in_packets, 0, "{counts:?}");
        counts.sphere_tests
    };
    let pair = |at: usize| {
        let x = 120.0 * (at as f32 - (FEW_SPHERES / 2) as f32 / 2.0);
        [[x, 0.0, 256.0, 5.0], [3.0 * x, 0.0, 768.0, 30.0]]
    };
    let pairs: Vec<[f32; 4]> = (0..FEW_SPHERES / 2).flat_map(pair).collect();
    // All of them are in both rows of tiles.
    let in_rows = 2 * FEW_SPHERES as u64;
    assert_eq!(tests(&pairs), in_rows);
    assert_eq!(tests(&pairs[..2]), 4);
    let mut more = pairs.clone();
    more.push([0.0, 0.0, -9.0, 1.0]);
    assert!(tests(&more) > in_rows);
    // One is behind the middle of another one, and in front of its edge.
    let mut across = pairs.clone();
    across[1] = [pairs[0][0], 0.0, 258.0, 10.0];
    assert!(tests(&across) > in_rows);
}

#[test]
fn a_large_sphere_is_tested_in_the_tiles_that_its_box_meets() {
    let size = size(320, 320);
    for step in 0..140 {
        let mut spheres = vec![[step as f32 - 70.0, 70.0 - step as f32, 256.0, 70.0]];
        spheres.extend([[0.0, 0.0, -9.0, 1.0]; FEW_SPHERES]);
        let mut scene = scene_of(&spheres);
        (scene.viewport.width, scene.viewport.height) = (319.0, 319.0);
        // Without bounds no rows are painted, and no pixel is contested.
        let tuning = Tuning {
            bounds: Bounds::Ignored,
            ..Tuning::default()
        };
        let camera = Camera::new(scene.viewport, size);
        let prepared = Prepared::new(&scene, camera, tuning, &Room::default());
        let [large] = &prepared.bins.large[..] else {
            panic!("not one large sphere at step {step}");
        };
        let tiles = |first: u32, last: u32| u64::from(last / tuning.tile - first / tuning.tile + 1);
        let [left, right, top, bottom] = large.sides;
        let tiles = tiles(left, right) * tiles(top, bottom);
        let renderer = tuned(&scene, size, tuning.tile, tuning.bounds);
        let counts = renderer.draw(0..320, &mut vec![0; size.pixel_bytes()]);
        assert_eq!(counts.sphere_tests, tiles, "{large:?}");
        // In whole rows, in the rows of tiles that its box meets.
        let bands = u64::from(bottom / tuning.tile - top / tuning.tile + 1);
        let renderer = tuned(&scene, size, tuning.tile, Bounds::Proven);
        let counts = renderer.draw(0..320, &mut vec![0; size.pixel_bytes()]);
        assert_eq!(counts.sphere_tests, bands, "{large:?}");
    }
}

/// Two spheres of one colour whose outlines are the sides of tiles, nearly straight, and the background
/// between them.
#[test]
fn tiles_of_one_colour_do_not_spread() {
    // A plane through the camera and the y axis touches it at a distance of 1000.
    let beside = |edge: f32, sign: f32| {
        let slope = (edge - 159.5) / 256.0;
        let length = (1.0 + slope * slope).sqrt();
        let (along, across) = (1000.0 / length, sign * 3000.0 / length);
        Sphere {
            centre: [along * slope + across, 0.0, along - across * slope],
            radius: 3000.0,
            colour: [9; 3],
        }
    };
    let mut scene = scene_of(&[]);
    (scene.viewport.width, scene.viewport.height) = (319.0, 63.0);
    scene.spheres = [beside(127.5, -1.0), beside(191.5, 1.0)]
        .into_iter()
        .collect();
    let size = size(320, 64);
    assert_drawn(&scene, size, "one colour");
    // What a tile of one colour is.
    let counts =
        tuned(&scene, size, 64, Bounds::Proven).draw(0..64, &mut vec![0; size.pixel_bytes()]);
    assert_eq!(
        (counts.sphere_tests, counts.pixels_in_packets),
        (4, 0),
        "{counts:?}"
    );
}

/// Up to `SMALL_CROWD` spheres a tile is drawn by masks, however much they overlap.
#[test]
fn a_small_crowd_is_drawn_by_masks() {
    for (count, by_packets) in [(SMALL_CROWD, 0), (SMALL_CROWD + 1, 64 * 64)] {
        let mut spheres: Vec<[f32; 4]> = Vec::new();
        spheres.extend((0..count).map(|at| [0.0, 0.0, 1e4 + at as f32 * 10.0, 9e3]));
        spheres.extend([[0.0, 0.0, -9.0, 1.0]; FEW_SPHERES]);
        let scene = scene_of(&spheres);
        let renderer = tuned(&scene, size(64, 64), 64, Bounds::Proven);
        let counts = renderer.draw(0..64, &mut vec![0; 3 * 64 * 64]);
        assert_eq!(counts.pixels_in_packets, by_packets, "{count}: {counts:?}");
    }
}
