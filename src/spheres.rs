//! Spheres as a structure of arrays, in file order, padded to whole packets.

use wide::f32x8;

/// Lanes of a packet: 8 pixels of a row, or 8 spheres being set up.
pub const LANES: usize = 8;

/// Red, green and blue, as they stand in the image.
pub type Rgb = [u8; 3];

/// One sphere of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre `(x, y, z)`; the camera is the origin and looks along +z.
    pub centre: [f32; 3],
    /// Radius, greater than zero.
    pub radius: f32,
    /// Flat colour.
    pub colour: Rgb,
}

/// Fills the last packet: wholly behind the camera, so no method ever sees it.
const PADDING: Sphere = Sphere {
    centre: [0.0, 0.0, -1.0],
    radius: 0.125,
    colour: [0; 3],
};

/// The spheres of a scene, one array a component, in file order.
///
/// The component arrays are whole packets; lanes past [`len`](Self::len) hold
/// spheres behind the camera.
#[derive(Clone, Debug, Default)]
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
    pub fn push(&mut self, sphere: Sphere) {
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
