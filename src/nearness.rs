//! How near a pixel is to showing the colour that another program drew.
//!
//! Rounding changes the visible sphere only beside an outline, or where two spheres are nearly
//! equally far. So the distance of wrong pixels from such places distinguishes rounding from a
//! programming mistake.
//!
//! With `P` the step from a ray to that of the next pixel, the `D` of
//! [`reference`](mod@crate::reference) along a line of pixels is
//!
//! ```text
//! D(h) = D + 2 (B C.P - c V.P) h + ((C.P)^2 - c P.P) h^2
//! ```
//!
//! and the outline is where it is zero. The distance used here is the least such `h` in the
//! direction of the gradient, which approximates small distances.

use crate::{
    camera::{Camera, ImageSize},
    reference::{Outline, Reference},
    scene::Scene,
    spheres::{Rgb, Sphere, Spheres},
};

/// What a pixel shows, and why another program may have drawn another colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The index of the sphere that the pixel shows; `None` is the background.
    pub seen: Option<usize>,
    /// The least change by which the pixel would show the colour found there;
    /// `None` if no change of its ray by some pixels would.
    pub cause: Option<Cause>,
    /// The relative error of the squares in the textbook formula, `b^2 - 4ac`, that would have
    /// this effect; infinite if there is no cause.
    pub rounding: f64,
}

/// Why a pixel nearly shows another colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// The outline of this sphere is near.
    Outline {
        /// The index of the sphere.
        sphere: usize,
        /// The distance, in pixels.
        pixels: f64,
    },
    /// This sphere is at nearly the same distance.
    Tie {
        /// The index of the sphere.
        sphere: usize,
        /// How much farther it is, relative to the distance of the visible one.
        gap: f64,
    },
}

impl Cause {
    /// The pixels to the outline, or the relative gap.
    #[must_use]
    pub fn distance(self) -> f64 {
        match self {
            Self::Outline { pixels, .. } => pixels,
            Self::Tie { gap, .. } => gap,
        }
    }

    /// The index of the sphere.
    #[must_use]
    pub fn sphere(self) -> usize {
        match self {
            Self::Outline { sphere, .. } | Self::Tie { sphere, .. } => sphere,
        }
    }

    fn nearer(self, other: Option<Self>) -> Self {
        match other {
            Some(other) if other.distance() <= self.distance() => other,
            _ => self,
        }
    }
}

/// Judges single pixels of a scene at one image size.
///
/// ```
/// use sfera::{camera::ImageSize, nearness::{Cause, Judge}, scene::Scene};
///
/// // The outline goes through the pixel at 3 of 5, x = 0.25.
/// let scene = Scene::parse(b"VP 1 1 1 BG 9 9 9 OBJ_N 1 S 0 0 4.123106 1 200 0 0")?;
/// let judge = Judge::new(&scene, ImageSize::new(5, 1)?);
/// let verdict = judge.judge((3, 0), [9, 9, 9], [200, 0, 0]);
/// let Some(Cause::Outline { sphere: 0, pixels }) = verdict.cause else { panic!() };
/// assert!(verdict.seen.is_none() && pixels < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Judge<'scene> {
    scene: &'scene Scene,
    camera: Camera,
}

/// An upper bound of the relative error of inverse depths in doubles, unless the camera is at
/// the surface of the sphere.
const DEPTH_DOUBT: f64 = 1e-6;

/// If the camera is nearer to a surface than this, relative to its distance from the centre,
/// doubles are not used.
const SURFACE_DOUBT: f64 = 1e-9;

/// If `D` in doubles is below this fraction of `r^2 A`, its sign is uncertain.
const OUTLINE_DOUBT: f64 = 1e-6;

impl<'scene> Judge<'scene> {
    /// The judge of `scene` as an image of `size`.
    #[must_use]
    pub fn new(scene: &'scene Scene, size: ImageSize) -> Self {
        Self {
            scene,
            camera: Camera::new(scene.viewport, size),
        }
    }

