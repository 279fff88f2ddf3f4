// Connections of paths to sampled lights.
#ifndef CONNECTION_GLSL
#define CONNECTION_GLSL
#include "light/light.glsl"
#include "path/path.glsl"
#include "path/scatterer.glsl"

// Emitter sampling: the light that a surface scatters straight from a sampled light, weighted, if nothing is in the ray's way.
struct Connection {
    vec3 light;
    Ray ray;
};

Connection connect(Path path, Surface s, Scatterer x, Guide guide) {
    LightSample light = sample_light(path.key, path.depth, s.position);
    vec3 wi = light.wi * x.frame;
    float pdf = pdf_direction(x, guide, wi);
    float weight = light.delta ? 1.0 : mis_weight(light.pdf, pdf);
    vec3 scattered = eval_scatterer(x, wi) * light.radiance;
    Connection connection = Connection(vec3(0.0), shadow_ray(s, light));
    if (x.passes || light.pdf <= 0.0 || max_component(scattered) <= 0.0) return connection;
    connection.light = scattered * (weight / light.pdf);
    return connection;
}

bool brings_light(Connection connection) {
    return max_component(connection.light) > 0.0;
}

#endif
