//! Families of scenes, each with one parameter of difficulty.
//!
//! Methods fail for spheres that are very far, very large or very close together. Each family
//! varies one such parameter and keeps the others. A scene depends only on its family,
//! difficulty and seed, so that every figure can be measured again.
//!
//! Every sphere of a scene has another colour, none of them that of the background, so a pixel
//! that shows the wrong sphere has the wrong colour.

use crate::{
    camera::power_of_two,
    random::Random,
    scene::{Scene, Viewport},
    spheres::{Rgb, Sphere},
};

/// Scenes that differ in one parameter of difficulty.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Its name.
    pub name: &'static str,
    /// The name of the parameter, for the axis of a chart.
    pub parameter: &'static str,
    /// The values of the parameter at which methods are measured, the easiest first.
    pub difficulties: &'static [f64],
    draw: fn(f64, &mut Random) -> (Viewport, Vec<Body>),
}

impl Family {
    /// The scene of one difficulty and seed.
    #[must_use]
    pub fn scene(&self, difficulty: f64, seed: u64) -> Scene {
        let (viewport, bodies) = (self.draw)(difficulty, &mut Random::new(seed));
        let spheres = bodies.into_iter().enumerate();
        Scene {
            viewport,
            background: BACKGROUND,
            spheres: spheres
                .map(|(index, body)| Sphere {
                    centre: body.centre.map(|length| length as f32),
                    radius: body.radius as f32,
                    colour: colour(index),
                })
                .collect(),
        }
    }
}

/// Ascending powers of ten.
const FROM_TEN_UP: [f64; 7] = [1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

/// Descending powers of ten.
const FROM_TENTH_DOWN: [f64; 7] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// From coordinates near the subnormals to coordinates near the largest float.
const SCALES: [f64; 14] = {
    let mut scales = [0.0; 14];
    let mut index = 0;
    while index < scales.len() {
        scales[index] = power_of_two(20 * index as i32 - 140);
        index += 1;
    }
    scales
};

/// Every family.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "far",
        parameter: "distance / radius",
        difficulties: &FROM_TEN_UP,
        draw: far,
    },
    Family {
        name: "huge",
        parameter: "radius / distance of the surface",
        difficulties: FROM_TEN_UP.split_at(6).0,
        draw: huge,
    },
    Family {
        name: "shells",
        parameter: "gap between shells / distance",
        difficulties: &FROM_TENTH_DOWN,
        draw: shells,
    },
    Family {
        name: "interpenetrating",
        parameter: "shift of the centre / distance",
        difficulties: &FROM_TENTH_DOWN,
        draw: interpenetrating,
    },
    Family {
        name: "equal",
        parameter: "equal spheres on one place",
        difficulties: &[1.0, 2.0, 4.0, 8.0, 16.0],
        draw: equal,
    },
    Family {
        name: "tangent",
        parameter: "distance / radius (D = 0)",
        difficulties: FROM_TEN_UP.split_at(6).0,
        draw: tangent,
    },
    Family {
        name: "almost tangent",
        parameter: "gap / radius",
        difficulties: &FROM_TENTH_DOWN,
        draw: almost_tangent,
    },
    Family {
        name: "inside",
        parameter: "distance of the wall / radius",
        difficulties: &FROM_TENTH_DOWN,
        draw: inside,
    },
    Family {
        name: "on the surface",
        parameter: "radius",
        difficulties: FROM_TEN_UP.split_at(6).0,
        draw: on_the_surface,
    },
    Family {
        name: "concentric",
        parameter: "gap between walls / radius",
        difficulties: &FROM_TENTH_DOWN,
        draw: concentric,
    },
    Family {
        name: "beside",
        parameter: "distance of the surface / radius",
        difficulties: &FROM_TENTH_DOWN,
        draw: beside,
    },
    Family {
        name: "scale",
        parameter: "scale of the whole scene",
        difficulties: &SCALES,
        draw: scale,
    },
    Family {
        name: "lattice",
        parameter: "spheres",
        difficulties: &[8.0, 64.0, 512.0, 4096.0],
        draw: lattice,
    },
    CLOUD,
    Family {
        name: "frustum",
        parameter: "spheres",
        difficulties: &[10.0, 100.0, 1_000.0],
        draw: frustum,
    },
    Family {
        name: "molecule",
        parameter: "atoms",
        difficulties: &[10.0, 100.0, 1_000.0],
        draw: molecule,
    },
    Family {
        name: "among",
        parameter: "spheres",
        difficulties: &[10.0, 100.0, 1_000.0],
        draw: among,
    },
    Family {
        name: "floor",
        parameter: "radius of the floor / of a sphere on it",
        difficulties: FROM_TEN_UP.split_at(6).0,
        draw: floor,
    },
    Family {
        name: "touching the plane",
        parameter: "radius / distance of the surface",
        difficulties: FROM_TEN_UP.split_at(6).0,
        draw: touching_the_plane,
    },
    Family {
        name: "linear in x",
        parameter: "radius / distance of the surface",
        difficulties: FROM_TEN_UP.split_at(5).0,
        draw: |radius, random| linear(radius, random, |[away, aside, ahead]| [away, aside, ahead]),
    },
    Family {
        name: "linear in y",
        parameter: "radius / distance of the surface",
        difficulties: FROM_TEN_UP.split_at(5).0,
        draw: |radius, random| linear(radius, random, |[away, aside, ahead]| [aside, away, ahead]),
    },
    Family {
        name: "wide",
        parameter: "width of the viewport / distance",
        difficulties: FROM_TEN_UP.split_at(5).0,
        draw: wide,
    },
    Family {
        name: "copies",
        parameter: "equal spheres, in runs and apart",
        difficulties: &[1.0, 2.0, 4.0, 8.0, 16.0],
        draw: copies,
    },
    Family {
        name: "near ties",
        parameter: "shift of the centre / distance",
        difficulties: &[1e-8, 1e-12, 1e-16, 1e-20, 1e-24, 1e-28, 1e-32, 1e-36],
        draw: near_ties,
    },
];

