//! Packets draw the bytes that one pixel at a time draws, on any number of
//! threads, in any build.

mod common;

use std::{
    fmt::Write,
    hash::{DefaultHasher, Hasher},
};

use common::{draw, scene, size};
use proptest::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sfera::{
    camera::ImageSize,
    render::{Form, Method, Renderer},
    scene::Scene,
    testing::families::{FAMILIES, cloud},
};

/// The methods that exist in two forms.
const FLOAT_METHODS: [fn(Form) -> Method; 3] =
    [Method::Textbook, Method::Geometric, Method::Double];

fn threads(count: usize) -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(count);
    pool.build().expect("a thread pool")
}

/// Compares all forms and pools with one pixel at a time on one thread.
fn assert_identical(scene: &Scene, size: ImageSize, pools: &[ThreadPool]) {
    for method in FLOAT_METHODS {
        let one_by_one = draw(scene, size, method(Form::Scalar));
        let method = method(Form::Packets);
        for pool in pools {
            let packets = pool.install(|| draw(scene, size, method));
            assert!(
                packets == one_by_one,
                "{method} packets differ from scalar: {size:?}, {} threads, {} spheres",
                pool.current_num_threads(),
                scene.spheres().len(),
            );
        }
    }
    let on_one_thread = pools[0].install(|| draw(scene, size, Method::Exact));
    for pool in &pools[1..] {
        let again = pool.install(|| draw(scene, size, Method::Exact));
        assert!(again == on_one_thread, "exact depends on threads: {size:?}");
    }
}

/// Every incomplete packet, every incomplete tile, and every count of spheres around one and
/// two packets.
#[test]
fn every_small_width_height_and_count() {
    let pools = [threads(1)];
    for count in 0..=17 {
        let scene = cloud(count, count as u64);
        assert_eq!(scene.spheres().len(), count);
        for width in 1..=33 {
            for height in [1, 2, 5, 8] {
                assert_identical(&scene, size(width, height), &pools);
            }
        }
    }
}

#[test]
fn the_example() {
    let scene = Scene::read("scenes/example.txt").expect("the example");
    assert_identical(
        &scene,
        size(1920, 1080),
        &[threads(1), threads(2), threads(7)],
    );
}

#[test]
fn every_family() {
    let pools = [threads(2)];
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            let scene = family.scene(difficulty, 0);
            assert_identical(&scene, size(37, 29), &pools);
        }
    }
}

/// Spheres in front of the camera, behind it, around it, and touching it.
fn sphere() -> impl Strategy<Value = [f32; 4]> {
    let anywhere = (-9.0_f32..9.0, -9.0_f32..9.0, -9.0_f32..9.0, 0.01_f32..4.0)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let in_view = (-1.5_f32..1.5, -1.5_f32..1.5, 2.0_f32..6.0, 0.01_f32..1.5)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let around = (-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0, 1.8_f32..5.0)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    // 1^2 + 2^2 + 2^2 = 3^2
    let sides = prop::sample::select(vec![
        [1.0, 2.0, 2.0],
        [-2.0, 1.0, 2.0],
        [2.0, -2.0, 1.0],
        [-1.0, -2.0, -2.0],
    ]);
    let touching = (sides, 0.1_f32..4.0)
        .prop_map(|([x, y, z], unit)| [x * unit, y * unit, z * unit, 3.0 * unit]);
    let behind = (-2.0_f32..2.0, -2.0_f32..2.0, -9.0_f32..-0.5, 0.01_f32..2.0)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    prop_oneof![4 => in_view, 2 => anywhere, 1 => around, 1 => touching, 1 => behind]
}

#[test]
fn random_scenes_on_1_2_and_7_threads() {
    let pools = [threads(1), threads(2), threads(7)];
    let viewport = (0.1_f32..4.0, 0.1_f32..4.0, 0.1_f32..4.0);
    let scenes = (viewport, prop::collection::vec(sphere(), 0..24));
    let config = ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    proptest!(config, |(
        ((width, height, distance), spheres) in scenes,
        columns in 1_u32..80,
        rows in 1_u32..40,
    )| {
        let scene = scene([width, height, distance], &spheres);
        assert_identical(&scene, size(columns, rows), &pools);
    });
}

/// An image drawn in two parts, wherever it is cut, equals the image drawn at once.
#[test]
fn rows_drawn_apart_are_the_rows_drawn_together() {
    let scene = cloud(100, 2);
    let size = size(45, 71);
    let packets = FLOAT_METHODS.map(|method| method(Form::Packets));
    for method in packets.into_iter().chain([Method::Exact]) {
        let whole = draw(&scene, size, method);
        let renderer = Renderer::new(&scene, size, method);
        for cut in [0, 1, 15, 16, 17, 40, 70, 71] {
            let mut parts = vec![0; size.pixel_bytes()];
            let (above, below) = parts.split_at_mut(size.row_bytes() * cut as usize);
            renderer.draw(cut..size.height(), below);
            renderer.draw(0..cut, above);
            assert!(parts == whole, "{method:?} cut at row {cut}");
        }
    }
}

/// Writes the hashes of many pictures to a file. `make test` compares those of builds for
/// different CPUs.
#[test]
fn hashes_for_the_comparison_of_builds() {
    let mut hashes = String::new();
    let mut add = |name: &str, scene: &Scene, size: ImageSize| {
        let both_forms = |method: fn(Form) -> Method| [method(Form::Scalar), method(Form::Packets)];
        let methods = FLOAT_METHODS.into_iter().flat_map(both_forms);
        for method in methods.chain([Method::Exact]) {
            let mut hasher = DefaultHasher::new();
            hasher.write(&draw(scene, size, method));
            let hash = hasher.finish();
            writeln!(hashes, "{hash:016x} {method:?} {name}").expect("a string grows");
        }
    };
    let example = Scene::read("scenes/example.txt").expect("the example");
    add("example", &example, size(1920, 1080));
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            let scene = family.scene(difficulty, 3);
            add(
                &format!("{} {difficulty:e}", family.name),
                &scene,
                size(65, 49),
            );
        }
    }
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/image-hashes.txt");
    std::fs::write(path, hashes).expect("a file for the hashes");
}
