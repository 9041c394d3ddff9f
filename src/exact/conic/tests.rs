//! Every bound of a conic, against dyadic rationals.

use wide::{f32x8, f64x8};

use super::{Bounds, Extents, Grid, LANES, Lanes, Local, Outline, Shape, Sphere};
use crate::exact::trials::{Dyadic, Random, Trial, around, dyadic, each_trial};

fn lanes(sphere: &Sphere) -> Lanes {
    let [x, y, z] = sphere.centre;
    Lanes::of(std::iter::once([x, y, z, sphere.radius]))
}

/// Whether the sphere is so far to one side that all `V` with this `x` (or `y`) miss
/// it: the plane through them and the y axis (or x axis) does.
fn passes_beside(trial: &Trial, axis: usize, at: f64) -> bool {
    let (column, row) = if axis == 0 { (at, 0.0) } else { (0.0, at) };
    let size = trial.camera.size();
    let viewport = trial.camera.viewport();
    let (last, extent, at) = if axis == 0 {
        (f64::from(size.width() - 1), viewport.width, column)
    } else {
        (f64::from(size.height() - 1), -viewport.height, row)
    };
    let z = dyadic(f64::from(viewport.distance)) * dyadic(2.0 * last.max(0.5));
    let v = dyadic(f64::from(extent)) * (dyadic(2.0) * dyadic(at) - dyadic(last));
    let [centre, depth, r] = [
        trial.sphere.centre[axis],
        trial.sphere.centre[2],
        trial.sphere.radius,
    ]
    .map(|length| dyadic(f64::from(length)));
    let cross = centre * &z - depth * &v;
    &cross * &cross > &r * &r * (&z * &z + &v * &v)
}

#[test]
fn boxes_leave_nothing_out() {
    let mut boxes = 0;
    each_trial(200_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let extents = Extents::new(&grid, &lanes(&trial.sphere));
        let size = trial.camera.size();
        let [left, right, top, bottom] =
            [extents.left, extents.right, extents.top, extents.bottom].map(|side| side[0]);
        let (last_column, last_row) = (size.width() - 1, size.height() - 1);
        if extents.visible & 1 == 0 {
            let row = random.below(u64::from(size.height())) as u32;
            for (column, row) in [(trial.column, trial.row), (trial.column, row)] {
                if trial.truth_at(f64::from(column), f64::from(row)).hit() {
                    return Err("invisible, but hit".into());
                }
            }
            return Ok(());
        }
        if right > last_column || bottom > last_row || left > right || top > bottom {
            return Err(format!("columns {left}..={right}, rows {top}..={bottom}"));
        }
        // What is wholly before the camera is within its planes; the rest is anywhere.
        let [.., z] = trial.sphere.centre;
        let before = z > trial.sphere.radius;
        let beside = [
            (0, left > 0, f64::from(left) - 1.0),
            (0, right < last_column, f64::from(right) + 1.0),
            (1, top > 0, f64::from(top) - 1.0),
            (1, bottom < last_row, f64::from(bottom) + 1.0),
        ];
        for (axis, within, at) in beside {
            if within && !(before && passes_beside(trial, axis, at)) {
                return Err(format!("axis {axis}: {at} is hit"));
            }
            boxes += u64::from(within);
        }
        let truth = trial.truth();
        let within = (left..=right).contains(&trial.column) && (top..=bottom).contains(&trial.row);
        if truth.hit() && !within {
            return Err("a hit beyond the box".into());
        }
        if truth.hit() && !truth.at_most(f64::from(extents.most[0]), 1.0) {
            return Err(format!("nearer than {:e}", extents.most[0]));
        }
        Ok(())
    });
    assert!(boxes > 100_000, "only {boxes} sides of boxes");
}

