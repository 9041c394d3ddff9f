//! Inverse depths around rectangles, in floats and as ranges, against dyadic rationals.

use wide::f32x8;

use super::{Bounds, Depths, FloatDepths, LANES, Rectangles, f64x8};
use crate::{
    camera::{Camera, ImageSize},
    exact::{
        boxes::PixelBox,
        grid::{Grid, float_above},
        trials::{Dyadic, Random, Trial, dyadic, each_trial, rectangles, scale},
    },
    scene::Viewport,
    spheres::Sphere,
};

/// `d`, `b` in floats, in the order in which packets compute them.
fn evaluated(depths: &FloatDepths, p: f32, q: f32) -> (f32, f32) {
    let splat = |of: &[f32; LANES]| f32x8::splat(of[0]);
    let (p, q) = (f32x8::splat(p), f32x8::splat(q));
    let [d00, d10, d01, d20, d11, d02] = depths.d.each_ref().map(splat);
    let [b00, b10, b01] = depths.b.each_ref().map(splat);
    let d0 = d20.mul_add(p, d10).mul_add(p, d00);
    let d = d02.mul_add(q, d11.mul_add(p, d01)).mul_add(q, d0);
    let b = b01.mul_add(q, b10.mul_add(p, b00));
    (d.to_array()[0], b.to_array()[0])
}

/// Whether `exact/unit <= value <= exact/unit + spread`, for `unit > 0` or `< 0`.
fn within(value: f32, exact: &Dyadic, unit: &Dyadic, spread: f32) -> bool {
    let [value, spread] = [value, spread].map(|float| dyadic(f64::from(float)));
    let sign = if *unit < Dyadic::ZERO { -1.0 } else { 1.0 };
    let above = (value * unit - exact) * dyadic(sign);
    above >= Dyadic::ZERO && above <= spread * unit * dyadic(sign)
}

/// The trial's rectangle, its middle, and pixels of it counted from there: its corners,
/// some others, and the trial's own.
fn places(trial: &Trial, around: &Rectangles, random: &mut Random) -> Vec<[f64; 2]> {
    let of = |lanes: f64x8| lanes.to_array()[0];
    let half = [of(around.across), of(around.down)];
    let corners = [[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]];
    let mut places: Vec<_> = corners.map(|[p, q]| [p * half[0], q * half[1]]).into();
    places.push(half.map(|half| random.below(2 * half as u64 + 1) as f64 - half));
    places.push([
        f64::from(trial.column) - of(around.columns),
        f64::from(trial.row) - of(around.rows),
    ]);
    places
}

#[test]
fn floats_are_within_their_bounds() {
    let (mut known, mut met, mut sure) = (0, 0, 0);
    each_trial(60_000, |trial, random| {
        let grid = trial.grid(random);
        let around = rectangles(trial, random);
        let middle = [around.columns, around.rows].map(|lanes| lanes.to_array()[0]);
        let in_doubles = Depths::new(&grid, &around, &trial.eight());
        let depths = in_doubles.to_floats(Bounds::Proven);
        if depths.known & 1 == 0 {
            return if depths.spread[0] == f32::INFINITY && depths.d_sure[0] == f32::INFINITY {
                Ok(())
            } else {
                Err("unknown, but bounded".into())
            };
        }
        let unit_scale = dyadic(grid.scale);
        for [p, q] in places(trial, &around, random) {
            let truth = trial.truth_at(middle[0] + p, middle[1] + q);
            let (d, b) = evaluated(&depths, p as f32, q as f32);
            if !(d.is_finite() && b.is_finite()) {
                return Err(format!("{d:e}, {b:e} at ({p}, {q})"));
            }
            known += 1;
            let unit = &truth.c * &truth.z;
            let exact = &truth.d * &unit_scale * &unit_scale;
            let [d_spread, b_spread] = [in_doubles.d_bound, in_doubles.bound]
                .map(|bound| float_above(2.0 * bound.to_array()[0]));
            if !within(d, &exact, &(&unit * &unit), d_spread) {
                return Err(format!("D/c^2 at ({p}, {q}): {d:e} - {d_spread:e}"));
            }
            if !within(b, &(&truth.b * &unit_scale), &unit, b_spread) {
                return Err(format!("B/c at ({p}, {q}): {b:e} - {b_spread:e}"));
            }
            let upper = b + d.sqrt();
            let lower = upper - depths.spread[0];
            if truth.hit() && !truth.at_most(f64::from(upper), grid.scale) {
                return Err(format!("({p}, {q}) is nearer than {upper:e}"));
            }
            met += u64::from(d > 0.0);
            if d > depths.d_sure[0] && lower > 0.0 {
                sure += 1;
                if !(truth.hit() && truth.at_least(f64::from(lower), grid.scale)) {
                    return Err(format!("({p}, {q}) is farther than {lower:e}"));
                }
            }
        }
        Ok(())
    });
    assert!(known > 100_000, "only {known} places known");
    assert!(
        met > 20_000 && sure > 10_000,
        "only {met} met, {sure} surely"
    );
}