const CLOUD: Family = Family {
    name: "cloud",
    parameter: "spheres",
    difficulties: &[10.0, 100.0, 1_000.0, 10_000.0],
    draw: scatter,
};

/// `count` spheres spread evenly over a box in front of the camera that fills
/// the view, of radii that shrink like `count^(-1/3)`.
#[must_use]
pub fn cloud(count: usize, seed: u64) -> Scene {
    CLOUD.scene(count as f64, seed)
}

/// A colour that no sphere has.
const BACKGROUND: Rgb = [0; 3];

/// A different colour for each of the first 2^24 - 1 spheres: multiplying by an odd number
/// permutes the numbers modulo 2^24, and 0 is left for the background.
fn colour(index: usize) -> Rgb {
    const ODD: u32 = 0x9e_37_79;
    let [_, red, green, blue] = (index as u32 + 1).wrapping_mul(ODD).to_be_bytes();
    [red, green, blue]
}

/// A sphere before its lengths are rounded to floats.
struct Body {
    centre: Vector,
    radius: f64,
}

type Vector = [f64; 3];

fn times(factor: f64, vector: Vector) -> Vector {
    vector.map(|component| factor * component)
}

fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn length(vector: Vector) -> f64 {
    vector
        .iter()
        .map(|component| component * component)
        .sum::<f64>()
        .sqrt()
}

const fn viewport(width: f32, height: f32, distance: f32) -> Viewport {
    Viewport {
        width,
        height,
        distance,
    }
}

/// A cluster at a distance, the viewport narrowed so that it fills the picture.
fn far(distance: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let cluster = (0..8).map(|_| Body {
        centre: [
            random.between(-2.0, 2.0),
            random.between(-1.5, 1.5),
            distance + random.between(-2.0, 2.0),
        ],
        radius: random.between(0.5, 1.5),
    });
    (viewport(6.4, 4.8, distance as f32), cluster.collect())
}

