//! **sfera** renders scenes of flat-coloured spheres: every pixel provably right, in
//! about the time that the fastest inexact rasteriser takes.
//!
//! # The first picture
//!
//! ```
//! use sfera::{camera::ImageSize, scene::Scene};
//!
//! let scene = Scene::read("scenes/example.txt")?;
//! let size = ImageSize::new(192, 108)?;
//! let pixels = scene.render(size);
//! assert_eq!(pixels.len(), 192 * 108 * 3);
//! assert_eq!(pixels[..3], [255, 255, 255]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Scenes in memory, methods, and some rows
//!
//! A [`scene::Scene`] is read from a file, parsed from text, or made of spheres. A
//! [`render::Renderer`] draws any rows of it into any buffer, on the threads of rayon: the
//! default ones, or those of the pool in which `draw` is called.
//!
//! ```
//! use sfera::{
//!     camera::ImageSize,
//!     render::{Form, Method, Renderer, differing_pixels},
//!     scene::{Scene, Viewport},
//!     spheres::Sphere,
//! };
//!
//! let viewport = Viewport::new(1.0, 1.0, 1.0)?;
//! let ball = Sphere::new([0.0, 0.0, 5.0], 1.0, [200, 0, 0])?;
//! let scene = Scene::new(viewport, [255; 3], [ball])?;
//! let size = ImageSize::new(64, 48)?;
//! let pixels = scene.render(size);
//!
//! // Some rows, on threads of your own.
//! let renderer = Renderer::new(&scene, size, Method::Exact);
//! let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
//! let mut half = vec![0; 24 * size.row_bytes()];
//! pool.install(|| renderer.draw(24..48, &mut half));
//! assert_eq!(half, pixels[24 * size.row_bytes()..]);
//!
//! // As most programs compute it.
//! let textbook = Renderer::new(&scene, size, Method::Textbook(Form::Packets));
//! let mut inexact = vec![0; size.pixel_bytes()];
//! textbook.draw(0..48, &mut inexact);
//! assert_eq!(differing_pixels(&inexact, &pixels), 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Image files
//!
//! [`ppm::MappedImage`] makes a file that appears whole, in one step,
//! [`ppm::SharedImage`] draws some rows of a file in place, and [`ppm::write_image`]
//! writes to a stream.
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("example.ppm");
//! use sfera::{
//!     camera::ImageSize,
//!     ppm::MappedImage,
//!     render::{Method, Renderer},
//!     scene::Scene,
//! };
//!
//! let scene = Scene::read("scenes/example.txt")?;
//! let size = ImageSize::new(192, 108)?;
//! let renderer = Renderer::new(&scene, size, Method::Exact);
//! let mut image = MappedImage::create(&path, size)?;
//! image.draw(|rows, pixels| {
//!     renderer.draw(rows, pixels);
//! })?;
//! image.publish()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a dependent should know
//!
//! - **Speed needs `target-cpu`.** The packets are as wide as the CPU that the *dependent's*
//!   build names; the settings of this repository do not apply to it. Set
//!   `RUSTFLAGS="-C target-cpu=native"`, or `x86-64-v3` for a program that runs on other
//!   machines. Without it the bytes are the same, but drawing takes longer.
//! - The crates that only the program needs belong to the feature `program`, which is on by
//!   default: depend on sfera with `default-features = false`.
//! - Nothing here is global: no state, no thread pool, no signal handler.
//!
//! # The modules
//!
//! ```text
//! text -> Scene -> Spheres -> boxes -> tile candidates -> settled pixels -> RGB bytes -> mapped file -> rename
//! ```
//!
//! A module imports only modules above it in this table.
//!
//! | step | module | what it does |
//! | --- | --- | --- |
//! | names -> messages | [`name`] | shows names without characters that control a terminal |
//! | memory | `pages` | huge pages, where the system has them |
//! | tests | `random` | random numbers that depend on a seed alone |
//! | spheres | [`spheres`] | the structure of arrays, file order, padded to whole packets |
//! | text -> scene | [`scene`] | reads the text; a refusal names line and column |
//! | pixel -> ray | [`camera`] | the rule for rays, in each of its forms |
//! | pixel -> colour, defined | [`reference`](mod@reference) | the definition of the picture, one pixel at a time in integers |
//! | wrong pixel -> cause | [`nearness`] | how near a pixel is to showing another colour |
//! | ray -> colour, in float | [`methods`] | `textbook`, `geometric`, `double`: brute force, scalar and packets |
//! | ray -> colour, proven | [`exact`] | boxes, bins, coverage masks, packets, decisions |
//! | colours -> file | [`ppm`] | reserve, map, publish; the library's only `unsafe`, the mapping |
//! | all of it | [`mod@render`] | bands of rows -> pixels -> bytes |
//! | | `testing` | only for the tests and benches of this crate: families of hard scenes, settings of the engine and of the reader |
//!
//! Why no pixel is wrong is proven stage by stage in [`exact::proof`].
//!
//! The program is in `src/cli`, whose `mod.rs` lists its modules. It has two
//! more pieces of `unsafe` code: the signal handler, which removes temporary files, reports a
//! lost page of a mapped file (another process shortened the file) and ends the program; and
//! the allocator that reports a failed allocation.
//!
//! # Dependencies
//!
//! | crate | what for |
//! | --- | --- |
//! | `wide` | packets of 8 floats and of 8 doubles, without `unsafe` of our own |
//! | `rayon` | bands of rows, runs of spheres and chunks of text on all threads |
//! | `memmap2` | the mapped image; the bins in huge pages |
//! | `bytemuck` | lanes and records seen as bytes, without transmuting |
//! | `dashu` | integers of any size; in tests dyadic numbers |
//! | `rustix` | reserving blocks, files without a name, locks |
//! | `tempfile` | the file beside the image, where a file needs a name |
//! | `thiserror` | error types |
//! | `png`, `indicatif`, `libc` | the program alone: PNG images, the progress bar, signals |
//! | `clap`, `clap_complete`, `clap_mangen` | the program alone: arguments, completions, the manual page |
//! | `criterion`, `proptest`, `plotters` | for development: benches, random tests, charts |
//!
//! These are 64 crates with all that they depend on; tests and benches add 46. `make deny`
//! checks licences (all permissive), sources and, if the network allows it, advisories.
//!
//! # Security
//!
//! A scene may come from a stranger. Whatever its bytes are, the result is a picture
//! or an error: no panic, no signal, nothing overwritten. The reader and the renderer
//! are fuzzed (`make fuzz`), and `scenes/bad` has a test of the message for every
//! refusal. Only the mapping of files, the program's signal handlers and its message
//! for a failed allocation are `unsafe`. `make checked` runs every test with overflow
//! checks, `make sanitize` with the address sanitizer.
//!
//! What a scene can cost at most:
//! - Memory: 19 bytes for each sphere, at most 160 more while it is drawn, 4 bytes for
//!   each tile of 64 x 64 pixels, and a few megabytes. The number of spheres that the
//!   text claims costs nothing.
//! - Time: reading is linear in the bytes. Drawing is linear in spheres and pixels for
//!   ordinary scenes. A scene made to be hard can have every pixel decided in integers
//!   between all spheres that meet there, which takes some microseconds for each of
//!   them. There is no time limit inside: `timeout`, `ulimit -t` and `ulimit -v` are
//!   respected.
//!
//! There is no protection against another process that writes to the image or shortens
//! it while it is mapped. Shortening is reported (exit code 1); bytes that others write
//! stay in the picture.
//!
//! # Contributing
//!
//! `make check` (format, lints, documentation) and `make test` must pass. `make bench`
//! times each stage, `make peers` compares with other renderers, and `perf-notes.md`
//! records what was tried, with its figures, whether it was kept or not.
//! `tests/README.md` says which test holds which promise.
//!
//! | change | where it begins | what follows |
//! | --- | --- | --- |
//! | a float method | a file in [`methods`]: the formula as a comment, then its scalar and its packet form | [`render::Method`] with its names in `FromStr`, then each `match` that no longer compiles, that of `--method` in `cli/arguments.rs` too; the lists of methods in `cli/compare.rs`, in `tests/bit_identity.rs`, which compares both forms, and in `tests/stability.rs`, which says where it fails; `make bench` and `make chart` have such lists too |
//! | a word of the scene format | `scene/grammar.rs`, its tables and values | [`scene::Scene`] and its `Display`; `finish_header` or `finish_sphere` in `scene/parser.rs`, and `chunks.rs` for a word of spheres; the texts of `scene/parser/messages.rs`; advice on its mistakes in `scene/advice.rs`; a file in `scenes/bad` for each refusal (`tests/reader.rs` has the command that writes their messages); `tests/oracle.py`, `tests/fuzz/words.dict`, the README |
//! | a formula of the engine | the theorem in `exact/proof.md`, then the table of its roundings in `exact/bounds.rs` | the code, then the tests of its stage, `exact/*/tests.rs`, against rational arithmetic |
//! | the rule from pixels to rays | [`camera`], which holds every form of it | [`reference`](mod@reference), which must say the same in integers |
//! | a promise about files | the system calls in `ppm/system`, and their order in [`ppm`] | a row in the table of faults in `tests/README.md`, and its test in `tests/faults` |
//! | an option of the program | `cli/arguments.rs` | `tests/cli.rs`; the README's table of options |
//!
//! A bug that was found becomes a test that fails without the fix. Benches check their
//! answers before they time; tests do not measure time.

#[cfg(any(
    all(target_arch = "x86", not(target_feature = "sse2")),
    all(target_arch = "arm", target_vendor = "apple"),
    target_arch = "m68k",
))]
compile_error!(
    "this target rounds floats in other ways than IEEE 754 asks for, so the pictures would be wrong; build for one with SSE2, or for a 64-bit one"
);

pub mod name;

mod pages;

mod random;

pub mod spheres;

pub mod scene;

pub mod camera;

pub mod reference;

pub mod nearness;

pub mod methods;

pub mod exact;

pub mod ppm;

pub mod render;

#[doc(hidden)]
pub mod testing;
