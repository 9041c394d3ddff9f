//! Writes colours as bytes: runs of one colour, and packets of eight pixels.

use wide::{i8x32, u8x16, u8x32, u8x64, u32x8};

use super::bits::{lanes_of, set_bits};
use crate::{
    camera::BYTES_PER_PIXEL,
    spheres::{LANES, Rgb},
};

#[cfg(test)]
mod tests;

/// Bytes of the longest piece that is copied at a time.
const PIECE: usize = 32 * BYTES_PER_PIXEL;

const TWO_PIECES_AND_MORE: usize = 2 * PIECE + 1;

/// Bytes of a run that one vector blends.
const SHORT: usize = 64;

const PLACES: [u8; SHORT] = {
    let mut places = [0; SHORT];
    let mut place = 0;
    while place < SHORT {
        places[place] = place as u8;
        place += 1;
    }
    places
};

/// A colour, repeated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern([u8; PIECE]);

impl Pattern {
    #[inline]
    pub(super) fn new(colour: Rgb) -> Self {
        let mut pattern = [0; PIECE];
        for pixel in pattern.as_chunks_mut().0 {
            *pixel = colour;
        }
        Self(pattern)
    }

    /// Fills the pixels `from..to` of a line.
    #[inline]
    pub(super) fn paint(&self, line: &mut [u8], from: usize, to: usize) {
        let (from, to) = (from * BYTES_PER_PIXEL, to * BYTES_PER_PIXEL);
        let bytes = to - from;
        // Short runs of any length take the same path, since a branch on the length would
        // often be mispredicted.
        if bytes <= SHORT
            && let Some(line) = line[from..].first_chunk_mut::<SHORT>()
        {
            let (pattern, _) = self.0.as_chunks::<SHORT>();
            let within = u8x64::new(PLACES).simd_lt(u8x64::splat(bytes as u8));
            *line = within
                .select(u8x64::new(pattern[0]), u8x64::new(*line))
                .to_array();
            return;
        }
        let run = &mut line[from..to];
        match run.len() {
            TWO_PIECES_AND_MORE.. => self.paint_long(run),
            PIECE.. => self.both_ends::<PIECE>(run),
            48.. => self.both_ends::<48>(run),
            _ => run.copy_from_slice(&self.0[..bytes]),
        }
    }

    /// Fills a run of `N` to `2 N` bytes with two pieces, one at each end.
    #[inline(always)]
    fn both_ends<const N: usize>(&self, run: &mut [u8]) {
        let (piece, _) = self.0.as_chunks::<N>();
        let last = run.len() - N;
        run[..N].copy_from_slice(&piece[0]);
        run[last..].copy_from_slice(&piece[0]);
    }

    fn paint_long(&self, run: &mut [u8]) {
        /// For runs at least this long, filling with one byte is faster.
        const LONG: usize = 512;
        let [red, green, blue, ..] = self.0;
        if run.len() >= LONG && red == green && green == blue {
            run.fill(red);
            return;
        }
        let last = run.len() - PIECE;
        for piece in run.as_chunks_mut().0 {
            *piece = self.0;
        }
        run[last..].copy_from_slice(&self.0);
    }
}

/// A colour as a lane, its bytes in the order of the image, and a fourth.
#[inline]
pub(super) fn colour_lane(colour: Rgb) -> u32 {
    let [red, green, blue] = colour;
    u32::from_ne_bytes([red, green, blue, 0])
}

/// The bytes of a colour lane.
#[inline]
pub(super) fn bytes_of(lane: u32) -> Rgb {
    let [red, green, blue, _] = lane.to_ne_bytes();
    [red, green, blue]
}

/// Bytes of four pixels.
const FOUR: usize = 4 * BYTES_PER_PIXEL;

/// The first three bytes of each lane, in two halves.
#[inline(always)]
fn halves(lanes: u32x8) -> [[u8; 16]; 2] {
    const DROP_FOURTH: [i8; 16] = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1];
    // Where the machine has no such instruction, a swizzle is a call and a loop over bytes.
    if cfg!(not(any(
        target_feature = "ssse3",
        target_feature = "neon",
        target_feature = "simd128"
    ))) {
        let [a, b, c, d, e, f, g, h] = lanes.to_array();
        return [four([a, b, c, d]), four([e, f, g, h])];
    }
    let order: i8x32 = bytemuck::cast([DROP_FOURTH; 2]);
    let bytes: u8x32 = bytemuck::cast(lanes);
    bytemuck::cast(bytes.swizzle_half(order))
}

/// The first three bytes of four lanes.
#[inline(always)]
fn four(lanes: [u32; 4]) -> [u8; 16] {
    let [a, b, c, d] = lanes.map(|lane| u64::from(lane.to_le() & 0xff_ffff));
    let words = [a | b << 24 | c << 48, c >> 16 | d << 8];
    bytemuck::cast(words.map(u64::to_le_bytes))
}

/// Writes eight pixels at the beginning of `line`, or as many as it has room for. The first bytes
/// after them are overwritten.
#[inline(always)]
pub(super) fn put_eight(line: &mut [u8], colours: u32x8) {
    let halves = halves(colours);
    if let Some(line) = line.first_chunk_mut::<{ FOUR + 16 }>() {
        line[..16].copy_from_slice(&halves[0]);
        line[FOUR..].copy_from_slice(&halves[1]);
    } else {
        let pixels = line.len().min(LANES * BYTES_PER_PIXEL);
        let (first, second) = line[..pixels].split_at_mut(FOUR.min(pixels));
        first.copy_from_slice(&halves[0][..first.len()]);
        second.copy_from_slice(&halves[1][..second.len()]);
    }
}

/// Writes those of eight pixels at the beginning of `line` whose bits in `wanted` are set.
#[inline(always)]
pub(super) fn put_some(line: &mut [u8], colours: u32x8, wanted: u32) {
    if let Some(line) = line.first_chunk_mut::<{ FOUR + 16 }>() {
        let (wanted, halves) = (halves(lanes_of(wanted)), halves(colours));
        for (half, at) in [0, FOUR].into_iter().enumerate() {
            let (piece, _) = line[at..].as_chunks_mut::<16>();
            let new =
                u8x16::new(wanted[half]).select(u8x16::new(halves[half]), u8x16::new(piece[0]));
            piece[0] = new.to_array();
        }
    } else {
        for lane in set_bits(u64::from(wanted)) {
            line[lane * BYTES_PER_PIXEL..][..BYTES_PER_PIXEL]
                .copy_from_slice(&bytes_of(colours.as_array()[lane]));
        }
    }
}
