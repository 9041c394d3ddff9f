//! Settings of the engine for tests and benches.

/// How the engine uses its error bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounds {
    /// As proven: they decide which pixels are settled.
    #[default]
    Proven,
    /// As if they were infinite, so that integers decide every pixel: for tests.
    Refused,
    /// As if they were zero, so that every pixel is settled at once: for benches.
    Ignored,
}

/// Settings that do not change the picture.
#[derive(Clone, Copy, Debug)]
pub struct Tuning {
    /// Side of a tile: 8, 16, 32 or 64.
    pub tile: u32,
    /// How error bounds are used.
    pub bounds: Bounds,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            tile: 64,
            bounds: Bounds::default(),
        }
    }
}
