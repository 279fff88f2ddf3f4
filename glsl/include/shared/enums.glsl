// Enumerated values that GLSL and Rust share. build.rs makes a Rust constant of every constant in this folder; the
// comment above a group of constants becomes the doc comment of each of them.
#ifndef ENUMS_GLSL
#define ENUMS_GLSL

// Sampler of scattered directions: the value of the specialization constant SAMPLER.
const uint SAMPLER_BSDF = 0u;
const uint SAMPLER_REJECTION_MIX = 1u;
const uint SAMPLER_REJECTION = 2u;
const uint SAMPLER_SPHERE_INVERSION = 3u;
const uint SAMPLER_HEMISPHERE_INVERSION = 4u;
const uint SAMPLER_PRODUCT = 5u;
const uint SAMPLER_QUADTREE = 6u;

// Stage of the kernel refine_quadtrees. Each stage is one dispatch.
const uint REFINE_MEASURE = 0u;
const uint REFINE_PLACE = 1u;
const uint REFINE_DRAFT = 2u;
const uint REFINE_SETTLE = 3u;

// Quantity that the sampler rejection-mix mixes with the uniform share: densities (Eq. 8) or acceptances (Eq. 9).
const uint MIX_DENSITY = 0u;
const uint MIX_ACCEPTANCE = 1u;

// Map between directions and the square that is divided into bins. Both maps preserve areas.
const uint MAP_EQUAL_AREA = 0u;
const uint MAP_CYLINDRICAL = 1u;

// Pattern in which the samples of a pixel are distributed.
const uint PATTERN_INDEPENDENT = 0u;
const uint PATTERN_SOBOL = 1u;
const uint PATTERN_BLUE_NOISE = 2u;

// Quantity that Russian roulette derives a path's survival probability from.
const uint ROULETTE_THROUGHPUT = 0u;
const uint ROULETTE_CONTRIBUTION = 1u;

// Set of BSDFs on which a guide is used.
const uint GUIDE_SET_DIFFUSE = 0u;
const uint GUIDE_SET_AUTHORS = 1u;
const uint GUIDE_SET_ALL = 2u;

// Learner of the radiance grid: the value of the specialization constant LEARNER.
const uint LEARNER_SARSA = 0u;
const uint LEARNER_EXPECTED_SARSA = 1u;
const uint LEARNER_MONTE_CARLO = 2u;

// Reconstruction filter of the film.
const uint FILTER_BOX = 0u;
const uint FILTER_TENT = 1u;
const uint FILTER_GAUSSIAN = 2u;

// Kind of camera.
const uint CAMERA_PERSPECTIVE = 0u;
const uint CAMERA_THINLENS = 1u;
const uint CAMERA_ORTHOGRAPHIC = 2u;
const uint CAMERA_EQUIRECTANGULAR = 3u;
const uint CAMERA_EQUAL_AREA = 4u;

// Shape of a primitive. The shape occupies bits 0 and 1 of the primitive's flags.
const uint SHAPE_TRIANGLE = 0u;
const uint SHAPE_PARALLELOGRAM = 1u;
const uint SHAPE_DISK = 2u;
const uint SHAPE_SPHERE = 3u;

// Bit masks of a primitive's flags.
const uint PRIMITIVE_SHAPE_MASK = 3u;
const uint PRIMITIVE_FLIP_NORMAL = 4u;
const uint PRIMITIVE_VERTEX_NORMALS = 8u;
// The shape is large beside its distance from the world's origin, from which distances to its plane are measured then.
const uint PRIMITIVE_LARGE = 16u;
// Rays that meet the shape from behind pass. The front is the side to which the shading normal points.
const uint PRIMITIVE_FRONT_ONLY = 32u;
// The record is that of an instance.
const uint PRIMITIVE_INSTANCE = 64u;
// The transform of the instance is the identity.
const uint PRIMITIVE_UNMOVED = 128u;
// The transform of the instance depends on time.
const uint PRIMITIVE_MOVING = 256u;
// The sphere is the room of a disk of its radius that faces the point which it lights.
const uint PRIMITIVE_FACING = 512u;
// Rays that come straight from the camera pass the shape.
const uint PRIMITIVE_UNSEEN = 1024u;
// The shape is a triangle whose vertices move while the shutter is open.
const uint PRIMITIVE_DEFORMING = 2048u;

