//! The records of tiles.

use super::*;
use crate::{
    camera::{Camera, ImageSize},
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
    let fit_floats = Boxes::fit_floats(&grid);
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
            Boxes::of_floats(&grid, components.map(|length| [length; LANES]), fit_floats)
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
                    let all = [boxes.left, boxes.right, boxes.top, boxes.bottom];
                    Some((index, part(all.map(|side| side[0]))?))
                })
                .collect();
            let small = bins.records(column, row).flatten().map(|record| {
                let sides = [record.left, record.right, record.top, record.bottom];
                (record.index, sides.map(u32::from))
            });
            let large = bins.large.iter().filter_map(|large| {
                let sides = part([large.left, large.right, large.top, large.bottom])?;
                Some((large.index, sides))
            });
            let mut found: Vec<_> = small.chain(large).collect();
            found.sort_unstable();
            assert_eq!(found, expected, "({column}, {row}) of side {side}");
        }
    }
}
