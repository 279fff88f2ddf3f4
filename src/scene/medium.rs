//! Media: what fills the space between surfaces.

use std::sync::Arc;

use glam::{DMat4, DVec3, UVec3, Vec3};

/// Medium, homogeneous or varying with the place.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Medium {
    /// The medium's `id`, or its plugin and line, for messages.
    #[serde(skip)]
    pub name: String,
    /// Extinction coefficient, per scene unit, each channel >= 0.
    pub extinction: Vec3,
    /// Share of the extinction that is scattering, each channel in [0, 1]. With a volume of coefficients, the factor of these.
    pub albedo: Vec3,
    /// Where scattered light goes.
    pub phase: Phase,
    /// Radiance that a deep layer of the medium would emit if it did not scatter. The medium emits this times its absorption per scene unit.
    pub emission: Vec3,
    /// What varies with the place; `None` for a homogeneous medium.
    pub volumes: Option<Volumes>,
}

/// Volumes that multiply the coefficients of a medium.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Volumes {
    /// Factor of the extinction. Outside its box there is no medium.
    pub extinction: Volume,
    /// What multiplies the albedo.
    pub albedo: Option<AlbedoVolume>,
    /// Factor of the emission.
    pub emission: Option<Volume>,
}

/// Volume of a medium's albedo.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub enum AlbedoVolume {
    /// Factor of the albedo.
    Share(Volume),
    /// Factor of the coefficient of scattering. The albedo is the product divided by the extinction at the same place.
    Scattering(Volume),
}

/// Grid of values over a box.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Volume {
    /// Matrix from the world to the unit cube that the grid fills.
    pub unit_from_world: DMat4,
    /// Number of voxels along each axis.
    pub size: UVec3,
    /// Values, x fastest, then y, then z: one for each voxel, or three where `has_colors`. None is negative.
    #[serde(serialize_with = "numbers")]
    pub values: Arc<Vec<f32>>,
    /// Whether a voxel has a color.
    pub has_colors: bool,
    /// Whether each place has the value of the voxel that it lies in. Else values are interpolated between the centers of voxels.
    pub is_nearest: bool,
    /// Value beyond the border.
    pub wrap: VolumeWrap,
}

fn numbers<S: serde::Serializer>(values: &Arc<Vec<f32>>, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&**values, serializer)
}

/// Value of a volume beyond its border. Near the border interpolation needs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum VolumeWrap {
    /// The value of the outermost voxel.
    Clamp,
    /// The volume repeats itself.
    Repeat,
    /// The volume repeats itself, every other time mirrored.
    Mirror,
    /// Zero.
    Zero,
}

/// Most blocks along an axis. A ray crosses at most three times as many.
const MOST_BLOCKS: u32 = 64;
/// Fewest voxels along each side of a block.
const LEAST_SIDE: u32 = 4;

impl Volume {
    /// Voxels along the sides of the blocks that have majorants, and the number of blocks along each axis.
    pub fn blocks(&self) -> (u32, UVec3) {
        let side = self.size.max_element().div_ceil(MOST_BLOCKS).max(LEAST_SIDE);
        (side, self.size.map(|voxels| voxels.div_ceil(side)))
    }

    /// Box of the volume in world space, as (minimum, maximum).
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let world_from_unit = self.unit_from_world.inverse();
        let corners = (0..8).map(|corner: u32| {
            let unit = DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1)));
            world_from_unit.transform_point3(unit)
        });
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
    }

    /// Largest value of each color channel.
    pub fn most(&self) -> Vec3 {
        if self.has_colors {
            let (colors, _) = self.values.as_chunks::<3>();
            colors.iter().fold(Vec3::ZERO, |most, color| most.max(Vec3::from_array(*color)))
        } else {
            Vec3::splat(self.values.iter().copied().fold(0.0, f32::max))
        }
    }
}

impl Medium {
    /// Words that each table of the medium's volumes takes: the values of each volume, and the majorants of the extinction.
    pub fn word_counts(&self) -> impl Iterator<Item = u64> {
        let values = self.all_volumes().map(|volume| volume.values.len() as u64);
        let majorants = self.volumes.iter().map(|volumes| {
            let (_, blocks) = volumes.extinction.blocks();
            blocks.to_array().into_iter().map(u64::from).product()
        });
        values.chain(majorants)
    }

    /// The medium's volumes.
    pub fn all_volumes(&self) -> impl Iterator<Item = &Volume> {
        self.volumes.iter().flat_map(|Volumes { extinction, albedo, emission }| {
            let albedo = albedo.as_ref().map(|(AlbedoVolume::Share(volume) | AlbedoVolume::Scattering(volume))| volume);
            [Some(extinction), albedo, emission.as_ref()].into_iter().flatten()
        })
    }
}

/// Phase function: a mixture of two lobes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Phase {
    /// The lobes.
    pub lobes: [PhaseLobe; 2],
    /// Probability of the second lobe, in [0, 1].
    pub second_lobe: f32,
}

/// Lobe of a phase function.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum PhaseLobe {
    /// `hg` (Henyey and Greenstein 1941) with this mean cosine, in (-1, 1). With 0 it is `isotropic`.
    HenyeyGreenstein(f32),
    /// `rayleigh`.
    Rayleigh,
}

/// Media on the two sides of a surface; `None` is empty space. Indices into [`Media::all`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Boundary {
    /// Medium on the side from which the geometric normal points away.
    pub interior: Option<u32>,
    /// Medium on the side to which the geometric normal points.
    pub exterior: Option<u32>,
}

/// Media of a scene.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Media {
    /// The media.
    pub all: Vec<Medium>,
    /// Medium around the camera.
    pub of_camera: Option<u32>,
}

impl Phase {
    /// Phase function of one lobe.
    pub fn of_lobe(lobe: PhaseLobe) -> Self {
        Self { lobes: [lobe; 2], second_lobe: 0.0 }
    }

    /// Scatters alike into all directions.
    pub fn isotropic() -> Self {
        Self::of_lobe(PhaseLobe::HenyeyGreenstein(0.0))
    }
}
