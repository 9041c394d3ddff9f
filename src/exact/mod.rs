//! The engine: every pixel proven right.
//!
//! ```text
//! spheres -> boxes -> bins -> tiles: coverage masks or a crowd -> packets -> decisions -> bytes
//! ```
//!
//! | step | module | what it does |
//! | --- | --- | --- |
//! | | `bounds` | every constant of every error bound |
//! | | `kernels` | the formulas whose roundings those bounds count |
//! | | `tuning`, `pool`, `bits` | settings for tests, memory that is reused, bits of masks |
//! | | `grid` | the pixel grid, spheres eight at a time |
//! | | `sight` | a ray and a sphere in doubles, with running bounds |
//! | spheres -> boxes | `boxes` | the pixels in which a sphere may be visible, and its greatest inverse depth; culling |
//! | boxes -> bins | `bins` | the candidates of every tile |
//! | | `prepared` | all that is known before the first pixel |
//! | | `outline` | the columns a sphere covers in eight rows, as masks |
//! | | `depths` | inverse depths in a rectangle, as polynomials with an error bound |
//! | | `paint` | runs and packets to bytes |
//! | | `radical` | which of two spheres is nearer, pixel by pixel |
//! | tile of few spheres | `coverage` | masks from far to near; contested pixels |
//! | | `packet` | eight pixels against a sphere, each inverse depth an interval |
//! | tile of many spheres | `crowd` | packets for every pixel, nearest first where that pays; contested pixels of the other tiles |
//! | undecided pixels | `integers`, `decide` | doubles: depths, then powers; integers |
//! | | `counts` | how many pixels each step settled |
//! | all of it | `rows`, `band` | whole rows where no inverse depths overlap; a row of tiles |
//! | | `engine` | a prepared scene and memory to draw it in |
//!
//! A module imports only from those above it.
//!
//! The [`proof`] shows, theorem by theorem, that every pixel is right.

mod band;
mod bins;
mod bits;
mod bounds;
mod boxes;
mod counts;
mod coverage;
mod crowd;
mod decide;
mod depths;
mod engine;
mod grid;
mod integers;
mod kernels;
mod outline;
mod packet;
mod paint;
mod pool;
mod prepared;
mod radical;
mod rows;
mod sight;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trials;
pub(crate) mod tuning;

#[doc = include_str!("proof.md")]
pub mod proof {}

pub use counts::Counts;
pub(crate) use engine::Engine;
pub use engine::Workspace;
pub use prepared::may_show;
