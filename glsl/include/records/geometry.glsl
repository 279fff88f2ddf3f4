// Records of primitives with their attributes, and of instances. src/encode/bvh.rs writes them.
#ifndef RECORDS_GEOMETRY_GLSL
#define RECORDS_GEOMETRY_GLSL

// Primitive as rays meet it.
struct PrimitiveRecord {
    vec3 origin;           // first vertex or center
    uint flags;            // SHAPE_* and PRIMITIVE_*
    vec3 edge_u;           // first edge vector: `edge_u` of the scene's primitive
    float edge_tolerance;  // slack of the edge tests per unit of distance: the length of the longest edge, or the sphere's radius
    vec3 edge_v;           // second edge vector: `edge_v` of the scene's primitive
    // Dot product of the edges' cross product with every point of a flat shape's plane, relative to the shape's origin or, with
    // PRIMITIVE_LARGE, to the world's; 0 for a sphere.
    float plane;
};

// Attributes of a primitive, which only the nearest hit needs.
struct AttributeRecord {
    uvec3 normals;  // vertex normals in octahedral encoding, 16 bits per coordinate
    uint material;  // index of the material
    vec2 uv0;       // texture coordinates of the first vertex
    vec2 uv1;       // texture coordinates of the second vertex
    vec2 uv2;       // texture coordinates of the third vertex
    uint emitter;   // index of the emitter, or NONE
    uint light;     // index of the primitive's light in the alias table, or NONE
};

// Instance: a group of primitives in another place. It lies among the primitives. These are the rows of the matrix that turns
// directions of the world into directions of the group's space.
struct InstanceRecord {
    vec3 local_x;  // first row
    uint flags;  // PRIMITIVE_INSTANCE and PRIMITIVE_UNMOVED
    vec3 local_y;  // second row
    uint root;  // index of the first node of the group's hierarchy
    vec3 local_z;  // third row
    uint first_light;  // index of the instance's first light; those of its group follow each other
};

// Instance whose transform depends on time. Its flags, root and first light stand where an InstanceRecord has them.
struct MovingRecord {
    uint motion;         // first texel of the motion
    uint segments;       // number of the motion's segments
    uint unused;         // fills the place of a number
    uint flags;          // PRIMITIVE_INSTANCE and PRIMITIVE_MOVING
    uvec3 reserved;      // fills the place of a row
    uint root;           // index of the first node of the group's hierarchy
    uvec3 filling;       // fills the place of a row
    uint first_light;    // index of the instance's first light
};

// Triangle whose vertices move while the shutter is open. It lies among the primitives, with what a PrimitiveRecord has that does not
// depend on time.
struct DeformingRecord {
    vec3 origin;     // first vertex where the shutter opens
    uint flags;      // SHAPE_* and PRIMITIVE_*
    vec3 edge_u;     // first edge vector where the shutter opens
    uint intervals;  // number of equal parts of the shutter's time, at whose ends the triangle has a KeyRecord
    vec3 edge_v;     // second edge vector where the shutter opens
    uint first_key;  // texel of the first of its KeyRecords, which follow each other behind all primitives
};

// Deforming triangle at a time.
struct KeyRecord {
    vec3 vertex0;  // first vertex
    uint normal0;  // its normal in octahedral encoding, 16 bits per coordinate
    vec3 vertex1;  // second vertex
    uint normal1;  // its normal
    vec3 vertex2;  // third vertex
    uint normal2;  // its normal
};

// Segment of a motion, from one key to the next. With s from 0 to 1 on the way, the matrix is that of a rotation by s times the angle, after
// the stretch plus s times its growth. Segments follow each other in the order of time, behind all primitives and their keys.
struct MotionRecord {
    vec3 origin;     // place of the origin at the segment's start
    float start;     // time at which the segment starts: 0 where the shutter opens, 1 where it closes
    vec3 travel;     // way of the origin
    float per_time;  // one over the duration
    vec3 axis;       // unit axis of the rotation
    float turns;     // angle of the rotation, in whole turns
    vec3 stretch_x;  // matrix at the start: the image of the first axis
    float unused;    // fills the texel
    vec3 stretch_y;  // image of the second axis
    float unused1;   // fills the texel
    vec3 stretch_z;  // image of the third axis
    float unused2;   // fills the texel
    vec3 growth_x;   // growth of the stretch
    float unused3;   // fills the texel
    vec3 growth_y;   // growth of the second image
    float unused4;   // fills the texel
    vec3 growth_z;   // growth of the third image
    float unused5;   // fills the texel
};

// Place of an instance, which lies where a primitive has its attributes: the world's images of the axes of the group's space, and the
// coordinates of its origin.
struct PlacementRecord {
    vec3 world_x;    // image of the first axis
    float origin_x;  // first coordinate of the origin
    vec3 world_y;    // image of the second axis
    float origin_y;  // second coordinate of the origin
    vec3 world_z;    // image of the third axis
    float origin_z;  // third coordinate of the origin
};

#endif
