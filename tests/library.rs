//! The library as its users call it: what its types refuse, and what they return.

use std::{fs, io, path::PathBuf};

use sfera::{
    camera::ImageSize,
    ppm::{self, ImageError, MappedImage, SharedImage},
    render::{Form, Method, Renderer, Workspace, differing_pixels},
    scene::{Scene, SceneErrorKind, Viewport},
    spheres::{LengthError, Sphere},
};

const SMALLEST: f32 = f32::from_bits(1);

fn size() -> ImageSize {
    ImageSize::new(5, 3).expect("a size with pixels")
}

/// All that the proof assumes of the numbers of a scene.
#[test]
fn numbers_that_are_not_finite_and_lengths_that_are_not_positive_are_refused() {
    let colour = [1, 2, 3];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut centre = [0.0; 3];
            centre[axis] = bad;
            let refused = Sphere::new(centre, 1.0, colour);
            assert!(matches!(refused, Err(LengthError::NotFinite { .. })));
        }
    }
    for bad in [f32::NAN, f32::INFINITY, 0.0, -0.0, -SMALLEST] {
        assert!(Sphere::new([0.0; 3], bad, colour).is_err(), "{bad}");
        assert!(Viewport::new(bad, 1.0, 1.0).is_err(), "{bad}");
        assert!(Viewport::new(1.0, bad, 1.0).is_err(), "{bad}");
        assert!(Viewport::new(1.0, 1.0, bad).is_err(), "{bad}");
    }
    assert!(Sphere::new([f32::MAX, -0.0, -f32::MAX], SMALLEST, colour).is_ok());
    assert!(Viewport::new(SMALLEST, f32::MAX, 1.0).is_ok());
    let error = Viewport::new(1.0, 0.0, 1.0).expect_err("no height");
    assert_eq!(
        error.to_string(),
        "the height of the viewport is 0; it must be greater than 0"
    );
}

#[test]
fn a_scene_is_equal_to_the_one_that_its_text_describes() {
    let viewport = Viewport::new(1.5, 1.0, 2.0).expect("a viewport");
    let spheres =
        [3.0, 4.0].map(|z| Sphere::new([0.25, 0.0, z], 0.5, [z as u8, 0, 9]).expect("a sphere"));
    let scene = Scene::new(viewport, [7; 3], spheres).expect("a scene");
    assert_eq!(scene.to_string().parse::<Scene>().expect("a scene"), scene);
    let mut text = Vec::new();
    scene.write_text(&mut text).expect("memory to write to");
    assert_eq!(text, scene.to_string().into_bytes());
    let other = Scene::new(viewport, [7; 3], [spheres[1], spheres[0]]).expect("a scene");
    assert_ne!(other, scene);
}

#[test]
fn methods_have_names() {
    for method in [
        Method::Textbook(Form::Packets),
        Method::Geometric(Form::Packets),
        Method::Double(Form::Packets),
        Method::Exact,
        Method::Reference,
    ] {
        assert_eq!(method.to_string().parse(), Ok(method));
    }
    assert_eq!(Method::Double(Form::Scalar).form(), Some(Form::Scalar));
    assert_eq!(Method::Textbook(Form::Packets).form(), Some(Form::Packets));
    assert_eq!(Method::Exact.form(), None);
    let unknown = "Exact"
        .parse::<Method>()
        .expect_err("names are in lower case");
    assert!(unknown.to_string().contains("\"Exact\""));
}

#[test]
fn a_picture_in_one_call_is_the_exact_one() {
    let scene = Scene::read("scenes/example.txt").expect("the example");
    let mut pixels = vec![0; size().pixel_bytes()];
    let counts = Renderer::new(&scene, size(), Method::Exact).draw(0..3, &mut pixels);
    assert_eq!(counts.pixels(), 15);
    assert_eq!(scene.render(size()), pixels);
}

#[test]
fn a_renderer_hands_on_the_memory_that_it_has_used() {
    let scene = Scene::read("scenes/example.txt").expect("the example");
    let renderer = Renderer::new(&scene, size(), Method::Exact);
    renderer.draw(0..3, &mut vec![0; size().pixel_bytes()]);
    let [used, empty] =
        [renderer.into_workspace(), Workspace::default()].map(|memory| format!("{memory:?}"));
    assert!(used.len() > empty.len(), "{used}");
}

/// Spheres without end.
#[cfg(target_os = "linux")]
struct Endless {
    some: Vec<u8>,
    read: usize,
}

#[cfg(target_os = "linux")]
impl io::Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let some = &self.some[self.read % self.some.len()..];
        let length = some.len().min(buffer.len());
        buffer[..length].copy_from_slice(&some[..length]);
        self.read += length;
        Ok(length)
    }
}

