// Declares the records that kernels read as texels or keep in private memory, so that build.rs can compare layout.rs
// with them. This kernel is never dispatched.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "guide/learners/path_vertex.glsl"
#include "guide/normalization/normalization_record.glsl"
layout(local_size_x = 1) in;

struct PrimitiveRecord {
    vec3 origin;
    uint flags;
    vec3 edge_u;
    float edge_tolerance;  // slack of the edge tests per unit of distance; equals the longest edge
    vec3 edge_v;
    float plane;  // a flat shape's: dot(cross(edge_u, edge_v), p) of its points p, relative to its anchor
};

struct AttributeRecord {
    uvec3 normals;  // octahedral, 16 bits a coordinate
    uint material;
    vec2 uv0;
    vec2 uv1;
    vec2 uv2;
    uint emitter;
    uint light;  // index of the light in the alias table, or NONE
};

// Entry of the alias table that chooses lights (Walker 1974, Vose 1991).
struct LightRecord {
    uint threshold;       // 32 random bits below this take the light, others its alias
    uint group_and_alias; // where cells learn which lights to draw: group << LIGHT_GROUP_SHIFT | alias; else the alias alone
    uint kind_and_index;  // LIGHT_*; primitive of an area light, first texel of a delta light, patch of an environment
    float probability;    // of this light among all lights, or among those of its group
};

// Group of lights among which cells learn to choose.
struct LightGroupRecord {
    uint first;   // light
    uint count;   // number of lights; 0: the group is not used
    float power;  // of its lights over that of all lights; for the host alone
    uint unused;
};

struct EmitterRecord {
    vec3 radiance;
    uint texture_index;  // texture that multiplies the radiance, or NONE
};

struct DeltaLightRecord {
    vec3 position;         // unused for a directional light
    float cos_cutoff;      // spot lights only: cosine of the cutoff angle
    vec3 direction;        // unit, the direction in which light travels; unused for a point light
    float cutoff_angle;    // spot lights only, radians
    vec3 intensity;        // W/sr; irradiance in W/m^2 for a directional light
    float falloff;         // spot lights only: 1 / (angle over which the intensity falls to 0)
    vec3 axis_u;           // lights with a picture only: the picture is at 0.5 + (d.axis_u, d.axis_v) / d.direction
    uint texture_index;    // lights with a picture only: the picture, or NONE
    vec3 axis_v;
    uint unused;
};

struct MaterialRecord {
    uint kind_and_flags;     // BSDF_* or MATERIAL_BLEND, MATERIAL_SIDES; flags MATERIAL_*
    uint material0;          // first material of a blend or of two sides
    uint material1_or_relief; // second material; otherwise the texture of a bump or normal map
    float relief_scale;      // scale of a bump map
    vec4 colors[3];          // see bsdf/parameters.glsl; the fourth component is unused
    float scalars[12];       // see bsdf/parameters.glsl
    uvec4 links[2];          // links from parameters to textures
    vec4 coating;            // optical thickness, eta
    vec4 coating_specular;   // specular reflectance
};

struct TextureRecord {
    uint kind;       // TEXTURE_*
    uint address;    // address of the first word
    uvec2 size;      // texels
    vec3 u_row;      // row of the affine map from the surface's coordinates to u
    float scale;     // factor of texels stored as halves
    vec3 v_row;      // row of the affine map to v
    float reserved;
    vec4 colors[2];  // colors of a checkerboard
};

layout(scalar, set = 0, binding = 0) restrict buffer Probe0 { PrimitiveRecord primitives[]; };
layout(scalar, set = 0, binding = 1) restrict buffer Probe1 { AttributeRecord attributes[]; };
layout(scalar, set = 0, binding = 2) restrict buffer Probe2 { MaterialRecord materials[]; };
layout(scalar, set = 0, binding = 3) restrict buffer Probe3 { LightRecord lights[]; };
layout(scalar, set = 0, binding = 11) restrict buffer Probe11 { LightGroupRecord light_groups[]; };
layout(scalar, set = 0, binding = 4) restrict buffer Probe4 { EmitterRecord emitters[]; };
layout(scalar, set = 0, binding = 5) restrict buffer Probe5 { DeltaLightRecord delta_lights[]; };

layout(scalar, set = 0, binding = 6) restrict buffer Probe6 { NormalizationEntry normalization_entries[]; };
layout(scalar, set = 0, binding = 7) restrict buffer Probe7 { PathVertex path_vertices[]; };
layout(scalar, set = 0, binding = 10) restrict buffer Probe10 { TextureRecord textures[]; };

void main() {
    textures[0].reserved = textures[1].scale + textures[1].size.x + textures[1].colors[0].x;
    primitives[0].plane = primitives[1].origin.x + primitives[1].edge_tolerance + primitives[1].edge_v.x;
    lights[0].group_and_alias = lights[1].threshold;
    light_groups[0].count = light_groups[1].first;
    emitters[0].texture_index = uint(emitters[1].radiance.x);
    delta_lights[0].cutoff_angle = delta_lights[1].position.x;
    normalization_entries[0].uniform_share = normalization_entries[1].guide_scale;
    path_vertices[0].factor.x = path_vertices[1].segment.scale + path_vertices[1].light.x;
    attributes[0].light = attributes[1].normals.x + attributes[1].material + attributes[1].emitter;
    materials[0].relief_scale = materials[1].colors[0].x + materials[1].scalars[0] + materials[1].coating.x;
}
