//! Which of two spheres is nearer, against the decision of each pixel.

use super::{
    Bounds, CANCELLATION_LIMIT, GREATEST_SIDE, Grid, LANES, Nearer, NearerColumns, PLANE_ROUNDINGS,
    PLANE_SIDE_BOUND, PLANE_TERMS_BOUND, POWERS_CANCELLATION_LIMIT, PowerBetween, SIDE, SIDE_BOUND,
    UNDERFLOW_BOUND, common_sides, compare,
};
use crate::{
    camera::{Camera, ImageSize},
    exact::{
        bins::{EightRecords, Record},
        bounds::POWER_BOUND,
        decide::decide,
        depths::{Depths, SphereDepths},
        trials::{Dyadic, Random, Trial, dyadic, each_trial, on_the_surface, partner, scale},
    },
    methods::NONE,
    scene::Viewport,
    spheres::Sphere,
};

/// Both spheres in the trial's tile, if both may be visible there.
fn pair(trial: &Trial, grid: &Grid, random: &mut Random) -> Option<[Record; 2]> {
    let mut trial = *trial;
    if random.below(8) == 0 {
        trial.sphere = on_the_surface(random);
    }
    let other = Trial {
        sphere: partner(&trial, random),
        ..trial
    };
    let lengths = other.lengths();
    let valid = lengths.iter().all(|length| length.is_finite()) && lengths[3] > 0.0;
    let mut records = [trial.record(grid)?, other.record(grid).filter(|_| valid)?];
    records[1].index = 1;
    if random.below(2) == 0 {
        records.reverse();
    }
    Some(records)
}

fn depths(trial: &Trial, grid: &Grid, record: &Record) -> SphereDepths {
    let tile = trial.tile();
    let eight = EightRecords::of(&[*record]);
    let depths = Depths::new(grid, &tile.rectangles(&eight), &eight.spheres);
    depths.of_sphere(0, &eight.spheres, (tile.column, tile.row), Bounds::Proven)
}

/// Two spheres whose boxes in the trial's tile have pixels in common.
struct Meeting {
    grid: Grid,
    region: [usize; 4],
    records: [Record; 2],
    depths: [SphereDepths; 2],
    nearer: Nearer,
}

impl Meeting {
    fn of(trial: &Trial, random: &mut Random) -> Option<Self> {
        let mut grid = Grid::new(trial.camera);
        let records = pair(trial, &grid, random)?;
        grid.scale = scale(records[0].upper, random);
        let region = common_sides(&records[0], &records[1])?;
        let depths = records.map(|record| depths(trial, &grid, &record));
        let nearer = compare(&grid, Bounds::Proven, region, &depths[0], &depths[1]);
        Some(Self {
            grid,
            region,
            records,
            depths,
            nearer,
        })
    }
}

#[test]
fn the_nearer_sphere_is_the_one_that_is_seen() {
    let (mut constant, mut varied, mut undecided) = ([0, 0], [0, 0], 0);
    let mut of_powers = [0; 6];
    each_trial(40_000, |trial, random| {
        let Some(meeting) = Meeting::of(trial, random) else {
            return Ok(());
        };
        let (region, nearer) = (meeting.region, meeting.nearer);
        let [first, second] = meeting.records;
        let powers = match meeting.depths.map(|depths| depths.power) {
            [a, b] if a == 0.0 && b == 0.0 => 0,
            [a, b] if a == b => 1,
            [a, b] if a > 0.0 && b > 0.0 => 2,
            [a, b] if a < 0.0 && b < 0.0 => 3,
            [a, b] if a <= 0.0 && b <= 0.0 => 4,
            _ => 5,
        };
        let mut columns = NearerColumns::default();
        match nearer {
            Nearer::First => columns.first.fill(u64::MAX),
            Nearer::Second => columns.second.fill(u64::MAX),
            Nearer::Varies(seam) => seam.columns(&mut columns),
            Nearer::Unknown => return Ok(()),
        }
        let tile = trial.tile();
        let [left, right, top, bottom] = region;
        let row = ((trial.row - tile.row) as usize).clamp(top, bottom);
        for column in left..right + 1 {
            let place = tile.pixel(column, row);
            let seen = |records: &[Record]| {
                let candidates: Vec<_> = records.iter().map(Record::candidate).collect();
                decide(&trial.camera, place, &candidates, true).0
            };
            if seen(&[first]) == NONE || seen(&[second]) == NONE {
                continue;
            }
            let of_row = [columns.first[row], columns.second[row]];
            let said = of_row.map(|columns| columns >> column & 1 == 1);
            let counts = match nearer {
                Nearer::Varies(_) => &mut varied,
                _ => &mut constant,
            };
            let meant = match said {
                [true, false] => first.index,
                [false, true] => second.index,
                [false, false] => {
                    undecided += 1;
                    continue;
                }
                [true, true] => return Err("both are nearer".into()),
            };
            counts[usize::from(said[1])] += 1;
            of_powers[powers] += 1;
            // Of spheres that are equally near, the first of the file would be seen.
            let mut exchanged = [first, second];
            exchanged[0].index = 1 - first.index;
            exchanged[1].index = 1 - second.index;
            if seen(&[first, second]) != meant || seen(&exchanged) != 1 - meant {
                return Err(format!(
                    "{meant} is not nearer at {place:?}: {first:?}, {second:?}, {nearer:?}"
                ));
            }
        }
        Ok(())
    });
    let enough = constant.iter().chain(&varied).all(|&count| count > 4_000) && undecided > 100;
    assert!(enough, "only {constant:?}, {varied:?}, {undecided}");
    // Of both on the surface, of the same power, outside, inside, one on the surface, and apart.
    assert!(
        of_powers.iter().all(|&count| count > 500),
        "only {of_powers:?}"
    );
}

