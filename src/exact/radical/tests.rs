//! Which of two spheres is nearer, against the decision of each pixel.

use super::{Bounds, Grid, Nearer, NearerColumns, Region, compare};
use crate::{
    exact::{
        bins::{EightRecords, Record},
        decide::decide,
        depths::{Depths, SphereDepths},
        trials::{Random, Trial, each_trial, on_the_surface, partner, scale},
    },
    methods::NONE,
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

#[test]
fn the_nearer_sphere_is_the_one_that_is_seen() {
    let (mut constant, mut varied, mut undecided) = ([0, 0], [0, 0], 0);
    let mut of_powers = [0; 6];
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
        let powers = match [of_first.power, of_second.power] {
            [a, b] if a == 0.0 && b == 0.0 => 0,
            [a, b] if a == b => 1,
            [a, b] if a > 0.0 && b > 0.0 => 2,
            [a, b] if a < 0.0 && b < 0.0 => 3,
            [a, b] if a <= 0.0 && b <= 0.0 => 4,
            _ => 5,
        };
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
