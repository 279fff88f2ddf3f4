// Never dispatched: declares the records that kernels read as texels, so that build.rs can hold layout.rs against them.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
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
    uint reserved;
};

layout(scalar, set = 0, binding = 0) restrict buffer Probe0 { PrimitiveRecord primitives[]; };
layout(scalar, set = 0, binding = 1) restrict buffer Probe1 { AttributeRecord attributes[]; };

void main() {
    primitives[0].reserved = primitives[1].origin.x + primitives[1].edge_tolerance + primitives[1].edge_v.x;
    attributes[0].reserved = attributes[1].normals.x + attributes[1].material + attributes[1].emitter;
}