// Kind of a material that is a choice between two materials. The files of the folder bsdf declare the numbers of the other kinds.
const uint MATERIAL_BLEND = 13u;
const uint MATERIAL_SIDES = 14u;

// Bit masks of the first word of a material's record. The low byte holds the kind; the other bits are flags.
const uint MATERIAL_KIND_MASK = 255u;
const uint MATERIAL_TWO_SIDED = 256u;
const uint MATERIAL_GGX = 512u;
const uint MATERIAL_NONLINEAR = 1024u;
const uint MATERIAL_FAST_APPROXIMATION = 2048u;
const uint MATERIAL_BUMP = 4096u;
const uint MATERIAL_NORMAL_MAP = 8192u;
const uint MATERIAL_COATED = 16384u;
const uint MATERIAL_RELIEF_OUTSIDE = 32768u;
const uint MATERIAL_SMOOTH_BASE = 65536u;
// Some part of the material has holes: an opacity below 1.
const uint MATERIAL_HOLES = 131072u;
// Some part of the material lets light go straight on, through holes or through a thin sheet of glass.
const uint MATERIAL_LETS_THROUGH = 262144u;
// The surface bounds a medium: what fills the space may differ between its sides.
const uint MATERIAL_BOUNDARY = 524288u;
// What reflects light takes nothing from the diffuse base below it: a weight says what the base sheds.
const uint MATERIAL_WEIGHTED_BASE = 1048576u;
// A rough diffuse surface, or the weighted base of a plastic, keeps all light that it does not absorb.
const uint MATERIAL_ENERGY_PRESERVING = 2097152u;
// A sheen covers the surface.
const uint MATERIAL_SHEEN = 4194304u;
// The surface is a smooth dielectric and nothing else: all light that it transmits goes on in one direction.
const uint MATERIAL_REFRACTS = 8388608u;
// Radiance that crosses the surface does not change with the index of refraction.
const uint MATERIAL_UNSCALED = 16777216u;
// A bump or normal map casts no soft shadows.
const uint MATERIAL_RELIEF_UNSHADOWED = 33554432u;
// Normals of a bump or normal map are raised until their mirror directions leave the surface.
const uint MATERIAL_RELIEF_RAISED = 67108864u;
// A fiber runs along u, not along v.
const uint MATERIAL_ALONG_U = 134217728u;

// Position of the exterior medium in the word of a material's record that holds both media.
const uint EXTERIOR_MEDIUM_SHIFT = 16u;

// Feature that some material or emitter of the scene uses: a bit of SURFACE_FEATURES.
const uint FEATURE_OPACITY = 1u;
const uint FEATURE_BUMP = 2u;
const uint FEATURE_NORMAL_MAP = 4u;
const uint FEATURE_COATING = 8u;
const uint FEATURE_TANGENTS = 16u;
const uint FEATURE_TEXTURES = 32u;
const uint FEATURE_TEXTURED_EMITTERS = 64u;
const uint FEATURE_BECKMANN = 128u;
const uint FEATURE_RELIEF_OUTSIDE = 256u;
const uint FEATURE_SMOOTH_BASE = 512u;
// Some medium is a grid.
const uint FEATURE_VOLUMES = 1024u;
// Some medium emits light.
const uint FEATURE_GLOW = 2048u;
// Some emitter of a surface has a cone.
const uint FEATURE_CONES = 4096u;
const uint FEATURE_WEIGHTED_BASE = 8192u;
const uint FEATURE_ENERGY_PRESERVING = 16384u;
const uint FEATURE_SHEEN = 32768u;
// Connections to lights go on through materials that refract.
const uint FEATURE_REFRACTED_CONNECTIONS = 65536u;
const uint FEATURE_UNSCALED = 131072u;
const uint FEATURE_RELIEF_UNSHADOWED = 262144u;
const uint FEATURE_RELIEF_RAISED = 524288u;
const uint FEATURE_FILM = 1048576u;

