//! The knobs that tests and benches turn.

/// What the engine makes of its error bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounds {
    /// They decide what is settled.
    #[default]
    Proven,
    /// Nothing is settled before integers: for tests.
    Refused,
    /// Everything is settled at once, as if nothing were rounded: for benches.
    Ignored,
}

/// How an engine goes about its work; the picture is the same.
#[derive(Clone, Copy, Debug)]
pub struct Tuning {
    /// Side of a tile: 8, 16, 32 or 64.
    pub tile: u32,
    /// What is made of error bounds.
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
