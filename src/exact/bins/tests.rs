//! The records of tiles, and records made of lanes.

use super::*;
use crate::{
    camera::{Camera, ImageSize},
    exact::{
        grid::SIDE,
        paint::{bytes_of, colour_lane},
    },
    random::Random,
    scene::Viewport,
    spheres::Sphere,
};

/// Every tile has exactly the spheres whose boxes meet it, each with the part of its box
/// that is in the tile; for every side of a tile.
#[test]
fn tiles_hold_the_spheres_whose_boxes_meet_them() {
    let size = ImageSize::new(203, 131).expect("a size with pixels");
    let viewport = Viewport {
        width: 2.0,
        height: 1.3,
        distance: 1.0,
    };
    let grid = Grid::new(Camera::new(viewport, size));
    let unit = float_unit(&grid);
    let mut random = Random::new(3);
    let spheres: Spheres = (0..300)
        .map(|_| Sphere {
            centre: [
                random.between(-9.0, 9.0) as f32,
                random.between(-6.0, 6.0) as f32,
                random.between(5.0, 9.0) as f32,
            ],
            radius: random.power(10.0, -2.0, 0.5) as f32,
            colour: [0; 3],
        })
        .collect();
    let boxes: Vec<Boxes> = spheres
        .iter()
        .map(|Sphere { centre, radius, .. }| {
            let components = [centre[0], centre[1], centre[2], radius];
            Boxes::new(&grid, components.map(f32x8::splat), unit)
        })
        .collect();
    for side in [8, 16, 32, 64] {
        let bins = Bins::new(&spheres, &grid, side, Bounds::Proven, &Room::default());
        assert!(!bins.has_none_small() && !bins.large.is_empty());
        let tiles = (0..size.height().div_ceil(side))
            .flat_map(|row| (0..size.width().div_ceil(side)).map(move |column| (column, row)));
        for (column, row) in tiles {
            let (x, y) = (column * side, row * side);
            let part = |[left, right, top, bottom]: [u32; 4]| {
                let (last_x, last_y) = (x + side - 1, y + side - 1);
                (left <= last_x && right >= x && top <= last_y && bottom >= y).then(|| {
                    [
                        left.max(x) - x,
                        right.min(last_x) - x,
                        top.max(y) - y,
                        bottom.min(last_y) - y,
                    ]
                })
            };
            let expected: Vec<_> = (0_u32..)
                .zip(&boxes)
                .filter(|(_, boxes)| boxes.visible & 1 == 1)
                .filter_map(|(index, boxes)| {
                    let all = boxes.sides;
                    Some((index, part(all.map(|side| side[0]))?))
                })
                .collect();
            let small = bins.records(column, row).flatten().map(|record| {
                let sides = record.sides;
                (record.index, sides.map(u32::from))
            });
            let large = bins.large.iter().filter_map(|large| {
                let sides = part(large.sides)?;
                Some((large.index, sides))
            });
            let mut found: Vec<_> = small.chain(large).collect();
            found.sort_unstable();
            assert_eq!(found, expected, "({column}, {row}) of side {side}");
        }
    }
}

/// No two of its bytes are equal.
fn sphere_of_bytes(index: u32) -> Sphere {
    let length =
        |component: u32| f32::from_bits(0x3f01_0203 + 0x0004_0404 * (4 * index + component));
    let byte = |component: u32| (3 * index + component + 1) as u8;
    Sphere {
        centre: [length(0), length(1), length(2)],
        radius: length(3),
        colour: [byte(0), byte(1), byte(2)],
    }
}

/// On a machine of either byte order, whether or not the last eight are full.
#[test]
fn records_of_eight_lanes_are_those_of_one_sphere_each() {
    let spheres: Spheres = (0..13).map(sphere_of_bytes).collect();
    let sides = |lane: u32| [lane, lane + 10, lane + 20, lane + 30];
    for first in [0, 8] {
        let lanes: [u32; LANES] = std::array::from_fn(|lane| lane as u32);
        let placed = Placed {
            small: 0xff,
            across: 0b0101_0000,
            down: 0b0110_0000,
            tile: [0; LANES],
            sides: lanes.map(|lane| {
                let [left, right, top, bottom] = sides(lane);
                left | right << 8 | top << 16 | bottom << 24
            }),
            upper: lanes.map(|lane| 0.1 + lane as f32),
        };
        let tiles = Tiles {
            shift: SIDE.ilog2(),
            columns: 2,
            rows: 2,
        };
        let records = records_of(&spheres, first, &placed, tiles);
        for (lane, record) in records.iter().enumerate().take(spheres.len() - first) {
            let index = (first + lane) as u32;
            let Sphere {
                centre,
                radius,
                colour,
            } = sphere_of_bytes(index);
            let [left, right, top, bottom] = sides(lane as u32);
            let alone = Large {
                sphere: [centre[0], centre[1], centre[2], radius],
                upper: 0.1 + lane as f32,
                index,
                colour,
                sides: [
                    left,
                    right + tiles.side() * (placed.across >> lane & 1),
                    top,
                    bottom + tiles.side() * (placed.down >> lane & 1),
                ],
            };
            let alone = alone.record(0, 0, tiles.side());
            assert_eq!(
                bytemuck::bytes_of(record),
                bytemuck::bytes_of(&alone),
                "{index}"
            );
        }
    }
}