/// The exact `c' - c` of the second sphere and the first.
fn exact_difference(first: &Record, second: &Record) -> Dyadic {
    let power = |record: &Record| {
        let [x, y, z, r] = record.sphere.map(|length| dyadic(f64::from(length)));
        &x * &x + &y * &y + &z * &z - &r * &r
    };
    power(second) - power(first)
}

/// The sign of a difference beyond its limit is right, and its error is at most `2^-27` of it; one
/// within its limit is below twice the limit. The limit is the lower one of two.
#[test]
fn differences_of_powers_are_known_beyond_their_limits() {
    let (mut beyond, mut within) = ([0, 0], 0);
    each_trial(40_000, |trial, random| {
        let grid = Grid::new(trial.camera);
        let Some([first, second]) = pair(trial, &grid, random) else {
            return Ok(());
        };
        let [of_first, of_second] = [first, second].map(|record| depths(trial, &grid, &record));
        let PowerBetween {
            difference,
            limit,
            error: bound,
        } = PowerBetween::new(&of_first, &of_second);
        let terms = (0..4).map(|at| {
            let [a, b] = [first.sphere[at], second.sphere[at]].map(f64::from);
            ((b - a) * (b + a)).abs()
        });
        let of_terms = CANCELLATION_LIMIT * terms.sum::<f64>();
        let powers = of_first.power.abs() + of_second.power.abs();
        let of_powers = POWERS_CANCELLATION_LIMIT * powers;
        let least = of_terms.min(of_powers);
        if (limit - least).abs() > 1e-9 * least {
            return Err(format!("a limit of {limit:e}, not of {least:e}"));
        }
        let exact = exact_difference(&first, &second);
        let error = dyadic(difference) - &exact;
        let bound = dyadic(bound);
        if &error * &error > &bound * &bound {
            return Err(format!("{difference:e}, wrong by more than {bound:?}"));
        }
        let most = if difference.abs() > limit {
            beyond[usize::from(of_powers < of_terms)] += 1;
            dyadic(difference * (-27.0_f64).exp2())
        } else {
            within += u64::from(limit > 0.0);
            dyadic(2.0 * limit)
        };
        let compared = if difference.abs() > limit {
            error
        } else {
            exact
        };
        if &compared * &compared <= &most * &most {
            Ok(())
        } else {
            Err(format!(
                "{difference:e} with a limit of {limit:e}: {first:?}, {second:?}"
            ))
        }
    });
    let enough = beyond.iter().all(|&count| count > 500) && within > 500;
    assert!(enough, "only {beyond:?} beyond, {within} within");
}

