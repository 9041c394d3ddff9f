//! Every method in both forms, on one thread and on two: a few large spheres,
//! and many small ones. Answers are checked before anything is timed.

use std::{path::Path, time::Duration};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use sfera::{
    camera::ImageSize,
    families::cloud,
    render::{Form, Method, Renderer},
    scene::Scene,
};

const FLOAT_METHODS: [Method; 3] = [Method::Textbook, Method::Geometric, Method::Double];

fn methods(criterion: &mut Criterion) {
    let example = Scene::read(Path::new("scenes/example.txt")).expect("the example");
    let full = ImageSize::new(1920, 1080).expect("a size with pixels");
    compare(criterion, "example", &example, full);
    let quarter = ImageSize::new(480, 270).expect("a size with pixels");
    compare(criterion, "1000 spheres", &cloud(1_000, 1), quarter);
}

fn compare(criterion: &mut Criterion, name: &str, scene: &Scene, size: ImageSize) {
    for method in FLOAT_METHODS {
        let mut scalar = vec![0; size.pixel_bytes()];
        let mut packets = vec![0; size.pixel_bytes()];
        draw(scene, size, method, Form::Scalar, &mut scalar);
        draw(scene, size, method, Form::Packets, &mut packets);
        assert!(
            scalar == packets,
            "{method:?} packets differ from scalar on {name}"
        );
    }
    let both_forms = |method| [Form::Scalar, Form::Packets].map(|form| (method, form));
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
        for (method, form) in contenders.clone().chain([(Method::Exact, Form::Packets)]) {
            let method_name = format!("{method:?}").to_lowercase();
            let form_name = match (method, form) {
                (Method::Exact, _) => "engine",
                (_, Form::Scalar) => "scalar",
                (_, Form::Packets) => "packets",
            };
            group.bench_function(BenchmarkId::new(method_name, form_name), |bencher| {
                bencher.iter(|| pool.install(|| draw(scene, size, method, form, &mut pixels)));
            });
        }
        group.finish();
    }
}

/// Preparation included: it is part of a frame.
fn draw(scene: &Scene, size: ImageSize, method: Method, form: Form, pixels: &mut [u8]) {
    Renderer::new(scene, size, method, form).draw(0..size.height(), pixels, &|_| ());
}

criterion_group!(benches, methods);
criterion_main!(benches);
