// Emitter sampling: draws a light with a probability in proportion to its power, or by what a cell of the guide has learned
// (light_selection.glsl), and a point or direction of it. One function per light gives the density both for a sampled
// direction and for a ray that hits the light by chance, so that the weights of the two sum to 1.
#ifndef LIGHT_GLSL
#define LIGHT_GLSL
#include "bsdf/thin_dielectric.glsl"
#include "geometry/deforming.glsl"
#include "light/emitter.glsl"
#include "light/environment.glsl"
#include "light/light_selection.glsl"
#include "light/light_shape.glsl"

struct LightSample {
    vec3 wi;        // unit, world space
    vec3 target;    // point of the light, moved off it to the visible side; unused if infinitely far away
    bool infinite;
    vec3 radiance;  // radiance that arrives if nothing is in the way; for a delta light, times the solid angle
    float pdf;      // per steradian; for a delta light, the probability of choosing it; 0: no sample
    bool delta;     // whether no ray can hit the light
    bool faces;     // whether the light's front is turned to the point which it lights
};

// Where a ray meets a light: its primitive, and the instance that shows it; NONE for the environment.
struct LightPlace {
    uint primitive;
    uint instance;
};

const LightPlace OF_ENVIRONMENT = LightPlace(NONE, NONE);

const LightSample NO_LIGHT_SAMPLE = LightSample(vec3(0.0, 0.0, 1.0), vec3(0.0), true, vec3(0.0), 0.0, false, false);

uint kind_of_light(LightRecord light) {
    return light.kind_and_index >> LIGHT_KIND_SHIFT;
}

uint index_of_light(LightRecord light) {
    return light.kind_and_index & ((1u << LIGHT_KIND_SHIFT) - 1u);
}

// Place of an area light.
LightPlace place_of_area_light(LightRecord light) {
    uint index = index_of_light(light);
    if (has_light(LIGHT_PLACED) && kind_of_light(light) == LIGHT_PLACED) {
        PlacedLightRecord placed = load_placed_light(index);
        return LightPlace(placed.primitive, placed.instance);
    }
    return LightPlace(index, NONE);
}

// Probability of drawing a light at a vertex in a cell.
float light_probability(uint light, uint cell) {
    if (light == NONE) return 0.0;
    LightRecord record = load_light(light);
    float probability = record.probability;
    return learns_lights() ? group_probability(cell, record.group_and_alias >> LIGHT_GROUP_SHIFT) * probability : probability;
}

// A light that was drawn.
struct ChosenLight {
    uint index;
    LightRecord record;
    uint group;               // 0 where lights are drawn in proportion to their power
    float group_probability;  // 1 where lights are drawn in proportion to their power
    uvec4 bits;               // random words of the vertex; x and y are used up
};

// Draws one of `count` consecutive lights by their alias table, which uses up two words.
void choose_of_lights(inout ChosenLight chosen, uvec2 words, uint first, uint count) {
    uint light, rest;
    umulExtended(words.x, count, light, rest);
    chosen.index = first + light;
    chosen.record = load_light(chosen.index);
    uint alias = learns_lights() ? chosen.record.group_and_alias & LIGHT_INDEX_MASK : chosen.record.group_and_alias;
    if (words.y >= chosen.record.threshold) {
        chosen.index = alias;
        chosen.record = load_light(alias);
    }
}

// Draws a light for a vertex in a cell of the guide.
ChosenLight choose_light(RandomKey key, uint vertex, uint cell) {
    ChosenLight chosen = ChosenLight(0u, LightRecord(0u, 0u, 0u, 0.0), 0u, 1.0, random_bits(key, vertex, RANDOM_EMITTER));
    if (!learns_lights()) {
        choose_of_lights(chosen, chosen.bits.xy, 0u, scene().light_count);
        return chosen;
    }
    uvec4 more_bits = plain_bits(key, vertex, RANDOM_LIGHT);
    vec2 u = unit_floats(chosen.bits).xy;
    chosen.group_probability = descend_to_group(cell, true, chosen.group, u, unit_floats(more_bits).zw);
    LightGroupRecord lights = load_light_group(chosen.group);
    choose_of_lights(chosen, more_bits.xy, lights.first, lights.count);
    if (lights.count == 0u) chosen.record.probability = 0.0;
    return chosen;
}