/// The bounds of theorem 10, from the numbers of both spheres, in the order of the proof.
#[test]
fn bounds_of_sides_have_all_terms() {
    let (mut compared, mut shrunk, mut cancelled) = ([0, 0], 0, 0);
    each_trial(30_000, |trial, random| {
        let Some(Meeting {
            grid,
            records: [first, second],
            depths: [of_first, of_second],
            nearer: Nearer::Varies(seam),
            ..
        }) = Meeting::of(trial, random)
        else {
            return Ok(());
        };
        // Of two spheres before the camera the one of less power is tested.
        let PowerBetween {
            difference,
            limit,
            error,
        } = PowerBetween::new(&of_first, &of_second);
        if !(of_first.power > 0.0 && of_second.power > 0.0) {
            return Ok(());
        }
        let (tested, other) = if difference > 0.0 {
            (&of_first, &of_second)
        } else {
            (&of_second, &of_first)
        };
        let flat = difference.abs() <= limit;
        let unit = grid.scale * grid.scale;
        let power = if flat { unit } else { difference.abs() };
        let greatest = |sphere: &SphereDepths| sphere.b_terms + sphere.d_upper.sqrt();
        let more = if flat {
            2.0 * limit * greatest(tested).max(greatest(other)) / unit
        } else {
            0.0
        };
        let (b_terms, d_bound) = if flat {
            (0.0, 0.0)
        } else {
            (tested.b_terms, tested.d_bound)
        };
        let apart = |axis: usize| (other.sphere[axis] - tested.sphere[axis]).abs();
        let x_upper = tested.x0.abs() + tested.across * grid.x_axis.step;
        let y_upper = tested.y0.abs() + tested.down * grid.y_axis.step;
        let of_plane =
            2.0 * grid.scale / power * (apart(0) * x_upper + apart(1) * y_upper + apart(2));
        let terms = of_plane + b_terms;
        // Of the difference of powers, of the power in `b`, and of the arithmetic.
        let of_power = if flat { 0.0 } else { error / power };
        let [_, y, z, _] = tested.sphere;
        let of_b = POWER_BOUND * (1.0 + 2.0 * (y * y + z * z) / tested.power);
        let sharp = of_power * of_plane + of_b * b_terms + PLANE_ROUNDINGS * terms;
        let unit_of_side = (GREATEST_SIDE / terms).log2().floor().exp2().min(1.0);
        let [terms, sharp, more] = [terms, sharp, more].map(|value| value * unit_of_side);
        let d_bound = d_bound * unit_of_side * unit_of_side;
        let [l0, l1, l2] = seam.l.map(|of| f64::from(of.abs()));
        let upper = l0 + tested.across * l1 + tested.down * l2;
        let in_floats = PLANE_SIDE_BOUND * upper;
        let of_terms = PLANE_TERMS_BOUND * terms;
        let cancels = of_terms > in_floats;
        let of_terms = if cancels {
            of_terms.min(sharp)
        } else {
            of_terms
        };
        let l_bound = in_floats + of_terms + UNDERFLOW_BOUND + more;
        let upper = upper + l_bound;
        let bound = d_bound + (2.0 * l_bound + SIDE_BOUND * upper) * upper + UNDERFLOW_BOUND;
        if !(1e-30..1e38).contains(&bound) {
            return Ok(());
        }
        shrunk += u64::from(unit_of_side < 1.0);
        cancelled += u64::from(cancels);
        // What is looked at is what is compared: `l` is `2 (C' - C).V/g` in the plane.
        if flat {
            let across = 2.0 * apart(0) * grid.x_axis.step / grid.scale * unit_of_side;
            if across > 1e-30 && (l1 - across).abs() > 1e-6 * across {
                return Err(format!("{l1:e} instead of {across:e} across"));
            }
        }
        compared[usize::from(flat)] += 1;
        let ratio = f64::from(seam.bound) / bound;
        if (1.0 - 1e-6..1.0 + 1e-5).contains(&ratio) {
            Ok(())
        } else {
            Err(format!(
                "{:e} instead of {bound:e}: {first:?}, {second:?}",
                seam.bound
            ))
        }
    });
    assert!(
        compared.iter().all(|&count| count > 300) && shrunk > 100 && cancelled > 100,
        "only {compared:?}, {shrunk}, {cancelled}"
    );
}

/// All pixels of a tile.
const ALL: [usize; 4] = [0, SIDE - 1, 0, SIDE - 1];

/// Two spheres in a tile that is all of the picture.
fn two(centres: [[f32; 3]; 2], radii: [f32; 2]) -> (Grid, [SphereDepths; 2]) {
    let viewport = Viewport {
        width: 1.0,
        height: 1.0,
        distance: 1.0,
    };
    let size = ImageSize::new(SIDE as u32, SIDE as u32).expect("a size");
    let camera = Camera::new(viewport, size);
    let grid = Grid::new(camera);
    let depths = [0, 1].map(|at| {
        let sphere = Sphere {
            centre: centres[at],
            radius: radii[at],
            colour: [0; 3],
        };
        let trial = Trial {
            camera,
            sphere,
            column: 0,
            row: 0,
        };
        depths(&trial, &grid, &trial.record(&grid).expect("a box"))
    });
    (grid, depths)
}