/// In a process of its own, which may use few addresses.
#[cfg(target_os = "linux")]
#[test]
fn a_scene_without_the_memory_for_it_is_an_error_that_names_no_line() {
    use rustix::process::{Resource, Rlimit, setrlimit};
    const CHILD: &str = "SFERA_TEST_OF_MEMORY";
    if std::env::var_os(CHILD).is_none() {
        let name = "a_scene_without_the_memory_for_it_is_an_error_that_names_no_line";
        let program = std::env::current_exe().expect("this program");
        let child = std::process::Command::new(program)
            .args(["--exact", name])
            .env(CHILD, "")
            .env("RAYON_NUM_THREADS", "2")
            .output()
            .expect("it runs");
        let output = String::from_utf8_lossy(&child.stdout);
        assert!(child.status.success(), "{output}");
        return;
    }
    let few = Some(200 << 20);
    let limit = Rlimit {
        current: few,
        maximum: few,
    };
    setrlimit(Resource::As, limit).expect("a limit");
    let header = b"VP 1 1 1 BG 0 0 0 OBJ_N 4294967295\n".as_slice();
    let spheres = Endless {
        some: b"S 0 0 5 1 9 9 9\n".repeat(1000),
        read: 0,
    };
    let everything = |_| |_: &Sphere| true;
    let error = Scene::read_stream(&mut io::Read::chain(header, spheres), "endless", everything)
        .expect_err("too many spheres");
    assert!(matches!(error.kind(), SceneErrorKind::Memory), "{error}");
    assert_eq!((error.line(), error.column()), (None, None));
    assert!(
        error
            .to_string()
            .contains("not enough memory for 4294967295 spheres"),
        "{error}"
    );
}

/// The caller's own error, from either source.
#[derive(Debug, PartialEq)]
enum Failure {
    OfImage(String),
    OfStream(io::ErrorKind),
    Drawing(&'static str),
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        Self::OfImage(error.to_string())
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::OfStream(error.kind())
    }
}

/// What fails while it draws says so, and the error is the caller's own.
#[test]
fn errors_of_what_draws_are_returned() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    let fail = |_rows, _pixels: &mut [u8]| Err(Failure::Drawing("no ink"));
    let no_ink = Err(Failure::Drawing("no ink"));

    let mut whole = MappedImage::create(path("whole.ppm"), size()).expect("an image");
    assert_eq!(whole.try_draw(fail), no_ink);
    drop(whole);
    assert!(!path("whole.ppm").exists());

    let mut shared = SharedImage::open(path("shared.ppm"), size()).expect("an image");
    assert_eq!(shared.try_draw(1..2, fail), no_ink);

    let mut stream = Vec::new();
    assert_eq!(ppm::try_write_image(&mut stream, size(), fail), no_ink);
    assert_eq!(stream, ppm::header(size()).as_bytes());

    // Errors of the file or the stream come the same way.
    let mut full = [0_u8; 4];
    let drawn: Result<(), Failure> =
        ppm::try_write_image(&mut full.as_mut_slice(), size(), |_, _| Ok(()));
    assert_eq!(drawn, Err(Failure::OfStream(io::ErrorKind::WriteZero)));

    // Of a picture that another process removes meanwhile.
    let mut removed = SharedImage::open(path("removed.ppm"), size()).expect("an image");
    let drawn = removed.try_draw(0..3, |_, _| {
        fs::remove_file(path("removed.ppm")).map_err(Failure::from)
    });
    assert!(matches!(drawn, Err(Failure::OfImage(message)) if message.contains("removed")));
}

#[test]
#[should_panic(expected = "rows 2..4 of an image of 3")]
fn rows_beyond_a_shared_image_are_refused_before_anything_is_mapped() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = SharedImage::open(folder.path().join("image.ppm"), size());
    let _ = image.expect("an image").draw(2..4, |_, _| ());
}

#[test]
fn an_image_is_written_to_a_stream_row_by_row() {
    assert_eq!(size().to_string(), "5 x 3");
    let mut stream = Vec::new();
    ppm::write_image(&mut stream, size(), |rows, pixels| {
        for (row, pixels) in rows.zip(pixels.chunks_exact_mut(size().row_bytes())) {
            pixels.fill(row as u8);
        }
    })
    .expect("memory to write to");
    let rows = (0..3).flat_map(|row| [row; 15]);
    let expected: Vec<u8> = b"P6\n5 3\n255\n".iter().copied().chain(rows).collect();
    assert_eq!(stream, expected);
}

#[test]
fn pixels_that_differ_are_counted_once_each() {
    let one = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    for (other, expected) in [
        (vec![1, 2, 3, 4, 5, 6, 7, 8, 9], 0),
        (vec![0, 2, 3, 4, 0, 6, 7, 8, 0], 3),
        (vec![0, 0, 0, 4, 5, 6], 1),
        (vec![], 0),
    ] {
        assert_eq!(differing_pixels(&one, &other), expected, "{other:?}");
        assert_eq!(differing_pixels(&other, &one), expected, "{other:?}");
    }
}