// Patches of each area light. Each patch is a light of its own; those of a light are consecutive, and come first of all lights.
uint patches_per_light() {
    return LIGHT_PATCHES * LIGHT_PATCHES;
}

// The light's primitive, which an instance shows or none, in the world. A facing disk is the one that is turned to the point which it lights.
PrimitiveRecord light_in_world(uint primitive, uint instance) {
    PrimitiveRecord p = primitive_now(primitive);
    if (has_light(LIGHT_PLACED) && is_moved(instance)) p = primitive_in_world(p, placement_of(instance));
    if (is_facing(p)) p = turned_disk(p);
    return p;
}

// Index of the light of a primitive, which an instance shows or none; NONE where the primitive does not emit.
uint light_of(uint primitive, uint instance) {
    uint light = attribute_light(primitive);
    if (has_light(LIGHT_PLACED) && instance != NONE && light != NONE) light += instance_first_light(instance);
    return light;
}

// Density per steradian of the direction from `from` to a surface point of an area light, given that this light was
// chosen.
float pdf_area_light(uint primitive, uint instance, Surface s, vec3 from) {
    PrimitiveRecord p = light_in_world(primitive, instance);
    uint shape = p.flags & PRIMITIVE_SHAPE_MASK;
    if (HAS_SPHERES && shape == SHAPE_SPHERE) {
        // From before a sphere, sample_sphere draws points of its near side only. Through holes or thin glass of that side, a path may
        // meet the far inside, which emits where the normal is flipped.
        bool may_be_entered = has_feature(FEATURE_OPACITY) || has_kind(BSDF_THIN_DIELECTRIC);
        bool emits_inwards = (p.flags & PRIMITIVE_FLIP_NORMAL) != 0u;
        if (may_be_entered && emits_inwards && sees_cone(from, p.origin, p.edge_tolerance)) return 0.0;
        return pdf_sphere(from, s.position, p.origin, p.edge_tolerance);
    }
    float area = flat_area(shape, p.edge_u, p.edge_v);
    return pdf_area(from, s.position, s.geometric_normal, area);
}

// Bound of the distance by which a ray from `from` may meet the plane or sphere of the surface too early.
float arrival_error(Surface s, bool sphere, vec3 from) {
    float at_plane = dot(abs(s.geometric_normal), abs(from) + abs(s.position));
    return 16.0 * ROUNDING * (sphere ? distance(from, s.position) : at_plane);
}

// Number of the patch of a flat light that a point lies in. Patches are the parts of the unit square that sample_flat maps to the
// light.
uint patch_of_light(uint primitive, uint instance, vec3 position) {
    PrimitiveRecord p = light_in_world(primitive, instance);
    vec3 d = position - p.origin;
    // Two steps, because squares of small or large edges leave a float's range.
    vec3 n = cross(p.edge_u, p.edge_v);
    float scale = 1.0 / max(max_abs(n), 1.0e-37);
    n *= scale;
    vec2 uv = vec2(dot(cross(d, p.edge_v) * scale, n), dot(cross(p.edge_u, d) * scale, n)) / dot(n, n);
    vec2 u = square_of_flat(p.flags & PRIMITIVE_SHAPE_MASK, uv);
    uvec2 at = uvec2(clamp(u, 0.0, 1.0 - 1.0 / 16777216.0) * float(LIGHT_PATCHES));
    return at.y * LIGHT_PATCHES + at.x;
}

// Place in the unit square of a place within a patch.
vec2 place_in_patch(uint patch_index, vec2 u) {
    return (vec2(patch_index % LIGHT_PATCHES, patch_index / LIGHT_PATCHES) + u) / float(LIGHT_PATCHES);
}

bool has_light_patches() {
    return LIGHT_PATCHES != 1u;
}

