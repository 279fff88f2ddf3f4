// Never dispatched: declares the records that kernels read as texels or keep to themselves, so that build.rs can hold layout.rs against them.
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
    float edge_tolerance;  // slack of the edge tests per unit of distance, as long as the longest edge
    vec3 edge_v;
    float reserved;
};

struct AttributeRecord {
    uvec3 normals;  // octahedral, 16 bits a coordinate
    uint material;
    vec2 uv0;
    vec2 uv1;
    vec2 uv2;
    uint emitter;
    uint light;  // entry of the table that lights are chosen from, or NONE
};

// How a light is chosen, by an alias table (Walker 1974, Vose 1991).
struct LightRecord {
    uint threshold;       // of 32 random bits: those below take this light, the others its alias
    uint alias;
    uint kind_and_index;  // LIGHT_*; the primitive of an area light, the first texel of a delta light, else 0
    float probability;    // of this light among all
};

struct EmitterRecord {
    vec3 radiance;
    uint texture_index;  // that multiplies it, or NONE
};

struct DeltaLightRecord {
    vec3 position;         // of a directional light: unused
    float cos_cutoff;      // of a spot, as are the next two
    vec3 direction;        // unit, in which the light travels; of a point light: unused
    float cutoff_angle;    // radians
    vec3 intensity;        // W/sr; of a directional light the irradiance, W/m^2
    float falloff;         // one over the angle in which the intensity falls to 0
};

struct MaterialRecord {
    uint kind_and_flags;     // BSDF_* or MATERIAL_BLEND, MATERIAL_SIDES; flags MATERIAL_*
    uint material0;          // of a blend or of two sides: the first material
    uint material1_or_relief; // the second; otherwise the texture of a bump or normal map
    float relief_scale;      // of a bump map
    vec4 colors[3];          // see bsdf/parameters.glsl; the fourth component is unused
    float scalars[12];
    uvec4 links[2];          // parameters with textures
    vec4 coating;            // optical thickness, eta
    vec4 coating_specular;   // specular reflectance
};

struct TextureRecord {
    uint kind;       // TEXTURE_*
    uint address;    // of the first word
    uvec2 size;      // texels
    vec3 u_row;      // from the surface's coordinates
    float scale;     // factor of halves
    vec3 v_row;
    float reserved;
    vec4 colors[2];  // of a checkerboard
};

layout(scalar, set = 0, binding = 0) restrict buffer Probe0 { PrimitiveRecord primitives[]; };
layout(scalar, set = 0, binding = 1) restrict buffer Probe1 { AttributeRecord attributes[]; };
layout(scalar, set = 0, binding = 2) restrict buffer Probe2 { MaterialRecord materials[]; };
layout(scalar, set = 0, binding = 3) restrict buffer Probe3 { LightRecord lights[]; };
layout(scalar, set = 0, binding = 4) restrict buffer Probe4 { EmitterRecord emitters[]; };
layout(scalar, set = 0, binding = 5) restrict buffer Probe5 { DeltaLightRecord delta_lights[]; };

layout(scalar, set = 0, binding = 6) restrict buffer Probe6 { NormalizationEntry normalization_entries[]; };
layout(scalar, set = 0, binding = 7) restrict buffer Probe7 { PathVertex path_vertices[]; };
layout(scalar, set = 0, binding = 10) restrict buffer Probe10 { TextureRecord textures[]; };

void main() {
    textures[0].reserved = textures[1].scale + textures[1].size.x + textures[1].colors[0].x;
    primitives[0].reserved = primitives[1].origin.x + primitives[1].edge_tolerance + primitives[1].edge_v.x;
    lights[0].alias = lights[1].threshold;
    emitters[0].texture_index = uint(emitters[1].radiance.x);
    delta_lights[0].cutoff_angle = delta_lights[1].position.x;
    normalization_entries[0].uniform_share = normalization_entries[1].guide_scale;
    path_vertices[0].factor.x = path_vertices[1].segment.scale + path_vertices[1].light.x;
    attributes[0].light = attributes[1].normals.x + attributes[1].material + attributes[1].emitter;
    materials[0].relief_scale = materials[1].colors[0].x + materials[1].scalars[0] + materials[1].coating.x;
}
