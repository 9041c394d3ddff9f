//! The visible spheres of tiles of few spheres, against the decision of each pixel.

use super::{Bounds, Coverage, Record};
use crate::exact::{
    bins::Candidate,
    decide::decide,
    grid::Grid,
    trials::{Random, Trial, each_trial, partner, scale, sphere},
};

/// Some spheres that are visible in the trial's tile, its own among them.
fn records(trial: &Trial, grid: &Grid, random: &mut Random) -> Vec<Record> {
    let count = 1 + random.below(12);
    let mut records = Vec::new();
    for index in 0..count {
        let mut other = *trial;
        if index > 0 {
            other.sphere = match random.below(3) {
                0 => partner(trial, random),
                _ => sphere(random, &trial.camera, trial.column, trial.row),
            };
            let valid = other.lengths().iter().all(|length| length.is_finite());
            if !valid || other.sphere.radius <= 0.0 {
                other.sphere = trial.sphere;
            }
        }
        if let Some(record) = other.record(grid) {
            records.push(Record {
                index: index as u32,
                ..record
            });
        }
    }
    records
}

#[test]
fn what_is_not_contested_is_what_is_seen() {
    let (mut sure, mut contested, mut nothing) = (0, 0, 0);
    let mut coverage = Coverage::default();
    each_trial(8_000, |trial, random| {
        let mut grid = Grid::new(trial.camera);
        if let Some(record) = trial.record(&grid) {
            grid.scale = scale(record.upper, random);
        }
        let records = records(trial, &grid, random);
        let tile = trial.tile();
        coverage.find(&grid, &tile, &records, Bounds::Proven);
        let mut pixels = vec![(trial.column - tile.column, trial.row - tile.row)];
        let (width, height) = (tile.width as u64, tile.last as u64);
        pixels.extend((0..12).map(|_| (random.below(width) as u32, random.below(height) as u32)));
        for (column, row) in pixels {
            let (x, y) = (column as usize, row as usize);
            let place = (tile.column + column, tile.row + row);
            let seen =
                |candidates: &mut Vec<Candidate>| decide(&trial.camera, place, candidates, true).0;
            let meant = seen(&mut records.iter().map(Record::candidate).collect());
            let covers = |at: &&usize| coverage.may_cover(&coverage.spheres[**at], x, y);
            let mut covering = coverage.order.iter().filter(covers);
            let record = |at: &usize| coverage.spheres[*at].record;
            if coverage.contested[y / 8][y % 8] >> x & 1 == 1 {
                contested += 1;
                let candidates = covering.map(|at| record(at).candidate());
                if seen(&mut candidates.collect()) != meant {
                    return Err(format!(
                        "the sphere seen at {place:?} of {records:?} is left out"
                    ));
                }
                continue;
            }
            let drawn = covering.next_back().map(|at| record(at).sphere);
            let meant = records.iter().find(|record| record.index == meant);
            let meant = meant.map(|record| record.sphere);
            sure += u64::from(drawn.is_some());
            nothing += u64::from(drawn.is_none());
            if drawn != meant {
                return Err(format!(
                    "{drawn:?} instead of {meant:?} at {place:?} of {records:?}"
                ));
            }
        }
        Ok(())
    });
    let enough = sure > 10_000 && contested > 1_000 && nothing > 1_000;
    assert!(
        enough,
        "only {sure} sure, {contested} contested, {nothing} of nothing"
    );
}