/// A floor and a wall that are spheres, seen at grazing angles from one unit away,
/// and small spheres half sunk into the floor.
fn huge(radius: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let tilt = random.between(-0.2, 0.2);
    let down = [tilt.sin(), -tilt.cos(), 0.05];
    let aside = [tilt.cos(), tilt.sin(), 0.3];
    let touching = |direction: Vector, height: f64| Body {
        centre: times((radius + height) / length(direction), direction),
        radius,
    };
    let mut bodies = vec![touching(down, 1.0), touching(aside, 3.0)];
    bodies.extend((0..4).map(|_| {
        let along = random.between(4.0, 12.0);
        Body {
            centre: plus(down, [random.between(-3.0, 3.0), 0.0, along]),
            radius: random.between(0.5, 1.0),
        }
    }));
    (viewport(1.6, 1.2, 1.0), bodies)
}

/// Nested shells, their order in the file shuffled: the outermost is seen.
fn shells(gap: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = nests(random, |random, bodies| {
        let centre = in_view(random);
        let innermost = random.between(0.5, 0.8);
        for shell in 0..4 {
            bodies.push(Body {
                centre,
                radius: innermost + f64::from(shell) * gap * length(centre),
            });
        }
    });
    (viewport(1.6, 1.2, 1.0), bodies)
}

/// Equal radii, centres a little apart: each is nearer on its side of a seam.
fn interpenetrating(shift: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = nests(random, |random, bodies| {
        let centre = in_view(random);
        let radius = random.between(0.6, 1.0);
        for _ in 0..3 {
            let apart = times(shift * length(centre), random.direction());
            bodies.push(Body {
                centre: plus(centre, apart),
                radius,
            });
        }
    });
    (viewport(1.6, 1.2, 1.0), bodies)
}

/// The same spheres again and again, in other colours: the first is seen.
fn equal(copies: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let originals: [(Vector, f64); 4] =
        std::array::from_fn(|_| (in_view(random), random.between(0.5, 1.0)));
    let bodies = (0..copies as usize).flat_map(|_| originals);
    let bodies = bodies.map(|(centre, radius)| Body { centre, radius });
    (viewport(1.6, 1.2, 1.0), bodies.collect())
}

/// Spheres that touch the ray through the centre of a pixel, exactly, if
/// `width - 1` is a multiple of 64 and `height - 1` one of 48.
fn tangent(distance: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    touching_rays(distance, random, |_| 0.0)
}

/// Spheres that miss the ray through the centre of a pixel by a little, or cover it.
fn almost_tangent(gap: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    touching_rays(
        10.0,
        random,
        |random| if random.below(2) == 0 { gap } else { -gap },
    )
}

/// With the viewport 64 by 48, the ray of such a pixel is `V = (x, y, z)` of whole
/// numbers. For `n` in the plane of the viewport, at right angles to `V` and of
/// whole length, the sphere around `k V + n` with radius `|n|` touches it.
fn touching_rays(
    distance: f64,
    random: &mut Random,
    gap: impl Fn(&mut Random) -> f64,
) -> (Viewport, Vec<Body>) {
    const RADIUS: f64 = 5.0;
    let z = distance * RADIUS;
    let bodies = (0..16).map(|body| {
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let (x, y, normal) = match body % 4 {
            0 => (random.whole(24), 0.0, [0.0, RADIUS, 0.0]),
            1 => (0.0, random.whole(18), [RADIUS, 0.0, 0.0]),
            2 => {
                let m = random.whole(4);
                (4.0 * m, 3.0 * m, [-3.0, 4.0, 0.0])
            }
            _ => {
                let m = random.whole(4);
                (3.0 * m, -4.0 * m, [4.0, 3.0, 0.0])
            }
        };
        let k = 1.0 + random.below(2) as f64;
        Body {
            centre: plus(times(k, [x, y, z]), times(side, normal)),
            radius: RADIUS * (1.0 + gap(random)),
        }
    });
    let bodies = bodies.collect();
    (viewport(64.0, 48.0, z as f32), bodies)
}

/// Far walls of spheres that contain the camera, close to their surface.
fn inside(gap: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = (0..3).map(|_| {
        let radius = random.between(1.0, 2.0);
        let distance = radius * (1.0 - gap * random.between(0.5, 1.0));
        Body {
            centre: times(distance, random.direction()),
            radius,
        }
    });
    (viewport(3.2, 2.4, 1.0), bodies.collect())
}

