//! The intervals of packets, in floats and in doubles, against dyadic rationals.

use super::{
    Bounds, EightRecords, Grid, InDoubles, LANES, Meetings, PixelRow, SIDE, STEPS, SURFACE_REACH,
    SURFACE_SCALES, Surface, Terms, exponents, f32x8, f64x8, in_column, in_row, packet, splat,
    u32x8, widths,
};
use crate::exact::{
    bins::Record,
    boxes::PixelBox,
    depths::Depths,
    paint::{bytes_of, colour_lane},
    trials::{Random, Trial, each_trial, on_the_surface, rectangles, scale},
};

/// The colours of the background and of the sphere.
const BACKGROUND: u32 = 0;
const COLOUR: [u8; 3] = [1, 2, 3];

/// Checks a packet against the exact `1/z`: it must be in the interval if settled, not above it if
/// in doubt, and the pixel must not be hit if missed. Returns which of the three it is.
fn judge(pixels: &PixelRow, at: usize, trial: &Trial, scale: f64) -> Result<usize, String> {
    let of = |lanes: f32x8| lanes.to_array()[0];
    let (upper, rival) = (packet(&pixels.upper, at), packet(&pixels.rival, at));
    let (lower, upper, rival) = (of(pixels.lower(at)), of(upper), of(rival));
    let undecided = pixels.undecided_lanes(at) & 1 == 1;
    let truth = trial.truth();
    let no_nearer = |bound: f32| !truth.hit() || truth.at_most(f64::from(bound), scale);
    let leads = bytes_of(pixels.colours(at).to_array()[0]) == COLOUR;
    let (kind, right) = match (leads, undecided) {
        (true, false) => {
            let hit = truth.hit() && truth.at_least(f64::from(lower), scale);
            (0, hit && no_nearer(upper))
        }
        (true, true) => (1, no_nearer(upper)),
        (false, true) => (1, no_nearer(rival)),
        (false, false) => (2, !truth.hit()),
    };
    if right {
        Ok(kind)
    } else {
        Err(format!(
            "{lower:e} to {upper:e}, in doubt {rival:e}, undecided {undecided}"
        ))
    }
}

#[test]
fn intervals_hold_the_exact_inverse_depth() {
    let mut kinds = [0; 3];
    each_trial(100_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let Some(PixelBox { upper, .. }) = PixelBox::new(&grid, &trial.sphere) else {
            return Ok(());
        };
        grid.scale = scale(upper, random);
        let around = rectangles(trial, random);
        let depths = Depths::new(&grid, &around, &trial.eight()).to_floats(Bounds::Proven);
        if depths.known & 1 == 0 {
            return Ok(());
        }
        let from = |at: u32, middles: f64x8| f64::from(at) - middles.to_array()[0];
        let p = from(trial.column, around.columns);
        let q = f32x8::splat(from(trial.row, around.rows) as f32);
        // A packet may begin at any pixel up to seven before, within the rectangle.
        let before = p - f64::from(depths.p[0]);
        let lane = random.below(before.min(7.0) as u64 + 1) as usize;
        let first = random.below((SIDE - LANES) as u64) as usize;
        let steps = f32x8::new(STEPS) + f32x8::splat(p as f32 - lane as f32);
        let mut pixels = PixelRow::new(BACKGROUND);
        let width = exponents(f32x8::new(depths.spread)).to_array()[0];
        let terms = Terms::new(&depths, 0, steps, colour_lane(COLOUR) | width);
        pixels.meet::<true>(&terms, first, q);
        kinds[judge(&pixels, first + lane, trial, grid.scale)?] += 1;
        Ok(())
    });
    let [met, doubtful, missed] = kinds;
    let enough = met > 16_000 && doubtful > 1_000 && missed > 6_000;
    assert!(
        enough,
        "only {met} met, {doubtful} in doubt, {missed} missed"
    );
}

/// A packet whose first pixel is the first of its tile, and the trial's pixel any lane of it: that
/// lane, the record of the sphere, and the first column and row of the tile.
fn packet_of(trial: &Trial, random: &mut Random) -> (usize, Record, (u32, u32)) {
    let lane = (random.below(8) as u32).min(trial.column);
    let record = Record {
        sphere: trial.lengths(),
        sides: [0, lane as u8, 0, 0],
        colour: COLOUR,
        ..Record::default()
    };
    (lane as usize, record, (trial.column - lane, trial.row))
}

