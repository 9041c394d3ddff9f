//! The rule from pixels to rays, in each of its forms.

use super::*;

const VIEWPORTS: [[f32; 3]; 5] = [
    [1.777, 1.0, 1.0],
    [3.0, 2.0, 0.5],
    [0.1, 7.0, 1000.0],
    [f32::MAX, 1e-30, 1.0],
    [f32::MIN_POSITIVE / 1024.0, 1.0, 1e-20],
];

const SIDES: [u32; 7] = [1, 2, 3, 8, 17, 1920, u32::MAX];

fn camera([width, height, distance]: [f32; 3], side: u32) -> [Camera; 2] {
    let viewport = Viewport {
        width,
        height,
        distance,
    };
    [(side, 1), (1, side)]
        .map(|(columns, rows)| Camera::new(viewport, ImageSize::of_sides(columns, rows)))
}

/// Some indices of a side: both ends, the middle, and others.
fn indices(side: u32) -> impl Iterator<Item = u32> {
    let some = [0, 1, 2, side / 3, side / 2, side - side / 3, side - 1];
    some.into_iter().filter(move |&index| index < side)
}

#[test]
fn five_columns_and_five_rows() {
    let [wide, high] = camera([2.0, 8.0, 1.0], 5);
    let columns: Vec<f64> = (0..5).map(|column| wide.x_double(column)).collect();
    let rows: Vec<f64> = (0..5).map(|row| high.y_double(row)).collect();
    assert_eq!(columns, [-1.0, -0.5, 0.0, 0.5, 1.0]);
    // Row 0 is the +y edge.
    assert_eq!(rows, [4.0, 2.0, 0.0, -2.0, -4.0]);
    assert_eq!((wide.y_double(0), high.x_double(0)), (0.0, 0.0));
}

#[test]
fn the_outermost_pixels_are_on_the_edges_of_the_viewport() {
    for lengths in VIEWPORTS {
        // Of longer sides the products have too many digits for doubles.
        for side in SIDES.into_iter().filter(|side| (2..1 << 20).contains(side)) {
            let [wide, high] = camera(lengths, side);
            let [half_width, half_height] =
                [lengths[0], lengths[1]].map(|length| f64::from(length) / 2.0);
            assert_eq!(wide.x_double(0), -half_width);
            assert_eq!(wide.x_double(side - 1), half_width);
            assert_eq!(high.y_double(0), half_height);
            assert_eq!(high.y_double(side - 1), -half_height);
        }
    }
}

#[test]
fn doubles_are_the_ratios_rounded_and_symmetric() {
    for lengths in VIEWPORTS {
        for side in SIDES {
            let [wide, high] = camera(lengths, side);
            for index in indices(side) {
                let mirrored = side - 1 - index;
                assert_eq!(wide.x_double(index), -wide.x_double(mirrored));
                assert_eq!(high.y_double(index), -high.y_double(mirrored));
                let ratios = [
                    (wide.x_ratio(index), lengths[0], wide.x_double(index)),
                    (high.y_ratio(index), lengths[1], high.y_double(index)),
                ];
                for ((n, d), length, double) in ratios {
                    // The product of a float and a ratio of 33 bits, with two roundings.
                    let exact = f64::from(length) * (n as f64 / d as f64);
                    assert!(
                        (double - exact).abs() <= 4.0 * f64::EPSILON * exact.abs(),
                        "{index} of {side}: {double:e} {exact:e}"
                    );
                }
            }
        }
    }
}

/// Directions in floats are those in doubles, up to roundings relative to the viewport.
#[test]
fn floats_are_the_doubles_rounded() {
    // The float methods may lose lengths that are tiny relative to the largest.
    for lengths in &VIEWPORTS[..3] {
        for side in SIDES {
            let [wide, high] = camera(*lengths, side);
            let largest = lengths.iter().copied().fold(0.0, f32::max);
            let unit = f64::from(wide.z_float()) / f64::from(lengths[2]);
            let scaled = unit * f64::from(largest);
            assert!((1.0..2.0).contains(&scaled), "{lengths:?}");
            for index in indices(side) {
                for (float, double, length) in [
                    (wide.x_float(index), wide.x_double(index), lengths[0]),
                    (high.y_float(index), high.y_double(index), lengths[1]),
                ] {
                    let error = f64::from(float) / unit - double;
                    let bound = 4.0 * f64::from(f32::EPSILON) * f64::from(length);
                    assert!(error.abs() <= bound, "{index} of {side}: {error:e}");
                }
            }
        }
    }
}

/// Also behind the last column, where a packet goes beyond the picture.
#[test]
fn packets_are_their_lanes() {
    for lengths in VIEWPORTS {
        for side in SIDES {
            let [wide, _] = camera(lengths, side);
            for first in indices(side) {
                let column = |lane: usize| first.saturating_add(lane as u32);
                let floats = wide.x_floats(first).to_array();
                for (lane, float) in floats.into_iter().enumerate() {
                    let one = wide.x_float(column(lane));
                    assert_eq!(float.to_bits(), one.to_bits(), "{first} of {side}");
                }
                let doubles = wide.x_doubles(first).to_array();
                for (lane, double) in doubles.into_iter().enumerate() {
                    let one = wide.x_double(column(lane));
                    assert_eq!(double.to_bits(), one.to_bits(), "{first} of {side}");
                }
            }
        }
    }
}

#[test]
fn sizes_without_pixels_or_with_too_many_bytes_are_refused() {
    for (width, height) in [(0, 0), (0, 1), (1, 0)] {
        assert_eq!(
            ImageSize::new(width, height),
            Err(SizeError::Empty { width, height })
        );
    }
    let room = isize::MAX as u128 - ImageSize::HEADER_ROOM;
    let pixels = room / BYTES_PER_PIXEL as u128;
    let width = u32::try_from(pixels).unwrap_or(u32::MAX);
    let height = (pixels / u128::from(width)) as u32;
    let largest = ImageSize::new(width, height).expect("a size that can be addressed");
    assert_eq!(largest.pixels(), u64::from(width) * u64::from(height));
    let height = height + 1;
    assert_eq!(
        ImageSize::new(width, height),
        Err(SizeError::TooLarge { width, height })
    );
}