/// Spheres on whose surface the camera is, exactly: `3^2 + 4^2 + 12^2 = 13^2`.
fn on_the_surface(radius: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    const DIRECTIONS: [Vector; 6] = [
        [3.0, 4.0, 12.0],
        [-4.0, -3.0, 12.0],
        [12.0, 4.0, 3.0],
        [-12.0, 3.0, 4.0],
        [4.0, 12.0, 3.0],
        [3.0, -12.0, -4.0],
    ];
    let bodies = DIRECTIONS.map(|direction| {
        let unit = (radius * random.between(0.5, 1.0)).ceil();
        Body {
            centre: times(unit, direction),
            radius: 13.0 * unit,
        }
    });
    (viewport(3.2, 2.4, 1.0), bodies.into())
}

/// Nested walls around the camera, their order in the file shuffled: the innermost is seen.
fn concentric(gap: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let centre = times(random.between(0.2, 0.5), random.direction());
    let mut bodies: Vec<Body> = (0..6)
        .map(|wall| Body {
            centre,
            radius: 1.0 + f64::from(wall) * gap,
        })
        .collect();
    random.shuffle(&mut bodies);
    // One is off centre, so that a seam is visible.
    bodies[0].centre = plus(centre, times(gap, random.direction()));
    (viewport(3.2, 2.4, 1.0), bodies)
}

/// Spheres whose surface is close to the camera and reaches behind its plane, and spheres
/// entirely behind it.
fn beside(gap: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let mut bodies: Vec<Body> = (0..5)
        .map(|_| {
            let radius = random.between(0.5, 2.0);
            let [x, y, _] = random.direction();
            let direction = [x, y, random.between(-0.1, 0.5)];
            Body {
                centre: times(radius * (1.0 + gap) / length(direction), direction),
                radius,
            }
        })
        .collect();
    bodies.extend((0..3).map(|_| Body {
        centre: [random.between(-1.0, 1.0), random.between(-1.0, 1.0), -2.0],
        radius: random.between(0.5, 1.5),
    }));
    random.shuffle(&mut bodies);
    (viewport(6.4, 4.8, 1.0), bodies)
}

/// A cluster near the camera, with all lengths of the scene multiplied by a power of two.
fn scale(factor: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = (0..8).map(|_| Body {
        centre: times(factor, in_view(random)),
        radius: factor * random.between(0.5, 1.0),
    });
    let bodies = bodies.collect();
    let side = |length: f64| (length * factor) as f32;
    (viewport(side(1.6), side(1.2), side(1.0)), bodies)
}

/// A crystal: a tilted cube of touching and overlapping atoms of two sizes.
fn lattice(spheres: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let side = spheres.cbrt().round() as usize;
    let (turn, tilt) = (random.between(0.2, 0.6), random.between(0.2, 0.6));
    let middle = (side as f64 - 1.0) / 2.0;
    let distance = 2.5 * side as f64;
    let place = |index: usize| index as f64 - middle;
    let atoms = (0..side * side * side).map(|index| {
        let (i, j, k) = (index % side, index / side % side, index / side / side);
        let (x, y, z) = (place(i), place(j), place(k));
        let (x, z) = (
            x * turn.cos() - z * turn.sin(),
            x * turn.sin() + z * turn.cos(),
        );
        let (y, z) = (
            y * tilt.cos() - z * tilt.sin(),
            y * tilt.sin() + z * tilt.cos(),
        );
        Body {
            centre: [x, y, z + distance],
            radius: if (i + j + k).is_multiple_of(2) {
                0.6
            } else {
                0.4
            },
        }
    });
    (viewport(1.0, 0.75, 1.2), atoms.collect())
}

/// Spheres spread evenly over a box that fills the view.
fn scatter(count: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let largest = 0.5 / count.cbrt();
    let bodies = (0..count as usize).map(|_| Body {
        centre: [
            random.between(-2.0, 2.0),
            random.between(-1.2, 1.2),
            random.between(2.0, 4.0),
        ],
        radius: largest * random.between(0.5, 1.0),
    });
    (viewport(16.0 / 9.0, 1.0, 1.0), bodies.collect())
}

