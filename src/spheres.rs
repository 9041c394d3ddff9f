//! Spheres as a structure of arrays, in file order, padded to whole packets.

use std::{collections::TryReserveError, ops::Range};

use wide::f32x8;

/// Lanes of a packet: 8 pixels of a row, or 8 spheres.
pub(crate) const LANES: usize = 8;

/// A float as a double that may be a factor of a product.
///
/// For a product of two floats in doubles, s390x has an instruction, MDEBR, which QEMU 7.2 executes
/// wrongly. That emulator is the one of Debian 12, so the compiler is kept from seeing that the
/// factor was a float.
#[inline(always)]
pub(crate) fn double(float: f32) -> f64 {
    let double = f64::from(float);
    if cfg!(target_arch = "s390x") {
        std::hint::black_box(double)
    } else {
        double
    }
}

/// Red, green and blue, the bytes of a pixel.
pub type Rgb = [u8; 3];

/// One sphere of a scene.
///
/// Its lengths are finite and its radius is greater than zero, which is all that the
/// exact method assumes of it.
///
/// ```
/// use sfera::spheres::Sphere;
///
/// let ball = Sphere::new([0.0, 0.0, 5.0], 1.0, [200, 0, 0])?;
/// assert_eq!(ball.radius(), 1.0);
/// assert!(Sphere::new([0.0, 0.0, f32::NAN], 1.0, [200, 0, 0]).is_err());
/// assert!(Sphere::new([0.0, 0.0, 5.0], 0.0, [200, 0, 0]).is_err());
/// # Ok::<(), sfera::spheres::LengthError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub(crate) centre: [f32; 3],
    pub(crate) radius: f32,
    pub(crate) colour: Rgb,
}

/// Why a number can't be a length of a scene.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LengthError {
    /// It is infinite or NaN.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// The name of the length.
        name: &'static str,
        /// The number.
        value: f32,
    },
    /// It is not greater than zero.
    #[error("{name} is {value}; it must be greater than 0")]
    NotPositive {
        /// The name of the length.
        name: &'static str,
        /// The number.
        value: f32,
    },
}

/// Checks that a coordinate is finite.
fn finite(name: &'static str, value: f32) -> Result<f32, LengthError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(LengthError::NotFinite { name, value })
    }
}

/// Checks that a length is finite and greater than zero.
pub(crate) fn positive(name: &'static str, value: f32) -> Result<f32, LengthError> {
    if finite(name, value)? > 0.0 {
        Ok(value)
    } else {
        Err(LengthError::NotPositive { name, value })
    }
}

impl Sphere {
    /// The sphere of this centre `(x, y, z)`, radius and flat colour. The camera is the
    /// origin and looks along +z.
    ///
    /// # Errors
    ///
    /// If a number is not finite, or the radius is not greater than zero.
    pub fn new(centre: [f32; 3], radius: f32, colour: Rgb) -> Result<Self, LengthError> {
        let [x, y, z] = centre;
        Ok(Self {
            centre: [
                finite("the x of the centre", x)?,
                finite("the y of the centre", y)?,
                finite("the z of the centre", z)?,
            ],
            radius: positive("the radius", radius)?,
            colour,
        })
    }

    /// The centre `(x, y, z)`.
    #[must_use]
    pub fn centre(&self) -> [f32; 3] {
        self.centre
    }

    /// The radius, greater than zero.
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The flat colour.
    #[must_use]
    pub fn colour(&self) -> Rgb {
        self.colour
    }
}

/// Fills the last packet: it is entirely behind the camera, so no method ever shows it.
const PADDING: Sphere = Sphere {
    centre: [0.0, 0.0, -1.0],
    radius: 0.125,
    colour: [0; 3],
};

/// The spheres of a scene, one array for each component, in file order.
///
/// The arrays of lengths are padded to a multiple of 8 with spheres behind the camera,
/// which no ray meets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spheres {
    x: Vec<f32x8>,
    y: Vec<f32x8>,
    z: Vec<f32x8>,
    radius: Vec<f32x8>,
    colour: Vec<Rgb>,
}

impl Spheres {
    /// How many spheres the scene has, padding not counted.
    #[must_use]
    pub fn len(&self) -> usize {
        self.colour.len()
    }