/// The greatest depth is that of the pole that faces the camera's plane.
#[test]
fn no_pole_is_nearer_than_the_box_says() {
    let mut poles = 0;
    each_trial(100_000, |trial, _| {
        let [x, y, z] = trial.sphere.centre.map(f64::from);
        let depth = z - f64::from(trial.sphere.radius);
        if depth <= 0.0 {
            return Ok(());
        }
        let grid = Grid::new(trial.camera);
        let most = Extents::new(&grid, &lanes(&trial.sphere)).most[0];
        let column = x / depth * grid.x_scale + grid.x_middle;
        let row = grid.y_middle - y / depth * grid.y_scale;
        if !column.is_finite() || !row.is_finite() {
            return Ok(());
        }
        let truth = trial.truth_at(column, row);
        poles += u64::from(truth.hit());
        if truth.hit() && !truth.at_most(f64::from(most), 1.0) {
            return Err(format!("the pole is nearer than {most:e}"));
        }
        Ok(())
    });
    assert!(poles > 20_000, "only {poles} poles");
}

/// Spheres that touch the plane of a column exactly: 3-4-5 triangles so long that
/// doubles round on the way.
#[test]
fn boxes_hold_columns_that_touch() {
    for number in 0..100_000 {
        let mut random = Random::new(number);
        let mut whole = |bits: u32| (1 + random.below(1 << bits)) as f64;
        let (along, across, unit) = (whole(20), whole(20), whole(20));
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
        let camera = crate::camera::Camera::new(
            crate::scene::Viewport {
                width: (8.0 * unit) as f32,
                height: (8.0 * unit) as f32,
                distance: (3.0 * unit) as f32,
            },
            crate::camera::ImageSize::new(side, side).expect("a size"),
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
            // Its centre is beyond 24 bits: no exact case.
            continue;
        }
        let extents = Extents::new(&Grid::new(camera), &lanes(&sphere));
        let columns = extents.left[0]..=extents.right[0];
        let rows = extents.top[0]..=extents.bottom[0];
        assert!(
            extents.visible & 1 == 1 && columns.contains(&column) && rows.contains(&row),
            "trial {number}: {columns:?} {rows:?}; {}",
            trial.describe(),
        );
    }
}

/// A row of the picture: the trial's own, or one that the outline touches to the last
/// digits, as rows of pixels hardly ever do. With its `Y` and `Y^2 + 1`.
fn some_row(trial: &Trial, grid: &Grid, random: &mut Random) -> (f64, f64, f64) {
    let last = f64::from(trial.camera.size().height() - 1);
    let [_, y, z] = trial.sphere.centre.map(f64::from);
    let r = f64::from(trial.sphere.radius);
    let q = (z - r) * (z + r);
    let root = r * (y * y + q).max(0.0).sqrt();
    let place = match random.below(4) {
        0 => f64::from(trial.row),
        1 => grid.y_middle - (y * z - root) / q * grid.y_scale,
        2 => grid.y_middle - (y * z + root) / q * grid.y_scale,
        _ => random.between(0.0, last),
    };
    // So that twice its distance from the last row is a double, as a pixel's is.
    let digits = (53.0 - (last + 1.0).log2().ceil()).exp2();
    let row = (place * digits).round() / digits;
    if last == 0.0 || !(0.0..=last).contains(&row) {
        let (y, squared) = grid.row(i64::from(trial.row));
        return (f64::from(trial.row), y, squared);
    }
    let y = trial.camera.y_extent() * (last - 2.0 * row) / (2.0 * last);
    (row, y, y * y + 1.0)
}