#[test]
fn doubles_hold_the_exact_inverse_depth() {
    let mut kinds = [0; 3];
    each_trial(30_000, |trial, random| {
        let grid = trial.grid(random);
        let (lane, record, corner) = packet_of(trial, random);
        let in_doubles = |bounds| InDoubles::new(&grid, bounds, corner, &record);
        let mut rows = [PixelRow::new(BACKGROUND)];
        let packets = in_doubles(Bounds::Proven).meet(&mut rows, &[u64::MAX; SIDE]);
        if packets != 1 {
            return Err(format!("{packets} packets"));
        }
        kinds[judge(&rows[0], lane, trial, grid.scale)?] += 1;
        let mut refused = [PixelRow::new(BACKGROUND)];
        in_doubles(Bounds::Refused).meet(&mut refused, &[u64::MAX; SIDE]);
        let lower = refused[0].lower(lane).to_array()[0];
        if refused[0].undecided_lanes(lane) & 1 == 0 || lower > 0.0 || lower.is_nan() {
            return Err("refused, but settled".into());
        }
        Ok(())
    });
    let [met, doubtful, missed] = kinds;
    assert!(
        met > 5_000 && doubtful > 200 && missed > 5_000,
        "only {kinds:?}"
    );
}

/// Of spheres on whose surface the camera is. Half of the rays nearly touch it there.
#[test]
fn floats_hold_inverse_depths_from_the_surface() {
    let mut kinds = [0; 3];
    each_trial(60_000, |trial, random| {
        let mut trial = *trial;
        trial.sphere = on_the_surface(random);
        let mut grid = Grid::new(trial.camera);
        grid.scale = scale(1.0, random);
        if random.below(2) == 0 {
            // Where B = 0 in its row, or a few columns beside that.
            let of = |lanes: f64x8| lanes.to_array()[0];
            let [x, y, z] = trial.sphere.centre.map(f64::from);
            let slope = -(y * of(grid.y_axis.y(splat(f64::from(trial.row)))) + z) / x;
            let column = slope * grid.x_axis.scale + grid.x_axis.middle;
            let beside = random.sign() * random.power(2.0, -2.0, 14.0);
            let last = trial.camera.size().width() - 1;
            trial.column = (column + beside).round().clamp(0.0, f64::from(last)) as u32;
        }
        let (lane, record, corner) = packet_of(&trial, random);
        let mut rows = [PixelRow::new(BACKGROUND)];
        InDoubles::new(&grid, Bounds::Proven, corner, &record).meet(&mut rows, &[u64::MAX; SIDE]);
        kinds[judge(&rows[0], lane, &trial, grid.scale)?] += 1;
        Ok(())
    });
    let [met, doubtful, missed] = kinds;
    assert!(
        met > 20_000 && doubtful > 1_000 && missed > 20_000,
        "only {kinds:?}"
    );
}

/// Beyond these ranges such a sphere is met in doubles.
#[test]
fn floats_are_used_on_the_surface_within_their_ranges_only() {
    let fits = |reach: f64, scale: f64| {
        let mut grid = Trial::new(0).grid(&mut Random::new(0));
        (grid.reach, grid.scale) = (reach, scale);
        // `g/(2 r)` is the scale.
        Surface::new(&grid, [0.0, 0.0, 0.5, 0.5]).is_some()
    };
    assert!(fits(SURFACE_REACH, 1.0) && !fits(SURFACE_REACH.next_up(), 1.0));
    let (least, most) = (SURFACE_SCALES.start, SURFACE_SCALES.end);
    assert!(fits(1.0, least) && !fits(1.0, least.next_down()));
    assert!(fits(1.0, most.next_down()) && !fits(1.0, most));
}

