//! The reference defines the picture. It is tested with known answers, and every pixel of hard
//! scenes is compared with an oracle in another language and by another formula.

mod common;

use std::{
    fmt::Write,
    process::{Command, Stdio},
};

use common::{scene, size};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use sfera::{camera::ImageSize, reference::Reference, scene::Scene, testing::families::FAMILIES};

/// The picture as text, rows from the top: a digit for a sphere, a dot for the background.
fn picture(scene: &Scene, size: ImageSize) -> String {
    let reference = Reference::new(scene, size);
    let row = |row| {
        (0..size.width())
            .map(|column| match reference.seen(column, row) {
                Some(index) => char::from_digit(index as u32, 10).expect("at most ten spheres"),
                None => '.',
            })
            .collect::<String>()
    };
    (0..size.height()).map(row).collect::<Vec<_>>().join("\n")
}

/// The sphere that the ray along the axis sees.
fn ahead(spheres: &[[f32; 4]]) -> Option<usize> {
    Reference::new(&scene([1.0; 3], spheres), size(1, 1)).seen(0, 0)
}

#[test]
fn an_empty_scene_is_background() {
    assert_eq!(picture(&scene([1.0; 3], &[]), size(3, 2)), "...\n...");
}

#[test]
fn up_is_plus_y_and_right_is_plus_x() {
    let spheres = [[0.0, 2.0, 4.0, 0.5], [2.0, 0.0, 4.0, 0.5]];
    assert_eq!(
        picture(&scene([1.0; 3], &spheres), size(3, 3)),
        ".0.\n..1\n...",
    );
}

#[test]
fn one_column_looks_through_x_0_and_one_row_through_y_0() {
    let spheres = [
        [0.0, 0.0, 4.0, 0.5],
        [0.0, 2.0, 4.0, 0.5],
        [2.0, 0.0, 4.0, 0.5],
    ];
    let scene = scene([1.0; 3], &spheres);
    assert_eq!(picture(&scene, size(1, 1)), "0");
    assert_eq!(picture(&scene, size(1, 3)), "1\n0\n.");
    assert_eq!(picture(&scene, size(3, 1)), ".02");
    assert_eq!(picture(&scene, size(1, 2)), "1\n.");
}

#[test]
fn a_tangent_ray_sees_the_sphere_and_one_ulp_less_misses_it() {
    let radius = 3.0_f32;
    assert_eq!(ahead(&[[radius, 0.0, 7.0, radius]]), Some(0));
    assert_eq!(ahead(&[[radius, 0.0, 7.0, radius.next_down()]]), None);
    assert_eq!(ahead(&[[radius.next_up(), 0.0, 7.0, radius]]), None);
}

#[test]
fn a_tangent_ray_off_every_axis_sees_the_sphere() {
    // The upper right ray is along (2, 3, 6), perpendicular to (3, -6, 2). Both vectors
    // have length 7.
    let right_angle = |k: f32, m: f32, radius| {
        let spheres = [[
            2.0 * k + 3.0 * m,
            3.0 * k - 6.0 * m,
            6.0 * k + 2.0 * m,
            radius,
        ]];
        Reference::new(&scene([4.0, 6.0, 6.0], &spheres), size(3, 3)).seen(2, 0)
    };
    for k in [8.0, 1000.0, 100_000.0] {
        assert_eq!(right_angle(k, 1.0, 7.0), Some(0));
        assert_eq!(right_angle(k, -2.0, 14.0), Some(0));
        assert_eq!(right_angle(k, 1.0, 7.0_f32.next_down()), None);
        assert_eq!(right_angle(k, -2.0, 14.0_f32.next_down()), None);
    }
}

#[test]
fn spheres_behind_the_camera_are_invisible() {
    assert_eq!(ahead(&[[0.0, 0.0, -4.0, 1.0]]), None);
    assert_eq!(ahead(&[[1.0, 0.0, -4.0, 1.0]]), None);
    // Partly in front of the plane of the camera, but the ray never meets it.
    assert_eq!(ahead(&[[2.0, 0.0, -0.5, 1.0]]), None);
    // B = 0: the sphere beside the camera touches no ray.
    assert_eq!(ahead(&[[2.0, 0.0, 0.0, 1.0]]), None);
}

#[test]
fn a_camera_inside_sees_the_far_wall() {
    assert_eq!(ahead(&[[0.0, 0.0, 0.0, 2.0]]), Some(0));
    assert_eq!(ahead(&[[0.0, 0.0, -1.5, 2.0]]), Some(0));
    // The wall at 2 is behind the sphere from 1 to 1.5 and in front of the one from 3.
    let within = [0.0, 0.0, 1.25, 0.25];
    let beyond = [0.0, 0.0, 4.0, 1.0];
    assert_eq!(ahead(&[[0.0, 0.0, 0.0, 2.0], within]), Some(1));
    assert_eq!(ahead(&[[0.0, 0.0, 0.0, 2.0], beyond]), Some(0));
    assert_eq!(ahead(&[beyond, [0.0, 0.0, 0.0, 2.0]]), Some(1));
}

