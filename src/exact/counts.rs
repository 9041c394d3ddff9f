//! What a picture took.

use std::ops::AddAssign;

use super::decide::Rung;

/// How many pixels each rung of the ladder settled, and at what effort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// Pixels settled in runs, without looking at them.
    pub pixels_in_runs: u64,
    /// Pixels settled by a packet.
    pub pixels_in_packets: u64,
    /// Pixels settled one by one in doubles.
    pub pixels_in_doubles: u64,
    /// Pixels settled one by one in double-doubles.
    pub pixels_in_double_doubles: u64,
    /// Pixels settled one by one in integers.
    pub pixels_in_integers: u64,
    /// How often a row or a packet met a sphere.
    pub sphere_tests: u64,
}

impl Counts {
    /// Pixels settled by any rung: all of them that the exact method drew.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.pixels_in_runs + self.pixels_beyond_runs()
    }

    pub(super) fn pixels_beyond_runs(&self) -> u64 {
        self.pixels_in_packets
            + self.pixels_in_doubles
            + self.pixels_in_double_doubles
            + self.pixels_in_integers
    }

    pub(super) fn settled_by(&mut self, rung: Rung) {
        match rung {
            Rung::Doubles => self.pixels_in_doubles += 1,
            Rung::DoubleDoubles => self.pixels_in_double_doubles += 1,
            Rung::Integers => self.pixels_in_integers += 1,
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.pixels_in_runs += other.pixels_in_runs;
        self.pixels_in_packets += other.pixels_in_packets;
        self.pixels_in_doubles += other.pixels_in_doubles;
        self.pixels_in_double_doubles += other.pixels_in_double_doubles;
        self.pixels_in_integers += other.pixels_in_integers;
        self.sphere_tests += other.sphere_tests;
    }
}
