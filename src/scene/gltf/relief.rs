//! Directions of normal maps. `normalmap` follows the texture coordinates by u, and a turn of u about the normal. glTF's green points up
//! in the image, which is that turn only where the image is not mirrored on the surface, and `TANGENT` may say otherwise.

use glam::{DVec2, DVec3};
use gltf::{Primitive, Semantic};

use super::asset::Asset;
use super::corners::triangles;
use super::images::TextureUse;
use crate::Result;

/// Directions of a normal map that are turned about: red and green.
pub(super) type Turned = [bool; 2];

/// Triangles of a primitive with the same directions.
pub(super) struct Part {
    pub turned: Turned,
    /// Indices of the triangles; `None` for all.
    pub triangles: Option<Vec<usize>>,
}

impl Part {
    const ALL: Self = Self { turned: [false; 2], triangles: None };

    /// Directions on a shape that may be mirrored.
    pub fn turned_on(&self, is_mirrored: bool) -> Turned {
        [self.turned[0], self.turned[1] != is_mirrored]
    }
}

/// Least cosine between a tangent and the direction of u, or the opposite one, that gets no warning.
const LEAST_COSINE: f64 = 0.5;

/// Parts of a primitive; one part where the material has no normal map.
pub(super) fn parts(asset: &Asset, mesh: usize, primitive: &Primitive) -> Result<Vec<Part>> {
    let set = primitive.material().normal_texture().map(|normals| TextureUse::of_normals(&normals).uv_set);
    let uvs = set.and_then(|set| primitive.get(&Semantic::TexCoords(set)));
    let (Some(uvs), Some(positions)) = (uvs, primitive.get(&Semantic::Positions)) else { return Ok(vec![Part::ALL]) };
    let (uvs, positions) = (asset.elements::<2>(&uvs)?, asset.elements::<3>(&positions)?);
    let tangents = primitive.get(&Semantic::Tangents).map(|tangents| asset.elements::<4>(&tangents)).transpose()?;
    let mut strays = false;
    let mut turned = |corners: [u32; 3]| -> Option<Turned> {
        let corner = |of: usize| corners.map(|index| index as usize)[of];
        let [a, b, c] = [0, 1, 2].map(|of| Some((positions.get(corner(of))?, uvs.get(corner(of))?)));
        let [(p0, uv0), (p1, uv1), (p2, uv2)] = [a?, b?, c?];
        let edge = |p: &[f64; 3]| DVec3::from_array(*p) - DVec3::from_array(*p0);
        let [along1, along2] = [uv1, uv2].map(|uv| DVec2::from_array(*uv) - DVec2::from_array(*uv0));
        // Positive where an image is mirrored on the surface, because v points down in it.
        let area = along1.perp_dot(along2);
        let direction = (edge(p1) * along2.y - edge(p2) * along1.y) * area.signum();
        if area == 0.0 {
            return None;
        }
        let Some(tangents) = &tangents else { return Some([false, area > 0.0]) };
        let [a, b, c] = [0, 1, 2].map(|of| tangents.get(corner(of)));
        let [x, y, z, w] = [0, 1, 2, 3].map(|of| Some(a?[of] + b?[of] + c?[of]));
        let along = DVec3::new(x?, y?, z?).normalize_or_zero().dot(direction.normalize_or_zero());
        strays |= along.abs() < LEAST_COSINE;
        Some([along < 0.0, (w? < 0.0) != (along < 0.0)])
    };
    let all = triangles(asset, primitive, positions.len())?;
    let turns: Vec<Turned> = all.into_iter().map(|corners| turned(corners).unwrap_or_default()).collect();
    if strays {
        asset.warn(format!("mesh {mesh}: its tangents do not follow its texture coordinates; its normal map does"));
    }
    let mut parts = Vec::new();
    for turned in [[false, false], [false, true], [true, false], [true, true]] {
        let triangles: Vec<usize> = (0..turns.len()).filter(|&at| turns[at] == turned).collect();
        if triangles.len() == turns.len() {
            return Ok(vec![Part { turned, triangles: None }]);
        }
        if !triangles.is_empty() {
            parts.push(Part { turned, triangles: Some(triangles) });
        }
    }
    Ok(parts)
}