/// Between its ends, drawn in by the slack, every real point of a row is hit; beyond
/// them, put out by the slack, none.
#[test]
fn rows_enter_and_leave_within_the_slack() {
    let (mut ends, mut everywhere) = (0, 0);
    each_trial(200_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let [outline, ..] = Outline::eight(&grid, &lanes(&trial.sphere), Bounds::Proven);
        let (row, y, squared) = some_row(trial, &grid, random);
        let truth = |column: f64| trial.truth_at(column, row);
        match outline.shape {
            Shape::Unknown => return Ok(()),
            Shape::Everywhere => {
                everywhere += 1;
                return if truth(0.0).c < Dyadic::ZERO {
                    Ok(())
                } else {
                    Err("not everywhere".into())
                };
            }
            Shape::Convex => {}
        }
        let (y, squared) = (f64x8::splat(y), f64x8::splat(squared));
        let last = trial.camera.size().width();
        let columns = outline.ends(y, squared, 0, last);
        let [start, end, outer_start, outer_end] = [
            columns.start[0],
            columns.end[0],
            columns.outer_start[0],
            columns.outer_end[0],
        ];
        if [start, end, outer_start, outer_end]
            .iter()
            .any(|&column| column > last)
        {
            return Err(format!("{columns:?} past the picture"));
        }
        let hit = |column: u32| truth(f64::from(column)).hit();
        if start < end && !(hit(start) && hit(end - 1)) {
            return Err(format!("row {row}: not all hit in {start}..{end}"));
        }
        let before = outer_start.min(last).wrapping_sub(1);
        let none_before = outer_start == 0 || !hit(before);
        let none_after = outer_end >= last || !hit(outer_end);
        // An empty row is empty, wherever it says so.
        let empty = outer_start >= outer_end;
        let some = empty && hit(trial.column);
        if some || !none_before || !none_after {
            return Err(format!("row {row}: hit beyond {outer_start}..{outer_end}"));
        }
        let (left, right, m) = outline.sides(y, squared);
        let [left, right, m] = [left, right, m].map(|lanes| lanes.to_array()[0]);
        // There are no real columns beside the only one.
        if m <= outline.front || last == 1 {
            return Ok(());
        }
        let slack = outline.slack;
        let (inner_left, inner_right) = ((left + slack).next_up(), (right - slack).next_down());
        if inner_left <= inner_right {
            ends += 1;
            for at in [inner_left, inner_right] {
                if !truth(at).hit() {
                    return Err(format!("row {row}: {at:e} is not hit, slack {slack:e}"));
                }
            }
        }
        for at in [(left - slack).next_down(), (right + slack).next_up()] {
            if truth(at).d > Dyadic::ZERO {
                return Err(format!("row {row}: {at:e} is hit, slack {slack:e}"));
            }
        }
        Ok(())
    });
    assert!(ends > 10_000, "only {ends} ends");
    assert!(everywhere > 2_000, "only {everywhere} everywhere");
}

/// The farthest point that is seen is where the rays touch, straight away from the axis.
#[test]
fn no_hit_is_farther_than_the_least() {
    let mut farthest = 0;
    each_trial(100_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let [outline, ..] = Outline::eight(&grid, &lanes(&trial.sphere), Bounds::Proven);
        let [x, y, z] = trial.sphere.centre.map(f64::from);
        let r = f64::from(trial.sphere.radius);
        let (across, squared) = (x.hypot(y), x * x + y * y + z * z);
        let root = (squared - r * r).sqrt();
        let around = r * root / squared;
        let shrunk = |length: f64| length * root * root / squared;
        // From the middle of the circle away from the axis, and that is along z as well.
        let (from, up) = if across > 0.0 {
            (
                shrunk(across) - around * z / squared.sqrt(),
                shrunk(z) + around * across / squared.sqrt(),
            )
        } else {
            (around, shrunk(z))
        };
        let near = 1.0 - random.power(10.0, -16.0, -3.0);
        let slope = shrunk(across) / shrunk(z) + (from / up - shrunk(across) / shrunk(z)) * near;
        let [x, y] = if across > 0.0 {
            [x / across * slope, y / across * slope]
        } else {
            [slope, 0.0]
        };
        let (column, row) = (
            grid.x_middle + x * grid.x_scale,
            grid.y_middle - y * grid.y_scale,
        );
        let places = [
            (f64::from(trial.column), f64::from(trial.row)),
            (column, row),
        ];
        for (column, row) in places {
            if !column.is_finite() || !row.is_finite() {
                continue;
            }
            let truth = trial.truth_at(column, row);
            if truth.hit() && outline.least > 0.0 {
                farthest += 1;
                if !truth.at_least(f64::from(outline.least), 1.0) {
                    return Err(format!(
                        "({column:e}, {row:e}) is farther than {:e}",
                        outline.least
                    ));
                }
            }
        }
        Ok(())
    });
    assert!(farthest > 20_000, "only {farthest} hits");
}

