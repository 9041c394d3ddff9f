//! Outlines in rows, against dyadic rationals.

use std::cell::Cell;

use super::{Bounds, Columns, EightRows, Ends, LANES, Outline, Placement, Shape, f64x8, splat};
use crate::{
    camera::{Camera, ImageSize},
    exact::{
        bins::{EightRecords, Record},
        grid::Grid,
        trials::{Dyadic, Random, Trial, each_trial},
    },
    scene::Viewport,
    spheres::Sphere,
};

/// The outline of the trial's sphere in its tile, as tiles of few spheres compute it.
fn placed(trial: &Trial, grid: &Grid, rows: f64x8, down: f64x8) -> Outline {
    let tile = trial.tile();
    let placement = Placement {
        rows,
        down,
        column: tile.column,
        row: tile.row,
    };
    let [outline, ..] = Outline::eight(grid, &placement, &trial.eight(), Bounds::Proven);
    outline
}

/// The record of the trial's sphere, if it has one in the tile; the middle row of its outline and
/// the upper bound of the distance from that row; and the outline.
fn placed_by_box(trial: &Trial, grid: &Grid) -> Option<(Record, [f64x8; 2], Outline)> {
    let record = trial.record(grid)?;
    let rectangles = trial.tile().rectangles(&EightRecords::of(&[record]));
    let (rows, down) = (rectangles.rows, rectangles.down + splat(LANES as f64));
    Some((record, [rows, down], placed(trial, grid, rows, down)))
}

fn is_run(mask: u64) -> bool {
    let run = mask.checked_shr(mask.trailing_zeros()).unwrap_or(0);
    run & run.wrapping_add(1) == 0
}

/// Checks the masks of a row.
fn check_row(
    trial: &Trial,
    eight: &EightRows,
    lane: usize,
    row: f64,
    width: usize,
) -> Result<(), String> {
    let (inner, outer) = (eight.inner[lane], eight.outer[lane]);
    let full = u64::MAX >> (64 - width);
    let column = f64::from(trial.tile().column);
    let hit = |at: u32| trial.truth_at(column + f64::from(at), row).hit();
    let wrong = |what: &str| Err(format!("row {row}, {inner:x} in {outer:x}: {what}"));
    if inner & !outer != 0 || outer & !full != 0 || !is_run(inner) || !is_run(outer) {
        return wrong("no runs of columns");
    }
    let [first, end] = eight.ends[lane].map(u32::from);
    let ends = if outer == 0 {
        (0, 0)
    } else {
        (outer.trailing_zeros(), 64 - outer.leading_zeros())
    };
    if (first, end) != ends && !(first == end && outer == 0) {
        return wrong(&format!("ends {first}..{end}"));
    }
    if inner != 0 && !(hit(inner.trailing_zeros()) && hit(63 - inner.leading_zeros())) {
        return wrong("surely covered, but not hit");
    }
    // The pixels of a row that are hit are one run: pixels missing from the mask would be
    // beside its ends, or anywhere if the mask is empty.
    let asked = if outer == 0 {
        vec![0, width as u32 - 1, (trial.column - trial.tile().column)]
    } else {
        let before = outer.trailing_zeros().checked_sub(1);
        before
            .into_iter()
            .chain([64 - outer.leading_zeros()])
            .collect()
    };
    if asked.into_iter().any(|at| (at as usize) < width && hit(at)) {
        return wrong("hit, but surely not covered");
    }
    Ok(())
}

