//! The families are what they say.

use std::collections::HashSet;

use sfera::{
    families::{FAMILIES, Family, cloud},
    scene::Scene,
};

fn family(name: &str) -> Family {
    let family = FAMILIES.into_iter().find(|family| family.name == name);
    family.expect("a family of this name")
}

#[test]
fn every_scene_is_one_that_a_file_can_hold() {
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            for seed in 0..8 {
                let scene = family.scene(difficulty, seed);
                let viewport = scene.viewport;
                for length in [viewport.width, viewport.height, viewport.distance] {
                    assert!(
                        length > 0.0 && length.is_finite(),
                        "{} {difficulty}",
                        family.name
                    );
                }
                for sphere in scene.spheres.iter() {
                    assert!(sphere.centre.iter().all(|length| length.is_finite()));
                    assert!(sphere.radius > 0.0 && sphere.radius.is_finite());
                }
            }
        }
    }
}

#[test]
fn no_two_spheres_share_a_colour_and_none_has_the_background() {
    let scene = cloud(100_000, 1);
    let colours: HashSet<_> = scene.spheres.colour().iter().collect();
    assert_eq!(colours.len(), 100_000);
    assert!(!colours.contains(&scene.background));
}

#[test]
fn a_seed_gives_the_same_scene_again_and_another_seed_another() {
    let spheres = |scene: Scene| scene.spheres.iter().collect::<Vec<_>>();
    for family in FAMILIES {
        let scene = |seed| spheres(family.scene(family.difficulties[0], seed));
        assert_eq!(scene(4), scene(4));
        assert_ne!(scene(4), scene(5));
    }
}

#[test]
fn far_is_as_far_as_it_says() {
    let far = family("far");
    for &difficulty in far.difficulties {
        for sphere in far.scene(difficulty, 0).spheres.iter() {
            let [x, y, z] = sphere.centre;
            let ratio = f64::from(x.hypot(y).hypot(z) / sphere.radius);
            assert!(
                (0.5 * difficulty..2.5 * difficulty).contains(&ratio),
                "{ratio}"
            );
        }
    }
}

/// In integers: all lengths of this family are whole.
#[test]
fn tangents_touch_the_ray_of_a_pixel_exactly() {
    let tangent = family("tangent");
    for &difficulty in tangent.difficulties {
        let scene = tangent.scene(difficulty, 1);
        let z = scene.viewport.distance as i128;
        for sphere in scene.spheres.iter() {
            let [cx, cy, cz] = sphere.centre.map(|length| length as i128);
            let r = sphere.radius as i128;
            let touches = |x: i128, y: i128| {
                let a = x * x + y * y + z * z;
                let b = cx * x + cy * y + cz * z;
                b * b == a * (cx * cx + cy * cy + cz * cz - r * r)
            };
            let mut rays = (-32..=32).flat_map(|x| (-24..=24).map(move |y| (x, y)));
            assert!(
                rays.any(|(x, y)| touches(x, y)),
                "{sphere:?} touches no ray"
            );
        }
    }
}

#[test]
fn a_camera_on_the_surface_is_on_it_exactly() {
    let surface = family("on the surface");
    for &difficulty in surface.difficulties {
        for sphere in surface.scene(difficulty, 1).spheres.iter() {
            let [x, y, z] = sphere.centre.map(f64::from);
            let r = f64::from(sphere.radius);
            // Whole numbers below 2^26: no rounding.
            assert_eq!(x * x + y * y + z * z, r * r);
        }
    }
}

#[test]
fn a_cloud_has_as_many_spheres_as_asked_for_all_of_them_in_front() {
    for count in [0, 1, 7, 1_000] {
        let scene = cloud(count, 3);
        assert_eq!(scene.spheres.len(), count);
        assert!(
            scene
                .spheres
                .iter()
                .all(|sphere| sphere.centre[2] > sphere.radius)
        );
    }
}