/// The walls of two spheres around the camera are told apart as a whole in regions that are not
/// close to where they change places.
#[test]
fn which_of_two_walls_is_nearer_is_known_in_whole_regions() {
    let (grid, [one, other]) = two([[0.0, 0.0, 0.0], [-0.75, 0.0, 0.25]], [2.0, 1.9]);
    let mut columns = NearerColumns::default();
    let Nearer::Varies(seam) = compare(&grid, Bounds::Proven, ALL, &one, &other) else {
        panic!("they do not change places");
    };
    seam.columns(&mut columns);
    let all_of = |of: &[u64; SIDE], bits: u64| of.iter().all(|row| row & bits == bits);
    let mut constant = [0, 0];
    for left in (LANES..SIDE - LANES).step_by(LANES) {
        let region = [left, left + LANES - 1, 0, SIDE - 1];
        let nearer = compare(&grid, Bounds::Proven, region, &one, &other);
        // With eight columns on either side.
        let around = 0xff_ffff << (left - LANES);
        if all_of(&columns.first, around) {
            assert!(matches!(nearer, Nearer::First), "{region:?}: {nearer:?}");
            constant[0] += 1;
        } else if all_of(&columns.second, around) {
            assert!(matches!(nearer, Nearer::Second), "{region:?}: {nearer:?}");
            constant[1] += 1;
        }
    }
    assert!(constant.iter().all(|&count| count > 0), "{constant:?}");
}

/// However close they are: the plane is then far beyond all floats.
#[test]
fn which_of_two_is_nearer_is_known_of_the_closest_spheres() {
    for exponent in 8..150 {
        let apart = 2_f64.powi(-exponent) as f32;
        let (grid, [left_one, right_one]) = two([[0.0, 0.0, 10.0], [apart, 0.0, 10.0]], [8.0; 2]);
        let Nearer::Varies(seam) = compare(&grid, Bounds::Proven, ALL, &left_one, &right_one)
        else {
            panic!("2^-{exponent}: they do not change places");
        };
        let mut nearer = NearerColumns::default();
        seam.columns(&mut nearer);
        let left_half = u64::MAX >> (SIDE / 2);
        assert_eq!(nearer.first, [left_half; SIDE], "2^-{exponent}");
        assert_eq!(nearer.second, [!left_half; SIDE], "2^-{exponent}");
    }
}

/// Wherever the camera is.
#[test]
fn a_sphere_within_another_one_is_told_apart_in_the_whole_tile() {
    for (z, inner_is_nearer) in [(1.75, false), (0.0, true), (0.5, true)] {
        let centres = [[0.0, 0.0, z], [0.25, -0.125, z]];
        let (grid, [inner, outer]) = two(centres, [1.0, 1.5]);
        let nearer = compare(&grid, Bounds::Proven, ALL, &inner, &outer);
        let said = matches!(nearer, Nearer::First) == inner_is_nearer
            && matches!(nearer, Nearer::Second) != inner_is_nearer;
        assert!(said, "z = {z}: {nearer:?}");
    }
}

/// In every pixel of any region but those where the two change places.
#[test]
fn which_of_two_is_nearer_is_known_beside_the_plane() {
    let (grid, [left_one, right_one]) = two([[-0.5, 0.0, 10.0], [0.5, 0.0, 10.0]], [8.0; 2]);
    let (before, after) = (SIDE / 2 - 1, SIDE / 2);
    let full = |from: usize, to: usize| u64::MAX >> (SIDE - 1 - to) & u64::MAX << from;
    for first in 0..SIDE {
        for last in first..SIDE {
            let (top, bottom) = (SIDE - 1 - last, SIDE - 1 - first);
            let region = [first, last, top, bottom];
            match compare(&grid, Bounds::Proven, region, &left_one, &right_one) {
                Nearer::First => assert!(last <= before, "{region:?}"),
                Nearer::Second => assert!(first >= after, "{region:?}"),
                Nearer::Unknown => panic!("{region:?} is unknown"),
                Nearer::Varies(seam) => {
                    assert!(first <= before && last >= after, "{region:?}");
                    let mut nearer = NearerColumns::default();
                    nearer.first.fill(u64::MAX);
                    nearer.second.fill(u64::MAX);
                    seam.columns(&mut nearer);
                    let octets = top / LANES * LANES..(bottom / LANES + 1) * LANES;
                    for row in octets {
                        let said = [nearer.first[row], nearer.second[row]];
                        if !(top..=bottom).contains(&row) {
                            assert_eq!(said, [0, 0], "row {row} of {region:?}");
                            continue;
                        }
                        let asked = full(first, last);
                        let expected = [asked & full(0, before), asked & full(after, SIDE - 1)];
                        assert_eq!(
                            said.map(|of| of & asked),
                            expected,
                            "row {row} of {region:?}"
                        );
                    }
                }
            }
        }
    }
}