// Flags of a volume. One without VOLUME_COLORS has numbers, one without VOLUME_NEAREST is interpolated between its voxels.
const uint VOLUME_COLORS = 1u;
const uint VOLUME_NEAREST = 2u;
// Beyond its border a volume goes on with its outermost voxels, repeats or mirrors itself with one of these flags; it is 0 without them.
const uint VOLUME_CLAMP = 4u;
const uint VOLUME_REPEAT = 8u;
const uint VOLUME_MIRROR = 16u;
// The volume of a medium's albedo has coefficients of scattering, which are divided by the extinction.
const uint VOLUME_SCATTERING = 32u;

// Flag in the first word of a texture's record: storage format, filter, wrap mode, and whether the texture transforms
// the surface's coordinates. An image takes one word per texel for bytes or heights, and two words for halves. TEXTURE_KINDS
// is the union of the flags of all textures.
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
const uint TEXTURE_HEIGHTS = 1024u;
const uint TEXTURE_PROGRAM = 2048u;
// The bytes are encoded by the sRGB curve, and the mix of the four texels is decoded in their place.
const uint TEXTURE_ENCODED = 4096u;

// Operation of a program of textures. PROGRAM_OPERATIONS and PROGRAM_LATER_OPERATIONS have a bit for each operation that the scene
// uses: the first for those below 32, the second for the others.
const uint OPERATION_TRANSFORM = 0u;
const uint OPERATION_SPHERICAL = 1u;
const uint OPERATION_CYLINDRICAL = 2u;
const uint OPERATION_COMPONENT = 3u;
const uint OPERATION_ADD = 4u;
const uint OPERATION_SUBTRACT = 5u;
const uint OPERATION_MULTIPLY = 6u;
const uint OPERATION_DIVIDE = 7u;
const uint OPERATION_MINIMUM = 8u;
const uint OPERATION_MAXIMUM = 9u;
const uint OPERATION_POWER = 10u;
const uint OPERATION_ABSOLUTE = 11u;
const uint OPERATION_SINE = 12u;
const uint OPERATION_SQUARE_ROOT = 13u;
const uint OPERATION_MIX = 14u;
const uint OPERATION_DOT = 15u;
const uint OPERATION_LUMINANCE = 16u;
const uint OPERATION_IMAGE = 17u;
const uint OPERATION_CHECKER = 18u;
const uint OPERATION_DOTS = 19u;
const uint OPERATION_FBM = 20u;
const uint OPERATION_WRINKLED = 21u;
const uint OPERATION_MARBLE = 22u;
const uint OPERATION_FLOOR = 23u;
const uint OPERATION_LESS = 24u;
const uint OPERATION_EXPONENTIAL = 25u;
const uint OPERATION_LOGARITHM = 26u;
const uint OPERATION_ARCTANGENT = 27u;
const uint OPERATION_COMBINE = 28u;
const uint OPERATION_HSV_FROM_RGB = 29u;
const uint OPERATION_RGB_FROM_HSV = 30u;
const uint OPERATION_HSL_FROM_RGB = 31u;
const uint OPERATION_RGB_FROM_HSL = 32u;
const uint OPERATION_TABLE = 33u;
const uint OPERATION_WHITE_NOISE = 34u;
const uint OPERATION_NOISE_1D = 35u;
const uint OPERATION_NOISE_2D = 36u;
const uint OPERATION_NOISE_3D = 37u;
const uint OPERATION_NOISE_4D = 38u;
const uint OPERATION_VORONOI_1D = 39u;
const uint OPERATION_VORONOI_2D = 40u;
const uint OPERATION_VORONOI_3D = 41u;
const uint OPERATION_VORONOI_4D = 42u;
const uint OPERATION_BRICKS = 43u;

// Operand of an operation: a register below PROGRAM_REGISTERS, or one of these.
const uint OPERAND_CONSTANT = 16u;
const uint OPERAND_UV = 17u;
const uint OPERAND_POSITION = 18u;
const uint OPERAND_NORMAL = 19u;
const uint OPERAND_SHADING_NORMAL = 20u;
const uint OPERAND_INCOMING = 21u;

