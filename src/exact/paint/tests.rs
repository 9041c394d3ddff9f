//! Colours in lanes and in the bytes of an image.

use wide::u32x8;

use super::{BYTES_PER_PIXEL, LANES, Pattern, Rgb, bytes_of, colour_lane, put_eight, put_some};

/// No two of their bytes are equal.
const COLOURS: [Rgb; LANES] = [
    [0xff, 0x80, 0x01],
    [0x7f, 0x81, 0x02],
    [0x03, 0x04, 0x05],
    [0x06, 0x07, 0x08],
    [0x09, 0x0a, 0x0b],
    [0x0c, 0x0d, 0x0e],
    [0x0f, 0x10, 0x11],
    [0x12, 0x13, 0xfe],
];

/// On a machine of either byte order, in lines with room for fewer pixels and for more.
#[test]
fn colour_lanes_are_written_in_the_order_of_the_image() {
    const UNTOUCHED: u8 = 0xa5;
    let lanes = COLOURS.map(colour_lane);
    assert_eq!(lanes.map(bytes_of), COLOURS);
    for pixels in 0..=2 * LANES {
        let mut line = vec![UNTOUCHED; pixels * BYTES_PER_PIXEL];
        put_eight(&mut line, u32x8::new(lanes));
        let written = pixels.min(LANES);
        let (written, rest) = line.split_at(written * BYTES_PER_PIXEL);
        assert_eq!(
            written,
            &COLOURS.as_flattened()[..written.len()],
            "{pixels}"
        );
        // Some bytes that follow may be overwritten.
        assert!(
            rest.iter().skip(4).all(|&byte| byte == UNTOUCHED),
            "{pixels}"
        );
    }
}

#[test]
fn wanted_colour_lanes_are_written_and_no_others() {
    const UNTOUCHED: u8 = 0xa5;
    let lanes = u32x8::new(COLOURS.map(colour_lane));
    for wanted in 0..0x100 {
        // Only pixels for which there is room are wanted.
        for pixels in 32 - u32::leading_zeros(wanted)..=16 {
            let mut line = vec![UNTOUCHED; pixels as usize * BYTES_PER_PIXEL];
            put_some(&mut line, lanes, wanted);
            let (line, _) = line.as_chunks::<BYTES_PER_PIXEL>();
            for (lane, pixel) in line.iter().enumerate() {
                let is_wanted = lane < LANES && wanted >> lane & 1 == 1;
                let colour = if is_wanted {
                    COLOURS[lane]
                } else {
                    [UNTOUCHED; 3]
                };
                assert_eq!(*pixel, colour, "{lane} of {pixels}, {wanted:b}");
            }
        }
    }
}

/// Runs of every length, up to the length from which grey is filled as one byte.
#[test]
fn a_run_is_painted_and_nothing_beside_it() {
    const UNTOUCHED: u8 = 0xa5;
    const WIDTH: usize = 200;
    for colour in [[7, 7, 7], [200, 7, 7], [7, 7, 200], [7, 200, 7], [1, 2, 3]] {
        let pattern = Pattern::new(colour);
        for from in [0, 1, 5, WIDTH - 1] {
            for to in from..=WIDTH {
                let mut line = [UNTOUCHED; WIDTH * BYTES_PER_PIXEL];
                pattern.paint(&mut line, from, to);
                let (pixels, _) = line.as_chunks::<BYTES_PER_PIXEL>();
                for (at, &pixel) in pixels.iter().enumerate() {
                    let painted = (from..to).contains(&at);
                    let expected = if painted { colour } else { [UNTOUCHED; 3] };
                    assert_eq!(pixel, expected, "pixel {at} of {from}..{to}, {colour:?}");
                }
            }
        }
    }
}