    /// Whether the scene has no sphere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.colour.is_empty()
    }

    /// Appends a sphere.
    pub(crate) fn push(&mut self, sphere: Sphere) {
        let index = self.len();
        if index.is_multiple_of(LANES) {
            let [x, y, z] = PADDING.centre;
            self.x.push(f32x8::splat(x));
            self.y.push(f32x8::splat(y));
            self.z.push(f32x8::splat(z));
            self.radius.push(f32x8::splat(PADDING.radius));
        }
        let [x, y, z] = sphere.centre;
        lanes_mut(&mut self.x)[index] = x;
        lanes_mut(&mut self.y)[index] = y;
        lanes_mut(&mut self.z)[index] = z;
        lanes_mut(&mut self.radius)[index] = sphere.radius;
        self.colour.push(sphere.colour);
    }

    /// How many spheres there is memory for.
    #[cfg(test)]
    pub(crate) fn capacity(&self) -> usize {
        let components = [&self.x, &self.y, &self.z, &self.radius];
        let packets = components.map(Vec::capacity).into_iter().max();
        self.colour
            .capacity()
            .max(packets.unwrap_or_default() * LANES)
    }

    /// Reserves memory for exactly `additional` more spheres.
    pub(crate) fn try_reserve_exact(&mut self, additional: usize) -> Result<(), TryReserveError> {
        let packets = self.missing_packets(additional);
        for component in self.components_mut() {
            component.try_reserve_exact(packets)?;
        }
        self.colour.try_reserve_exact(additional)
    }

    /// Appends room for `additional` spheres, to be filled in any order.
    pub(crate) fn try_grow(&mut self, additional: usize) -> Result<Slots<'_>, TryReserveError> {
        let length = self.len();
        let packets = self.missing_packets(additional);
        for component in self.components_mut() {
            component.try_reserve(packets)?;
        }
        self.colour.try_reserve(additional)?;
        let [x, y, z] = PADDING.centre;
        let padding = [x, y, z, PADDING.radius];
        for (component, padding) in self.components_mut().into_iter().zip(padding) {
            component.resize(component.len() + packets, f32x8::splat(padding));
        }
        self.colour.resize(length + additional, PADDING.colour);
        let new = length..length + additional;
        Ok(Slots {
            x: &mut lanes_mut(&mut self.x)[new.clone()],
            y: &mut lanes_mut(&mut self.y)[new.clone()],
            z: &mut lanes_mut(&mut self.z)[new.clone()],
            radius: &mut lanes_mut(&mut self.radius)[new.clone()],
            colour: &mut self.colour[new],
        })
    }

    /// Copies the spheres `from` to the positions from `to` on.
    pub(crate) fn copy_within(&mut self, from: Range<usize>, to: usize) {
        for component in self.components_mut() {
            lanes_mut(component).copy_within(from.clone(), to);
        }
        self.colour.copy_within(from, to);
    }

    /// Drops all spheres from `length` on.
    pub(crate) fn truncate(&mut self, length: usize) {
        let length = length.min(self.len());
        self.colour.truncate(length);
        let [x, y, z] = PADDING.centre;
        let padding = [x, y, z, PADDING.radius];
        for (component, padding) in self.components_mut().into_iter().zip(padding) {
            component.truncate(length.div_ceil(LANES));
            lanes_mut(component)[length..].fill(padding);
        }
    }

    fn components_mut(&mut self) -> [&mut Vec<f32x8>; 4] {
        [&mut self.x, &mut self.y, &mut self.z, &mut self.radius]
    }

    /// Packets to be added so that `additional` spheres fit.
    fn missing_packets(&self, additional: usize) -> usize {
        let length = self.len().saturating_add(additional);
        length.div_ceil(LANES) - self.x.len()
    }

    /// Sphere `index` of the file.
    ///
    /// # Panics
    ///
    /// If `index >= len()`.
    #[must_use]
    pub fn get(&self, index: usize) -> Sphere {
        Sphere {
            centre: [self.x()[index], self.y()[index], self.z()[index]],
            radius: self.radius()[index],
            colour: self.colour[index],
        }
    }

    /// The spheres in file order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Sphere> + '_ {
        (0..self.len()).map(|index| self.get(index))
    }

    /// The x components of the centres, padded.
    #[must_use]
    pub fn x(&self) -> &[f32] {
        bytemuck::cast_slice(&self.x)
    }

    /// The y components of the centres, padded.
    #[must_use]
    pub fn y(&self) -> &[f32] {
        bytemuck::cast_slice(&self.y)
    }

    /// The z components of the centres, padded.
    #[must_use]
    pub fn z(&self) -> &[f32] {
        bytemuck::cast_slice(&self.z)
    }

    /// The radii, padded.
    #[must_use]
    pub fn radius(&self) -> &[f32] {
        bytemuck::cast_slice(&self.radius)
    }

    /// The colours, not padded.
    #[must_use]
    pub fn colour(&self) -> &[Rgb] {
        &self.colour
    }
}

/// Room for spheres in a structure of arrays.
#[derive(Debug)]
pub(crate) struct Slots<'a> {
    x: &'a mut [f32],
    y: &'a mut [f32],
    z: &'a mut [f32],
    radius: &'a mut [f32],
    colour: &'a mut [Rgb],
}

impl Slots<'_> {
    pub(crate) fn len(&self) -> usize {
        self.colour.len()
    }

    /// The first `count` slots, and the others.
    pub(crate) fn split_at(self, count: usize) -> (Self, Self) {
        let (x, more_x) = self.x.split_at_mut(count);
        let (y, more_y) = self.y.split_at_mut(count);
        let (z, more_z) = self.z.split_at_mut(count);
        let (radius, more_radius) = self.radius.split_at_mut(count);
        let (colour, more_colour) = self.colour.split_at_mut(count);
        let first = Self {
            x,
            y,
            z,
            radius,
            colour,
        };
        let others = Self {
            x: more_x,
            y: more_y,
            z: more_z,
            radius: more_radius,
            colour: more_colour,
        };
        (first, others)
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, index: usize, sphere: Sphere) {
        let [x, y, z] = sphere.centre;
        self.x[index] = x;
        self.y[index] = y;
        self.z[index] = z;
        self.radius[index] = sphere.radius;
        self.colour[index] = sphere.colour;
    }
}

fn lanes_mut(packets: &mut [f32x8]) -> &mut [f32] {
    bytemuck::cast_slice_mut(packets)
}

impl FromIterator<Sphere> for Spheres {
    fn from_iter<I: IntoIterator<Item = Sphere>>(spheres: I) -> Self {
        let mut all = Self::default();
        for sphere in spheres {
            all.push(sphere);
        }
        all
    }
}

#[cfg(test)]
mod tests;