#[test]
fn leader_and_rivals_are_those_of_every_order() {
    // The leader has the greatest upper bound, the rival the greatest of the others. The
    // width of the leader is rounded up to the next power of two.
    let settled = [(1.0, 2.0), (1.5, 1.75), (0.5, 2.125), (2.5, 2.75)];
    let open = [(1.0, 2.0), (1.5, 1.75), (0.5, 3.0), (2.5, 2.75)];
    for (intervals, lower, upper, rival) in [(settled, 2.25, 2.75, 2.125), (open, -1.0, 3.0, 2.75)]
    {
        for turn in 0..intervals.len() {
            let mut pixels = PixelRow::new(BACKGROUND);
            for step in 0..intervals.len() {
                let (lower, upper) = intervals[(turn + step) % intervals.len()];
                let [lower, upper] = [lower, upper].map(f32x8::splat);
                let leader: f32x8 = packet(&pixels.upper, 3);
                pixels.update(3, upper, upper.simd_gt(leader), exponents(upper - lower));
            }
            let [lower, upper, rival] = [lower, upper, rival].map(f32x8::splat);
            assert_eq!(pixels.lower(3), lower);
            assert_eq!(packet::<_, f32x8>(&pixels.upper, 3), upper);
            assert_eq!(packet::<_, f32x8>(&pixels.rival, 3), rival);
            let undecided = lower.simd_gt(rival).to_bitmask() ^ 0xff;
            assert_eq!(pixels.undecided_lanes(3), undecided);
        }
    }
}

/// A width comes back as a power of two above it and not above its double, whatever the
/// colour beside it; in either byte order the colour is untouched.
#[test]
fn widths_are_rounded_up_to_powers_of_two() {
    let widths_of = |width: f32| {
        let colours = exponents(f32x8::splat(width)) | u32x8::splat(colour_lane([255; 3]));
        assert_eq!(bytes_of(colours.to_array()[0]), [255; 3]);
        widths(colours).to_array()[0]
    };
    for exponent in -126..127 {
        let power = f32::from_bits(((exponent + 127) as u32) << 23);
        let below_double = (2.0 * power).next_down();
        for width in [power, power.next_up(), 1.5 * power, below_double] {
            assert_eq!(widths_of(width), 2.0 * power, "{width:e}");
        }
    }
    assert_eq!(widths_of(f32::MAX), f32::INFINITY);
    assert_eq!(widths_of(f32::INFINITY), f32::INFINITY);
    for width in [0.0, f32::from_bits(1), f32::MIN_POSITIVE.next_down()] {
        assert_eq!(widths_of(width), f32::MIN_POSITIVE, "{width:e}");
    }
    // The background has no width.
    assert_eq!(
        widths(u32x8::splat(colour_lane([255; 3]))),
        f32x8::splat(0.0)
    );
}

/// The formulas whose roundings are counted are those that packets evaluate, bit by bit.
#[test]
fn packets_evaluate_what_is_counted() {
    let mut seen = 0;
    each_trial(20_000, |trial, random| {
        let grid = trial.grid(random);
        let around = rectangles(trial, random);
        let depths = Depths::new(&grid, &around, &trial.eight()).to_floats(Bounds::Proven);
        let p = f32x8::new(STEPS) + f32x8::splat(depths.p[0]);
        let q = f32x8::splat(depths.q[0]);
        let terms = Terms::new(&depths, 0, p, Default::default());
        let splat = |of: [f32; LANES]| f32x8::splat(of[0]);
        let (d, b) = in_column(depths.d.map(splat), depths.b.map(splat), p);
        let bits = |lanes: f32x8| lanes.to_array().map(f32::to_bits);
        let counted = [d[0], d[1], d[2], b[0], b[1]].map(bits);
        let evaluated = [terms.d[0], terms.d[1], terms.d[2], terms.b[0], terms.b[1]].map(bits);
        if counted != evaluated {
            return Err(format!("{evaluated:x?} instead of {counted:x?}"));
        }
        let mut pixels = PixelRow::new(Default::default());
        pixels.meet::<true>(&terms, 0, q);
        let [d, b] = in_row(d, b, q);
        let (counted, sure) = (b + d.sqrt(), f32x8::splat(depths.d_sure[0]));
        let evaluated: f32x8 = packet(&pixels.upper, 0);
        let spread = f32x8::splat(depths.spread[0]);
        let zero = f32x8::splat(0.0);
        let leads = (counted - spread).simd_gt(zero) & d.simd_gt(sure);
        let counted = leads.select(counted, evaluated);
        seen += u64::from(leads.to_bitmask().count_ones());
        if bits(counted) == bits(evaluated) {
            Ok(())
        } else {
            Err(format!("{evaluated:?} instead of {counted:?}"))
        }
    });
    assert!(seen > 10_000, "only {seen} seen");
}

