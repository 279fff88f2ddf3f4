// Values that both sides name. build.rs reads these lines and writes the Rust constants, so this file holds nothing else.

// Sampler of scattered directions.
const uint SAMPLER_BSDF = 0u;
const uint SAMPLER_REJECTION_MIX = 1u;

// Learner of the radiance grid.
const uint LEARNER_SARSA = 0u;

// Reconstruction filter.
const uint FILTER_BOX = 0u;
const uint FILTER_TENT = 1u;
const uint FILTER_GAUSSIAN = 2u;

// Kind of the camera.
const uint CAMERA_PERSPECTIVE = 0u;
const uint CAMERA_THINLENS = 1u;
const uint CAMERA_ORTHOGRAPHIC = 2u;

// Shape of a primitive; bits 0 and 1 of the record's flags.
const uint SHAPE_TRIANGLE = 0u;
const uint SHAPE_PARALLELOGRAM = 1u;
const uint SHAPE_DISK = 2u;
const uint SHAPE_SPHERE = 3u;

// Flags of a primitive's attributes.
const uint PRIMITIVE_SHAPE_MASK = 3u;
const uint PRIMITIVE_FLIP_NORMAL = 4u;
const uint PRIMITIVE_VERTEX_NORMALS = 8u;

// Kind of a material.
const uint BSDF_DIFFUSE = 0u;

// "No such thing" as an index.
const uint NONE = 4294967295u;

// What a kernel counts, as indices into its counters.
const uint COUNTER_RAYS = 0u;
const uint COUNTER_SCATTERED_RAYS = 1u;
const uint COUNTER_LIGHT_HITS = 2u;
const uint COUNTER_GUIDED_SAMPLES = 3u;
const uint COUNTER_TRIES = 4u;
const uint COUNTER_INVALID_SAMPLES = 5u;
const uint COUNTER_NONFINITE = 6u;
const uint COUNTER_OVERRUNS = 7u;
const uint COUNTER_COUNT = 8u;
