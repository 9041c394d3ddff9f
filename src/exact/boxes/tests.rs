//! Boxes and the greatest inverse depth, against dyadic rationals.

use wide::f32x8;

use super::{
    BOX_BOUND, Boxes, FLOAT_RANGE, FLOAT_SCALES, Grid, PixelBox, Sphere, first_beside, float_unit,
    in_range, power, whole,
};
use crate::{
    camera::{Camera, ImageSize},
    exact::trials::{Random, Trial, Truth, each_trial, scale},
    scene::Viewport,
};

/// Whether any `V` with this `X` (or `Y`) meets the sphere: in the projection along the y axis
/// (or the x axis), a ray of the plane meets a circle, as in a picture of one row (or column).
fn meets_plane(trial: &Trial, axis: usize, at: f64) -> bool {
    let size = trial.camera.size();
    let mut sphere = trial.sphere;
    let sides = if axis == 0 {
        sphere.centre[1] = 0.0;
        (size.width(), 1)
    } else {
        sphere.centre[0] = 0.0;
        (1, size.height())
    };
    let size = ImageSize::of_sides(sides.0, sides.1);
    let camera = Camera::new(trial.camera.viewport(), size);
    let (column, row) = if axis == 0 { (at, 0.0) } else { (0.0, at) };
    Truth::new(&camera, &sphere, column, row).hit()
}

fn in_doubles(grid: &Grid, trial: &Trial) -> Option<Option<PixelBox>> {
    Some(PixelBox::new(grid, &trial.sphere))
}

/// The box in floats, if these can be used.
fn in_floats(grid: &Grid, trial: &Trial) -> Option<Option<PixelBox>> {
    let unit = float_unit(grid);
    let components = trial.lengths().map(f32x8::splat);
    let lengths = unit.map(|unit| components.map(|lanes| lanes * f32x8::splat(unit)))?;
    (in_range(lengths) == 0xff).then(|| {
        let Boxes {
            visible,
            sides,
            upper,
        } = Boxes::new(grid, components, unit);
        assert!(visible == 0 || visible == 0xff);
        (visible != 0).then(|| PixelBox {
            sides: sides.map(|side| side[0]),
            upper: upper[0],
        })
    })
}

type BoxOf = fn(&Grid, &Trial) -> Option<Option<PixelBox>>;

/// How many sides, spheres beside the camera, and invisible ones were tried, and sides of boxes
/// that are no more than a pixel too wide: those of ends that are nearer than `sharp_below`, in pixels.
fn leave_nothing_out(trials: u64, box_of: BoxOf, sharp_below: f64) -> [u64; 4] {
    let [mut sides, mut beside, mut invisible, mut sharp] = [0; 4];
    each_trial(trials, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let Some(its_box) = box_of(&grid, trial) else {
            return Ok(());
        };
        let size = trial.camera.size();
        let Some(PixelBox { sides: ends, upper }) = its_box else {
            invisible += 1;
            let mut any = |side: u32| random.below(u64::from(side)) as u32;
            let other = (any(size.width()), any(size.height()));
            for (column, row) in [(trial.column, trial.row), other] {
                if trial.truth_at(f64::from(column), f64::from(row)).hit() {
                    return Err(format!("invisible, but hit at ({column}, {row})"));
                }
            }
            return Ok(());
        };
        let [left, right, top, bottom] = ends;
        let (last_column, last_row) = (size.width() - 1, size.height() - 1);
        if right > last_column || bottom > last_row || left > right || top > bottom {
            return Err(format!("columns {left}..={right}, rows {top}..={bottom}"));
        }
        let beyond = [
            (0, left > 0, f64::from(left) - 1.0),
            (0, right < last_column, f64::from(right) + 1.0),
            (1, top > 0, f64::from(top) - 1.0),
            (1, bottom < last_row, f64::from(bottom) + 1.0),
        ];
        let reaches_camera = trial.sphere.centre[2] <= trial.sphere.radius;
        if is_sharp(trial, &grid, sharp_below) {
            let within = [
                (0, right - left, [left + 1, right.max(1) - 1]),
                (1, bottom - top, [top + 1, bottom.max(1) - 1]),
            ];
            for (axis, _, ends) in within.into_iter().filter(|&(_, length, _)| length > 1) {
                if let Some(at) = ends
                    .into_iter()
                    .find(|&at| !meets_plane(trial, axis, at.into()))
                {
                    return Err(format!("axis {axis}: {at} is within the box and not hit"));
                }
                sharp += 2;
            }
        }
        for (axis, within, at) in beyond {
            if within && meets_plane(trial, axis, at) {
                return Err(format!("axis {axis}: {at} is hit"));
            }
            sides += u64::from(within);
            beside += u64::from(within && reaches_camera);
        }
        let truth = trial.truth();
        let within = (left..=right).contains(&trial.column) && (top..=bottom).contains(&trial.row);
        if truth.hit() && !within {
            return Err("a hit beyond the box".into());
        }
        grid.scale = scale(upper, random);
        let Some(Some(PixelBox { upper, .. })) = box_of(&grid, trial) else {
            return Ok(());
        };
        if truth.hit() && !truth.at_most(f64::from(upper), grid.scale) {
            return Err(format!("nearer than {upper:e}"));
        }
        let nearest =
            grid.scale / (f64::from(trial.sphere.centre[2]) - f64::from(trial.sphere.radius));
        if (1e-30..1e30).contains(&nearest) && f64::from(upper) > nearest * (1.0 + 1e-6) {
            return Err(format!("{upper:e}, but nowhere nearer than {nearest:e}"));
        }
        Ok(())
    });
    [sides, beside, invisible, sharp]
}