#[test]
fn d_is_within_its_range_in_every_part_of_the_rectangle() {
    let (mut inside, mut sharp) = (0, 0);
    each_trial(20_000, |trial, random| {
        let grid = trial.grid(random);
        let around = rectangles(trial, random);
        let of = |lanes: f64x8| lanes.to_array()[0];
        let depths = Depths::new(&grid, &around, &trial.eight());
        let sphere = depths.of_sphere(0, &trial.eight(), (0, 0), Bounds::Proven);
        if !sphere.known {
            return Ok(());
        }
        let mut part = |half: f64| {
            let mut end = || random.below(2 * half as u64 + 1) as f64 - half;
            let (a, b) = (end(), end());
            [0.5 * (a + b), 0.5 * (a - b).abs()]
        };
        let (columns, rows) = (part(of(around.across)), part(of(around.down)));
        let range = sphere.range_of_d(columns, rows);
        let unit_scale = dyadic(grid.scale);
        for [p, q] in [
            [-1.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [1.0, -1.0],
            [0.0, 0.0],
        ] {
            let at = |[middle, half]: [f64; 2], side: f64| (middle + half * side).floor();
            let truth = trial.truth_at(
                of(around.columns) + at(columns, p),
                of(around.rows) + at(rows, q),
            );
            let unit = &truth.c * &truth.z;
            let exact = &truth.d * &unit_scale * &unit_scale;
            let [least, greatest] = range.map(|end| dyadic(end) * &unit * &unit);
            if exact < least || exact > greatest {
                return Err(format!("{range:?} in {columns:?}, {rows:?} at {p}, {q}"));
            }
            inside += 1;
        }
        let [least, greatest] = range;
        sharp += u64::from(least > 0.0 && greatest < 2.0 * least);
        Ok(())
    });
    assert!(inside > 50_000 && sharp > 1_000, "only {inside}, {sharp}");
}

fn doubles(depths: &Depths) -> [f64x8; 11] {
    let [d00, d10, d01, d20, d11, d02] = depths.d;
    let (d_bound, d_upper) = (depths.d_bound, depths.d_upper);
    let (b_linear, bound) = (depths.b_linear, depths.bound);
    [
        d00,
        d10,
        d01,
        d20,
        d11,
        d02,
        d_bound,
        d_upper,
        depths.b[0],
        b_linear,
        bound,
    ]
}

/// Whether a sphere makes a NaN in a rectangle that reaches far beyond the picture.
fn makes_nan(trial: &Trial, scale: f64) -> Result<bool, String> {
    let mut grid = Grid::new(trial.camera);
    grid.scale = scale;
    let side = f64::from(trial.camera.size().width());
    let around = Rectangles {
        columns: f64x8::splat(0.5 * side),
        rows: f64x8::splat(0.0),
        across: f64x8::splat(32.0),
        down: f64x8::splat(side),
    };
    let depths = Depths::new(&grid, &around, &trial.eight());
    let doubles = doubles(&depths).map(|lanes| lanes.to_array()[0]);
    let says = depths.known.to_bitmask();
    if says & 1 == 1 && !doubles.iter().all(|double| double.is_finite()) {
        return Err(format!("{depths:?}"));
    }
    let floats = depths.to_floats(Bounds::Proven);
    let ranges = depths.ranges();
    let results = [
        floats.spread,
        floats.d_sure,
        ranges.lower,
        ranges.upper,
        [PixelBox::new(&grid, &trial.sphere).map_or(0.0, |its_box| its_box.upper); LANES],
    ];
    if results.iter().any(|lanes| lanes[0].is_nan()) {
        return Err(format!("{floats:?} {ranges:?}"));
    }
    Ok(doubles.iter().any(|double| double.is_nan()))
}

/// `fast_max` of NaN differs between machines, so a lane with NaN must give no bound, and the
/// results must not be NaN.
#[test]
fn a_lane_with_a_nan_says_nothing() {
    const LENGTHS: [f32; 5] = [0.0, f32::from_bits(1), 1e-20, 1.0, f32::MAX];
    let mut with_nan = 0;
    for number in 0..4 * 5 * 5 * 5 {
        let length = |place: usize| LENGTHS[number / 5_usize.pow(3 - place as u32) % 5];
        let mut trial = Trial::new(number as u64);
        trial.sphere.centre = [length(1), length(2), length(3)];
        trial.sphere.radius = LENGTHS[1 + number / 125];
        for side in [1, 64, 1 << 30] {
            let size = ImageSize::of_sides(side, side);
            trial.camera = Camera::new(trial.camera.viewport(), size);
            for scale in [1.0, (-149.0_f64).exp2(), 149.0_f64.exp2()] {
                match makes_nan(&trial, scale) {
                    Ok(nan) => with_nan += u64::from(nan),
                    Err(wrong) => panic!("{wrong}; {}", trial.describe()),
                }
            }
        }
    }
    assert!(with_nan > 50, "only {with_nan} lanes with NaN");
}

#[test]
fn ranges_hold_every_hit() {
    let (mut covered, mut tighter, mut inside) = (0, 0, 0);
    each_trial(60_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let Some(PixelBox { upper, .. }) = PixelBox::new(&grid, &trial.sphere) else {
            return Ok(());
        };
        grid.scale = scale(upper, random);
        let whole = PixelBox::new(&grid, &trial.sphere).expect("a visible sphere");
        let around = rectangles(trial, random);
        let ranges = Depths::new(&grid, &around, &trial.eight()).ranges();
        let (least, greatest) = (ranges.lower[0], ranges.upper[0]);
        let all = ranges.covered & 1 == 1;
        covered += u64::from(all);
        tighter += u64::from(greatest < whole.upper);
        inside += u64::from(all && least > 0.0 && trial.truth().c < Dyadic::ZERO);
        let middle = [around.columns, around.rows].map(|lanes| lanes.to_array()[0]);
        for [p, q] in places(trial, &around, random) {
            let truth = trial.truth_at(middle[0] + p, middle[1] + q);
            if all && !(truth.hit() && truth.at_least(f64::from(least), grid.scale)) {
                return Err(format!("({p}, {q}) is not hit, or farther than {least:e}"));
            }
            if truth.hit() && !truth.at_most(f64::from(greatest), grid.scale) {
                return Err(format!("({p}, {q}) is nearer than {greatest:e}"));
            }
        }
        Ok(())
    });
    assert!(covered > 3_000, "only {covered} covered");
    assert!(tighter > 3_000, "only {tighter} tighter");
    assert!(inside > 1_000, "only {inside} from inside");
}