#[test]
fn masks_hold_what_is_hit_and_no_more() {
    let mut shapes = [0; 4];
    let (mut some, mut doubtful) = (0, 0);
    each_trial(60_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let Some((record, _, outline)) = placed_by_box(trial, &grid) else {
            return Ok(());
        };
        let tile = trial.tile();
        match outline.shape {
            Shape::Between => shapes[0] += 1,
            Shape::From => shapes[1] += 1,
            Shape::UpTo => shapes[2] += 1,
            Shape::Everywhere => shapes[3] += 1,
            // An outline by itself is never that of a box.
            Shape::Box => return Err("a box".into()),
            Shape::Unknown => {}
        }
        let [_, _, top, bottom] = record.sides.map(usize::from);
        let octets = top / LANES..bottom / LANES + 1;
        let mut rows = Vec::new();
        outline.rows(octets.clone(), tile.width, &record, &mut rows);
        if rows.len() != octets.len() {
            return Err(format!("{} octets of {octets:?}", rows.len()));
        }
        let any = top + random.below((bottom - top) as u64 + 1) as usize;
        let own = (trial.row - tile.row) as usize;
        for row in [top, bottom, any, own.clamp(top, bottom)] {
            let eight = &rows[row / LANES - octets.start];
            some += u64::from(eight.inner[row % LANES] != 0);
            doubtful += u64::from(eight.inner[row % LANES] != eight.outer[row % LANES]);
            let at = f64::from(tile.row) + row as f64;
            if outline.shape == Shape::Unknown {
                let columns = eight.outer[row % LANES];
                let column = trial.column - tile.column;
                let hit = trial.truth_at(f64::from(trial.column), at).hit();
                if eight.inner[row % LANES] != 0 || hit && columns >> column & 1 == 0 {
                    return Err(format!("unknown, {columns:x} in row {row}"));
                }
                continue;
            }
            check_row(trial, eight, row % LANES, at, tile.width)?;
        }
        Ok(())
    });
    assert!(
        some > 20_000 && doubtful > 2_000,
        "only {some} rows, {doubtful} in doubt"
    );
    assert!(
        shapes.iter().all(|&count| count > 300),
        "only {shapes:?} shapes"
    );
}

/// A row that nearly touches the outline, up to the last digits, which rows of pixels hardly
/// ever do; or any other row.
fn some_row(trial: &Trial, grid: &Grid, random: &mut Random) -> f64 {
    let last = f64::from(trial.camera.size().height() - 1);
    let [_, y, z] = trial.sphere.centre.map(f64::from);
    let r = f64::from(trial.sphere.radius);
    let q = (z - r) * (z + r);
    let root = r * (y * y + q).max(0.0).sqrt();
    let place = match random.below(4) {
        0 => f64::from(trial.row),
        1 => grid.y_axis.middle - (y * z - root) / q * grid.y_axis.scale,
        2 => grid.y_axis.middle - (y * z + root) / q * grid.y_axis.scale,
        _ => random.between(0.0, last),
    };
    // Its distance from the middle must be a double, like that of a pixel.
    let digits = (50.0 - (last + 1.0).log2().ceil()).exp2();
    let row = (place * digits).round() / digits;
    if (0.0..=last).contains(&row) {
        row
    } else {
        f64::from(trial.row)
    }
}

