//! What a crowd does not meet, and when it is sorted.

use super::*;
use crate::{
    camera::{Camera, ImageSize},
    exact::{bins::Room, paint::colour_lane, prepared::Prepared, tuning::Tuning},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

/// What is left of a crowd: the spheres gathered, whether they were sorted, how many groups of eight
/// and how many packets were met.
#[derive(Debug)]
struct Met {
    gathered: usize,
    sorted: bool,
    eights: usize,
    packets: u64,
}

/// Meets spheres in the middle tile of a picture of so many, of which some rows are drawn. Lengths are
/// in pixels at distance 64.
fn met(spheres: impl Iterator<Item = [f32; 4]>, tiles: u32, first: usize, last: usize) -> Met {
    let width = tiles * SIDE as u32;
    let sphere = |[x, y, z, radius]: [f32; 4]| Sphere {
        centre: [x, y, z],
        radius,
        colour: [1; 3],
    };
    let scene = Scene {
        viewport: Viewport {
            width: width as f32,
            height: 64.0,
            distance: 64.0,
        },
        background: [0; 3],
        spheres: spheres.map(sphere).collect(),
    };
    let size = ImageSize::new(width, SIDE as u32).expect("a size");
    let camera = Camera::new(scene.viewport, size);
    let prepared = Prepared::new(&scene, camera, Tuning::default(), &Room::default());
    let column = tiles / 2 * SIDE as u32;
    let crowded = PreparedTile {
        prepared: &prepared,
        tile: Tile {
            column,
            row: 0,
            width: SIDE,
            first,
            last,
        },
    };
    let large = prepared.bins.large.iter();
    let mut large: Vec<Record> = large
        .map(|large| large.record(column, 0, SIDE as u32))
        .collect();
    let mut crowd = Crowd::default();
    let sorted = crowd.gather(&crowded, &mut large);
    let gathered = crowd.records.len();
    let mut pixels = vec![PixelRow::new(colour_lane([0; 3])); SIDE];
    let packets = crowd.meet(&crowded, sorted, &mut pixels);
    Met {
        gathered,
        sorted,
        eights: crowd.boxes.len(),
        packets,
    }
}

/// Packets of a sphere as large as the tile.
const ALL: u64 = (SIDE * BLOCKS) as u64;

/// Almost flat, and nowhere nearer than so far.
fn wall(distance: f32) -> [f32; 4] {
    [0.0, 0.0, 1e6 + distance, 1e6]
}

/// Many spheres that each cover the tile, one behind the other.
#[test]
fn what_a_nearer_sphere_hides_is_not_met() {
    let walls = (0..1000).rev().map(|at| wall(1000.0 + 10.0 * at as f32));
    let stack = met(walls, 1, 0, SIDE);
    assert!(stack.gathered == 1000 && stack.sorted, "{stack:?}");
    // Before the first floors two may be met.
    assert!(stack.eights == 1 && stack.packets <= 2 * ALL, "{stack:?}");
}

/// A wall that is larger than the tiles hides what is behind it before anything is met.
#[test]
fn what_is_behind_a_wall_is_not_gathered() {
    let gathered = |first: usize, last: usize| {
        let before = (0..50).map(|at| [at as f32 - 25.0, 0.0, 64.0, 1.0]);
        let behind = (0..5000).map(|at| [at as f32 / 50.0 - 50.0, 9.0, 200.0, 4.0]);
        let spheres = before.chain(behind);
        let walls = [wall(100.0), wall(150.0)].into_iter();
        met(walls.chain(spheres), 3, first, last).gathered
    };
    assert_eq!(gathered(0, SIDE), 51);
    // What is beside the rows that are drawn is left out as well.
    assert_eq!(gathered(25, 40), 51);
    assert_eq!(gathered(0, 5), 1);
    assert_eq!(gathered(60, SIDE), 1);
}

#[test]
fn without_a_wall_what_is_beside_the_rows_is_not_gathered() {
    let gathered = |first: usize, last: usize| {
        let above = (0..200).map(|at| [at as f32 / 4.0 - 25.0, 20.0, 64.0, 1.0]);
        let below = (0..300).map(|at| [at as f32 / 6.0 - 25.0, -20.0, 64.0, 1.0]);
        met(above.chain(below), 3, first, last).gathered
    };
    assert_eq!(gathered(0, SIDE), 500);
    assert_eq!(gathered(0, 32), 200);
    assert_eq!(gathered(32, SIDE), 300);
    assert_eq!(gathered(1, SIDE), 500);
}

/// The first copy of the first sphere, or more undecided pixels than these, make a crowd sorted.
#[test]
fn copies_are_suspected() {
    let mut crowd = Crowd::default();
    assert!(!crowd.may_hold_copies(MANY_UNDECIDED));
    assert!(crowd.may_hold_copies(MANY_UNDECIDED + 1));
    crowd.hidden.copied = true;
    assert!(crowd.may_hold_copies(0));
}

/// A box of so many columns and rows, beginning at the corner.
fn of_sides(columns: u8, rows: u8) -> Record {
    Record {
        sides: [0, columns - 1, 0, rows - 1],
        ..Record::default()
    }
}

#[test]
fn a_crowd_is_deep_from_its_limits_on() {
    let side = SIDE as u8;
    let deep = |large: &[(usize, Record)], small: &[(usize, Record)]| {
        let mut crowd = Crowd::default();
        for &(count, record) in large.iter().chain(small) {
            crowd.records.extend(std::iter::repeat_n(record, count));
        }
        crowd.is_deep(large.iter().map(|(count, _)| count).sum())
    };
    let all = of_sides(side, side);
    assert!(deep(&[(DEEP, all)], &[]));
    assert!(!deep(
        &[(DEEP - 1, all), (1, of_sides(side, side - 1))],
        &[]
    ));
    // Small ones of the least area, in the least number that is a multiple of the sample.
    let (side, area) = (LABORIOUS.isqrt() as u8, LABORIOUS);
    let count = DEEP * SIDE * SIDE / area;
    assert!(deep(&[], &[(count, of_sides(side, side))]));
    assert!(!deep(&[], &[(count - SAMPLE, of_sides(side, side))]));
    assert!(!deep(&[], &[(2 * count, of_sides(side, side - 1))]));
    // Both together.
    assert!(deep(
        &[(DEEP / 2, all)],
        &[(count / 2, of_sides(side, side))]
    ));
    assert!(!deep(
        &[(DEEP / 2, all)],
        &[(count / 2 - SAMPLE, of_sides(side, side))]
    ));
}

/// Whatever their places in the file.
#[test]
fn the_nearest_come_first_and_of_copies_the_first_of_the_file() {
    let record = |upper: f32, x: f32, index: u32| Record {
        sphere: [x, 0.0, 9.0, 1.0],
        upper,
        index,
        ..Record::default()
    };
    let mut records = Vec::new();
    for index in 0..60 {
        // Equally near spheres that differ, and copies, one after the other.
        records.push(record((index % 3) as f32, (index % 6) as f32, index));
    }
    records.rotate_left(17);
    let mut crowd = Crowd {
        records,
        ..Crowd::default()
    };
    crowd.sort();
    let mut found: Vec<_> = crowd
        .records
        .iter()
        .map(|record| (record.upper, record.index))
        .collect();
    assert!(found.is_sorted_by(|a, b| a.0 >= b.0), "{found:?}");
    found.sort_unstable_by_key(|&(_, index)| index);
    assert_eq!(
        found,
        [0, 1, 2, 3, 4, 5].map(|index| ((index % 3) as f32, index))
    );
}

#[test]
fn the_blocks_of_a_box_are_those_that_have_a_pixel_of_it() {
    for first in 0..SIDE as u8 {
        for last in first..SIDE as u8 {
            for (left, right, top, bottom) in [(first, last, 0, 7), (9, 30, first, last)] {
                let record = Record {
                    sides: [left, right, top, bottom],
                    ..Record::default()
                };
                let side = LANES as u8;
                let (columns, rows) = (left / side..=right / side, top / side..=bottom / side);
                let mut blocks = 0;
                for row in rows {
                    for column in columns.clone() {
                        blocks |= 1 << (row * BLOCKS as u8 + column);
                    }
                }
                assert_eq!(blocks_of(&record), blocks, "{record:?}");
            }
        }
    }
}
