//! The intervals of packets, against dyadic rationals; orders and masks, against
//! the plain way to make them.

use wide::{f32x8, f64x8};

use super::{
    BLOCK, BLOCKS, EMPTY, LANES, Order, Record, STEPS, Terms, block_bit, blocks_of, blocks_of_box,
    packet, place, rgb,
};
use crate::exact::{
    Bounds,
    conic::{Extents, Grid, Lanes, Local},
    trials::{Random, around, each_trial},
};

/// What a packet says of the exact `1/z`: in its interval if surely hit, not nearer
/// if in doubt, and not hit if missed.
#[test]
fn intervals_hold_the_exact_inverse_depth() {
    let (mut met, mut doubtful) = ([0; 2], [0; 2]);
    each_trial(200_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let [x, y, z] = trial.sphere.centre;
        let lanes = Lanes::of(std::iter::once([x, y, z, trial.sphere.radius]));
        let extents = Extents::new(&grid, &lanes);
        if extents.visible & 1 == 0 {
            return Ok(());
        }
        let around = around(trial, extents.most[0], random);
        let local = Local::new::<false>(&grid, &around, &lanes, extents.most, Bounds::Proven);
        let from = |at: u32, middles: f64x8| f64::from(at) - middles.to_array()[0];
        let (p, q) = (
            from(trial.column, around.columns),
            from(trial.row, around.rows),
        );
        // A packet may begin at any pixel up to seven before, within the rectangle.
        let before = p - f64::from(local.p[0]);
        let lane = random.below(before.min(7.0) as u64 + 1) as usize;
        let first = random.below(64 - 7) as usize;
        let steps = f32x8::new(STEPS) + f32x8::splat(p as f32 - lane as f32);
        let q = f32x8::splat(q as f32);
        let mut packets = EMPTY;
        let clear = random.below(2) == 0;
        if clear {
            let terms = Terms::new::<true>(&local, 1.0, 0, steps);
            packets.meet::<true, true>(&terms, first, q);
        } else {
            let terms = Terms::new::<false>(&local, 1.0, 0, steps);
            packets.meet::<true, false>(&terms, first, q);
        }
        let of = |values| packet(values, first).to_array()[lane];
        let (least, most, rival) = (of(&packets.least), of(&packets.most), of(&packets.rival));
        let truth = trial.truth();
        let open = packets.open(first) >> lane & 1 == 1;
        let right = if least > f32::NEG_INFINITY {
            met[usize::from(clear)] += 1;
            !open
                && truth.hit()
                && truth.at_least(f64::from(least), around.scale)
                && truth.at_most(f64::from(most), around.scale)
        } else if rival > f32::NEG_INFINITY {
            doubtful[usize::from(clear)] += 1;
            open && (!truth.hit() || truth.at_most(f64::from(rival), around.scale))
        } else {
            !open && !truth.hit()
        };
        if right {
            Ok(())
        } else {
            Err(format!(
                "{least:e} to {most:e}, in doubt {rival:e}, open {open}, clear {clear}"
            ))
        }
    });
    assert!(met.iter().all(|&met| met > 10_000), "only {met:?} hits");
    assert!(
        doubtful.iter().all(|&doubtful| doubtful > 1_000),
        "only {doubtful:?} doubtful"
    );
}

fn any_record(random: &mut Random) -> Record {
    let mut ends = || {
        let (one, other) = (random.below(64) as u8, random.below(64) as u8);
        (one.min(other), one.max(other))
    };
    let ((left, right), (top, bottom)) = (ends(), ends());
    Record {
        left,
        right,
        top,
        bottom,
        most: match random.below(8) {
            0 => f32::INFINITY,
            1 => f32::from_bits(1),
            2 => 1.0,
            _ => random.power(2.0, -149.0, 127.0) as f32,
        },
        ..Record::default()
    }
}

#[test]
fn records_come_nearest_first_and_of_equals_in_their_order() {
    for number in 0..20_000 {
        let mut random = Random::new(number);
        let count = random.below(200);
        let records: Vec<Record> = (0..count).map(|_| any_record(&mut random)).collect();
        let mut expected: Vec<usize> = (0..records.len()).collect();
        expected.sort_by(|&a, &b| records[b].most.total_cmp(&records[a].most));
        let mut order = Order::default();
        let order: Vec<usize> = order
            .nearest_first(&records)
            .iter()
            .map(|&key| place(key))
            .collect();
        assert_eq!(order, expected, "trial {number}");
    }
}

#[test]
fn blocks_are_those_of_their_pixels() {
    for number in 0..20_000 {
        let record = any_record(&mut Random::new(number));
        let mut blocks = 0;
        for row in usize::from(record.top) / BLOCK..=usize::from(record.bottom) / BLOCK {
            for column in usize::from(record.left) / BLOCK..=usize::from(record.right) / BLOCK {
                blocks |= block_bit(column, row);
            }
        }
        assert_eq!(blocks_of_box(&record), blocks, "trial {number}: {record:?}");
    }
    let side = BLOCK * BLOCKS;
    for (width, height) in
        (1..=side).flat_map(|width| (1..=side).map(move |height| (width, height)))
    {
        let last = Record {
            right: width as u8 - 1,
            bottom: height as u8 - 1,
            ..Record::default()
        };
        assert_eq!(
            blocks_of(width, height),
            blocks_of_box(&last),
            "{width} x {height}"
        );
    }
}

#[test]
fn colours_are_packed_in_order() {
    let colours: [[u8; 3]; LANES] =
        std::array::from_fn(|lane| [lane, lane + 100, lane + 200].map(|byte| byte as u8));
    let packed = rgb(f32x8::new(colours.map(super::bits)));
    assert_eq!(packed.as_flattened().as_chunks::<3>().0, colours);
}