/// The ends are tested as real columns, not only at the next pixels.
#[test]
fn rows_begin_and_end_at_real_columns() {
    let (mut inner_ends, mut outer_ends, mut none) = (0, 0, 0);
    each_trial(100_000, |trial, random| {
        if trial.camera.size().width() == 1 || trial.camera.size().height() == 1 {
            // There are no real columns or rows beside the only one.
            return Ok(());
        }
        let grid = Grid::new(trial.camera);
        let down = [8.0, 16.0, 40.0][random.below(3) as usize];
        let lane = random.below(LANES as u64) as usize;
        let q = lane as f64 - random.below(down as u64 + 1).min(7) as f64;
        let row = some_row(trial, &grid, random);
        let mut outline = placed(trial, &grid, splat(row - q), splat(down));
        // Rows are counted from the middle, which may lie between two of them here.
        outline.row = (lane as f64 - q) as f32;
        let width = trial.tile().width;
        let seen = Cell::new(None);
        let record = |ends: Ends| {
            let of = |(start, end): (super::f32x8, super::f32x8)| {
                [start.to_array()[lane], end.to_array()[lane]].map(f64::from)
            };
            let bit = |mask: super::f32x8| mask.to_bitmask() >> lane & 1 == 1;
            seen.set(Some((
                of(ends.inner),
                of(ends.outer),
                bit(ends.surely),
                bit(ends.possibly),
            )));
            Ends { ..ends }
        };
        let ahead = if outline.shape == Shape::Between && outline.m_bound > 0.0 {
            outline.ahead(0)
        } else {
            (0xff, 0xff)
        };
        let ahead = [ahead.0, ahead.1].map(|rows| rows >> lane & 1 == 1);
        let rows = match outline.shape {
            Shape::Between => outline.cut(0, width, (0xff, 0xff), |cut| record(real_between(cut))),
            Shape::From => outline.cut(0, width, (0xff, 0xff), |cut| record(real_from(cut))),
            Shape::UpTo => outline.cut(0, width, (0xff, 0xff), |cut| record(real_up_to(cut))),
            Shape::Everywhere | Shape::Box | Shape::Unknown => return Ok(()),
        };
        let _ = rows;
        let (inner, outer, surely, possibly) = seen.get().expect("ends");
        let column = f64::from(trial.tile().column);
        let truth = |at: f64| trial.truth_at(column + at, row);
        // Only columns whose sum with that of the tile is a double are tested.
        let near = |at: f64| at.abs() < 900.0 && (column + at) - column == at;
        if surely && ahead[0] && inner[0] <= inner[1] {
            for at in inner.into_iter().filter(|&at| near(at)) {
                inner_ends += 1;
                if !truth(at).hit() {
                    return Err(format!("row {row}: {at:e} of {inner:?} is not hit"));
                }
            }
        }
        if possibly && ahead[1] && outer[0] <= outer[1] {
            for at in [(outer[0] as f32).next_down(), (outer[1] as f32).next_up()]
                .map(f64::from)
                .into_iter()
                .filter(|&at| near(at))
            {
                outer_ends += 1;
                if truth(at).hit() {
                    return Err(format!("row {row}: {at:e} beside {outer:?} is hit"));
                }
            }
        } else if truth(f64::from(trial.column) - column).hit() {
            return Err(format!("row {row}: hit, but not possibly"));
        } else {
            none += 1;
        }
        Ok(())
    });
    assert!(inner_ends > 5_000, "only {inner_ends} inner ends");
    assert!(outer_ends > 5_000, "only {outer_ends} outer ends");
    assert!(none > 100, "only {none} rows beside");
}

fn all() -> super::f32x8 {
    super::f32x8::splat(f32::from_bits(u32::MAX))
}

/// As `Outline::between`, without rounding to whole columns; likewise the others.
fn real_between(cut: &super::Cut) -> Ends {
    let zero = super::f32x8::splat(0.0);
    Ends {
        inner: (cut.high - cut.inner, cut.low + cut.inner),
        outer: (cut.low - cut.outer, cut.high + cut.outer),
        surely: cut.sure.simd_gt(zero),
        possibly: cut.possible.simd_ge(zero),
    }
}

fn real_from(cut: &super::Cut) -> Ends {
    let far = super::f32x8::splat(super::FAR);
    Ends {
        inner: (cut.high + cut.outer, far),
        outer: (cut.low + cut.inner, far),
        surely: all(),
        possibly: all(),
    }
}

fn real_up_to(cut: &super::Cut) -> Ends {
    let near = super::f32x8::splat(-super::FAR);
    Ends {
        inner: (near, cut.low - cut.outer),
        outer: (near, cut.high - cut.inner),
        surely: all(),
        possibly: all(),
    }
}

type FindEnds = fn(&super::Cut) -> Ends;

/// The ends in the test above are those that are rounded to columns.
#[test]
fn real_ends_are_those_of_the_masks() {
    each_trial(20_000, |trial, _| {
        let grid = Grid::new(trial.camera);
        let row = splat(f64::from(trial.row));
        let outline = placed(trial, &grid, row, splat(8.0));
        let (first, width) = (0, trial.tile().width);
        let pairs: [(FindEnds, FindEnds); 3] = [
            (Outline::between, real_between),
            (Outline::from, real_from),
            (Outline::up_to, real_up_to),
        ];
        for (whole, real) in pairs {
            let one = outline.cut(first, width, (0xff, 0xff), whole);
            let other = outline.cut(first, width, (0xff, 0xff), |cut| {
                let Ends {
                    inner,
                    outer,
                    surely,
                    possibly,
                } = real(cut);
                Ends {
                    inner: (inner.0.ceil(), inner.1.floor()),
                    outer: (outer.0.ceil(), outer.1.floor()),
                    surely,
                    possibly,
                }
            });
            if one.inner != other.inner || one.outer != other.outer {
                return Err(format!("{one:?} and {other:?}"));
            }
        }
        Ok(())
    });
}

