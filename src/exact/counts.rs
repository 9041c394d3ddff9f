//! How the pixels of a picture were settled.

use std::ops::AddAssign;

use super::decide::Rung;

/// How many pixels each stage settled, and how many intersections that took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// Pixels settled in runs, without testing each.
    pub pixels_in_runs: u64,
    /// Pixels settled by a packet.
    pub pixels_in_packets: u64,
    /// Pixels settled one by one in doubles.
    pub pixels_in_doubles: u64,
    /// Pixels settled one by one in integers.
    pub pixels_in_integers: u64,
    /// Intersections of a row or a packet with a sphere.
    pub sphere_tests: u64,
}

impl Counts {
    /// Pixels settled by any stage: all that the exact method drew.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.pixels_in_runs + self.pixels_beyond_runs()
    }

    pub(super) fn pixels_beyond_runs(&self) -> u64 {
        self.pixels_in_packets + self.pixels_in_doubles + self.pixels_in_integers
    }

    pub(super) fn settled_by(&mut self, rung: Rung) {
        match rung {
            Rung::Doubles => self.pixels_in_doubles += 1,
            Rung::Integers => self.pixels_in_integers += 1,
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.pixels_in_runs += other.pixels_in_runs;
        self.pixels_in_packets += other.pixels_in_packets;
        self.pixels_in_doubles += other.pixels_in_doubles;
        self.pixels_in_integers += other.pixels_in_integers;
        self.sphere_tests += other.sphere_tests;
    }
}

#[cfg(test)]
mod tests {
    use super::{Counts, Rung};

    /// Each number is counted and added by itself.
    #[test]
    fn every_pixel_is_counted_once() {
        let mut counts = Counts {
            pixels_in_runs: 1,
            pixels_in_packets: 20,
            sphere_tests: 3,
            ..Counts::default()
        };
        let settled = [(Rung::Doubles, 300), (Rung::Integers, 50_000)];
        for (rung, times) in settled {
            for _ in 0..times {
                counts.settled_by(rung);
            }
        }
        let expected = Counts {
            pixels_in_runs: 1,
            pixels_in_packets: 20,
            pixels_in_doubles: 300,
            pixels_in_integers: 50_000,
            sphere_tests: 3,
        };
        assert_eq!(counts, expected);
        assert_eq!(counts.pixels(), 50_321);
        let mut sum = counts;
        sum += counts;
        let twice = Counts {
            pixels_in_runs: 2,
            pixels_in_packets: 40,
            pixels_in_doubles: 600,
            pixels_in_integers: 100_000,
            sphere_tests: 6,
        };
        assert_eq!(sum, twice);
    }
}
