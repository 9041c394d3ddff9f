//! The parts of the reference, and what only a judge asks of it. What it means is tested in
//! `tests/reference.rs`.

use super::*;

#[test]
fn floats_are_integers_times_powers_of_two() {
    let floats = [
        0.0,
        f32::from_bits(1),
        f32::MIN_POSITIVE.next_down(),
        f32::MIN_POSITIVE,
        f32::MIN_POSITIVE.next_up(),
        1.0,
        1.5,
        0.1,
        3e20,
        f32::MAX,
    ];
    for float in floats {
        let (magnitude, exponent) = parts(float);
        // Half of the exponent at a time: the smallest power is no normal double.
        let half = f64::from(exponent / 2).exp2();
        let value = f64::from(magnitude) * half * f64::from(exponent - exponent / 2).exp2();
        assert_eq!(value, f64::from(float), "{float:e}");
    }
}

#[test]
fn the_unit_is_the_largest_that_divides_every_length() {
    assert_eq!(common_exponent([96.0, 0.0, 128.0]), 5);
    assert_eq!(common_exponent([96.0, 0.375]), -3);
    assert_eq!(common_exponent([f32::from_bits(2), 1.0]), -148);
    assert_eq!(common_exponent([0.0]), 0);
    assert_eq!(in_units(-96.0, 5), IBig::from(-3));
    assert_eq!(in_units(96.0, 3), IBig::from(12));
}

#[test]
fn quotients_of_any_size_are_doubles() {
    let power = |exponent: usize| IBig::from(1) << exponent;
    for (n, d) in [
        (0, 0),
        (1, 70),
        (70, 1),
        (64, 0),
        (65, 0),
        (500, 1),
        (1, 500),
        (900, 200),
    ] {
        let expected = (n as f64 - d as f64).exp2();
        assert_eq!(quotient(&power(n), &power(d)), expected, "{n} {d}");
        assert_eq!(quotient(&-power(n), &power(d)), -expected, "{n} {d}");
    }
    assert_eq!(quotient(&IBig::from(1), &IBig::from(3)), 1.0 / 3.0);
    assert_eq!(quotient(&IBig::from(0), &IBig::from(3)), 0.0);
}

/// Along the gradient, the polynomial is zero at this distance.
#[test]
fn an_outline_is_where_its_polynomial_is_zero() {
    let curvatures = [
        [0.0; 3],
        [1.0, 0.0, 2.0],
        [1.0, 3.0, -2.0],
        [-0.5, 0.7, 0.25],
    ];
    for [along, mixed, upright] in curvatures {
        for gradient in [
            [3.0, 0.0],
            [0.0, -3.0],
            [2.0, 1.0],
            [-1.0, 2.0],
            [-2.0, -2.0],
        ] {
            for value in [0.125, -0.125, 0.0] {
                let outline = Outline {
                    value,
                    gradient,
                    curvature: [along, mixed, upright],
                };
                let [across, down] = gradient;
                let slope = f64::hypot(across, down);
                // Up where the value is negative, down where it is positive.
                let distance = if value > 0.0 {
                    -outline.distance()
                } else {
                    outline.distance()
                };
                let (x, y) = (distance * across / slope, distance * down / slope);
                let there = value
                    + across * x
                    + down * y
                    + along * x * x
                    + 2.0 * mixed * x * y
                    + upright * y * y;
                assert!(there.abs() < 1e-12, "{outline:?}: {there:e} at {distance}");
            }
        }
    }
}

/// From outside and in front of the camera only; and with all digits.
#[test]
fn outlines_are_of_spheres_that_have_one() {
    let scene: Scene = "VP 1 1 1 BG 0 0 0 OBJ_N 4
        S 3 4 12 5 1 1 1  S 0 0 1 9 1 1 1  S 0 0 -9 1 1 1 1  S 0 0 3 3 1 1 1"
        .parse()
        .expect("a scene");
    let size = ImageSize::new(5, 3).expect("a size");
    let reference = Reference::new(&scene, size);
    for sphere in 1..4 {
        assert!(reference.outline(sphere, (2, 1)).is_none(), "{sphere}");
    }
    // V is (x, y, 8), x from -4 to 4 and y from 4 to -4, with the unit 8 = 2 (W-1)(H-1)/2 of both
    // ratios: D is a polynomial in small integers, but for their common factor.
    let outline = reference.outline(0, (3, 0)).expect("an outline");
    let d = |column: f64, row: f64| {
        let v = [(column - 2.0) / 4.0, (1.0 - row) / 2.0, 1.0];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let centre = [3.0, 4.0, 12.0];
        dot(centre, v).powi(2) - (dot(centre, centre) - 25.0) * dot(v, v)
    };
    let Outline {
        value,
        gradient,
        curvature,
    } = outline;
    let scale = value / d(3.0, 0.0);
    for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-2.0, 3.0), (1.0, -1.0)] {
        let [along, mixed, upright] = curvature;
        let there = value
            + gradient[0] * x
            + gradient[1] * y
            + along * x * x
            + 2.0 * mixed * x * y
            + upright * y * y;
        let expected = scale * d(3.0 + x, y);
        assert!((there / expected - 1.0).abs() < 1e-12, "{there} {expected}");
    }
    let greatest = gradient
        .iter()
        .chain(&curvature)
        .fold(0.0, |most, one| one.abs().max(most));
    assert_eq!(greatest, 1.0);
}

/// Of perfect squares, of which doubles know the roots exactly; and of their neighbours.
#[test]
fn sums_with_roots_have_the_signs_of_real_numbers() {
    let integers = -6_i32..=6;
    let radicands = [0, 1, 2, 3, 4, 8, 9, 15, 16, 17, 24, 25, 26, 36];
    for p in integers {
        for u in radicands {
            let root = f64::from(u).sqrt();
            let real = f64::from(p) + root;
            let found = sign_with_root(&p.into(), &u.into());
            assert_eq!(Some(found), real.partial_cmp(&0.0), "{p} + sqrt {u}");
            for w in radicands {
                // The least difference of different sums is about 1e-3.
                let real = (real - f64::from(w).sqrt()) * 1e9;
                let found = sign_with_two_roots(&p.into(), &u.into(), &w.into());
                let expected = real.round().partial_cmp(&0.0);
                assert_eq!(Some(found), expected, "{p} + sqrt {u} - sqrt {w}");
            }
        }
    }
}