/// Floats are used up to the greatest permitted value: `D/c^2` is `0.73 2^100` in the first
/// case, and 4 times as much in the second.
#[test]
fn depths_are_known_up_to_the_greatest() {
    let sphere = Sphere {
        centre: [0.0, 0.0, 2.0],
        radius: 1.5,
        colour: [0; 3],
    };
    let narrow = Viewport {
        width: 1e-6,
        height: 1e-6,
        distance: 1.0,
    };
    let size = ImageSize::new(1001, 1001).expect("a size");
    let mut trial = Trial::new(0);
    (trial.camera, trial.sphere) = (Camera::new(narrow, size), sphere);
    let known = |scale: f64| {
        let mut grid = Grid::new(trial.camera);
        grid.scale = scale;
        let around = Rectangles {
            columns: f64x8::splat(500.0),
            rows: f64x8::splat(500.0),
            across: f64x8::splat(4.0),
            down: f64x8::splat(1.0),
        };
        Depths::new(&grid, &around, &trial.eight())
            .known
            .to_bitmask()
            & 1
            == 1
    };
    let scale = (50.0_f64).exp2();
    assert!(known(scale));
    assert!(!known(2.0 * scale));
}

/// The bounds of theorem 5, from the polynomials, in the order of the proof: for a camera outside and
/// inside.
#[test]
fn bounds_of_ranges_have_all_terms() {
    let mut compared = [0; 2];
    each_trial(30_000, |trial, random| {
        let grid = trial.grid(random);
        let around = rectangles(trial, random);
        let depths = Depths::new(&grid, &around, &trial.eight());
        if depths.known.to_bitmask() & 1 == 0 {
            return Ok(());
        }
        let of = |lanes: f64x8| lanes.to_array()[0];
        let [d00, d10, d01, d20, d11, d02] = depths.d.map(of);
        let [b00, b10, b01] = depths.b.map(of);
        let [s, t] = [around.across, around.down].map(of);
        let [d_bound, bound, d_upper] = [depths.d_bound, depths.bound, depths.d_upper].map(of);
        let corners = [(s, t), (s, -t), (-s, t), (-s, -t)].map(|(p, q)| {
            let d = d00 + d10 * p + d01 * q + d20 * p * p + d11 * p * q + d02 * q * q;
            [d - d_bound, b00 + b10 * p + b01 * q]
        });
        let outside = of(depths.power) > 0.0;
        let covered = !outside || corners.iter().all(|&[d, b]| d > 0.0 && b > bound);
        let lower = if outside {
            let nearest = |&[d, b]: &[f64; 2]| b + d.max(0.0).sqrt();
            corners.iter().map(nearest).fold(f64::INFINITY, f64::min)
        } else {
            let linear = s * d10.abs() + t * d01.abs();
            let least = d00 - linear - s * s * d20.abs() - s * t * d11.abs() - t * t * d02.abs();
            b00 - s * b10.abs() - t * b01.abs() + (least - d_bound).max(0.0).sqrt()
        };
        let (lower, ranges) = ((lower - bound).max(0.0), depths.ranges());
        if (ranges.covered & 1 == 1) != covered {
            return Err(format!("covered: {covered}, instead of {ranges:?}"));
        }
        let magnitude = b00.abs() + of(depths.b_linear) + d_upper.sqrt();
        if !(1e-30..1e30).contains(&magnitude) {
            return Ok(());
        }
        let near =
            |found: f32, expected: f64| (f64::from(found) - expected).abs() <= 4e-7 * magnitude;
        compared[usize::from(!outside)] += u64::from(covered);
        let upper = b00 + of(depths.b_linear) + d_upper.sqrt() + bound;
        if near(ranges.upper[0], upper) && (!covered || near(ranges.lower[0], lower)) {
            Ok(())
        } else {
            Err(format!("{lower:e} to {upper:e} instead of {ranges:?}"))
        }
    });
    assert!(
        compared.iter().all(|&count| count > 1_000),
        "only {compared:?}"
    );
}