/// On a machine of either byte order.
#[test]
fn the_fourth_byte_of_a_colour_carries_the_width_of_an_interval() {
    let colour = [0xff, 0x80, 0x7f];
    let some = [
        0.0,
        f32::from_bits(1),
        1e-38,
        0.75,
        1.0,
        1.5,
        1e38,
        f32::MAX,
    ];
    let none = [f32::INFINITY, f32::NAN, -f32::NAN, f32::INFINITY];
    let none = [none, none].as_flattened().try_into().expect("eight");
    for exact in [some, none] {
        let lanes = u32x8::splat(colour_lane(colour)) | exponents(f32x8::new(exact));
        let carried = widths(lanes).to_array();
        for (lane, (&width, &carried)) in exact.iter().zip(&carried).enumerate() {
            assert_eq!(bytes_of(lanes.to_array()[lane]), colour, "{width:e}");
            // At least as wide, and the least such power of two.
            let least = f32::MIN_POSITIVE;
            let most = if width < f32::MAX {
                (2.0 * width).max(least)
            } else {
                f32::INFINITY
            };
            let holds = width.is_nan() && carried == f32::INFINITY;
            let holds = holds || (width..=most).contains(&carried);
            assert!(holds, "{width:e}: {carried:e}");
        }
    }
}

/// Each way of meeting a sphere returns how many packets that were.
#[test]
fn packets_are_counted() {
    let mut trial = Trial::new(0);
    trial.sphere.centre = [0.0, 0.0, 9.0];
    trial.sphere.radius = 1.0;
    let grid = Grid::new(trial.camera);
    let around = rectangles(&trial, &mut Random::new(0));
    let depths = Depths::new(&grid, &around, &trial.eight()).to_floats(Bounds::Proven);
    let met = |[left, right, top, bottom]: [u8; 4], wanted: &[u64; SIDE]| {
        let record = Record {
            sides: [left, right, top, bottom],
            ..Record::default()
        };
        let meetings = Meetings::new(&depths, &EightRecords::of(&[record]));
        let mut rows = vec![PixelRow::new(BACKGROUND); SIDE];
        let in_doubles = InDoubles::new(&grid, Bounds::Proven, (0, 0), &record);
        let masked = meetings.masked::<true>(0, &mut rows, wanted);
        assert_eq!(in_doubles.meet(&mut rows, wanted), masked);
        let [from, last, ..] = meetings.packets(0);
        let lines = (usize::from(top), usize::from(bottom) + 1);
        let first_packet = meetings.part::<true>(0, &mut rows, (from, from + LANES), lines);
        assert_eq!(first_packet, (lines.1 - lines.0) as u64);
        let part = meetings.part::<true>(0, &mut rows, (from, last + 1), lines);
        assert_eq!(meetings.whole::<true>(0, &mut rows), part);
        [part, masked]
    };
    let all = [u64::MAX; SIDE];
    assert_eq!(met([9, 13, 60, 63], &all), [4, 4]);
    assert_eq!(met([5, 12, 20, 29], &all), [10, 10]);
    assert_eq!(met([5, 13, 20, 29], &all), [20, 20]);
    assert_eq!(met([9, 32, 20, 29], &all), [40, 40]);
    assert_eq!(met([9, 31, 0, 0], &all), [3, 3]);
    // Column 9 is in one packet, 16 and 17 are in the next one; one row is beyond the box.
    let mut some = [0; SIDE];
    (some[20], some[22], some[29], some[30]) =
        (1 << 9, 1 << 9 | 1 << 16, 1 << 16 | 1 << 17, 1 << 9);
    assert_eq!(met([9, 32, 20, 29], &some), [40, 4]);
    assert_eq!(met([9, 32, 20, 29], &[0; SIDE]), [40, 0]);
}