    /// Judges a pixel, given as column and row, whose `right` colour differs from the one
    /// `found`. Its time grows with the number of spheres.
    #[must_use]
    pub fn judge(&self, pixel: (u32, u32), right: Rgb, found: Rgb) -> Verdict {
        let ray = Ray::new(&self.camera, pixel);
        let seen = self.seen(&ray, pixel, right);
        let estimate = self.verdict(&ray, seen, found);
        let cause = estimate.cause.map(|cause| match cause {
            Cause::Outline { sphere, pixels } => Cause::Outline {
                sphere,
                pixels: self
                    .exact(&[sphere])
                    .outline(0, pixel)
                    .map_or(pixels, Outline::distance),
            },
            Cause::Tie { sphere, gap } => Cause::Tie {
                sphere,
                gap: seen
                    .and_then(|seen| self.exact(&[seen, sphere]).gap([0, 1], pixel))
                    .unwrap_or(gap),
            },
        });
        Verdict { cause, ..estimate }
    }

    /// Like [`judge`](Self::judge), but only in doubles: it may be wrong in very close cases,
    /// but is always fast.
    #[must_use]
    pub fn estimate(&self, pixel: (u32, u32), right: Rgb, found: Rgb) -> Verdict {
        let ray = Ray::new(&self.camera, pixel);
        let candidates = self.candidates(&ray);
        let of_its_colour = candidates
            .iter()
            .find(|&&index| self.colour(Some(index)) == right);
        self.verdict(&ray, of_its_colour.copied(), found)
    }

    /// The sphere that the pixel shows: the reference decides among those that may be nearest.
    fn seen(&self, ray: &Ray, pixel: (u32, u32), right: Rgb) -> Option<usize> {
        let candidates = self.candidates(ray);
        let exact = self.exact(&candidates);
        let seen = exact.seen(pixel.0, pixel.1).map(|index| candidates[index]);
        if self.colour(seen) == right {
            return seen;
        }
        // The error in doubles was greater than the bound above.
        Reference::new(self.scene, self.camera.size()).seen(pixel.0, pixel.1)
    }

    /// The nearest sphere in doubles and all that may be nearer, in file order.
    fn candidates(&self, ray: &Ray) -> Vec<usize> {
        let mut nearest = f64::NEG_INFINITY;
        let mut candidates: Vec<(usize, f64)> = Vec::new();
        for (index, sphere) in self.scene.spheres.iter().enumerate() {
            let sight = ray.sight(&sphere);
            if sight.doubtful {
                candidates.push((index, f64::INFINITY));
            } else if sight.met && sight.depth >= nearest * (1.0 - DEPTH_DOUBT) {
                candidates.push((index, sight.depth));
                if sight.depth > nearest {
                    nearest = sight.depth;
                    candidates.retain(|&(_, depth)| depth >= nearest * (1.0 - DEPTH_DOUBT));
                }
            }
        }
        candidates.into_iter().map(|(index, _)| index).collect()
    }

    /// The verdict in doubles on a pixel that shows `seen`.
    fn verdict(&self, ray: &Ray, seen: Option<usize>, found: Rgb) -> Verdict {
        let background = if found == self.scene.background {
            seen.and_then(|_| self.background_cause(ray))
        } else {
            None
        };
        let cause = self.sphere_cause(ray, seen, found, background);
        let of = |sphere: usize| self.scene.spheres.get(sphere);
        let rounding = match cause {
            None => f64::INFINITY,
            Some(Cause::Outline { sphere, .. }) => ray.error_at_outline(&of(sphere)),
            Some(Cause::Tie { sphere, gap }) => {
                let both = seen.into_iter().chain([sphere]);
                gap / both
                    .map(|sphere| ray.error_growth(&of(sphere)))
                    .sum::<f64>()
            }
        };
        Verdict {
            seen,
            cause,
            rounding,
        }
    }

    fn colour(&self, seen: Option<usize>) -> Rgb {
        seen.map_or(self.scene.background, |index| {
            self.scene.spheres.colour()[index]
        })
    }

    /// The reference of a few spheres of the scene.
    fn exact(&self, spheres: &[usize]) -> Reference {
        let spheres: Spheres = spheres
            .iter()
            .map(|&index| self.scene.spheres.get(index))
            .collect();
        let few = Scene {
            viewport: self.scene.viewport,
            background: self.scene.background,
            spheres,
        };
        Reference::new(&few, self.camera.size())
    }

