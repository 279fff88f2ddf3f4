// Values that both sides name. As of every file of this folder, build.rs makes Rust constants of these lines.
#ifndef ENUMS_GLSL
#define ENUMS_GLSL

// Sampler of scattered directions.
const uint SAMPLER_BSDF = 0u;
const uint SAMPLER_REJECTION_MIX = 1u;
const uint SAMPLER_REJECTION = 2u;
const uint SAMPLER_SPHERE_INVERSION = 3u;
const uint SAMPLER_HEMISPHERE_INVERSION = 4u;
const uint SAMPLER_PRODUCT = 5u;
const uint SAMPLER_QUADTREE = 6u;

// Stage of the refinement of quadtrees.
const uint REFINE_MEASURE = 0u;
const uint REFINE_PLACE = 1u;
const uint REFINE_DRAFT = 2u;
const uint REFINE_SETTLE = 3u;

// What rejection-mix mixes with the uniform share: densities (Eq. 8) or acceptances (Eq. 9).
const uint MIX_DENSITY = 0u;
const uint MIX_ACCEPTANCE = 1u;

// Map between directions and the squares of their bins.
const uint MAP_EQUAL_AREA = 0u;
const uint MAP_CYLINDRICAL = 1u;

// How the samples of a pixel are distributed.
const uint PATTERN_INDEPENDENT = 0u;
const uint PATTERN_SOBOL = 1u;
const uint PATTERN_BLUE_NOISE = 2u;

// What Russian roulette goes by.
const uint ROULETTE_THROUGHPUT = 0u;
const uint ROULETTE_CONTRIBUTION = 1u;

// Which scattering functions a guide is used on.
const uint GUIDE_SET_DIFFUSE = 0u;
const uint GUIDE_SET_AUTHORS = 1u;
const uint GUIDE_SET_ALL = 2u;

// Learner of the radiance grid.
const uint LEARNER_SARSA = 0u;
const uint LEARNER_EXPECTED_SARSA = 1u;
const uint LEARNER_MONTE_CARLO = 2u;
const uint LEARNER_IRRADIANCE_SARSA = 3u;

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

// Kind of a material: a scattering function, or a choice between two materials.
const uint BSDF_DIFFUSE = 0u;
const uint BSDF_ROUGH_DIFFUSE = 1u;
const uint BSDF_DIELECTRIC = 2u;
const uint BSDF_THIN_DIELECTRIC = 3u;
const uint BSDF_ROUGH_DIELECTRIC = 4u;
const uint BSDF_CONDUCTOR = 5u;
const uint BSDF_ROUGH_CONDUCTOR = 6u;
const uint BSDF_PLASTIC = 7u;
const uint BSDF_ROUGH_PLASTIC = 8u;
const uint BSDF_PRINCIPLED = 9u;
const uint MATERIAL_BLEND = 10u;
const uint MATERIAL_SIDES = 11u;

// The first word of a material's record: its kind in the low byte, and flags.
const uint MATERIAL_KIND_MASK = 255u;
const uint MATERIAL_TWO_SIDED = 256u;
const uint MATERIAL_GGX = 512u;
const uint MATERIAL_NONLINEAR = 1024u;
const uint MATERIAL_FAST_APPROXIMATION = 2048u;
const uint MATERIAL_BUMP = 4096u;
const uint MATERIAL_NORMAL_MAP = 8192u;
const uint MATERIAL_COATED = 16384u;
const uint MATERIAL_RELIEF_OUTSIDE = 32768u;

// What the scene's materials use besides their kinds: bits of SURFACE_FEATURES.
const uint FEATURE_OPACITY = 1u;
const uint FEATURE_BUMP = 2u;
const uint FEATURE_NORMAL_MAP = 4u;
const uint FEATURE_COATING = 8u;
const uint FEATURE_TANGENTS = 16u;
const uint FEATURE_TEXTURES = 32u;
const uint FEATURE_TEXTURED_EMITTERS = 64u;
const uint FEATURE_BECKMANN = 128u;
const uint FEATURE_RELIEF_OUTSIDE = 256u;

// The first word of a texture's record: an image, a word per texel for bytes and two for halves, or a checkerboard; how it is
// filtered and wrapped; whether its coordinates are not the surface's. TEXTURE_KINDS unites those of all textures.
const uint TEXTURE_SRGB_BYTES = 1u;
const uint TEXTURE_LINEAR_BYTES = 2u;
const uint TEXTURE_HALVES = 4u;
const uint TEXTURE_CHECKERBOARD = 8u;
const uint TEXTURE_BILINEAR = 16u;
const uint TEXTURE_NEAREST = 32u;
const uint TEXTURE_REPEAT = 64u;
const uint TEXTURE_MIRROR = 128u;
const uint TEXTURE_CLAMP = 256u;
const uint TEXTURE_TRANSFORMED = 512u;

// Parameters of materials, as a record's links to textures count them.
const uint PARAMETER_COLOR0 = 0u;
const uint PARAMETER_SCALAR0 = 3u;

// The upper bits of an address of a word say its page.
const uint TEXEL_PAGE_SHIFT = 30u;

// Kind of the environment.
const uint ENVIRONMENT_NONE = 0u;
const uint ENVIRONMENT_CONSTANT = 1u;
const uint ENVIRONMENT_MAP = 2u;

// Kind of a light that is sampled; the upper bits of the word that bears it.
const uint LIGHT_AREA = 0u;
const uint LIGHT_ENVIRONMENT = 1u;
const uint LIGHT_POINT = 2u;
const uint LIGHT_SPOT = 3u;
const uint LIGHT_DIRECTIONAL = 4u;
const uint LIGHT_KIND_SHIFT = 29u;

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
const uint COUNTER_SHADOW_RAYS = 8u;
const uint COUNTER_COUNT = 9u;

#endif