/// Spheres spread evenly over the space that the camera sees, from near to far, so
/// large that they cover about as much of the picture whatever their number.
fn frustum(count: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    const NEAR: f64 = 2.0;
    const FAR: f64 = 100.0;
    const WIDTH: f64 = 16.0 / 9.0;
    let mean_inverse_square = 3.0 * (FAR - NEAR) / (FAR.powi(3) - NEAR.powi(3));
    let radius = (1.5 * WIDTH / (std::f64::consts::PI * count * mean_inverse_square)).sqrt();
    let bodies = (0..count as usize).map(|_| {
        let z = random.between(NEAR.powi(3), FAR.powi(3)).cbrt();
        Body {
            centre: [
                random.between(-0.5, 0.5) * WIDTH * z,
                random.between(-0.5, 0.5) * z,
                z,
            ],
            radius: (radius * random.between(0.5, 1.5)).min(z - 1.0),
        }
    });
    let bodies = bodies.collect();
    (viewport(WIDTH as f32, 1.0, 1.0), bodies)
}

/// A folded chain of atoms with the radii of carbon, nitrogen, oxygen and sulphur in
/// tenths of a nanometre, each bound to the one before and pushed back where it would
/// leave the globule, which fills the height of the picture.
fn molecule(atoms: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    const RADII: [f64; 4] = [1.7, 1.55, 1.52, 1.8];
    const BOND: f64 = 1.45;
    let globule = 1.3 * atoms.cbrt();
    let distance = 3.0 * globule + 4.0;
    let (mut place, mut along) = ([0.0; 3], random.direction());
    let bodies = (0..atoms as usize).map(|_| {
        let back = if length(place) > globule { 1.0 } else { 0.0 };
        let turned = plus(
            plus(along, random.direction()),
            times(-back / globule, place),
        );
        along = times(length(turned).max(0.1).recip(), turned);
        place = plus(place, times(BOND, along));
        Body {
            centre: plus(place, [0.0, 0.0, distance]),
            radius: RADII[random.below(4) as usize],
        }
    });
    let bodies = bodies.collect();
    (viewport(16.0 / 15.0, 0.6, 0.8), bodies)
}

/// A crowd on all sides of the camera: some in front of it, some behind, some across its
/// plane, and among few large ones some that contain it.
fn among(count: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let largest = 2.0 / count.cbrt();
    let bodies = (0..count as usize).map(|_| Body {
        centre: std::array::from_fn(|_| random.between(-2.0, 2.0)),
        radius: largest * random.between(0.2, 1.0),
    });
    (viewport(3.2, 2.4, 1.0), bodies.collect())
}

/// A floor that is a sphere, and small spheres on it, near and far.
fn floor(radius: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let centre = [0.0, -radius - random.between(0.8, 1.5), 0.0];
    let mut bodies = vec![Body { centre, radius }];
    bodies.extend((0..24).map(|_| {
        let [x, z] = [random.between(-3.0, 3.0), random.between(1.5, 9.0)];
        let up = [x, radius, z];
        let size = random.between(0.3, 1.0);
        Body {
            centre: plus(centre, times((radius + size) / length(up), up)),
            radius: size,
        }
    }));
    random.shuffle(&mut bodies);
    (viewport(1.6, 1.2, 1.0), bodies)
}

/// Spheres that touch the plane of the camera, exactly: their outlines are parabolas.
fn touching_the_plane(radius: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = (0..6).map(|_| {
        let radius = radius * random.between(0.3, 1.0);
        let angle = random.between(0.0, std::f64::consts::TAU);
        let away = aside_of_unit_gap(radius) * random.between(0.5, 2.0);
        Body {
            centre: [away * angle.cos(), away * angle.sin(), radius],
            radius,
        }
    });
    (viewport(6.4, 4.8, 1.0), bodies.collect())
}

/// The distance from the axis of a sphere that reaches the plane of the camera, if its surface
/// is one unit away: `away^2 + radius^2 = (radius + 1)^2`.
fn aside_of_unit_gap(radius: f64) -> f64 {
    (2.0 * radius + 1.0).sqrt()
}