// Point of an area light. `epsilon` of the surface suits rays from `from` that end there.
Surface sample_area_light(uint primitive, uint instance, vec3 from, vec2 u) {
    PrimitiveRecord p = light_in_world(primitive, instance);
    uint shape = p.flags & PRIMITIVE_SHAPE_MASK;
    bool sphere = HAS_SPHERES && shape == SHAPE_SPHERE;
    vec2 uv = sample_flat(shape, u);
    vec3 point = p.origin + uv.x * p.edge_u + uv.y * p.edge_v;
    vec3 outward = vec3(0.0);
    if (sphere) {
        outward = sample_sphere(from, p.origin, p.edge_tolerance, u);
        point = p.origin + p.edge_tolerance * outward;
    }
    // The ray ends at the point: length 0.
    Ray ray = Ray(point, vec3(0.0, 0.0, 1.0), 0.0);
    Surface s = surface_at(ray, Hit(0.0, uv, primitive, instance));
    if (sphere) {
        // The rounded position of a point of a tiny sphere may lie on the sphere's other side.
        s.geometric_normal = (p.flags & PRIMITIVE_FLIP_NORMAL) != 0u ? -outward : outward;
        s.shading_normal = s.geometric_normal;
    }
    s.epsilon += arrival_error(s, sphere, from);
    return s;
}

LightSample area_light_sample(uint index, LightRecord light, vec3 from, vec2 u) {
    LightPlace place = place_of_area_light(light);
    if (has_light_patches()) u = place_in_patch(index % patches_per_light(), u);
    Surface s = sample_area_light(place.primitive, place.instance, from, u);
    vec3 d = s.position - from;
    float squared = dot(d, d);
    vec3 wi = d * inversesqrt(max(squared, 1.0e-37));
    float probability = light.probability * float(patches_per_light());
    float pdf = squared > 0.0 ? probability * pdf_area_light(place.primitive, place.instance, s, from) : 0.0;
    return LightSample(wi, leave_surface(s, -wi).origin, false, surface_emission(s, -wi), pdf, false, dot(s.shading_normal, wi) < 0.0);
}

// Share of a spot light's intensity at the angle with this cosine to its axis. The share falls linearly with the angle,
// as in Mitsuba.
float spot_falloff(float cosine, DeltaLightRecord light) {
    if (cosine <= light.cos_cutoff) return 0.0;
    float angle = (2.0 * PI) * turns_of(vec2(cosine, sqrt(max(1.0 - cosine * cosine, 0.0))));
    return clamp((light.cutoff_angle - angle) * light.falloff, 0.0, 1.0);
}

bool has_pictured_lights() {
    return has_light(LIGHT_PICTURED_SPOT) || has_light(LIGHT_PROJECTOR);
}

// Color of the picture of a spot light or a projector at the offset `d` from it. A projector throws its picture into a
// pyramid, so bright that a screen across its axis is evenly lit.
vec3 picture_color(uint kind, DeltaLightRecord light, vec3 d) {
    float depth = dot(d, light.direction);
    vec2 uv = depth != 0.0 ? 0.5 + vec2(dot(d, light.axis_u), dot(d, light.axis_v)) / depth : vec2(0.5);
    vec3 color = vec3(1.0);
    if (has_feature(FEATURE_TEXTURED_EMITTERS)) {
        vec3 picture = sample_pattern(light.texture_index == NONE ? 0u : light.texture_index, uv).rgb;
        if (light.texture_index != NONE) color = picture;
    }
    if (kind != LIGHT_PROJECTOR) return color;
    float stretch = length(d) / max(depth, 1.0e-20);
    return depth > 0.0 && uv == clamp(uv, 0.0, 1.0) ? color * (stretch * stretch * stretch) : vec3(0.0);
}

LightSample delta_light_sample(LightRecord light, vec3 from) {
    uint kind = kind_of_light(light);
    DeltaLightRecord delta = load_delta_light(index_of_light(light));
    if (kind == LIGHT_DIRECTIONAL) {
        return LightSample(-delta.direction, vec3(0.0), true, delta.intensity, light.probability, true, true);
    }
    vec3 d = delta.position - from;
    float squared = max(dot(d, d), 1.0e-37);
    vec3 wi = d * inversesqrt(squared);
    vec3 radiance = delta.intensity / squared;
    if (kind == LIGHT_SPOT || kind == LIGHT_PICTURED_SPOT) radiance *= spot_falloff(-dot(wi, delta.direction), delta);
    if (has_pictured_lights() && kind >= LIGHT_PICTURED_SPOT) radiance *= picture_color(kind, delta, -d);
    return LightSample(wi, delta.position, false, radiance, light.probability, true, true);
}

