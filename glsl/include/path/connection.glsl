// Emitter sampling: connections of a path's vertex to a sampled light.
#ifndef CONNECTION_GLSL
#define CONNECTION_GLSL
#include "light/light_learning.glsl"
#include "light/light.glsl"
#include "path/path.glsl"
#include "path/scatterer.glsl"

struct Connection {
    KEPT(light) vec3 light;  // that the surface scatters from the sampled light, weighted, if nothing blocks the ray
    KEPT(ray) Ray ray;
    KEPT(light) LightEvidence evidence;  // for the light selection that cells learn
    KEPT(bend) vec3 scattered;   // what the surface scatters, weighted, of a light of radiance 1 that a ray can meet
    KEPT(bend) LightPlace place;
};

const Ray NO_RAY = Ray(vec3(0.0), vec3(0.0), 0.0);
const Connection NO_CONNECTION = Connection(vec3(0.0), NO_RAY, NO_LIGHT_EVIDENCE, vec3(0.0), OF_ENVIRONMENT);

// Samples a light. Multiple importance sampling weighs it against the direction that the path draws itself.
Connection connect(Path path, Surface surface, Scatterer scatterer, Guide guide) {
    ChosenLight chosen = choose_light(path.key, path.depth, scatterer.cell);
    LightSample light = sample_light(path.key, path.depth, surface.position, chosen);
    vec3 wi = light.wi * scatterer.frame;
    float pdf = pdf_direction(scatterer, guide, wi);
    float weight = light.delta ? 1.0 : mis_weight(light.pdf, pdf);
    vec3 response = eval_scatterer(scatterer, wi);
    vec3 scattered = response * light.radiance;
    Connection connection = NO_CONNECTION;
    connection.ray = shadow_ray(surface, light);
    if (scatterer.passes) return connection;
    if (bends_light() && light.pdf > 0.0 && !light.delta && light.faces) {
        connection.scattered = response * (weight / light.pdf);
        if (!light.infinite) connection.place = place_of_area_light(chosen.record);
    }
    bool scatters = light.pdf > 0.0 && max_component(scattered) > 0.0;
    if (records_lights(path.key.sample_index)) {
        float found = scatters ? mean_rgb(scattered) * (chosen.group_probability / light.pdf) : 0.0;
        connection.evidence = light_evidence(scatterer.cell, chosen.group, found, leftover_float(chosen.bits));
    }
    if (!scatters) return connection;
    connection.light = scattered * (weight / light.pdf);
    return connection;
}

// Whether the connection may bring light. Refracted rays may meet another color of their light than straight ones.
bool brings_light(Connection connection) {
    if (bends_light()) return max_component(connection.light) > 0.0 || max_component(connection.scattered) > 0.0;
    return max_component(connection.light) > 0.0;
}

#endif
