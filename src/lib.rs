//! **sfera** renders scenes of flat-coloured spheres: every pixel provably
//! right, at the speed at which memory can be written.
//!
//! # Calling it
//!
//! A [`scene::Scene`] is read from a file or parsed from text; a
//! [`render::Renderer`] draws any rows of it into any buffer, on rayon's threads:
//! the default ones, or those of a pool that `draw` is called in.
//!
//! ```
//! use sfera::{
//!     camera::ImageSize,
//!     render::{Form, Method, Renderer},
//!     scene::Scene,
//! };
//!
//! let scene = Scene::parse(b"VP 1 1 1  BG 255 255 255  OBJ_N 1  S 0 0 5 1 200 0 0")?;
//! let size = ImageSize::new(64, 48)?;
//! let renderer = Renderer::new(&scene, size, Method::Exact, Form::default());
//!
//! let mut pixels = vec![0; size.pixel_bytes()];
//! renderer.draw(0..size.height(), &mut pixels, &|_rows_done| ());
//! let centre = 24 * size.row_bytes() + 32 * 3;
//! assert_eq!(pixels[centre..centre + 3], [200, 0, 0]);
//!
//! // Some rows, on threads of one's own.
//! let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
//! let mut half = vec![0; 24 * size.row_bytes()];
//! pool.install(|| renderer.draw(24..48, &mut half, &|_| ()));
//! assert_eq!(half, pixels[24 * size.row_bytes()..]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Image files are made by [`ppm::MappedImage`] (whole, in one step),
//! [`ppm::SharedImage`] (in place, some rows) and [`ppm::write_image`] (a stream).
//! The crates that only the program needs belong to the feature `program`, which is
//! on by default. Nothing here is global: no state, no thread pool, no signal
//! handler that was not asked for.
//!
//! # The way through the code
//!
//! ```text
//! text -> Scene -> Spheres -> boxes -> tile candidates -> settled pixels -> RGB bytes -> mapped file -> rename
//! ```
//!
//! A module imports only what stands above it in this table.
//!
//! | step | module | what it does |
//! | --- | --- | --- |
//! | names -> messages | [`name`] | shows names without what a terminal obeys |
//! | memory | `pages` | huge pages, where the system has them |
//! | spheres | [`spheres`] | the structure of arrays, file order, padded to whole packets |
//! | text -> scene | [`scene`] | reads the text; a refusal names line and column |
//! | pixel -> ray | [`camera`] | the one rule, every form of it side by side |
//! | ray -> colour, in float | [`methods`] | `textbook`, `geometric`, `double`: brute force, scalar and packets |
//! | ray -> colour, proven | [`exact`] | boxes, bins, coverage masks, packets, decisions |
//! | colours -> file | [`ppm`] | reserve, map, publish; the library's only `unsafe`, the mapping |
//! | all of it | [`mod@render`] | bands of rows -> pixels -> bytes |
//!
//! Why no pixel is wrong is proven stage by stage in [`exact::proof`].
//!
//! Beside the way stand [`reference`](mod@reference): what the picture means,
//! one pixel at a time in integers; [`nearness`]: how near a pixel is to showing
//! something else; and [`families`]: scenes that grow harder by one knob. Tests,
//! benches, `--method reference` and `--verify` read them; nothing else does.

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

pub mod spheres;

pub mod scene;

pub mod camera;

pub mod reference;

pub mod families;

pub mod nearness;

pub mod methods;

pub mod exact;

pub mod ppm;

pub mod render;