/// The farthest visible point is the point of contact that is farthest from the axis.
#[test]
fn no_hit_is_farther_than_the_lower_bound() {
    let mut farthest = 0;
    each_trial(60_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let outline = placed(trial, &grid, splat(f64::from(trial.row)), splat(8.0));
        let [x, y, z] = trial.sphere.centre.map(f64::from);
        let r = f64::from(trial.sphere.radius);
        if z <= r && outline.lower != 0.0 {
            return Err(format!(
                "{:e} of a sphere that is not before the camera",
                outline.lower
            ));
        }
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
        let place = (
            grid.x_axis.middle + x * grid.x_axis.scale,
            grid.y_axis.middle - y * grid.y_axis.scale,
        );
        let places = [(f64::from(trial.column), f64::from(trial.row)), place];
        for (column, row) in places {
            if !column.is_finite() || !row.is_finite() {
                continue;
            }
            let truth = trial.truth_at(column, row);
            if truth.hit() && outline.lower > 0.0 {
                farthest += 1;
                if !truth.at_least(f64::from(outline.lower), 1.0) {
                    return Err(format!(
                        "({column:e}, {row:e}) is farther than {:e}",
                        outline.lower
                    ));
                }
            }
        }
        Ok(())
    });
    assert!(farthest > 10_000, "only {farthest} hits");
}

#[test]
fn everywhere_is_where_the_camera_is_inside() {
    each_trial(20_000, |trial, _| {
        let grid = Grid::new(trial.camera);
        let outline = placed(trial, &grid, splat(f64::from(trial.row)), splat(8.0));
        let inside = trial.truth().c < Dyadic::ZERO;
        if inside == (outline.shape == Shape::Everywhere) {
            Ok(())
        } else {
            Err(format!("{:?}", outline.shape))
        }
    });
}

#[test]
fn columns_are_masks_of_their_ends() {
    use super::f32x8;
    for start in -3_i32..=66 {
        for end in -3_i32..=66 {
            for width in [1, 2, 33, 63, 64] {
                let ends = (f32x8::splat(start as f32), f32x8::splat(end as f32));
                let columns = Columns::new(ends, all(), 0b1011_1111, width);
                let within = |at: i32| (start..=end).contains(&at) && (at as usize) < width;
                let mask = (0..64).fold(0, |mask, at| mask | u64::from(within(at)) << at);
                let masks = columns.masks();
                assert_eq!(masks[0], mask, "{start}..={end} of {width}");
                assert_eq!(masks[6], 0, "{start}..={end} of {width}");
                let [first, last] = columns.ends()[0].map(u32::from);
                if mask == 0 {
                    assert_eq!(first, last, "{start}..={end} of {width}");
                } else {
                    assert_eq!(first, mask.trailing_zeros(), "{start}..={end} of {width}");
                    assert_eq!(
                        last,
                        64 - mask.leading_zeros(),
                        "{start}..={end} of {width}"
                    );
                }
            }
        }
    }
}

/// Ends are used if their error is at most a quarter of a pixel.
#[test]
fn ends_are_known_up_to_a_quarter_of_a_pixel() {
    let (mut nearly, mut beyond) = (0, 0);
    for step in 0..200 {
        let width = (400_000.0 * 1.01_f64.powi(step)) as u32;
        let mut trial = Trial::new(0);
        trial.sphere = Sphere {
            centre: [0.0, 0.0, 10.0],
            radius: 3.0,
            colour: [0; 3],
        };
        let viewport = Viewport {
            width: 1.0,
            height: 1.0,
            distance: 1.0,
        };
        let size = ImageSize::of_sides(width, width);
        trial.camera = Camera::new(viewport, size);
        (trial.column, trial.row) = (width / 2, width / 2);
        let grid = Grid::new(trial.camera);
        let outline = placed(&trial, &grid, splat(f64::from(trial.row)), splat(40.0));
        assert_eq!(outline.shape == Shape::Between, outline.slack < 0.25);
        nearly += u32::from((0.126..0.25).contains(&outline.slack));
        beyond += u32::from(outline.slack > 0.25);
    }
    assert!(
        nearly > 20 && beyond > 20,
        "{nearly} nearly, {beyond} beyond"
    );
}