// Sum of the octaves of a noise.
const uint FRACTAL_FBM = 0u;
const uint FRACTAL_MULTIFRACTAL = 1u;
const uint FRACTAL_HYBRID = 2u;
const uint FRACTAL_RIDGED = 3u;
const uint FRACTAL_TERRAIN = 4u;

// Quantity of a Voronoi diagram, measure of its distances, and what is asked of it.
const uint VORONOI_NEAREST = 0u;
const uint VORONOI_SECOND = 1u;
const uint VORONOI_SMOOTH = 2u;
const uint VORONOI_EDGE = 3u;
const uint VORONOI_RADIUS = 4u;
const uint METRIC_EUCLIDEAN = 0u;
const uint METRIC_MANHATTAN = 1u;
const uint METRIC_CHEBYCHEV = 2u;
const uint METRIC_MINKOWSKI = 3u;
const uint VORONOI_DISTANCE = 0u;
const uint VORONOI_COLOR = 1u;
const uint VORONOI_POSITION = 2u;
const uint VORONOI_W = 3u;

// Number of a material's first color or scalar parameter, as counted by the links from materials to textures.
const uint PARAMETER_COLOR0 = 0u;
const uint PARAMETER_SCALAR0 = 3u;
// Numbers of the parameters of a sheen, which follow those of all BSDFs.
const uint PARAMETER_SHEEN_REFLECTANCE = 15u;
const uint PARAMETER_SHEEN_ROUGHNESS = 16u;
// Number of the thickness of a thin film.
const uint PARAMETER_FILM_THICKNESS = 17u;

// Position of the page number in a texel word's address: the page is address >> TEXEL_PAGE_SHIFT.
const uint TEXEL_PAGE_SHIFT = 30u;

// Model of a ward: a number in its record.
const float WARD_BALANCED = 0.0;
const float WARD_ORIGINAL = 1.0;
const float WARD_DUER = 2.0;

// Mean cosine that stands for the lobe of Rayleigh scattering, in the record of a phase function.
const float PHASE_RAYLEIGH = 2.0;

// Kind of environment.
const uint ENVIRONMENT_NONE = 0u;
const uint ENVIRONMENT_CONSTANT = 1u;
const uint ENVIRONMENT_MAP = 2u;

// Kind of a sampled light. LIGHT_KIND_SHIFT is the position of the kind in the word of a light's record that holds it.
const uint LIGHT_AREA = 0u;
const uint LIGHT_ENVIRONMENT = 1u;
const uint LIGHT_POINT = 2u;
const uint LIGHT_SPOT = 3u;
const uint LIGHT_DIRECTIONAL = 4u;
const uint LIGHT_PICTURED_SPOT = 5u;
const uint LIGHT_PROJECTOR = 6u;
// Area light that an instance shows.
const uint LIGHT_PLACED = 7u;
const uint LIGHT_KIND_SHIFT = 29u;

// A light's record holds its group and its alias in one word. LIGHT_GROUP_SHIFT is the position of the group, and
// LIGHT_INDEX_MASK the mask of the alias.
const uint LIGHT_GROUP_SHIFT = 24u;
const uint LIGHT_INDEX_MASK = 16777215u;
// Patches along each side of an environment, where cells learn which lights to draw. Each patch is a light of its own.
const uint ENVIRONMENT_PATCHES = 8u;

// Index that stands for "none".
const uint NONE = 4294967295u;

// Index of a statistic among a kernel's counters. COUNTER_COUNT is the number of counters.
const uint COUNTER_RAYS = 0u;
const uint COUNTER_SCATTERED_RAYS = 1u;
const uint COUNTER_LIGHT_HITS = 2u;
const uint COUNTER_GUIDED_SAMPLES = 3u;
const uint COUNTER_TRIES = 4u;
const uint COUNTER_INVALID_SAMPLES = 5u;
const uint COUNTER_NONFINITE = 6u;
const uint COUNTER_OVERRUNS = 7u;
const uint COUNTER_SHADOW_RAYS = 8u;
const uint COUNTER_CUT_SHADOW_RAYS = 9u;
const uint COUNTER_CUT_FLIGHTS = 10u;
const uint COUNTER_COUNT = 11u;

#endif