/// Whether the slack is less than half a pixel, so that the box is no more than a pixel too wide: it is
/// relative to the greater end. A camera on the circle of a projection has all columns, or all rows.
fn is_sharp(trial: &Trial, grid: &Grid, below: f64) -> bool {
    let [x, y, z, r] = trial.lengths().map(f64::from);
    let on_circle = |centre: f64| (centre * centre + z * z - r * r).abs() <= 1e-9 * r * r;
    if z <= r {
        return !on_circle(x) && !on_circle(y);
    }
    let q = (z - r) * (z + r);
    let end = |centre: f64, scale: f64, side: u32| {
        (centre.abs() * z + r * (centre * centre + q).sqrt()) / q * scale + f64::from(side)
    };
    let size = trial.camera.size();
    let across = end(x, grid.x_axis.scale, size.width());
    across.max(end(y, grid.y_axis.scale, size.height())) < below
}

#[test]
fn boxes_leave_nothing_out() {
    let [sides, beside, invisible, sharp] = leave_nothing_out(80_000, in_doubles, 1e12);
    assert!(sides > 40_000, "only {sides} sides of boxes");
    assert!(
        beside > 1_000,
        "only {beside} of spheres at the camera's plane"
    );
    assert!(invisible > 5_000, "only {invisible} invisible");
    assert!(sharp > 20_000, "only {sharp} sides are known to be sharp");
    let [sides, _, invisible, sharp] = leave_nothing_out(80_000, in_floats, 4e5);
    assert!(
        sides > 5_000 && invisible > 300 && sharp > 2_000,
        "only {sides} sides, {invisible} invisible, {sharp} sharp in floats"
    );
}

/// At the ends of their ranges floats give the boxes of doubles; beyond them they are not used.
#[test]
fn floats_are_used_within_their_ranges_only() {
    let (least, most) = (FLOAT_RANGE.start, FLOAT_RANGE.end);
    // A scene of ordinary lengths is within.
    assert!(least < 1e-6 && most > 1e6);
    let fit = |lengths: [f32; 4]| in_range(lengths.map(f32x8::splat)) == 0xff;
    for sign in [-1.0, 1.0] {
        assert!(fit([sign * most, sign * most, most, 1.0]));
        assert!(!fit([sign * most.next_up(), 0.0, most, 1.0]));
        assert!(!fit([0.0, sign * most.next_up(), most, 1.0]));
    }
    assert!(!fit([0.0, 0.0, most.next_up(), 1.0]));
    // `Cz - r` is the lower bound, or a little less.
    assert!(fit([0.0, 0.0, 1.0 + least, 1.0]));
    assert!(!fit([0.0, 0.0, 1.0 + least / 2.0, 1.0]));
    assert!(!fit([0.0, 0.0, f32::NAN, 1.0]));
    let fits = |side: u32, extent: f64, scale: f64| {
        let camera = Camera::new(
            Viewport::new(extent as f32, 1.0, 1.0).expect("a viewport"),
            ImageSize::new(side, 2).expect("a size"),
        );
        let mut grid = Grid::new(camera);
        grid.scale = scale;
        float_unit(&grid)
    };
    let (smallest, greatest) = (FLOAT_SCALES.start, FLOAT_SCALES.end);
    let normal = f64::from(f32::MIN_POSITIVE);
    assert_eq!(fits(2, 1.0, 1.0), Some(1.0));
    assert_eq!(fits(2, 1.0, normal.recip()), Some(f32::MIN_POSITIVE));
    assert_eq!(fits(2, 1.0, 2.0 * normal.recip()), None);
    assert_eq!(fits(2, 1.0, (-127.0_f64).exp2()), Some(127.0_f32.exp2()));
    assert_eq!(fits(2, 1.0, (-128.0_f64).exp2()), None);
    assert_eq!(fits(2, smallest, 1.0), None);
    assert_eq!(fits(2, greatest / 2.0, 1.0), Some(1.0));
    assert_eq!(fits(most as u32 - 1, 1.0, 1.0), Some(1.0));
    assert_eq!(fits(most as u32, 1.0, 1.0), None);
}