bool has_delta_lights() {
    return has_light(LIGHT_POINT) || has_light(LIGHT_SPOT) || has_light(LIGHT_DIRECTIONAL) || has_pictured_lights();
}

LightSample environment_light_sample(LightRecord light, uvec4 bits) {
    EnvironmentSample s = sample_environment(bits, index_of_light(light));
    float pdf = light.probability * s.pdf;
    return LightSample(s.wi, vec3(0.0), true, environment_radiance(s.wi), pdf, false, true);
}

// Sample of a light that was drawn, as seen from the point `from`. Facing disks stay turned there, for the shadow ray.
LightSample sample_light(RandomKey key, uint vertex, vec3 from, ChosenLight chosen) {
    LightRecord light = chosen.record;
    uint kind = kind_of_light(light);
    LightSample s = NO_LIGHT_SAMPLE;
    turn_disks(from, false);
    bool is_placed = has_light(LIGHT_PLACED) && kind == LIGHT_PLACED;
    if ((has_light(LIGHT_AREA) && kind == LIGHT_AREA) || is_placed) {
        s = area_light_sample(chosen.index, light, from, unit_floats(chosen.bits).zw);
    }
    if (has_light(LIGHT_ENVIRONMENT) && kind == LIGHT_ENVIRONMENT) {
        s = environment_light_sample(light, random_bits(key, vertex, RANDOM_ENVIRONMENT));
    }
    if (has_delta_lights() && kind >= LIGHT_POINT && !is_placed) s = delta_light_sample(light, from);
    s.pdf *= chosen.group_probability;
    return s;
}

// Finds where a straight line from `from` in the direction `wi` meets the light at a place, whatever is in the way. Returns whether it
// meets the light's front.
bool meets_light(LightPlace place, vec3 from, vec3 wi, out Surface surface) {
    PrimitiveRecord p = light_in_world(place.primitive, place.instance);
    uint shape = p.flags & PRIMITIVE_SHAPE_MASK;
    Ray line = Ray(from, wi, MAX_DISTANCE);
    Hit hit = Hit(MAX_DISTANCE, vec2(0.0), place.primitive, place.instance);
    bool met;
    if (HAS_SPHERES && shape == SHAPE_SPHERE) met = intersect_sphere(line, p.origin, p.edge_tolerance, hit.t, hit.uv);
    else met = intersect_flat(line, p, shape, hit.t, hit.uv);
    surface = surface_at(line, hit);
    return met && dot(surface.shading_normal, wi) < 0.0;
}

// Density, per steradian, with which sample_light draws, at a point `from` in a cell, the direction to a surface that a ray has hit.
float pdf_light_at_surface(uint primitive, uint instance, Surface s, vec3 from, uint cell) {
    uint light = light_of(primitive, instance);
    if (has_light_patches() && light != NONE) {
        light = light * patches_per_light() + patch_of_light(primitive, instance, s.position);
    }
    return light_probability(light, cell) * float(patches_per_light()) * pdf_area_light(primitive, instance, s, from);
}

// Density, per steradian, with which sample_light draws, at a point in a cell, a direction in which a ray hits nothing.
float pdf_light_at_environment(vec3 direction, uint cell) {
    EnvironmentDensity density = pdf_environment(direction);
    uint light = scene().environment_light == NONE ? NONE : scene().environment_light + density.patch_index;
    return light_probability(light, cell) * density.pdf;
}

// Ray from a surface to a light. Any surface that it hits blocks the light.
Ray shadow_ray(Surface s, LightSample light) {
    Ray ray = leave_surface(s, light.wi);
    if (!light.infinite) {
        vec3 d = light.target - ray.origin;
        ray.t_max = length(d);
        ray.direction = d / max(ray.t_max, 1.0e-30);
    }
    return ray;
}

// Weight of a sample with density `own`, where another sampler draws the same path with density `other`: the power
// heuristic (Veach 1997, exponent 2). Its noise is lower than that of the balance heuristic where one of the two
// samplers is good.
float mis_weight(float own, float other) {
    float ratio = other / own;
    return 1.0 / (1.0 + ratio * ratio);
}

#endif
