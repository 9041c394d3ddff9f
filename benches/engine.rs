//! The engine: the cost of its stages, its bounds and its tiles. Checks the pictures before it
//! times anything.

use std::time::Duration;

use criterion::{
    BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use sfera::{
    camera::ImageSize,
    render::{Method, Renderer, differing_pixels},
    scene::Scene,
    testing::{
        Bounds, Tuning,
        families::{FAMILIES, cloud},
        tuned,
    },
};

fn scenes() -> Vec<(&'static str, Scene)> {
    let example = Scene::read("scenes/example.txt").expect("the example");
    let lattice = FAMILIES.iter().find(|family| family.name == "lattice");
    let lattice = lattice.expect("a family of this name");
    vec![
        ("example", example),
        ("lattice of 4096", lattice.scene(4096.0, 1)),
        ("1000 spheres", cloud(1_000, 1)),
        ("10000 spheres", cloud(10_000, 1)),
        ("100000 spheres", cloud(100_000, 1)),
    ]
}

fn size() -> ImageSize {
    ImageSize::new(1920, 1080).expect("a size with pixels")
}

fn one_thread() -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread pool")
}

fn renderer(scene: &Scene, tuning: Tuning) -> Renderer<'_> {
    tuned(scene, size(), Method::Exact, tuning)
}

fn drawn(scene: &Scene, tuning: Tuning) -> Vec<u8> {
    let mut pixels = vec![0; size().pixel_bytes()];
    renderer(scene, tuning).draw(0..size().height(), &mut pixels);
    pixels
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(20)
        .measurement_time(Duration::from_secs(2));
    group
}

/// From spheres to bytes with preparation, and preparation alone; for comparison filling the
/// same memory with one value.
fn stages(criterion: &mut Criterion) {
    let pool = one_thread();
    for (name, scene) in scenes() {
        let mut pixels = vec![0; size().pixel_bytes()];
        let mut group = group(criterion, &format!("{name}, stages"));
        group.bench_function("prepare", |bencher| {
            bencher.iter(|| pool.install(|| renderer(&scene, Tuning::default())));
        });
        group.bench_function("whole", |bencher| {
            bencher.iter(|| {
                let rows = 0..size().height();
                pool.install(|| renderer(&scene, Tuning::default()).draw(rows, &mut pixels))
            });
        });
        group.bench_function("fill", |bencher| bencher.iter(|| pixels.fill(7)));
        group.finish();
    }
}

/// The cost of certainty: with error bounds, and with the bounds ignored.
fn bounds(criterion: &mut Criterion) {
    compare(
        criterion,
        "bounds",
        &[Bounds::Proven, Bounds::Ignored],
        |bounds| Tuning {
            bounds,
            ..Tuning::default()
        },
    );
}

fn tiles(criterion: &mut Criterion) {
    compare(criterion, "tiles", &[8, 16, 32, 64], |tile| Tuning {
        tile,
        ..Tuning::default()
    });
}

fn compare<T: Copy + std::fmt::Debug>(
    criterion: &mut Criterion,
    name: &str,
    choices: &[T],
    tuning: impl Fn(T) -> Tuning,
) {
    let pool = one_thread();
    for (scene_name, scene) in scenes() {
        let right = drawn(&scene, Tuning::default());
        let mut group = group(criterion, &format!("{scene_name}, {name}"));
        for &choice in choices {
            let tuning = tuning(choice);
            let mut pixels = drawn(&scene, tuning);
            let wrong = differing_pixels(&pixels, &right);
            // Without bounds one pixel in some thousands may be wrong; with them, none.
            let allowed = if tuning.bounds == Bounds::Ignored {
                size().pixels() / 1000
            } else {
                0
            };
            assert!(
                wrong <= allowed,
                "{wrong} pixels wrong: {choice:?} on {scene_name}"
            );
            group.bench_function(format!("{choice:?}"), |bencher| {
                bencher.iter(|| {
                    let rows = 0..size().height();
                    pool.install(|| renderer(&scene, tuning).draw(rows, &mut pixels))
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, stages, bounds, tiles);
criterion_main!(benches);
