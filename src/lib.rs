//! **sfera** renders scenes of flat-coloured spheres: every pixel provably
//! right, at the speed at which memory can be written.
//!
//! # The way through the code
//!
//! ```text
//! text -> Scene -> Spheres -> conics -> tile candidates -> settled pixels -> RGB bytes -> mapped file -> rename
//! ```
//!
//! A module imports only what stands above it in this table.
//!
//! | step | module | what it does |
//! | --- | --- | --- |
//! | spheres | [`spheres`] | the structure of arrays, file order, padded to whole packets |
//! | text -> scene | [`scene`] | reads the text; a refusal names line and column |
//! | pixel -> ray | [`camera`] | the one rule, every form of it side by side |
//! | ray -> colour, in float | [`methods`] | `textbook`, `geometric`, `double`: brute force, scalar and packets |
//! | ray -> colour, proven | [`exact`] | conics, bins, tiles, packets, decisions |
//! | colours -> file | [`ppm`] | reserve, map, publish; the only `unsafe` |
//! | all of it | [`mod@render`] | bands of rows -> pixels -> bytes |
//!
//! Beside the way stand [`reference`](mod@reference): what the picture means,
//! one pixel at a time in integers, and [`families`]: scenes that grow harder by
//! one knob. Tests, benches and `--method reference` read them; nothing else does.

pub mod spheres;

pub mod scene;

pub mod camera;

pub mod reference;

pub mod families;

pub mod methods;

pub mod exact;

pub mod ppm;

pub mod render;
