// Records of lights and of what they emit. src/encode/lights.rs writes them. All lie in one buffer of texels, one kind after the
// other.
#ifndef RECORDS_LIGHTS_GLSL
#define RECORDS_LIGHTS_GLSL

// Emission of a surface.
struct EmitterRecord {
    vec3 radiance;       // emitted radiance, linear sRGB, W/(m^2 sr)
    uint texture_index;  // texture that multiplies the radiance, or NONE
};

// Cone of an emitter. An emitter without one has the slope 0 and the offset 1.
struct ConeRecord {
    vec3 slope;    // axis of the cone, over the difference of the cosines between which the light rises
    float offset;  // negative cosine at the cone's border, over that difference
};

// Entry of the alias table that chooses lights (Walker 1974, Vose 1991).
struct LightRecord {
    uint threshold;        // threshold for 32 random bits: bits below it take this light, others its alias
    uint group_and_alias;  // alias: index of another light. Where cells learn which lights to draw, the upper bits hold the light's group
    uint kind_and_index;   // LIGHT_*, and an index: primitive of an area light, first texel of a delta light, patch of an environment
    float probability;     // probability of this light among all lights, or among those of its group
};

// Group of lights among which cells learn to choose.
struct LightGroupRecord {
    uint first;   // first light of the group
    uint count;   // number of lights; 0 for a group that is not used
    float power;  // power of the group's lights over that of all lights, for the host alone
    uint unused;  // fills the texel
};

// Light that no ray can hit.
struct DeltaLightRecord {
    vec3 position;       // position in world space; unused for a directional light
    float cos_cutoff;    // cosine of the cutoff angle of a spot light
    vec3 direction;      // unit direction in which the light travels; unused for a point light
    float cutoff_angle;  // cutoff angle of a spot light, radians
    vec3 intensity;      // intensity, W/sr; for a directional light the irradiance, W/m^2
    float falloff;       // falloff of a spot light: 1 / (angle over which the intensity falls to 0)
    vec3 axis_u;         // axis of a light's picture, which is at 0.5 + (d.axis_u, d.axis_v) / d.direction
    uint texture_index;  // picture that a light throws, or NONE
    vec3 axis_v;         // other axis of a light's picture
    uint unused;         // fills the texel
};

// Area light that an instance shows.
struct PlacedLightRecord {
    uint primitive;  // primitive of the group
    uint instance;   // instance that shows it
    uvec2 unused;    // fills the texel
};

// Entry of the alias table of an environment map's blocks.
struct BlockRecord {
    uint threshold;     // threshold for 32 random bits: bits below it take this block, others its alias
    uint alias;         // index of another block
    uint unused;        // fills the texel
    float probability;  // probability of this block among those of its patch
};

#endif