fn record(at: u8) -> Record {
    let Sphere {
        centre,
        radius,
        colour,
    } = sphere_of_bytes(u32::from(at));
    Record {
        sphere: [centre[0], centre[1], centre[2], radius],
        colour,
        sides: [at, 2 * at + 3, 3 * at + 1, 3 * at + 1 + 4 * (at % 3)],
        ..Record::default()
    }
}

/// On a machine of either byte order, whether or not there are eight.
#[test]
fn eight_records_are_lanes_of_what_each_of_them_is() {
    for count in 1..=LANES {
        let records: Vec<Record> = (0..count as u8).map(record).collect();
        let eight = EightRecords::of(&records);
        let colours = eight.colours.to_array();
        let boxes = eight.boxes;
        let sides = boxes.all_sides();
        for lane in 0..LANES {
            let record = &records[lane.min(count - 1)];
            assert_eq!(
                colours[lane],
                colour_lane(record.colour),
                "{lane} of {count}"
            );
            assert_eq!(bytes_of(colours[lane]), record.colour, "{lane} of {count}");
            let its = record.sides;
            assert_eq!(boxes.sides(lane), its.map(usize::from));
            let sides = sides.map(|lanes| lanes.to_array()[lane]);
            assert_eq!(sides, its.map(u32::from), "{lane} of {count}");
            for (column, row) in (0..64).flat_map(|column| (0..64).map(move |row| (column, row))) {
                let across = record.columns().contains(&usize::from(column));
                let down = record.rows().contains(&usize::from(row));
                let holds = boxes.holding(column, row) >> lane & 1 == 1;
                assert_eq!(holds, across && down, "({column}, {row}), {record:?}");
            }
        }
    }
}

/// Packets hold the box, in as few as possible of them or in those that begin at multiples of
/// eight columns, and none of them extends beyond the widest tile.
#[test]
fn packets_hold_the_box_and_begin_at_multiples_of_eight_columns() {
    let side = SIDE as u8;
    let boxes = (0..side).flat_map(|left| (left..side).map(move |right| [left, right, 3, 61]));
    for sides in boxes {
        let record = Record {
            sides,
            ..Record::default()
        };
        let [left, right, top, bottom] = sides.map(usize::from);
        let [first, last, highest, lowest] = EightRecords::of(&[record]).boxes.packets().sides(0);
        assert_eq!([highest, lowest], [top, bottom]);
        assert!(first <= left && right <= last && last < SIDE, "{sides:?}");
        let multiples = [left - left % LANES, right - right % LANES + LANES - 1];
        if left / LANES + 1 == right / LANES && right - left < LANES {
            assert_eq!([first, last], [left, left + LANES - 1], "{sides:?}");
        } else {
            assert_eq!([first, last], multiples, "{sides:?}");
        }
    }
}

/// Memory for records is kept while it is enough, and is not much more than was asked for.
#[test]
fn memory_for_records_is_kept() {
    for count in [1, 1000, 3 * HUGE_PAGE / size_of::<Record>()] {
        let mut records = Records::default();
        records.reserve(count);
        let (first, room) = (records.all().as_ptr(), records.all().len());
        let most = (count + count / 8) * size_of::<Record>();
        let bytes = room * size_of::<Record>();
        assert!(
            room >= count && bytes < most + HUGE_PAGE,
            "{room} of {count}"
        );
        assert!(count > 1000 || bytes <= most, "{room} of {count}");
        for again in [1, count, room] {
            records.reserve(again);
            assert_eq!(records.all().as_ptr(), first, "{again} of {room}");
        }
        records.reserve(room + 1);
        assert!(records.all().len() > room);
    }
}

/// What bins took of a room is there again when they have returned it.
#[test]
fn bins_return_their_memory() {
    let size = ImageSize::new(64, 64).expect("a size");
    let viewport = Viewport::new(1.0, 1.0, 1.0).expect("a viewport");
    let grid = Grid::new(Camera::new(viewport, size));
    let sphere = Sphere {
        centre: [0.0, 0.0, 9.0],
        radius: 1.0,
        colour: [0; 3],
    };
    let spheres: Spheres = std::iter::repeat_n(sphere, 1000).collect();
    let room = Room::default();
    let bins = Bins::new(&spheres, &grid, 64, Bounds::Proven, &room);
    let records = bins.runs[0].records.all().as_ptr();
    bins.return_to(&room);
    assert_eq!(room.runs.take().records.all().as_ptr(), records);
}
