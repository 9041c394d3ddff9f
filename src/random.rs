//! Random numbers that depend only on their seed.

/// `SplitMix64`: G. Steele, D. Lea, C. Flood, Fast Splittable Pseudorandom Number
/// Generators, 2014.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Any 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly over `[low, high)`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let fraction = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * fraction
    }

    /// One of `0..count`; `count` is small against 2^64.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// A whole number between `-largest` and `largest`.
    pub fn whole(&mut self, largest: u64) -> f64 {
        self.below(2 * largest + 1) as f64 - largest as f64
    }

    /// `base` to a power between `low` and `high`: evenly by magnitude.
    pub fn power(&mut self, base: f64, low: f64, high: f64) -> f64 {
        base.powf(self.between(low, high))
    }

    /// 1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.below(2) == 0 { 1.0 } else { -1.0 }
    }

    /// Evenly over the unit sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let z = self.between(-1.0, 1.0);
        let angle = self.between(0.0, std::f64::consts::TAU);
        let across = (1.0 - z * z).sqrt();
        [across * angle.cos(), across * angle.sin(), z]
    }

    /// Puts items in any order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last as u64 + 1) as usize);
        }
    }
}