#[test]
fn the_innermost_of_concentric_walls_is_seen_and_the_outermost_of_shells() {
    let around = |radius| [0.0, 0.0, 0.0, radius];
    assert_eq!(
        ahead(&[around(2.0), around(2.0_f32.next_down()), around(2.5)]),
        Some(1)
    );
    let before = |radius| [0.0, 0.0, 9.0, radius];
    assert_eq!(
        ahead(&[before(2.0), before(2.0_f32.next_up()), before(1.5)]),
        Some(1)
    );
}

#[test]
fn a_camera_on_the_surface_sees_through_the_sphere_or_away_from_it() {
    assert_eq!(ahead(&[[0.0, 0.0, 2.0, 2.0]]), Some(0));
    assert_eq!(ahead(&[[3.0, 4.0, 12.0, 13.0]]), Some(0));
    assert_eq!(ahead(&[[3.0, 4.0, -12.0, 13.0]]), None);
    // A ray in the tangent plane sees nothing.
    assert_eq!(ahead(&[[2.0, 0.0, 0.0, 2.0]]), None);
    // The far walls are at 2B/A: 24 and 8 units away.
    assert_eq!(
        ahead(&[[3.0, 4.0, 12.0, 13.0], [12.0, 3.0, 4.0, 13.0]]),
        Some(1)
    );
}

#[test]
fn of_equally_near_spheres_the_first_is_seen() {
    let sphere = [0.5, 0.0, 4.0, 1.0];
    assert_eq!(ahead(&[[0.0, 0.0, 9.0, 1.0], sphere, sphere]), Some(1));
    // Near walls at 3 along the ray, of different radii, and a wall from inside.
    let at_three = [
        [0.0, 0.0, 4.0, 1.0],
        [0.0, 0.0, 5.0, 2.0],
        [0.0, 0.0, 0.0, 3.0],
    ];
    // And one with the camera on its surface, 3 in diameter.
    let on_surface = [0.0, 0.0, 1.5, 1.5];
    for turn in 0..4 {
        let mut spheres = [at_three[0], at_three[1], at_three[2], on_surface];
        spheres.rotate_left(turn);
        assert_eq!(ahead(&spheres), Some(0));
        // The next nearer float wins against all.
        let nearer = [0.0, 0.0, 4.0, 1.0_f32.next_up()];
        let with_nearer = [spheres[0], spheres[1], spheres[2], spheres[3], nearer];
        assert_eq!(ahead(&with_nearer), Some(4));
    }
}

#[test]
fn equal_distances_off_the_axis_are_equal() {
    // Mirror images in the plane of the middle column, only in which they are equally far.
    let left = [-0.3, 0.1, 4.0, 1.0];
    let right = [0.3, 0.1, 4.0, 1.0];
    let odd = scene([0.5, 0.2, 1.0], &[left, right]);
    assert_eq!(picture(&odd, size(7, 3)), ["0000111"; 3].join("\n"));
    let odd = scene([0.5, 0.2, 1.0], &[right, left]);
    assert_eq!(picture(&odd, size(7, 3)), ["1110000"; 3].join("\n"));
    let even = scene([0.5, 0.2, 1.0], &[left, right]);
    assert_eq!(picture(&even, size(6, 3)), ["000111"; 3].join("\n"));
}

#[test]
fn the_largest_and_the_smallest_floats_are_exact_too() {
    let smallest = f32::from_bits(1);
    // Two subnormal spheres in front of one with the largest floats.
    let spheres = [
        [0.0, 0.0, f32::MAX, f32::MAX / 2.0],
        [0.0, 0.0, 9.0 * smallest, smallest],
        [0.0, 0.0, 8.0 * smallest, smallest],
    ];
    assert_eq!(ahead(&spheres), Some(2));
    assert_eq!(ahead(&spheres[..1]), Some(0));
    // Half of the viewport is the smallest float.
    let viewport = [2.0 * smallest, 2.0 * smallest, f32::MAX];
    let reference = Reference::new(&scene(viewport, &spheres), size(3, 3));
    assert_eq!(reference.seen(0, 0), Some(2));
}

// Against the oracle.

/// A scene as text. The shortest digits of a float identify it.
fn text(scene: &Scene) -> String {
    let viewport = scene.viewport();
    let mut text = format!(
        "VP {:e} {:e} {:e}\nBG 0 0 0\nOBJ_N {}\n",
        viewport.width(),
        viewport.height(),
        viewport.distance(),
        scene.spheres().len(),
    );
    for sphere in scene.spheres().iter() {
        let [x, y, z] = sphere.centre();
        let [red, green, blue] = sphere.colour();
        writeln!(
            text,
            "S {x:e} {y:e} {z:e} {:e} {red} {green} {blue}",
            sphere.radius()
        )
        .expect("a string takes any text");
    }
    text
}

