//! The intervals of packets, in floats and in doubles, against dyadic rationals.

use super::{
    Bounds, Grid, LANES, Meeting, PixelRow, Record, SIDE, STEPS, Terms, f32x8, f64x8, packet,
};
use crate::exact::{
    bounds::restated::{in_column, in_row},
    boxes::Boxes,
    depths::{Depths, FloatDepths},
    trials::{Trial, each_trial, rectangles, scale},
};

/// What is wrong with what a packet says of the exact `1/z`, if anything: it is in its
/// interval if surely hit, not nearer if in doubt, and the pixel is not hit if missed.
/// Returns whether it is met, in doubt, or missed.
fn judge(pixels: &PixelRow, at: usize, trial: &Trial, scale: f64) -> Result<usize, String> {
    let of = |values| packet(values, at).to_array()[0];
    let (lower, upper, rival) = (of(&pixels.lower), of(&pixels.upper), of(&pixels.rival));
    let open = pixels.open(at) & 1 == 1;
    let truth = trial.truth();
    let met = upper > f32::NEG_INFINITY;
    let (kind, right) = if met {
        let interval = truth.hit()
            && truth.at_least(f64::from(lower), scale)
            && truth.at_most(f64::from(upper), scale);
        (0, interval && !open)
    } else if rival >= 0.0 {
        let below = !truth.hit() || truth.at_most(f64::from(rival), scale);
        (1, below && open)
    } else {
        (2, !open && !truth.hit())
    };
    if right {
        Ok(kind)
    } else {
        Err(format!(
            "{lower:e} to {upper:e}, in doubt {rival:e}, open {open}"
        ))
    }
}

#[test]
fn intervals_hold_the_exact_inverse_depth() {
    let mut kinds = [[0; 3]; 2];
    each_trial(100_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let boxes = Boxes::new(&grid, &trial.eight());
        if boxes.visible & 1 == 0 {
            return Ok(());
        }
        grid.scale = scale(boxes.upper[0], random);
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
        let mut pixels = PixelRow::new(0.0);
        let clear = random.below(2) == 0;
        if clear {
            let terms = Terms::new::<true>(&depths, 0, steps, 1.0);
            pixels.meet::<true, true>(&terms, first, q);
        } else {
            let terms = Terms::new::<false>(&depths, 0, steps, 1.0);
            pixels.meet::<true, false>(&terms, first, q);
        }
        let kind = judge(&pixels, first + lane, trial, grid.scale)
            .map_err(|wrong| format!("{wrong}, clear {clear}"))?;
        kinds[usize::from(clear)][kind] += 1;
        Ok(())
    });
    for [met, doubtful, missed] in kinds {
        let enough = met > 8_000 && doubtful > 500 && missed > 3_000;
        assert!(
            enough,
            "only {met} met, {doubtful} in doubt, {missed} missed"
        );
    }
}

#[test]
fn doubles_hold_the_exact_inverse_depth() {
    let mut kinds = [0; 3];
    each_trial(30_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let boxes = Boxes::new(&grid, &trial.eight());
        grid.scale = scale(boxes.upper[0], random);
        // Its own pixel first in the tile, or some lane of its packet.
        let lane = (random.below(8) as u32).min(trial.column);
        let record = Record {
            sphere: trial.lengths(),
            right: lane as u8,
            ..Record::default()
        };
        let floats = Depths::new(&grid, &rectangles(trial, random), &trial.eight());
        let meeting = Meeting {
            depths: &floats.to_floats(Bounds::Proven),
            lane: 0,
            colour: 1.0,
            record: &record,
        };
        let mut rows = [PixelRow::new(0.0)];
        let corner = (trial.column - lane, trial.row);
        let packets = meeting.in_doubles(&mut rows, &grid, corner, Bounds::Proven, |_| u64::MAX);
        if packets != 1 {
            return Err(format!("{packets} packets"));
        }
        kinds[judge(&rows[0], lane as usize, trial, grid.scale)?] += 1;
        let mut refused = [PixelRow::new(0.0)];
        meeting.in_doubles(&mut refused, &grid, corner, Bounds::Refused, |_| u64::MAX);
        if refused[0].open(lane as usize) & 1 == 0 {
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

#[test]
fn leader_and_rivals_are_those_of_every_order() {
    // Intervals one after another: the leader has the greatest lower bound, the rival the
    // greatest upper bound of the others.
    let intervals = [(1.0, 2.0), (1.5, 1.75), (0.5, 3.0), (2.5, 2.75)];
    for turn in 0..intervals.len() {
        let mut pixels = PixelRow::new(0.0);
        for step in 0..intervals.len() {
            let (lower, upper) = intervals[(turn + step) % intervals.len()];
            let [lower, upper] = [lower, upper].map(f32x8::splat);
            let leads = lower.simd_gt(packet(&pixels.lower, 3));
            pixels.update(3, lower, upper, leads, lower);
        }
        assert_eq!(packet(&pixels.lower, 3), f32x8::splat(2.5));
        assert_eq!(packet(&pixels.upper, 3), f32x8::splat(2.75));
        assert_eq!(packet(&pixels.rival, 3), f32x8::splat(3.0));
        assert_eq!(pixels.open(3), 0xff);
    }
}

/// The formulas whose roundings are counted are those that packets evaluate, bit by bit.
#[test]
fn packets_evaluate_what_is_counted() {
    let mut seen = 0;
    each_trial(20_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let boxes = Boxes::new(&grid, &trial.eight());
        grid.scale = scale(boxes.upper[0], random);
        let around = rectangles(trial, random);
        let depths = Depths::new(&grid, &around, &trial.eight()).to_floats(Bounds::Proven);
        let p = f32x8::new(STEPS) + f32x8::splat(depths.p[0]);
        let q = f32x8::splat(depths.q[0]);
        let terms = Terms::new::<true>(&depths, 0, p, Default::default());
        let splat = |of: [f32; LANES]| f32x8::splat(of[0]);
        let FloatDepths {
            d00,
            d10,
            d01,
            d20,
            d11,
            d02,
            b00,
            b10,
            b01,
            ..
        } = depths;
        let d = [d00, d10, d01, d20, d11, d02].map(splat);
        let (d, b) = in_column(d, [b00, b10, b01].map(splat), p);
        let bits = |lanes: f32x8| lanes.to_array().map(f32::to_bits);
        let counted = [d[0], d[1], d[2], b[0], b[1]].map(bits);
        let evaluated = [terms.d0, terms.d1, terms.d2, terms.b0, terms.b1].map(bits);
        if counted != evaluated {
            return Err(format!("{evaluated:x?} instead of {counted:x?}"));
        }
        let mut pixels = PixelRow::new(Default::default());
        pixels.meet::<true, true>(&terms, 0, q);
        let [d, b] = in_row(d, b, q);
        let (counted, clear) = (b + d.sqrt(), f32x8::splat(depths.clear[0]));
        let evaluated: f32x8 = packet(&pixels.upper, 0);
        let spread = f32x8::splat(depths.clear_spread[0]);
        let zero = f32x8::splat(0.0);
        let leads = (counted - spread).simd_gt(zero) & d.simd_gt(clear);
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