/// Spheres across the plane of the camera for which `D` has no term in x², exactly: a row
/// meets their outline once. Where `place` swaps both axes, the term in y² is missing, and
/// a column meets it once. In whole numbers, `aside^2 + ahead^2 = radius^2`.
fn linear(radius: f64, random: &mut Random, place: fn(Vector) -> Vector) -> (Viewport, Vec<Body>) {
    // 3^2 + 4^2 = 5^2, and others.
    const ASIDE_AHEAD_RADIUS: [[f64; 3]; 8] = [
        [3.0, 4.0, 5.0],
        [4.0, 3.0, 5.0],
        [-4.0, 3.0, 5.0],
        [5.0, -12.0, 13.0],
        [-12.0, 5.0, 13.0],
        [0.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
        [8.0, 15.0, 17.0],
    ];
    let bodies = ASIDE_AHEAD_RADIUS.map(|[aside, ahead, across]| {
        let unit = (radius / across * random.between(0.5, 1.0)).ceil();
        let side = if random.below(2) == 0 { 1.0 } else { -1.0 };
        let away = side * aside_of_unit_gap(unit * across) * random.between(0.5, 2.0);
        Body {
            centre: place([away, unit * aside, unit * ahead]),
            radius: unit * across,
        }
    });
    (viewport(6.4, 4.8, 1.0), bodies.into())
}

/// A viewport so wide that it sees far along spheres that cross the plane of the
/// camera; their outlines are hyperbolas.
fn wide(width: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let bodies = (0..10).map(|_| {
        let angle = random.between(0.0, std::f64::consts::TAU);
        let radius = random.between(0.3, 1.5);
        let away = radius * random.between(1.01, 3.0);
        Body {
            centre: [
                away * angle.cos(),
                away * angle.sin(),
                radius * random.between(-0.99, 0.99),
            ],
            radius,
        }
    });
    let bodies = bodies.collect();
    (viewport(width as f32, 0.75 * width as f32, 1.0), bodies)
}

/// Equal spheres in other colours, next to each other in the file and far apart, with
/// others between them: the first of each is seen.
fn copies(copies: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    let mut one = || (in_view(random), random.between(0.3, 0.8));
    let originals: [(Vector, f64); 6] = std::array::from_fn(|_| one());
    let mut places: Vec<(Vector, f64)> = Vec::new();
    for turn in 0..copies as usize {
        places.extend(originals);
        places.push(one());
        // Next to its copy.
        let again = originals[turn % originals.len()];
        places.extend([again, again]);
    }
    let bodies = places.into_iter();
    let bodies = bodies.map(|(centre, radius)| Body { centre, radius });
    (viewport(1.6, 1.2, 1.0), bodies.collect())
}

/// Large spheres of one radius whose distances differ by less than the last digit of a float:
/// their centres are near the axis, where floats can represent the shift.
fn near_ties(shift: f64, random: &mut Random) -> (Viewport, Vec<Body>) {
    const DISTANCE: f64 = 10.0;
    let mut bodies: Vec<Body> = (0..4)
        .map(|index| {
            let away = DISTANCE * shift * f64::from(index);
            let angle = random.between(0.0, std::f64::consts::TAU);
            Body {
                centre: [away * angle.cos(), away * angle.sin(), DISTANCE],
                radius: 3.0,
            }
        })
        .collect();
    random.shuffle(&mut bodies);
    (viewport(1.6, 1.2, 1.0), bodies)
}

/// Three nests of spheres, their order in the file shuffled.
fn nests(random: &mut Random, nest: impl Fn(&mut Random, &mut Vec<Body>)) -> Vec<Body> {
    let mut bodies = Vec::new();
    for _ in 0..3 {
        nest(random, &mut bodies);
    }
    random.shuffle(&mut bodies);
    bodies
}

/// A centre some units in front of the camera.
fn in_view(random: &mut Random) -> Vector {
    [
        random.between(-2.0, 2.0),
        random.between(-1.5, 1.5),
        random.between(3.0, 6.0),
    ]
}