/// Whatever the other lanes hold; and what floats do not hold has the box of doubles.
#[test]
fn each_lane_has_the_box_that_its_sphere_has_alone() {
    let [mut mixed, mut beyond] = [0; 2];
    for number in (0..16_000).step_by(8) {
        let trials: Vec<Trial> = (number..number + 8).map(Trial::new).collect();
        let grid = Grid::new(trials[0].camera);
        let unit = float_unit(&grid);
        let lane = |component: usize| {
            f32x8::new(std::array::from_fn(|lane| {
                trials[lane].lengths()[component]
            }))
        };
        let boxes = Boxes::new(&grid, [lane(0), lane(1), lane(2), lane(3)], unit);
        let mut in_floats = 0;
        for (lane, trial) in trials.iter().enumerate() {
            let trial = Trial {
                camera: trials[0].camera,
                ..*trial
            };
            let found = (boxes.visible >> lane & 1 == 1).then(|| PixelBox {
                sides: boxes.sides.map(|side| side[lane]),
                upper: boxes.upper[lane],
            });
            let alone = self::in_floats(&grid, &trial);
            in_floats += usize::from(alone.is_some());
            let alone = alone.unwrap_or_else(|| PixelBox::new(&grid, &trial.sphere));
            let numbers = |its_box: PixelBox| (its_box.sides, its_box.upper.to_bits());
            assert_eq!(
                found.map(numbers),
                alone.map(numbers),
                "{}",
                trial.describe()
            );
        }
        mixed += usize::from(in_floats > 0 && in_floats < 8);
        beyond += 8 - in_floats;
    }
    assert!(
        mixed > 100 && beyond > 1_000,
        "only {mixed} mixed, {beyond}"
    );
}

/// The greatest inverse depth is that of the point nearest to the camera's plane; for a
/// sphere that reaches this plane, that in the direction of its nearest point is used.
#[test]
fn no_pole_is_nearer_than_the_box_says() {
    let (mut poles, mut beside, mut in_float) = (0, 0, 0);
    each_trial(60_000, |trial, _| {
        let [x, y, z] = trial.sphere.centre.map(f64::from);
        let depth = z - f64::from(trial.sphere.radius);
        let before = depth > 0.0;
        let grid = Grid::new(trial.camera);
        let Some(in_doubles) = PixelBox::new(&grid, &trial.sphere) else {
            return Ok(());
        };
        let depth = if before { depth } else { z };
        let column = x / depth * grid.x_axis.scale + grid.x_axis.middle;
        let row = grid.y_axis.middle - y / depth * grid.y_axis.scale;
        let size = trial.camera.size();
        let seen = (0.0..f64::from(size.width())).contains(&column)
            && (0.0..f64::from(size.height())).contains(&row);
        if !column.is_finite() || !row.is_finite() || !before && !seen {
            return Ok(());
        }
        let (column, row) = if before {
            (column, row)
        } else {
            (column.floor(), row.floor())
        };
        let truth = trial.truth_at(column, row);
        poles += u64::from(truth.hit());
        beside += u64::from(truth.hit() && !before);
        let floats = in_floats(&grid, trial).flatten();
        in_float += u64::from(truth.hit() && floats.is_some());
        for PixelBox { upper, .. } in floats.into_iter().chain([in_doubles]) {
            if truth.hit() && !truth.at_most(f64::from(upper), 1.0) {
                return Err(format!("the pole is nearer than {upper:e}"));
            }
        }
        let (r, length) = (
            f64::from(trial.sphere.radius),
            (x * x + y * y + z * z).sqrt(),
        );
        let nearest = grid.reach * (length + r) / ((length - r) * (length + r)).abs();
        let sharp = (1e-6..1e6).contains(&nearest) && (length - r).abs() > 1e-6 * r;
        if !before && sharp && f64::from(in_doubles.upper) > nearest * (1.0 + 1e-6) {
            return Err(format!(
                "{:e}, but nowhere above {nearest:e}",
                in_doubles.upper
            ));
        }
        Ok(())
    });
    assert!(poles > 10_000, "only {poles} poles");
    assert!(beside > 500, "only {beside} nearest points");
    assert!(in_float > 1_000, "only {in_float} poles in floats");
}