    /// The cause by which the ray would miss every sphere that it meets.
    fn background_cause(&self, ray: &Ray) -> Option<Cause> {
        let mut farthest: Option<Cause> = None;
        for (sphere, geometry) in self.scene.spheres.iter().enumerate() {
            if !ray.sight(&geometry).met {
                continue;
            }
            let pixels = ray.outline(&geometry)?;
            if farthest.is_none_or(|cause| cause.distance() < pixels) {
                farthest = Some(Cause::Outline { sphere, pixels });
            }
        }
        farthest
    }

    /// The nearest cause by which a sphere of the colour found would be visible, or `best`.
    fn sphere_cause(
        &self,
        ray: &Ray,
        seen: Option<usize>,
        found: Rgb,
        mut best: Option<Cause>,
    ) -> Option<Cause> {
        let leave = seen.and_then(|sphere| {
            let pixels = ray.outline(&self.scene.spheres.get(sphere))?;
            Some(Cause::Outline { sphere, pixels })
        });
        let depth = seen.map(|index| ray.sight(&self.scene.spheres.get(index)).depth);
        for (sphere, &colour) in self.scene.spheres.colour().iter().enumerate() {
            if colour != found || Some(sphere) == seen {
                continue;
            }
            let geometry = self.scene.spheres.get(sphere);
            let sight = ray.sight(&geometry);
            let cause = if let Some(depth) = depth.filter(|_| sight.met) {
                let gap = ((depth - sight.depth) / depth).abs();
                Some(Cause::Tie { sphere, gap }.nearer(leave))
            } else {
                let enter = ray
                    .outline(&geometry)
                    .map(|pixels| Cause::Outline { sphere, pixels });
                let hidden = depth.is_some_and(|depth| depth > sight.depth);
                match (enter, leave) {
                    (Some(enter), Some(leave)) if hidden => {
                        // Both outlines have to be crossed.
                        Some(if leave.distance() > enter.distance() {
                            leave
                        } else {
                            enter
                        })
                    }
                    (_, None) if hidden => None,
                    _ => enter,
                }
            };
            best = cause.map(|cause| cause.nearer(best)).or(best);
        }
        best
    }
}

/// The ray of a pixel in doubles, and the steps to its neighbours.
struct Ray {
    direction: [f64; 3],
    across: [f64; 3],
    down: [f64; 3],
}

/// The intersection of a ray and a sphere in doubles.
struct Sight {
    met: bool,
    /// Whether its sign may be wrong.
    doubtful: bool,
    /// Inverse depth of the hit; for a sphere that is missed, that of its outline.
    depth: f64,
}

impl Ray {
    fn new(camera: &Camera, (column, row): (u32, u32)) -> Self {
        let viewport = camera.viewport();
        let step = |side: u32| f64::from(side.saturating_sub(1).max(1)).recip();
        let size = camera.size();
        Self {
            direction: [
                camera.x_double(column),
                camera.y_double(row),
                camera.z_double(),
            ],
            across: [f64::from(viewport.width) * step(size.width()), 0.0, 0.0],
            down: [0.0, -f64::from(viewport.height) * step(size.height()), 0.0],
        }
    }

    fn sight(&self, sphere: &Sphere) -> Sight {
        let centre = sphere.centre.map(f64::from);
        let squared_radius = f64::from(sphere.radius).powi(2);
        let a = dot(self.direction, self.direction);
        let b = dot(centre, self.direction);
        let squared_distance = dot(centre, centre);
        let c = squared_distance - squared_radius;
        let whole = squared_radius * a;
        let normal = cross(centre, self.direction);
        let d = whole - dot(normal, normal);
        let near_surface = c.abs() <= SURFACE_DOUBT * squared_distance;
        let root = d.max(0.0).sqrt();
        Sight {
            met: c <= 0.0 || (d >= 0.0 && b > 0.0),
            doubtful: near_surface || (c > 0.0 && b > 0.0 && d.abs() <= OUTLINE_DOUBT * whole),
            depth: if c > 0.0 || b <= 0.0 {
                (b.abs() + root) / c.abs()
            } else {
                a / (b + root)
            },
        }
    }

