//! Which of two spheres is nearer, against the decision of each pixel.

use super::{Bounds, Grid, Nearer, NearerColumns, Region, compare};
use crate::{
    exact::{
        bins::{EightRecords, Record},
        decide::decide,
        depths::{Depths, SphereDepths},
        trials::{Random, Trial, each_trial, scale, sphere},
    },
    methods::NONE,
    spheres::Sphere,
};

/// Another sphere that is near the trial's own, or seen near it.
fn partner(trial: &Trial, random: &mut Random) -> Sphere {
    let mut other = trial.sphere;
    let [x, y, z] = other.centre;
    let radius = other.radius;
    let nudge = |length: f32, random: &mut Random| {
        let steps = random.below(5) as i32 - 2;
        f32::from_bits(length.to_bits().wrapping_add_signed(steps))
    };
    match random.below(8) {
        0 => return sphere(random, &trial.camera, trial.column, trial.row),
        1 => other.radius *= random.between(0.5, 1.5) as f32,
        2 => {
            let moved = |length: f32| length + random.between(-1.5, 1.5) as f32 * radius;
            other.centre = [x, y, z].map(moved);
        }
        3 => {
            other.centre = [x, y, z].map(|length| nudge(length, random));
            other.radius = nudge(radius, random);
        }
        // The same power, so that the camera is in the radical plane.
        4 => other.centre = [-x, y, z],
        5 => other.centre = [y, x, z],
        6 => return on_the_surface(random),
        // Almost the same power.
        _ => other.centre = [-x, nudge(y, random), nudge(z, random)],
    }
    other
}

/// A sphere on whose surface the camera is, exactly.
fn on_the_surface(random: &mut Random) -> Sphere {
    let lengths = [[3, 4, 12, 13], [1, 2, 2, 3], [2, 3, 6, 7], [8, 9, 12, 17]];
    let [x, y, z, radius] = lengths[random.below(4) as usize];
    let turned = [[x, y, z], [y, z, x], [z, x, y]][random.below(3) as usize];
    let times = (1 + random.below(4)) as f32;
    Sphere {
        centre: turned.map(|length| (random.sign() as f32) * times * length as f32),
        radius: times * radius as f32,
        colour: [0; 3],
    }
}

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

#[test]
fn the_nearer_sphere_is_the_one_that_is_seen() {
    let (mut constant, mut varied, mut open) = ([0, 0], [0, 0], 0);
    each_trial(40_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        let Some([first, second]) = pair(trial, &grid, random) else {
            return Ok(());
        };
        grid.scale = scale(first.upper, random);
        let Some(region) = Region::of(&first, &second) else {
            return Ok(());
        };
        let [of_first, of_second] = [first, second].map(|record| depths(trial, &grid, &record));
        let nearer = compare(&grid, Bounds::Proven, region, &of_first, &of_second);
        let mut columns = NearerColumns::default();
        match nearer {
            Nearer::First => columns.first.fill(u64::MAX),
            Nearer::Second => columns.second.fill(u64::MAX),
            Nearer::Varies(seam) => seam.columns(&mut columns),
            Nearer::Unknown => return Ok(()),
        }
        let tile = trial.tile();
        let row = ((trial.row - tile.row) as usize).clamp(region.top, region.bottom);
        for column in region.left..region.right + 1 {
            let place = tile.pixel(column, row);
            let seen = |records: &[Record]| {
                let mut candidates: Vec<_> = records.iter().map(Record::candidate).collect();
                decide(&trial.camera, place, &mut candidates, true).0
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
                    open += 1;
                    continue;
                }
                [true, true] => return Err("both are nearer".into()),
            };
            counts[usize::from(said[1])] += 1;
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
    let enough = constant.iter().chain(&varied).all(|&count| count > 4_000) && open > 100;
    assert!(enough, "only {constant:?}, {varied:?}, {open}");
}
