//! The visible spheres of tiles of few spheres, against the decision of each pixel.

use super::{Bounds, Coverage, Record};
use crate::exact::{
    bins::Candidate,
    decide::decide,
    grid::Grid,
    trials::{Random, Trial, each_trial, scale, sphere},
};

/// Some spheres that are visible in the trial's tile, its own among them.
fn records(trial: &Trial, grid: &Grid, random: &mut Random) -> Vec<Record> {
    let count = 1 + random.below(12);
    let mut records = Vec::new();
    for index in 0..count {
        let mut other = *trial;
        if index > 0 {
            other.sphere = match random.below(3) {
                0 => {
                    let mut twin = trial.sphere;
                    twin.radius *= random.between(0.5, 1.0) as f32;
                    twin
                }
                _ => sphere(random, &trial.camera, trial.column, trial.row),
            };
            other.sphere.radius = other.sphere.radius.max(f32::from_bits(1));
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
            if coverage.contested[y / 8][y % 8] >> x & 1 == 1 {
                contested += 1;
                continue;
            }
            let covers = |at: &&usize| coverage.may_cover(&coverage.spheres[**at], x, y);
            let nearest = coverage.order.iter().rev().find(covers);
            let drawn = nearest.map(|&at| coverage.spheres[at].record.sphere);
            let mut candidates: Vec<Candidate> = records.iter().map(Record::candidate).collect();
            let place = (tile.column + column, tile.row + row);
            let (seen, _) = decide(&trial.camera, place, &mut candidates, true);
            let meant = records.iter().find(|record| record.index == seen);
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