    /// The error of `D`, relative to its squares, by which a hit would become a miss or a miss
    /// a hit.
    fn error_at_outline(&self, sphere: &Sphere) -> f64 {
        let centre = sphere.centre.map(f64::from);
        let a = dot(self.direction, self.direction);
        let normal = cross(centre, self.direction);
        let d = f64::from(sphere.radius).powi(2) * a - dot(normal, normal);
        d.abs() / (a * dot(centre, centre))
    }

    /// The ratio of the relative error of a distance, `(B - sqrt D)/A`, to that of the squares
    /// in `D`.
    fn error_growth(&self, sphere: &Sphere) -> f64 {
        let centre = sphere.centre.map(f64::from);
        let a = dot(self.direction, self.direction);
        let b = dot(centre, self.direction).abs();
        let normal = cross(centre, self.direction);
        let d = f64::from(sphere.radius).powi(2) * a - dot(normal, normal);
        let root = d.max(0.0).sqrt();
        let of_root = a * dot(centre, centre) / (2.0 * root);
        (of_root + b + root) / (b - root).abs()
    }

    /// Pixels to the outline of a sphere that has one in front of the camera.
    fn outline(&self, sphere: &Sphere) -> Option<f64> {
        let centre = sphere.centre.map(f64::from);
        let squared_radius = f64::from(sphere.radius).powi(2);
        let outside = dot(centre, centre) > squared_radius;
        if !outside || dot(centre, self.direction) <= 0.0 {
            return None;
        }
        // D = r^2 V.V - |C x V|^2 for any V, which avoids most of the cancellation.
        let form = |u: [f64; 3], v: [f64; 3]| {
            squared_radius * dot(u, v) - dot(cross(centre, u), cross(centre, v))
        };
        let Self {
            direction,
            across,
            down,
        } = *self;
        let outline = Outline {
            value: form(direction, direction),
            gradient: [2.0 * form(direction, across), 2.0 * form(direction, down)],
            curvature: [form(across, across), form(across, down), form(down, down)],
        };
        Some(outline.distance())
    }
}

