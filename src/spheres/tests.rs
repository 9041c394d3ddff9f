//! The structure of arrays: what is stored, and the padding behind it.

use super::*;

fn sphere(index: usize) -> Sphere {
    let number = index as f32;
    Sphere {
        centre: [number, -number, 0.5 * number],
        radius: number + 1.0,
        colour: [index as u8, 1, 2],
    }
}

fn first(count: usize) -> Spheres {
    (0..count).map(sphere).collect()
}

/// Checks the spheres, and that only whole packets of them and of padding are stored.
fn assert_holds(spheres: &Spheres, expected: &[Sphere]) {
    assert_eq!(spheres.len(), expected.len());
    assert_eq!(spheres.is_empty(), expected.is_empty());
    assert_eq!(spheres.iter().collect::<Vec<_>>(), expected);
    let padded = expected.len().next_multiple_of(LANES);
    let [x, y, z, radius] = [spheres.x(), spheres.y(), spheres.z(), spheres.radius()];
    assert_eq!(
        [x.len(), y.len(), z.len(), radius.len()],
        [padded; 4],
        "{} spheres",
        expected.len()
    );
    for lane in expected.len()..padded {
        assert!(z[lane] + radius[lane] < 0.0, "a sphere that can be seen");
        assert!(x[lane].is_finite() && y[lane].is_finite() && radius[lane] > 0.0);
    }
}

/// Counts around one and two packets.
fn counts() -> std::ops::RangeInclusive<usize> {
    0..=2 * LANES + 1
}

#[test]
fn pushed_spheres_are_stored_in_order() {
    for count in counts() {
        let expected: Vec<Sphere> = (0..count).map(sphere).collect();
        assert_holds(&first(count), &expected);
    }
}

#[test]
fn slots_are_filled_in_any_order() {
    for count in counts() {
        for more in counts() {
            let mut spheres = first(count);
            let slots = spheres.try_grow(more).expect("memory");
            assert_eq!(slots.len(), more);
            let (mut low, mut high) = slots.split_at(more / 3);
            for index in (0..high.len()).rev() {
                high.set(index, sphere(count + more / 3 + index));
            }
            for index in 0..low.len() {
                low.set(index, sphere(count + index));
            }
            let expected: Vec<Sphere> = (0..count + more).map(sphere).collect();
            assert_holds(&spheres, &expected);
        }
    }
}

#[test]
fn spheres_are_moved_and_dropped() {
    let all = 2 * LANES + 1;
    for kept in 0..=all {
        for dropped in 0..=all - kept {
            let mut spheres = first(all);
            // Drops the spheres before `dropped`, and those after the kept ones.
            spheres.copy_within(dropped..dropped + kept, 0);
            spheres.truncate(kept);
            let expected: Vec<Sphere> = (dropped..dropped + kept).map(sphere).collect();
            assert_holds(&spheres, &expected);
            spheres.truncate(all);
            assert_holds(&spheres, &expected);
            spheres.push(sphere(0));
            assert_holds(&spheres, &[&*expected, &[sphere(0)]].concat());
        }
    }
}

#[test]
fn more_spheres_than_memory_are_an_error() {
    let mut spheres = first(3);
    assert!(spheres.try_reserve_exact(usize::MAX).is_err());
    assert!(spheres.try_reserve_exact(usize::MAX / LANES).is_err());
    assert!(spheres.try_grow(usize::MAX / LANES).is_err());
    assert_holds(&spheres, &[sphere(0), sphere(1), sphere(2)]);
}
