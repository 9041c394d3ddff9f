//! The families of scenes have the properties that their documentation says.

use std::collections::HashSet;

use sfera::{
    scene::Scene,
    testing::families::{FAMILIES, Family, cloud},
};

fn family(name: &str) -> &'static Family {
    let family = FAMILIES.iter().find(|family| family.name == name);
    family.expect("a family of this name")
}

#[test]
fn every_scene_is_one_that_a_file_can_hold() {
    for family in FAMILIES {
        for &difficulty in family.difficulties {
            for seed in 0..8 {
                let scene = family.scene(difficulty, seed);
                let viewport = scene.viewport();
                for length in [viewport.width(), viewport.height(), viewport.distance()] {
                    assert!(
                        length > 0.0 && length.is_finite(),
                        "{} {difficulty}",
                        family.name
                    );
                }
                for sphere in scene.spheres().iter() {
                    assert!(sphere.centre().iter().all(|length| length.is_finite()));
                    assert!(sphere.radius() > 0.0 && sphere.radius().is_finite());
                }
            }
        }
    }
}

#[test]
fn no_two_spheres_share_a_colour_and_none_has_the_background() {
    let scene = cloud(100_000, 1);
    let colours: HashSet<_> = scene.spheres().colour().iter().collect();
    assert_eq!(colours.len(), 100_000);
    assert!(!colours.contains(&scene.background()));
}

#[test]
fn a_seed_gives_the_same_scene_again_and_another_seed_another() {
    let spheres = |scene: Scene| scene.spheres().iter().collect::<Vec<_>>();
    for family in FAMILIES {
        let scene = |seed| spheres(family.scene(family.difficulties[0], seed));
        assert_eq!(scene(4), scene(4));
        assert_ne!(scene(4), scene(5));
    }
}

#[test]
fn far_spheres_are_at_the_given_distance() {
    let far = family("far");
    for &difficulty in far.difficulties {
        for sphere in far.scene(difficulty, 0).spheres().iter() {
            let [x, y, z] = sphere.centre();
            let ratio = f64::from(x.hypot(y).hypot(z) / sphere.radius());
            assert!(
                (0.5 * difficulty..2.5 * difficulty).contains(&ratio),
                "{ratio}"
            );
        }
    }
}

