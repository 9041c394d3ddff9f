//! Every method in both forms, on one thread and on two, with few large spheres and with many
//! small ones. Checks the pictures before it times anything.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use sfera::{
    camera::ImageSize,
    render::{Form, Method, Renderer},
    scene::Scene,
    testing::families::cloud,
};

const FLOAT_METHODS: [fn(Form) -> Method; 3] =
    [Method::Textbook, Method::Geometric, Method::Double];

fn methods(criterion: &mut Criterion) {
    let example = Scene::read("scenes/example.txt").expect("the example");
    let full = ImageSize::new(1920, 1080).expect("a size with pixels");
    compare(criterion, "example", &example, full);
    let quarter = ImageSize::new(480, 270).expect("a size with pixels");
    compare(criterion, "1000 spheres", &cloud(1_000, 1), quarter);
}

fn compare(criterion: &mut Criterion, name: &str, scene: &Scene, size: ImageSize) {
    for method in FLOAT_METHODS {
        let name_of_method = method(Form::Scalar);
        let mut scalar = vec![0; size.pixel_bytes()];
        let mut packets = vec![0; size.pixel_bytes()];
        draw(scene, size, method(Form::Scalar), &mut scalar);
        draw(scene, size, method(Form::Packets), &mut packets);
        assert!(
            scalar == packets,
            "{name_of_method} packets differ from scalar on {name}"
        );
    }
    let both_forms = |method: fn(Form) -> Method| [Form::Scalar, Form::Packets].map(method);
    let contenders = FLOAT_METHODS.into_iter().flat_map(both_forms);
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("a thread pool");
        let mut group = criterion.benchmark_group(format!("{name}, threads {threads}"));
        group.throughput(Throughput::Elements(size.pixels()));
        group
            .sample_size(10)
            .measurement_time(Duration::from_secs(3));
        let mut pixels = vec![0; size.pixel_bytes()];
        for method in contenders.clone().chain([Method::Exact]) {
            let form = method
                .form()
                .map_or_else(|| "engine".to_owned(), |form| form.to_string());
            group.bench_function(BenchmarkId::new(method.to_string(), form), |bencher| {
                bencher.iter(|| pool.install(|| draw(scene, size, method, &mut pixels)));
            });
        }
        group.finish();
    }
}

/// Includes preparation, which is part of a frame.
fn draw(scene: &Scene, size: ImageSize, method: Method, pixels: &mut [u8]) {
    Renderer::new(scene, size, method).draw(0..size.height(), pixels);
}

criterion_group!(benches, methods);
criterion_main!(benches);
