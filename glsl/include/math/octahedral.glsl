// Unit vectors in 32 bits: octahedral encoding (Cigolle et al. 2014, "A Survey of Efficient Representations for
// Independent Unit Vectors").
#ifndef OCTAHEDRAL_GLSL
#define OCTAHEDRAL_GLSL

vec3 octahedral_decode(uint bits) {
    vec2 p = unpackSnorm2x16(bits);
    float z = 1.0 - abs(p.x) - abs(p.y);
    float fold = max(-z, 0.0);
    vec2 xy = p - vec2(p.x >= 0.0 ? fold : -fold, p.y >= 0.0 ? fold : -fold);
    return normalize(vec3(xy, z));
}

#endif