/// Checked in integers: all lengths of this family are whole.
#[test]
fn tangents_touch_the_ray_of_a_pixel_exactly() {
    let tangent = family("tangent");
    for &difficulty in tangent.difficulties {
        let scene = tangent.scene(difficulty, 1);
        let z = scene.viewport().distance() as i128;
        for sphere in scene.spheres().iter() {
            let [cx, cy, cz] = sphere.centre().map(|length| length as i128);
            let r = sphere.radius() as i128;
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
        for sphere in surface.scene(difficulty, 1).spheres().iter() {
            let [x, y, z] = sphere.centre().map(f64::from);
            let r = f64::from(sphere.radius());
            // Whole numbers below 2^26: no rounding.
            assert_eq!(x * x + y * y + z * z, r * r);
        }
    }
}

#[test]
fn a_cloud_has_as_many_spheres_as_asked_for_all_of_them_in_front() {
    for count in [0, 1, 7, 1_000] {
        let scene = cloud(count, 3);
        assert_eq!(scene.spheres().len(), count);
        assert!(
            scene
                .spheres()
                .iter()
                .all(|sphere| sphere.centre()[2] > sphere.radius())
        );
    }
}

#[test]
fn a_camera_among_spheres_has_them_on_all_sides() {
    let among = family("among");
    for &difficulty in &among.difficulties[1..] {
        let scene = among.scene(difficulty, 1);
        let count = |is: fn(f32, f32) -> bool| {
            let spheres = scene.spheres().iter();
            let chosen = spheres.filter(|sphere| is(sphere.centre()[2], sphere.radius()));
            chosen.count()
        };
        assert!(count(|z, radius| z > radius) > 0);
        assert!(count(|z, radius| z < -radius) > 0);
        assert!(count(|z, radius| z.abs() <= radius) > 0);
    }
}

#[test]
fn what_stands_on_a_floor_touches_it() {
    let floor = family("floor");
    for &difficulty in floor.difficulties {
        let scene = floor.scene(difficulty, 1);
        let exact = |at: usize| {
            let sphere = scene.spheres().get(at);
            (sphere.centre().map(f64::from), f64::from(sphere.radius()))
        };
        let all = 0..scene.spheres().len();
        let at = all
            .clone()
            .max_by(|&a, &b| exact(a).1.total_cmp(&exact(b).1));
        let at = at.expect("a floor");
        let (under, radius) = exact(at);
        assert_eq!(radius, difficulty);
        for (centre, size) in all.filter(|&other| other != at).map(exact) {
            let apart = [0, 1, 2].map(|axis| centre[axis] - under[axis]);
            let gap = apart[0].hypot(apart[1]).hypot(apart[2]) - radius - size;
            assert!(gap.abs() < 1e-6 * radius.max(size), "{gap}");
        }
    }
}

#[test]
fn a_frustum_is_filled_from_near_to_far_and_before_the_camera() {
    let frustum = family("frustum");
    for &difficulty in frustum.difficulties {
        let scene = frustum.scene(difficulty, 1);
        let view = scene.viewport();
        let (mut near, mut far) = (f32::INFINITY, 0.0_f32);
        for sphere in scene.spheres().iter() {
            let [x, y, z] = sphere.centre();
            assert!(z > sphere.radius());
            assert!(2.0 * x.abs() <= 1.001 * view.width() * z && 2.0 * y.abs() <= 1.001 * z);
            (near, far) = (near.min(z), far.max(z));
        }
        assert!(far < 100.1 && near < 60.0 && far > 60.0, "{near} to {far}");
    }
}

#[test]
fn spheres_touch_the_plane_exactly_and_do_not_hold_the_camera() {
    let touching = family("touching the plane");
    for &difficulty in touching.difficulties {
        for sphere in touching.scene(difficulty, 1).spheres().iter() {
            let [x, y, z] = sphere.centre();
            assert_eq!(z, sphere.radius());
            assert!(x != 0.0 && y != 0.0);
        }
    }
}

#[test]
fn a_term_of_d_is_exactly_zero() {
    for (name, axis) in [("linear in x", 1), ("linear in y", 0)] {
        let linear = family(name);
        for &difficulty in linear.difficulties {
            for sphere in linear.scene(difficulty, 1).spheres().iter() {
                // Whole numbers below 2^26: no rounding.
                let aside = f64::from(sphere.centre()[axis]);
                let [z, r] = [sphere.centre()[2], sphere.radius()].map(f64::from);
                assert_eq!(aside * aside + z * z, r * r);
            }
        }
    }
}

#[test]
fn a_wide_viewport_sees_spheres_across_the_plane() {
    let wide = family("wide");
    for &difficulty in wide.difficulties {
        let scene = wide.scene(difficulty, 1);
        assert_eq!(f64::from(scene.viewport().width()), difficulty);
        for sphere in scene.spheres().iter() {
            let [x, y, z] = sphere.centre();
            assert!(z.abs() < sphere.radius() && x.hypot(y) > sphere.radius());
        }
    }
}

#[test]
fn copies_come_in_runs_and_apart() {
    let copies = family("copies");
    for &difficulty in copies.difficulties {
        let scene = copies.scene(difficulty, 1);
        let body = |at: usize| {
            let sphere = scene.spheres().get(at);
            (sphere.centre().map(f32::to_bits), sphere.radius().to_bits())
        };
        let bodies: Vec<_> = (0..scene.spheres().len()).map(body).collect();
        let turns = difficulty as usize;
        assert_eq!(bodies.len(), 9 * turns);
        assert_eq!(bodies.iter().collect::<HashSet<_>>().len(), 6 + turns);
        assert!(bodies.windows(2).any(|pair| pair[0] == pair[1]));
        let last = bodies.iter().rposition(|body| *body == bodies[0]);
        assert!(last >= Some(9 * (turns - 1)), "its copies are apart");
    }
}

#[test]
fn near_ties_are_not_ties() {
    let near = family("near ties");
    for &difficulty in near.difficulties {
        let scene = near.scene(difficulty, 1);
        let centres: HashSet<_> = scene
            .spheres()
            .iter()
            .map(|sphere| sphere.centre().map(f32::to_bits))
            .collect();
        assert_eq!(centres.len(), scene.spheres().len());
        for sphere in scene.spheres().iter() {
            let [x, y, z] = sphere.centre();
            assert!(f64::from(x.hypot(y) / z) <= 3.001 * difficulty);
        }
    }
}

#[test]
fn atoms_of_a_molecule_are_bound_to_the_one_before() {
    let molecule = family("molecule");
    for &difficulty in molecule.difficulties {
        let scene = molecule.scene(difficulty, 1);
        let spheres: Vec<_> = scene.spheres().iter().collect();
        assert_eq!(spheres.len() as f64, difficulty);
        for pair in spheres.windows(2) {
            let apart = [0, 1, 2].map(|axis| pair[1].centre()[axis] - pair[0].centre()[axis]);
            let bond = apart[0].hypot(apart[1]).hypot(apart[2]);
            assert!(bond < pair[0].radius() + pair[1].radius(), "{bond}");
        }
        assert!(
            spheres
                .iter()
                .all(|sphere| sphere.centre()[2] > sphere.radius())
        );
    }
}
