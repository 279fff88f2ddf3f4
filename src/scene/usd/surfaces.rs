//! Surface shaders that are read, by the names of their inputs.

/// Names of a surface shader's inputs; an empty one stands for an input that it does not have.
pub(super) struct Names {
    /// Whether it is `UsdPreviewSurface`, which has a specular workflow and a threshold of opacity.
    pub is_preview: bool,
    pub base_color: &'static str,
    pub base_weight: &'static str,
    pub default_color: f64,
    pub metallic: &'static str,
    pub roughness: &'static str,
    pub default_roughness: f64,
    /// Factor of the highlights, which are always whole.
    pub specular_weight: &'static str,
    pub ior: &'static str,
    pub coat: &'static str,
    pub coat_roughness: &'static str,
    pub default_coat_roughness: f64,
    pub transmission: &'static str,
    pub emission: &'static str,
    /// Factor of the emission, by default 0.
    pub emission_weight: &'static str,
    pub opacity: &'static str,
    pub normal: &'static str,
}

const PREVIEW: Names = Names {
    is_preview: true,
    base_color: "diffuseColor",
    base_weight: "",
    default_color: 0.18,
    metallic: "metallic",
    roughness: "roughness",
    default_roughness: 0.5,
    specular_weight: "",
    ior: "ior",
    coat: "clearcoat",
    coat_roughness: "clearcoatRoughness",
    default_coat_roughness: 0.01,
    transmission: "",
    emission: "emissiveColor",
    emission_weight: "",
    opacity: "opacity",
    normal: "normal",
};

const STANDARD: Names = Names {
    is_preview: false,
    base_color: "base_color",
    base_weight: "base",
    default_color: 0.8,
    metallic: "metalness",
    roughness: "specular_roughness",
    default_roughness: 0.2,
    specular_weight: "specular",
    ior: "specular_IOR",
    coat: "coat",
    coat_roughness: "coat_roughness",
    default_coat_roughness: 0.1,
    transmission: "transmission",
    emission: "emission_color",
    emission_weight: "emission",
    opacity: "opacity",
    normal: "normal",
};

const OPEN_PBR: Names = Names {
    is_preview: false,
    base_color: "base_color",
    base_weight: "base_weight",
    default_color: 0.8,
    metallic: "base_metalness",
    roughness: "specular_roughness",
    default_roughness: 0.3,
    specular_weight: "specular_weight",
    ior: "specular_ior",
    coat: "coat_weight",
    coat_roughness: "coat_roughness",
    default_coat_roughness: 0.0,
    transmission: "transmission_weight",
    emission: "emission_color",
    emission_weight: "emission_luminance",
    opacity: "geometry_opacity",
    normal: "geometry_normal",
};

/// Names of the inputs of a shader by its `info:id`.
pub(super) fn names_of(id: &str) -> Option<&'static Names> {
    match id {
        "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => Some(&PREVIEW),
        "ND_standard_surface_surfaceshader" => Some(&STANDARD),
        "ND_open_pbr_surface_surfaceshader" => Some(&OPEN_PBR),
        _ => None,
    }
}