/// As a real number, not only at the next column.
#[test]
fn no_column_before_the_first_beside_is_hit() {
    let (mut ends, mut near) = (0, 0);
    each_trial(100_000, |trial, _| {
        let mut trial = *trial;
        let [x, _, z] = trial.sphere.centre;
        let r = trial.sphere.radius;
        (trial.sphere.centre[0], trial.sphere.centre[1]) = (x.abs(), 0.0);
        let w = power(trial.lengths().map(f64::from));
        let side = trial.camera.size().width();
        if !(-r < z && z <= r && w > 0.0 && side > 1) {
            return Ok(());
        }
        let grid = Grid::new(trial.camera);
        let lengths = [x.abs(), z, r].map(f64::from);
        let first = first_beside(lengths, grid.x_axis.scale, side);
        if !(0.0..f64::from(side)).contains(&first) {
            return Ok(());
        }
        ends += 1;
        if meets_plane(&trial, 0, first) {
            return Err(format!("column {first:e} is hit"));
        }
        // A slack of no more than twice the bound.
        let slack = BOX_BOUND * 2.0 * (first.abs() + 2.0 * f64::from(side));
        near += u64::from(meets_plane(&trial, 0, first + 2.0 * slack));
        Ok(())
    });
    assert!(
        ends > 2_000 && near > ends * 9 / 10,
        "only {ends} ends, {near} near"
    );
}

/// Spheres that touch the plane of a column exactly: 3-4-5 triangles so long that
/// doubles round on the way.
#[test]
fn boxes_hold_columns_that_touch() {
    // Of 20 bits for doubles, of 12 for floats.
    for (box_of, bits) in [(in_doubles as BoxOf, 20), (in_floats, 12)] {
        let touched = (0..60_000).filter(|&number| holds_columns_that_touch(number, box_of, bits));
        let touched = touched.count();
        assert!(touched > 10_000, "only {touched} touched");
    }
}

/// Whether the triangle is exact in these bits.
fn holds_columns_that_touch(number: u64, box_of: BoxOf, bits: u32) -> bool {
    let mut random = Random::new(number);
    let mut whole = |bits: u32| (1 + random.below(1 << bits)) as f64;
    let (along, across, unit) = (whole(bits), whole(bits), whole(bits));
    let (last, place) = (2.0 * whole(10), random.below(4));
    // The ray of column `last` is (4, 0, 3) times the unit: touch it from the left,
    // from below with x and y exchanged, and so on.
    let sign = if place & 1 == 0 { 1.0 } else { -1.0 };
    let (x, z) = (4.0 * along - 3.0 * across, 3.0 * along + 4.0 * across);
    let sphere = if place & 2 == 0 {
        [sign * x, 0.0, z]
    } else {
        [0.0, sign * x, z]
    };
    let side = last as u32 + 1;
    let camera = Camera::new(
        Viewport {
            width: (8.0 * unit) as f32,
            height: (8.0 * unit) as f32,
            distance: (3.0 * unit) as f32,
        },
        ImageSize::new(side, side).expect("a size"),
    );
    let sphere = Sphere {
        centre: sphere.map(|length| length as f32),
        radius: (5.0 * across) as f32,
        colour: [0; 3],
    };
    let middle = side / 2;
    let edge = if sign > 0.0 { side - 1 } else { 0 };
    let (column, row) = if place & 2 == 0 {
        (edge, middle)
    } else {
        (middle, side - 1 - edge)
    };
    let trial = Trial {
        camera,
        sphere,
        column,
        row,
    };
    if !trial.truth().hit() {
        // Its centre needs more than 24 bits, so it is not exact.
        return false;
    }
    let Some(its_box) = box_of(&Grid::new(camera), &trial) else {
        return false;
    };
    let [left, right, top, bottom] = its_box.expect("a visible sphere").sides;
    let (columns, rows) = (left..=right, top..=bottom);
    assert!(
        columns.contains(&column) && rows.contains(&row),
        "trial {number}: {columns:?} {rows:?}; {}",
        trial.describe(),
    );
    true
}

/// On a machine of either byte order.
#[test]
fn whole_numbers_are_the_low_bits_of_their_lanes() {
    let numbers = [0, 1, 2, 0x01_0203, 1 << 22, 0x7f_fffe, 0x7f_ffff, 77];
    let lanes = numbers.map(|number| number as f32);
    assert_eq!(whole(f32x8::new(lanes)), numbers);
}
