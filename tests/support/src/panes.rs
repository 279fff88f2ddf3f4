//! Surfaces that let light go straight on, to put into other scenes.

use glam::Vec3;
use lodestar::math::fresnel::fresnel_dielectric;
use lodestar::scene::{Bsdf, Material, MaterialKind, Primitive, PrimitiveShape, Scene, SurfaceMaterial, Textured};

/// Surface that lets light go straight on. What it does not let through it absorbs, but for glass.
#[derive(Debug, Clone, Copy)]
pub enum Pane {
    /// `mask` of this opacity.
    Mask(f32),
    /// `blendbsdf` of `null`, and with this weight of a black surface.
    Blend(f32),
    /// `twosided` whose sides are masks: the front of this opacity, the back opaque. Light from above meets the back.
    Front(f32),
    /// `thindielectric` that lets half of the light through that it does not reflect.
    Glass,
    /// `dielectric` of this index of refraction above, over that below. It lets three quarters of the light through that it does not
    /// reflect, and absorbs what it reflects.
    Interface(f32),
}

const ETA: f32 = 1.5;

impl Pane {
    /// Share of light that passes, where a shadow ray from below meets the pane's front with this cosine. That of an interface leaves out how
    /// refraction concentrates radiance.
    pub fn share(self, cosine: f64) -> f64 {
        match self {
            Self::Mask(opacity) | Self::Blend(opacity) | Self::Front(opacity) => 1.0 - f64::from(opacity),
            Self::Glass => {
                let r = fresnel_dielectric(cosine, f64::from(ETA)).reflectance;
                0.5 * (1.0 - 2.0 * r / (1.0 + r))
            }
            Self::Interface(eta) => 0.75 * (1.0 - fresnel_dielectric(cosine, f64::from(eta)).reflectance),
        }
    }

    /// Adds the pane's material. Returns its index.
    pub fn material(self, scene: &mut Scene) -> u32 {
        let mut add = |kind| {
            scene.materials.push(Material { name: "pane".into(), kind, boundary: None });
            scene.materials.len() as u32 - 1
        };
        let black = |opacity: f32| {
            let bsdf = Bsdf::Diffuse { reflectance: Textured::constant(Vec3::ZERO) };
            MaterialKind::Surface(SurfaceMaterial {
                opacity: Textured::constant(opacity),
                ..SurfaceMaterial::plain(bsdf)
            })
        };
        match self {
            Self::Mask(opacity) => add(black(opacity)),
            Self::Blend(weight) => {
                let materials = [add(black(0.0)), add(black(1.0))];
                add(MaterialKind::Blend { weight: Textured::constant(weight), materials })
            }
            Self::Front(opacity) => {
                let (front, back) = (add(black(opacity)), add(black(1.0)));
                add(MaterialKind::Sides { front, back })
            }
            Self::Glass => {
                let [specular_reflectance, specular_transmittance] =
                    [0.0, 0.5].map(|c| Textured::constant(Vec3::splat(c)));
                let glass = Bsdf::ThinDielectric { eta: ETA, specular_reflectance, specular_transmittance };
                add(MaterialKind::Surface(SurfaceMaterial::plain(glass)))
            }
            Self::Interface(eta) => {
                let [specular_reflectance, specular_transmittance] =
                    [0.0, 0.75].map(|c| Textured::constant(Vec3::splat(c)));
                let glass = Bsdf::Dielectric { eta, specular_reflectance, specular_transmittance };
                add(MaterialKind::Surface(SurfaceMaterial::plain(glass)))
            }
        }
    }

    /// Adds the pane as a square. The front is on the side of the cross product of `half_u` and `half_v`.
    pub fn add(self, scene: &mut Scene, center: Vec3, half_u: Vec3, half_v: Vec3) {
        let material = self.material(scene);
        scene.primitives.push(Primitive {
            shape: PrimitiveShape::Parallelogram,
            origin: center,
            edge_u: half_u,
            edge_v: half_v,
            normals: None,
            uvs: [glam::Vec2::ZERO; 3],
            flip_normal: false,
            front_only: false,
            unseen: false,
            material,
            emitter: None,
        });
    }
}

/// The scene with panes above its floor, one above the other, between the heights 1.05 and 1.2. Their fronts are below.
pub fn covered(mut scene: Scene, panes: &[Pane]) -> Scene {
    for (at, pane) in panes.iter().enumerate() {
        let height = 1.05 + 0.15 * at as f32 / panes.len() as f32;
        pane.add(&mut scene, height * Vec3::Y, 300.0 * Vec3::X, 300.0 * Vec3::Z);
    }
    scene
}

/// The scene, such as the Cornell box, with panes of all kinds: across its middle, one above another below its lamp.
pub fn with_panes(mut scene: Scene) -> Scene {
    let bounds = scene.primitives.iter().map(Primitive::bounds);
    let (low, high) = bounds.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    for (pane, height) in
        [(Pane::Mask(0.4), 0.2), (Pane::Interface(1.1), 0.3), (Pane::Glass, 0.45), (Pane::Blend(0.3), 0.7)]
    {
        let place = center + height * half.y * Vec3::Y;
        pane.add(&mut scene, place, 0.45 * half.x * Vec3::X, 0.6 * half.z * Vec3::Z);
    }
    scene
}
