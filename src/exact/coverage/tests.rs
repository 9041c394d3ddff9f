//! The visible spheres of tiles of few spheres, against the decision of each pixel.

use super::{Bounds, Coverage, Covering, LANES, Record, SIDE, Tile};
use crate::{
    camera::{Camera, ImageSize},
    exact::{
        bins::{Candidate, EightRecords},
        decide::decide,
        grid::Grid,
        trials::{Random, Trial, each_trial, partner, scale, sphere},
    },
    scene::Viewport,
    spheres::Sphere,
};

/// Some spheres that are visible in the trial's tile, its own among them.
/// Whether a sphere may be visible in a pixel.
fn may_cover(coverage: &Coverage, covering: &Covering, column: usize, row: usize) -> bool {
    let octets = covering.octets();
    octets.contains(&(row / LANES)) && coverage.outer(covering, row) >> column & 1 == 1
}

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
        contested_pixels_are_those_of_their_spheres(&coverage)?;
        let mut pixels = vec![(trial.column - tile.column, trial.row - tile.row)];
        let (width, height) = (tile.width as u64, tile.last as u64);
        pixels.extend((0..12).map(|_| (random.below(width) as u32, random.below(height) as u32)));
        for (column, row) in pixels {
            let (x, y) = (column as usize, row as usize);
            let place = (tile.column + column, tile.row + row);
            let seen =
                |candidates: Vec<Candidate>| decide(&trial.camera, place, &candidates, true).0;
            let meant = seen(records.iter().map(Record::candidate).collect());
            let covers = |at: &&usize| may_cover(&coverage, &coverage.spheres[**at], x, y);
            let mut covering = coverage.order.iter().filter(covers);
            let record = |at: &usize| coverage.spheres[*at].record;
            if coverage.contested[y / 8][y % 8] >> x & 1 == 1 {
                contested += 1;
                let candidates = covering.map(|at| record(at).candidate());
                if seen(candidates.collect()) != meant {
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

/// A sphere that touches the plane of the camera in a row, or almost: `k` has cancelled.
fn sphere_of_unknown_outline(random: &mut Random) -> Sphere {
    let radius = random.power(10.0, -2.0, 4.0);
    let [_, y, z] = random.direction();
    let length = y.hypot(z).max(1e-9);
    let aside = random.sign() * radius * random.power(10.0, -3.0, 0.5);
    Sphere {
        centre: [aside, radius * y / length, radius * z / length].map(|length| length as f32),
        radius: radius as f32,
        colour: [0; 3],
    }
}

/// A sphere of unknown outline covers its box only if all of that is hit.
#[test]
fn boxes_of_unknown_outlines_are_covered_where_they_are_hit() {
    let (mut covered, mut contested) = (0, 0);
    let mut coverage = Coverage::default();
    each_trial(20_000, |trial, random| {
        let trial = Trial {
            sphere: sphere_of_unknown_outline(random),
            ..*trial
        };
        let grid = trial.grid(random);
        let Some(record) = trial.record(&grid) else {
            return Ok(());
        };
        let tile = trial.tile();
        coverage.find(&grid, &tile, &[record], Bounds::Proven);
        let [covering] = &coverage.spheres[..] else {
            return Err("not one sphere".into());
        };
        let row = record.rows().start;
        let inner = coverage.rows_of(covering)[0].inner[row % LANES];
        if inner != coverage.outer(covering, row) {
            contested += 1;
            return Ok(());
        }
        covered += 1;
        let [left, right, top, bottom] = record.sides;
        for (column, row) in [(left, top), (right, top), (left, bottom), (right, bottom)] {
            let (x, y) = tile.pixel(usize::from(column), usize::from(row));
            let truth = trial.truth_at(f64::from(x), f64::from(y));
            if !truth.hit() || !truth.at_least(f64::from(covering.lower), grid.scale) {
                return Err(format!(
                    "not hit, or below {:e}, at {x}, {y}",
                    covering.lower
                ));
            }
        }
        Ok(())
    });
    assert!(
        covered > 3_000 && contested > 500,
        "only {covered} covered, {contested} contested"
    );
}

/// A sphere is met in its contested pixels and in no others, and not at all if it has none.
fn contested_pixels_are_those_of_their_spheres(coverage: &Coverage) -> Result<(), String> {
    for covering in &coverage.spheres {
        let [_, _, top, bottom] = covering.record.sides.map(usize::from);
        if covering.octets() != (top / LANES..bottom / LANES + 1) {
            return Err(format!("{:?} of {covering:?}", covering.octets()));
        }
        let of_sphere = coverage.contested_by(covering);
        let mut any = false;
        for (row, &found) in of_sphere.iter().enumerate() {
            let contested = coverage.contested[row / LANES][row % LANES];
            let covers = covering.octets().contains(&(row / LANES));
            let outer = if covers {
                coverage.outer(covering, row)
            } else {
                0
            };
            any |= contested & outer != 0;
            if found != contested & outer {
                return Err(format!("contested {found:x} in row {row} of {covering:?}"));
            }
        }
        if any != coverage.is_contested(covering) {
            return Err(format!("contested: {any} of {covering:?}"));
        }
    }
    Ok(())
}

/// Every packet of a box is within its rectangle, which is the smallest such rectangle around a
/// pixel.
#[test]
fn rectangles_hold_the_packets_of_their_boxes_and_no_more() {
    let tile = Tile {
        column: 640,
        row: 128,
        width: SIDE,
        first: 0,
        last: SIDE,
    };
    for first in 0..SIDE as u8 {
        for last in first..SIDE as u8 {
            let record = Record {
                sides: [first, last, first, last],
                ..Record::default()
            };
            let eight = EightRecords::of(&[record]);
            let rectangles = tile.rectangles(&eight);
            let of = |lanes: super::f64x8| lanes.to_array()[7];
            let (columns, across) = (of(rectangles.columns), of(rectangles.across));
            let (rows, down) = (of(rectangles.rows), of(rectangles.down));
            let packets = eight.boxes.packets().sides(0);
            let ends = [packets[0], packets[1]].map(|at| 640.0 + at as f64 - columns);
            assert_eq!(ends, [-across, across - 1.0], "{first} to {last}");
            let [first, last] = [first, last].map(f64::from);
            let ends = [128.0 + first - rows, 128.0 + last - rows];
            assert!(ends[0] == -down && ends[1] <= down, "{first} to {last}");
            assert!(ends[1] >= down - 2.0, "{first} to {last}");
            assert!(down >= 1.0);
            let placement = tile.placement(&eight);
            let (middle, most) = (of(placement.rows), of(placement.down));
            // `|q| <= 41` in the proof; all rows of the octets are within.
            assert!(most <= 41.0 && most <= (last - first) / 2.0 + 10.0);
            let octets = [
                (first / 8.0).floor() * 8.0,
                (last / 8.0).floor() * 8.0 + 7.0,
            ];
            assert!(
                octets
                    .iter()
                    .all(|row| (128.0 + row - middle).abs() <= most)
            );
        }
    }
}

/// What some spheres cover in a tile.
fn covered(tile: &Tile, spheres: &[[f32; 4]]) -> Coverage {
    let viewport = Viewport {
        width: 0.02,
        height: 0.02,
        distance: 1.0,
    };
    let size = ImageSize::new(200, 200).expect("a size");
    let camera = Camera::new(viewport, size);
    let grid = Grid::new(camera);
    let record = |(index, &[x, y, z, radius]): (u32, &[f32; 4])| {
        let sphere = Sphere {
            centre: [x, y, z],
            radius,
            colour: [0; 3],
        };
        let trial = Trial {
            camera,
            sphere,
            column: tile.column,
            row: tile.row,
        };
        let record = trial.record(&grid).expect("a box in the tile");
        Record { index, ..record }
    };
    let records: Vec<Record> = (0..).zip(spheres).map(record).collect();
    let mut coverage = Coverage::default();
    coverage.find(&grid, tile, &records, Bounds::Proven);
    coverage
}

/// The spheres that are not hidden, and whether one covers the tile.
fn left(tile: &Tile, spheres: &[[f32; 4]]) -> (Vec<u32>, bool) {
    let coverage = covered(tile, spheres);
    let index = |&at: &usize| coverage.spheres[at].record.index;
    let order = coverage.order.iter().map(index).collect();
    (order, coverage.is_covered)
}

/// What a sphere that covers the tile hides is dropped.
#[test]
fn what_is_behind_a_wall_is_dropped() {
    let whole = Tile {
        column: 64,
        row: 64,
        width: SIDE,
        first: 0,
        last: SIDE,
    };
    let wall = [0.0, 0.0, 1060.0, 1000.0];
    // Nearer outside of the picture only, so it stands before the wall in the order.
    let aslant = [600.0, 0.0, 870.0, 1000.0];
    let (behind, before) = ([0.0, 0.0, 2000.0, 5.0], [0.0, 0.0, 50.0, 0.1]);
    // Of its inverse depths and those of the wall some are equal, but in no pixel.
    let close = [0.0, 0.0, 1060.1, 1000.0];
    for tile in [
        whole,
        Tile {
            first: 10,
            last: 20,
            ..whole
        },
    ] {
        assert_eq!(left(&tile, &[wall]), (vec![0], true));
        assert_eq!(left(&tile, &[behind, wall]), (vec![1], true));
        assert_eq!(left(&tile, &[close, wall]), (vec![1], true));
        assert_eq!(left(&tile, &[wall, before, behind]), (vec![0, 1], false));
        assert_eq!(left(&tile, &[aslant, wall]), (vec![1], true));
        assert_eq!(left(&tile, &[aslant, wall, close, behind]), (vec![1], true));
        assert_eq!(left(&tile, &[before, behind]), (vec![1, 0], false));
    }
    // Inverse depths are compared pixel by pixel only where intervals overlap.
    assert!(covered(&whole, &[wall, before, behind]).depths.is_empty());
    assert_eq!(covered(&whole, &[wall, close]).depths.len(), 2);
    // A small sphere covers what is drawn of a tile.
    let some = Tile {
        column: 192,
        width: 8,
        first: 30,
        last: 34,
        ..whole
    };
    let (disc, behind) = ([0.48, 0.0, 50.0, 0.1], [19.2, 0.0, 2000.0, 5.0]);
    assert_eq!(left(&some, &[disc, behind]), (vec![0], true));
    assert!(!left(&Tile { last: 64, ..some }, &[disc, behind]).1);
}