fn dot([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> f64 {
    ax * bx + ay * by + az * bz
}

fn cross([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::families::cloud;

    const WHITE: Rgb = [255; 3];
    const RED: Rgb = [200, 0, 0];

    fn size(width: u32, height: u32) -> ImageSize {
        ImageSize::new(width, height).expect("a size with pixels")
    }

    fn pixels(verdict: Verdict) -> f64 {
        match verdict.cause {
            Some(Cause::Outline { pixels, .. }) => pixels,
            cause => panic!("{cause:?}"),
        }
    }

    /// The outline of a sphere straight ahead is a circle.
    #[test]
    fn the_distance_to_a_circle_is_that_to_a_circle() {
        let scene =
            Scene::parse(b"VP 2 2 1 BG 255 255 255 OBJ_N 1 S 0 0 10 1 200 0 0").expect("a scene");
        let side = 2001;
        let judge = Judge::new(&scene, size(side, side));
        // tan of the angle at which the sphere is seen, in pixels.
        let radius = (1.0 / 99.0_f64).sqrt() * f64::from(side - 1) / 2.0;
        let centre = (side - 1) / 2;
        for (column, row) in [
            (1100, 1000),
            (1101, 1000),
            (1071, 929),
            (960, 1060),
            (1000, 1000),
        ] {
            let from_centre = f64::from(column)
                .sub(centre)
                .hypot(f64::from(row).sub(centre));
            let expected = (from_centre - radius).abs();
            let (right, found) = if from_centre < radius {
                (RED, WHITE)
            } else {
                (WHITE, RED)
            };
            let verdict = judge.judge((column, row), right, found);
            assert_eq!(verdict.seen.is_some(), from_centre < radius);
            let distance = pixels(verdict);
            assert!(
                (distance - expected).abs() < 1e-9 * radius,
                "({column}, {row}): {distance} instead of {expected}"
            );
        }
    }

    trait Sub {
        fn sub(self, other: u32) -> f64;
    }

    impl Sub for f64 {
        fn sub(self, other: u32) -> f64 {
            self - f64::from(other)
        }
    }

    /// Distances far below the precision of doubles.
    #[test]
    fn the_smallest_distances_are_exact() {
        // The ray straight ahead touches the sphere, or nearly touches it.
        let beside = |x: f32| {
            let text = format!("VP 1 1 1 BG 255 255 255 OBJ_N 1 S {x:e} 0 1e6 1 200 0 0");
            let scene = Scene::parse(text.as_bytes()).expect("a scene");
            let judge = Judge::new(&scene, size(101, 101));
            pixels(judge.judge((50, 50), WHITE, RED))
        };
        // A pixel is 0.01 wide at distance 1, so 10^4 at the sphere.
        let expected = f64::from(f32::EPSILON) / 1e4;
        let distance = beside(1.0_f32.next_up());
        assert!((distance / expected - 1.0).abs() < 1e-5, "{distance:e}");

        // Walls at 3 and one unit in the last place of a radius behind it.
        let scene = Scene::parse(
            b"VP 1 1 1 BG 0 0 0 OBJ_N 2 S 0 0 4 1 200 0 0 S 0 0 4 0.99999994 255 255 255",
        )
        .expect("a scene");
        let judge = Judge::new(&scene, size(1, 1));
        let verdict = judge.judge((0, 0), RED, WHITE);
        let gap = f64::from(f32::EPSILON) / 2.0 / (3.0 + f64::from(f32::EPSILON) / 2.0);
        match verdict.cause {
            Some(Cause::Tie {
                sphere: 1,
                gap: found,
            }) => {
                assert!(
                    (found / gap - 1.0).abs() < 1e-12,
                    "{found:e} instead of {gap:e}"
                );
            }
            cause => panic!("{cause:?}"),
        }
        assert_eq!(verdict.seen, Some(0));
    }

    #[test]
    fn what_is_behind_or_hidden_or_of_no_sphere_is_no_cause() {
        let scene = Scene::parse(
            b"VP 1 1 1 BG 255 255 255 OBJ_N 3 S 0 0 4 1 200 0 0 S 0 0 -4 1 0 200 0 S 0 9 9 0.5 0 0 200",
        )
        .expect("a scene");
        let judge = Judge::new(&scene, size(11, 11));
        let cause = |found| judge.judge((5, 5), RED, found).cause;
        assert_eq!(cause([0, 200, 0]), None);
        assert_eq!(cause([1, 2, 3]), None);
        assert!(cause([0, 0, 200]).is_some_and(|cause| cause.distance() > 5.0));
        assert!(matches!(
            cause(WHITE),
            Some(Cause::Outline { sphere: 0, .. })
        ));

        // A small sphere close to the ray, behind a large one: both outlines must be crossed.
        let scene =
            Scene::parse(b"VP 1 1 1 BG 9 9 9 OBJ_N 2 S 0 0 4 1 200 0 0 S 0.3 0 8 0.1 255 255 255");
        let scene = scene.expect("a scene");
        let hidden = Judge::new(&scene, size(11, 11)).judge((5, 5), RED, WHITE);
        assert!(
            (pixels(hidden) - 10.0 / 15.0_f64.sqrt()).abs() < 1e-9,
            "{hidden:?}"
        );
    }

    #[test]
    fn doubles_and_integers_agree_where_nothing_is_small() {
        let scene = cloud(300, 5);
        let size = size(31, 23);
        let judge = Judge::new(&scene, size);
        let reference = Reference::new(&scene, size);
        let colours = scene.spheres.colour();
        let mut causes = 0;
        for row in 0..23 {
            for column in 0..31 {
                let seen = reference.seen(column, row);
                let right = seen.map_or(scene.background, |index| colours[index]);
                for found in [colours[7], colours[200], scene.background] {
                    if found == right {
                        continue;
                    }
                    let exact = judge.judge((column, row), right, found);
                    let estimate = judge.estimate((column, row), right, found);
                    assert_eq!(exact.seen, seen);
                    assert_eq!(estimate.seen, seen);
                    let (Some(exact), Some(estimate)) = (exact.cause, estimate.cause) else {
                        assert_eq!(exact.cause, estimate.cause);
                        continue;
                    };
                    causes += 1;
                    let (exact, estimate) = (exact.distance(), estimate.distance());
                    assert!(
                        (exact - estimate).abs() <= 1e-9 * exact.max(1e-3),
                        "{exact:e} {estimate:e}"
                    );
                }
            }
        }
        assert!(causes > 500);
    }
}