/// `d`, `b` in floats, in the order in which packets compute them.
fn evaluated(local: &Local, p: f32, q: f32) -> (f32, f32) {
    let splat = |of: &[f32; LANES]| f32x8::splat(of[0]);
    let (p, q) = (f32x8::splat(p), f32x8::splat(q));
    let d0 = splat(&local.d20).mul_add(p, splat(&local.d10));
    let d0 = d0.mul_add(p, splat(&local.d00));
    let d1 = splat(&local.d11).mul_add(p, splat(&local.d01));
    let d = splat(&local.d02).mul_add(q, d1).mul_add(q, d0);
    let b0 = splat(&local.b10).mul_add(p, splat(&local.b00));
    let b = splat(&local.b01).mul_add(q, b0);
    (d.to_array()[0], b.to_array()[0])
}

/// Whether `exact/unit <= value <= exact/unit + spread`, for `unit > 0` or `< 0`.
fn within(value: f32, exact: &Dyadic, unit: &Dyadic, spread: f32) -> bool {
    if value == f32::INFINITY {
        return spread == f32::INFINITY;
    }
    let [value, spread] = [value, spread].map(|float| dyadic(f64::from(float)));
    let sign = if *unit < Dyadic::ZERO { -1.0 } else { 1.0 };
    let above = (value * unit - exact) * dyadic(sign);
    above >= Dyadic::ZERO && above <= spread * unit * dyadic(sign)
}

#[test]
fn local_terms_are_within_their_bounds() {
    let (mut known, mut covering, mut away) = (0, 0, 0);
    each_trial(150_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let lanes = lanes(&trial.sphere);
        let most = Extents::new(&grid, &lanes).most;
        let around = around(trial, most[0], random);
        let local = Local::new::<true>(&grid, &around, &lanes, most, Bounds::Proven);
        let scale = dyadic(around.scale);
        covering += u64::from(local.least[0] > 0.0);
        away += u64::from(local.most[0] < 0.0);
        let of = |lanes: f64x8| lanes.to_array()[0];
        let (middle, half) = (
            [of(around.columns), of(around.rows)],
            [of(around.across), of(around.down)],
        );
        let mut places = vec![[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]];
        let mut any = || {
            let mut side = |half: f64| {
                let steps = random.below(2 * half as u64 + 1) as f64 - half;
                if half > 0.0 { steps / half } else { 0.0 }
            };
            [side(half[0]), side(half[1])]
        };
        places.extend([any(), any()]);
        let mut places: Vec<_> = places
            .into_iter()
            .map(|[p, q]| [(p * half[0]).round(), (q * half[1]).round()])
            .collect();
        places.push([
            f64::from(trial.column) - middle[0],
            f64::from(trial.row) - middle[1],
        ]);
        for [p, q] in places {
            let (column, row) = (middle[0] + p, middle[1] + q);
            let truth = trial.truth_at(column, row);
            if local.d_spread[0].is_finite() {
                known += 1;
                let (d, b) = evaluated(&local, p as f32, q as f32);
                let unit = &truth.c * &truth.z;
                let exact = &truth.d * &scale * &scale;
                if !within(d, &exact, &(&unit * &unit), local.d_spread[0]) {
                    return Err(format!(
                        "D/c^2 at ({p}, {q}): {d:e} - {:e}",
                        local.d_spread[0]
                    ));
                }
                let exact = &truth.b * &scale;
                if !within(b, &exact, &unit, local.spread[0]) {
                    return Err(format!("B/c at ({p}, {q}): {b:e} - {:e}", local.spread[0]));
                }
                if truth.c > Dyadic::ZERO && truth.b <= Dyadic::ZERO {
                    return Err(format!("B <= 0 at ({p}, {q})"));
                }
            }
            let within = |place: f64, side: u32| (0.0..f64::from(side)).contains(&place);
            let size = trial.camera.size();
            let seen = within(column, size.width()) && within(row, size.height());
            if truth.hit() && seen && !truth.at_most(f64::from(local.most[0]), around.scale) {
                return Err(format!("({p}, {q}) is nearer than {:e}", local.most[0]));
            }
            let least = f64::from(local.least[0]);
            if least >= 0.0 && !(truth.hit() && truth.at_least(least, around.scale)) {
                return Err(format!("({p}, {q}) is farther than {least:e}"));
            }
        }
        Ok(())
    });
    assert!(known > 300_000, "only {known} places known");
    assert!(covering > 5_000, "only {covering} tiles covered");
    assert!(away > 5_000, "only {away} spheres away");
}
