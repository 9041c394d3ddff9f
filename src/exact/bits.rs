//! Bits of masks.

use wide::u32x8;

/// All bits of the lanes whose bits are set.
#[inline(always)]
pub(super) fn lanes_of(mask: u32) -> u32x8 {
    let bits = u32x8::new(std::array::from_fn(|lane| 1 << lane));
    (u32x8::splat(mask) & bits).simd_eq(bits)
}

/// The positions of the bits that are set.
pub(super) fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        place
    })
}

/// The runs of bits that are set.
pub(super) fn runs(mut bits: u64) -> impl Iterator<Item = std::ops::Range<usize>> {
    std::iter::from_fn(move || {
        if bits == 0 {
            return None;
        }
        let start = bits.trailing_zeros() as usize;
        let end = start + (bits >> start).trailing_ones() as usize;
        bits &= u64::MAX.checked_shl(end as u32).unwrap_or(0);
        Some(start..end)
    })
}

#[cfg(test)]
mod tests {
    use super::runs;

    #[test]
    fn runs_are_those_of_the_bits_that_are_set() {
        let of = |bits| runs(bits).collect::<Vec<_>>();
        assert_eq!(of(0), []);
        assert_eq!(of(u64::MAX), vec![0..64; 1]);
        assert_eq!(of(0b1011_1001), [0..1, 3..6, 7..8]);
        assert_eq!(of(0b11 << 62 | 0b10), [1..2, 62..64]);
    }
}