/// The answers of `tests/oracle.py`, or `None` on a machine without Python, which is a
/// failure in CI.
fn oracle(scenes: &[(Scene, ImageSize)]) -> Option<Vec<Vec<Option<usize>>>> {
    let folder = tempfile::tempdir().expect("a folder for the scenes");
    let mut python = Command::new("python3");
    python.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracle.py"));
    for (index, (scene, size)) in scenes.iter().enumerate() {
        let path = folder.path().join(format!("{index}.txt"));
        std::fs::write(&path, text(scene)).expect("a scene file");
        python.arg(path);
        python.args([size.width().to_string(), size.height().to_string()]);
    }
    let answer = match python.stderr(Stdio::inherit()).output() {
        Ok(answer) => answer,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            assert!(
                std::env::var_os("CI").is_none(),
                "CI needs python3 for the oracle"
            );
            eprintln!("no python3 here: the reference was NOT compared with the oracle");
            return None;
        }
        Err(error) => panic!("python3 can't be started: {error}"),
    };
    assert!(
        answer.status.success(),
        "the oracle failed: {}",
        answer.status
    );
    let answer = String::from_utf8(answer.stdout).expect("numbers");
    let mut lines = answer.lines();
    let pictures = scenes.iter().map(|(_, size)| {
        lines
            .by_ref()
            .take(size.height() as usize)
            .flat_map(str::split_whitespace)
            .map(|word| word.parse::<i64>().expect("a number of a sphere"))
            .map(|index| usize::try_from(index).ok())
            .collect()
    });
    Some(pictures.collect())
}

fn assert_agreement(scenes: &[(Scene, ImageSize)]) {
    let Some(pictures) = oracle(scenes) else {
        return;
    };
    for ((scene, size), picture) in scenes.iter().zip(pictures) {
        let reference = Reference::new(scene, *size);
        assert_eq!(picture.len() as u64, size.pixels());
        for (pixel, expected) in picture.into_iter().enumerate() {
            let row = pixel as u32 / size.width();
            let column = pixel as u32 % size.width();
            assert_eq!(
                reference.seen(column, row),
                expected,
                "pixel ({column}, {row}) of {size:?} of\n{}",
                text(scene),
            );
        }
    }
}

#[test]
fn the_oracle_agrees_on_every_family() {
    let mut scenes = Vec::new();
    for family in FAMILIES {
        for (seed, &difficulty) in family.difficulties.iter().enumerate() {
            let scene = family.scene(difficulty, seed as u64);
            if scene.spheres().len() <= 64 {
                scenes.push((scene, size(17, 13)));
            }
        }
    }
    assert!(scenes.len() > 80);
    assert_agreement(&scenes);
}

#[test]
fn the_oracle_agrees_on_degenerate_scenes() {
    // Few values, so that tangents, ties and cameras on surfaces are frequent.
    let coordinate = (-4..=4).prop_map(|n| n as f32);
    let radius = (1..=5).prop_map(|n| n as f32);
    let sphere = (coordinate.clone(), coordinate.clone(), coordinate, radius)
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let side = prop_oneof![Just(1), Just(2), Just(5), Just(9)];
    let viewport = prop_oneof![
        Just([2.0, 2.0, 1.0]),
        Just([4.0, 6.0, 6.0]),
        Just([8.0, 8.0, 2.0])
    ];
    let scenes = (
        viewport,
        prop::collection::vec(sphere, 0..7),
        side.clone(),
        side,
    )
        .prop_map(|(viewport, spheres, width, height)| {
            (scene(viewport, &spheres), size(width, height))
        });
    compare_with_oracle(&scenes, 150);
}

#[test]
fn the_oracle_agrees_on_any_floats() {
    // Any bits of a finite float, so that all magnitudes occur together.
    let number = any::<u32>()
        .prop_map(f32::from_bits)
        .prop_filter("finite", |number| number.is_finite());
    let positive = number
        .prop_map(f32::abs)
        .prop_filter("greater than zero", |&number| number > 0.0);
    let number = any::<u32>()
        .prop_map(f32::from_bits)
        .prop_filter("finite", |number| number.is_finite());
    let sphere = (number.clone(), number.clone(), number, positive.clone())
        .prop_map(|(x, y, z, radius)| [x, y, z, radius]);
    let viewport = [positive.clone(), positive.clone(), positive];
    let scenes = (viewport, prop::collection::vec(sphere, 1..6))
        .prop_map(|(viewport, spheres)| (scene(viewport, &spheres), size(6, 5)));
    compare_with_oracle(&scenes, 60);
}

fn compare_with_oracle(scenes: &impl Strategy<Value = (Scene, ImageSize)>, count: usize) {
    let mut runner = TestRunner::deterministic();
    let scenes: Vec<_> = (0..count)
        .map(|_| scenes.new_tree(&mut runner).expect("a scene").current())
        .collect();
    assert_agreement(&scenes);
}