/// The bounds of theorem 2, from the outline's own coefficients, in the order of the proof.
#[test]
fn bounds_of_rows_have_all_terms() {
    use crate::exact::bounds::{
        COEFFICIENT_BOUND, CROSS_BOUND, FACTOR_BOUND, MIDDLE_BOUND, ROW_BOUND, ROW_END_BOUND,
        ROW_SQUARE_BOUND, U, UNDERFLOW_BOUND,
    };
    let mut compared = 0;
    each_trial(30_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let mut trial = *trial;
        let (rows, down, outline) = if random.below(3) == 0 {
            // So small, and its middle so near to a row, that the error of N is as great as N.
            trial.sphere.radius *= random.power(10.0, -12.0, -2.0) as f32;
            let [_, y, z] = trial.sphere.centre.map(f64::from);
            let middle = grid.y_axis.middle - y / z * grid.y_axis.scale;
            let (row, down) = (splat(middle), splat(8.0));
            (row, down, placed(&trial, &grid, row, down))
        } else {
            let Some((_, [rows, down], outline)) = placed_by_box(&trial, &grid) else {
                return Ok(());
            };
            (rows, down, outline)
        };
        let tile = trial.tile();
        if outline.shape != Shape::Between {
            return Ok(());
        }
        let [x, y, z] = trial.sphere.centre.map(f64::from);
        let r = f64::from(trial.sphere.radius);
        let y0 = grid.y_axis.y(rows).to_array()[0];
        let (t, dy) = (down.to_array()[0], grid.y_axis.step);
        let magnitude = |of: f32| f64::from(of.abs());
        let ([e0, e1, e2], [m0, m1]) = (outline.e.map(magnitude), outline.m.map(magnitude));

        let y_upper = y0.abs() + t * dy;
        let n_upper = (y - z * y0).abs() + z.abs() * dy * t;
        let n_bound = CROSS_BOUND * (y.abs() + z.abs() * y0.abs());
        let squares = r * r * (1.0 + y_upper * y_upper) + n_upper * n_upper;
        let k = y * y + z * z - r * r;
        let h = grid.x_axis.scale / k;
        let factor = (x * x + k) * h * h;
        let k_bound = 2.0 * U + U * (y * y + z * z) / k;
        let factor_bound = 4.0 * k_bound + FACTOR_BOUND;
        let e_upper = e0 + t * e1 + t * t * e2;
        let e_bound = factor
            * (COEFFICIENT_BOUND * squares + 2.0 * n_upper * n_bound + n_bound * n_bound)
            + (factor_bound + ROW_SQUARE_BOUND) * e_upper
            + UNDERFLOW_BOUND;
        let level_upper = y.abs() * y_upper + z.abs();
        let columns = grid.x_axis.middle + f64::from(tile.column);
        let middle =
            (k_bound + MIDDLE_BOUND) * (h * x).abs() * level_upper + MIDDLE_BOUND * columns;
        let sides = m0 + t * m1 + (e_upper + e_bound).sqrt();
        let slack = middle + ROW_END_BOUND * (sides + 64.0);
        let m_bound = if z > r { 0.0 } else { ROW_BOUND * level_upper };
        for (what, bound, expected) in [
            ("E", f64::from(outline.e_bound), e_bound),
            ("ends", f64::from(outline.slack), slack),
            ("m", outline.m_bound, m_bound),
        ] {
            // The bounds in floats are greater only by what is added for their own roundings.
            if (1e-30..1e30).contains(&expected) {
                compared += 1;
                let ratio = bound / expected;
                if !(1.0..1.0 + 2e-5).contains(&ratio) {
                    return Err(format!("bound of {what}: {bound:e}, not {expected:e}"));
                }
            }
        }
        Ok(())
    });
    assert!(compared > 5_000, "only {compared} bounds");
}
