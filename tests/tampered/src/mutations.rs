//! Mutations of the kernels. A text to replace must occur exactly once in its file. In its replacement, `MUTATED` is
//! true if the mutation is chosen.

/// Text of a file, and its replacement.
pub struct Patch {
    pub file: &'static str,
    pub text: &'static str,
    pub mutated: &'static str,
}

/// Change to the kernels.
pub struct Mutation {
    pub name: &'static str,
    pub patches: &'static [Patch],
}

const SLICE: &str = "glsl/include/film/slice.glsl";
const VERTEX: &str = "glsl/include/path/vertex.glsl";
const ROULETTE: &str = "glsl/include/path/roulette.glsl";
const TRACKING: &str = "glsl/include/path/tracking.glsl";
const VOLUME: &str = "glsl/include/path/volume.glsl";
const TALLY: &str = "glsl/include/film/tally.glsl";
const UPDATE_NORMALIZATION: &str = "glsl/kernels/learn/update_normalization.comp";
const BLUE_NOISE: &str = "glsl/include/random/blue_noise.glsl";
const CELLS: &str = "glsl/include/guide/grid/cells.glsl";
const DEFORMING: &str = "glsl/include/geometry/deforming.glsl";
const CONNECTION: &str = "glsl/include/path/connection.glsl";
const EXPECTED_SARSA: &str = "glsl/include/path/expected_sarsa.glsl";
const GUIDE: &str = "glsl/include/guide/samplers/guide.glsl";
const GUIDING: &str = "glsl/include/path/guiding.glsl";
const HAIR: &str = "glsl/include/bsdf/hair.glsl";
const INSTANCE: &str = "glsl/include/geometry/instance.glsl";
const MOTION: &str = "glsl/include/geometry/motion.glsl";
const LEARNING: &str = "glsl/include/path/learning.glsl";
const LIGHT: &str = "glsl/include/light/light.glsl";
const LIGHT_SHAPE: &str = "glsl/include/light/light_shape.glsl";
const MONTE_CARLO: &str = "glsl/include/guide/learners/monte_carlo.glsl";
const NORMALIZATION: &str = "glsl/include/guide/normalization/normalization_entry.glsl";
const PATH: &str = "glsl/include/path/path.glsl";
const STRAIGHT: &str = "glsl/include/path/straight.glsl";
const PASSAGE: &str = "glsl/include/path/passage.glsl";
const MEASURED: &str = "glsl/include/bsdf/measured.glsl";
const MEDIUM: &str = "glsl/include/path/medium.glsl";
const PLASTIC: &str = "glsl/include/bsdf/plastic.glsl";
const RADIANCE_GRID: &str = "glsl/include/guide/grid/radiance_grid.glsl";
const RANDOM: &str = "glsl/include/random/random.glsl";
const PARTS: &str = "glsl/include/guide/samplers/parts.glsl";
const PROGRAM: &str = "glsl/include/texture/program.glsl";
const PRODUCT: &str = "glsl/include/guide/samplers/product.glsl";
const QUADTREE: &str = "glsl/include/guide/samplers/quadtree.glsl";
const QUADTREE_NODES: &str = "glsl/include/guide/samplers/quadtree_nodes.glsl";
const QUADTREE_REFINEMENT: &str = "glsl/include/guide/samplers/quadtree_refinement.glsl";
const REFINE_QUADTREES: &str = "glsl/kernels/learn/refine_quadtrees.comp";
const REJECTION: &str = "glsl/include/guide/samplers/rejection_mix.glsl";
const SHEEN: &str = "glsl/include/bsdf/sheen.glsl";
const SEGMENT: &str = "glsl/include/guide/learners/segment.glsl";
const SOBOL: &str = "glsl/include/random/sobol.glsl";
const SURFACE: &str = "glsl/include/geometry/surface.glsl";
const THIN_FILM: &str = "glsl/include/math/thin_film.glsl";

/// Patch that gives the file of sets of samples the constant. The file of blue noise includes that file.
const SOBOL_FINDS_CONSTANT: Patch =
    Patch { file: SOBOL, text: "#define SOBOL_GLSL", mutated: "#define SOBOL_GLSL\n#include \"shared/variant.glsl\"" };

const fn mutation(name: &'static str, patches: &'static [Patch]) -> Mutation {
    Mutation { name, patches }
}

/// All mutations: the faults, then what another renderer does, then the changes that must not matter.
pub const MUTATIONS: &[Mutation] = &[
    mutation(
        "memo keyed by a visitor's normal",
        &[Patch {
            file: GUIDE,
            text: "return Guide(cell, bin, representative_normal(bin), n,",
            mutated: "return Guide(cell, bin, MUTATED ? n : representative_normal(bin), n,",
        }],
    ),
    mutation(
        "maximum over bin centers",
        &[Patch {
            file: NORMALIZATION,
            text: "bin_radiance * cosine.maximum",
            mutated: "bin_radiance * (MUTATED ? dot(bin_center(bin), representative_normal(normal_bin)) : cosine.maximum)",
        }],
    ),
    mutation(
        "clipped acceptance",
        &[Patch {
            file: NORMALIZATION,
            text: "entry.acceptance_scale = usable ? 1.0 / bound : 0.0;",
            mutated: "entry.acceptance_scale = usable ? (MUTATED ? 1.25 : 1.0) / bound : 0.0;",
        }],
    ),
    mutation(
        "off-by-one bin",
        &[Patch {
            file: REJECTION,
            text: "s.bin = square_bin(p, DIRECTION_RESOLUTION);",
            mutated: "s.bin = (square_bin(p, DIRECTION_RESOLUTION) + (MUTATED ? 1u : 0u)) % direction_bin_count();",
        }],
    ),
    mutation(
        "missing cosine",
        &[Patch {
            file: REJECTION,
            text: "acceptance(guide.entry, s.radiance * dot(s.wi, guide.nb))",
            mutated: "acceptance(guide.entry, s.radiance * (MUTATED ? 1.0 : dot(s.wi, guide.nb)))",
        }],
    ),
    mutation(
        "missing uniform share in the density",
        &[Patch {
            file: REJECTION,
            text: "+ uniform_density(guide, taken.wi);",
            mutated: "+ (MUTATED ? 0.0 : uniform_density(guide, taken.wi));",
        }],
    ),
    mutation(
        "fallback not in the density",
        &[Patch {
            file: NORMALIZATION,
            text: "(unconditional + (1.0 - unconditional) * all_fail)",
            mutated: "(unconditional + (MUTATED ? 0.0 : 1.0 - unconditional) * all_fail)",
        }],
    ),
    mutation(
        "proposals of a pair alike",
        &[Patch {
            file: REJECTION,
            text: "Proposal first = propose(random, guide, uniform_share || tries == MAX_TRIES);",
            mutated: "RandomStream again = random;\n        \
                  Proposal first = propose(random, guide, uniform_share || tries == MAX_TRIES);\n        \
                  if (MUTATED) random = again;",
        }],
    ),
    mutation(
        "horizon of the representative normal",
        &[Patch {
            file: GUIDE,
            text: "return dot(wi, guide.n) > 0.0 ?",
            mutated: "return dot(wi, MUTATED ? guide.nb : guide.n) > 0.0 ?",
        }],
    ),
    mutation(
        "inversion forgets the uniform share",
        &[Patch {
            file: NORMALIZATION,
            text: "(1.0 - e) * bin_density() / total",
            mutated: "(MUTATED ? 1.0 : 1.0 - e) * bin_density() / total",
        }],
    ),
    mutation(
        "neighbor of the drawn part",
        &[Patch {
            file: PARTS,
            text: "uint x = choose ? chosen_x : part.x;",
            mutated: "uint x = choose ? chosen_x ^ (MUTATED ? 1u : 0u) : part.x;",
        }],
    ),
    mutation(
        "descent counted whole",
        &[Patch {
            file: PRODUCT,
            text: "return mix(of_descent, of_cosine, guide.bsdf_share);",
            mutated: "return (MUTATED ? of_descent : (1.0 - guide.bsdf_share) * of_descent) + guide.bsdf_share * of_cosine;",
        }],
    ),
    mutation(
        "share of the cosine not in the density",
        &[Patch {
            file: GUIDING,
            text: "return GuideDensity(product_density(guide, scatterer.frame * wi, density), density);",
            mutated: "return GuideDensity(MUTATED ? density : product_density(guide, scatterer.frame * wi, density), density);",
        }],
    ),
    mutation(
        "another BSDF share than the cell's",
        &[Patch {
            file: GUIDING,
            text: "1.0 - whole_share : guide.bsdf_share;",
            mutated: "1.0 - whole_share : (MUTATED ? 0.25 : guide.bsdf_share);",
        }],
    ),
    mutation(
        "another share of a whole function in the density",
        &[Patch {
            file: GUIDING,
            text: "density_of_choice(pdf, density.over_whole, guided_share(scatterer.bsdf, guide))",
            mutated: "density_of_choice(pdf, density.over_whole, (MUTATED ? 0.8 : 1.0) * guided_share(scatterer.bsdf, guide))",
        }],
    ),
    mutation(
        "the guide's share of principled surfaces not in the density",
        &[Patch {
            file: GUIDING,
            text: "if (guides_whole() && is_guided(guide)) pdf = density_of_choice",
            mutated: "if (MUTATED && is_kind(scatterer.bsdf, BSDF_PRINCIPLED)) return pdf;\n    \
                  if (guides_whole() && is_guided(guide)) pdf = density_of_choice",
        }],
    ),
    mutation(
        "a smooth metal guided as a rough one in the density",
        &[Patch {
            file: GUIDING,
            text: "guided_share(scatterer.bsdf, guide));\n    return pdf;",
            mutated: "(MUTATED && is_kind(scatterer.bsdf, BSDF_ROUGH_CONDUCTOR) ? 1.0 : guided_share(scatterer.bsdf, guide)));\n    \
                  return pdf;",
        }],
    ),
    mutation(
        "bright samples with a smaller weight",
        &[Patch {
            file: TALLY,
            text: "float weight = w.of_sample * count;",
            mutated: "float weight = w.of_sample * count * (MUTATED && mean_rgb(b.mean) > mean_rgb(a.mean) ? 0.25 : 1.0);",
        }],
    ),
    mutation(
        "lobe counted whole",
        &[Patch {
            file: PLASTIC,
            text: "return (1.0 - plastic_specular_probability(b, reflectance)) * diffuse_density;",
            mutated: "return (MUTATED ? 1.0 : 1.0 - plastic_specular_probability(b, reflectance)) * diffuse_density;",
        }],
    ),
    mutation(
        "a sheen that gains energy",
        &[Patch {
            file: SHEEN,
            text: "lobe.kept = max(1.0 - max_component(lobe.albedo), 0.0);",
            mutated: "lobe.kept = MUTATED ? 1.0 : max(1.0 - max_component(lobe.albedo), 0.0);",
        }],
    ),
    mutation(
        "a film that turns no phase",
        &[Patch {
            file: THIN_FILM,
            text: "return FilmPolarization(-top * real, -top * imaginary,",
            mutated: "return FilmPolarization((MUTATED ? top : -top) * real, (MUTATED ? top : -top) * imaginary,",
        }],
    ),
    mutation(
        "a lobe of hair with another width around the fiber",
        &[Patch {
            file: HAIR,
            text: "f.scale = 0.626657069 * (0.265 * n",
            mutated: "f.scale = (MUTATED ? 0.7 : 0.626657069) * (0.265 * n",
        }],
    ),
    mutation(
        "samples of hair with another width around the fiber",
        &[Patch {
            file: HAIR,
            text: "float off = clamp(f.scale * log(odds), -PI, PI)",
            mutated: "float off = clamp((MUTATED ? 1.15 : 1.0) * f.scale * log(odds), -PI, PI)",
        }],
    ),
    mutation(
        "samples of a measured material that are all alike",
        &[Patch {
            file: MEASURED,
            text: "for (uint kind = MEASURED_BRIGHTNESS; kind <=",
            mutated: "for (uint kind = MUTATED ? MEASURED_VISIBLE_NORMALS : MEASURED_BRIGHTNESS; kind <=",
        }],
    ),
    mutation(
        "stale normalizer",
        &[Patch {
            file: UPDATE_NORMALIZATION,
            text: "        store_normalization_record(",
            mutated: "        bool is_kept = any(notEqual(normalization_record(normalization_index(cell, normal_bin)), uvec4(0u)));\n        \
                      if (!MUTATED || !is_kept) store_normalization_record(",
        }],
    ),
    mutation(
        "swapped halves of a sum",
        &[Patch {
            file: RADIANCE_GRID,
            text: "(float(s.high) * 4294967296.0 + float(s.low))",
            mutated: "(float(MUTATED ? s.low : s.high) * 4294967296.0 + float(MUTATED ? s.high : s.low))",
        }],
    ),
    mutation(
        "lost carry",
        &[Patch { file: RADIANCE_GRID, text: "if (old + units < old)", mutated: "if (!MUTATED && old + units < old)" }],
    ),
    mutation(
        "targets rounded down",
        &[Patch {
            file: RADIANCE_GRID,
            text: "(u < units - whole ? 1u : 0u)",
            mutated: "(u < units - whole && !MUTATED ? 1u : 0u)",
        }],
    ),
    mutation(
        "learning rate without decay",
        &[Patch {
            file: RADIANCE_GRID,
            text: "float alpha = target_count / weight;",
            mutated: "float alpha = target_count / (MUTATED ? before.weight + target_count : weight);",
        }],
    ),
    mutation(
        "target without attenuation",
        &[Patch {
            file: LEARNING,
            text: "mean_rgb(next.weight) * next.radiance",
            mutated: "(MUTATED ? 1.0 : mean_rgb(next.weight)) * next.radiance",
        }],
    ),
    mutation(
        "roulette scales the bootstrap target",
        &[Patch {
            file: VERTEX,
            text: "float target = target_at(path.key, path.depth, light, scatterer, next);",
            mutated: "float target = target_at(path.key, path.depth, light, scatterer, next);\n    \
                  if (MUTATED && path.depth >= RR_DEPTH && target != NO_TARGET) {\n        \
                  target /= clamp(max_component(path.throughput * next.weight), 0.05, 0.95);\n    }",
        }],
    ),
    mutation(
        "returns without survival",
        &[Patch {
            file: VERTEX,
            text: "path.last_vertex.factor /= max(survival, 1.0e-30);",
            mutated: "if (!MUTATED) path.last_vertex.factor /= max(survival, 1.0e-30);",
        }],
    ),
    mutation(
        "missing survival weight",
        &[Patch {
            file: VERTEX,
            text: "path.throughput /= max(survival, 1.0e-30);",
            mutated: "if (!MUTATED) path.throughput /= max(survival, 1.0e-30);",
        }],
    ),
    mutation(
        "survivors of roulette with too small a weight",
        &[Patch {
            file: VERTEX,
            text: "path.throughput /= max(survival, 1.0e-30);",
            mutated: "path.throughput /= max(survival, MUTATED ? 0.25 : 1.0e-30);",
        }],
    ),
    mutation(
        "targets that are no numbers",
        &[Patch {
            file: SEGMENT,
            text: "bool finite = is_finite(target);",
            mutated: "bool finite = MUTATED || is_finite(target);",
        }],
    ),
    mutation(
        "survivors of roulette give nothing up",
        &[Patch {
            file: ROULETTE,
            text: "return min(in_place * (1.0 / max(survival, 1.0e-30) - 1.0), collected);",
            mutated: "return min(in_place * (MUTATED ? 0.0 : 1.0 / max(survival, 1.0e-30) - 1.0), collected);",
        }],
    ),
    mutation(
        "ended paths bring less than survivors give up",
        &[Patch {
            file: VERTEX,
            text: "vec3 in_place = light_in_place(path.radiance, path.throughput, expected, survival);",
            mutated: "vec3 in_place = light_in_place(path.radiance, path.throughput, expected, survival);\n    \
                  if (MUTATED && !survives) in_place *= 0.8;",
        }],
    ),
    mutation(
        "roulette by a used random number",
        &[Patch {
            file: VERTEX,
            text: "expected_radiance(guide, next), u.w)",
            mutated: "expected_radiance(guide, next), MUTATED ? u.x : u.w)",
        }],
    ),
    mutation(
        "density 0 for the weights",
        &[Patch { file: VERTEX, text: "path.pdf = next.pdf;", mutated: "path.pdf = MUTATED ? 0.0 : next.pdf;" }],
    ),
    mutation(
        "emitters counted twice",
        &[Patch {
            file: VERTEX,
            text: "if (NEE) light *= emission_weight(",
            mutated: "if (NEE && !MUTATED) light *= emission_weight(",
        }],
    ),
    mutation(
        "missing Jacobian",
        &[Patch {
            file: LIGHT_SHAPE,
            text: "return squared / max(area, 1.0e-37) / max(cosine, 1.0e-20);",
            mutated: "return MUTATED ? 1.0 / area : squared / max(area, 1.0e-37) / max(cosine, 1.0e-20);",
        }],
    ),
    mutation(
        "points of a set not scrambled",
        &[
            SOBOL_FINDS_CONSTANT,
            Patch {
                file: SOBOL,
                text: "owen_scramble(sobol_digits(shuffled.xy), bits >> 25u)",
                mutated: "owen_scramble(sobol_digits(shuffled.xy), (MUTATED ? uvec4(0u) : bits) >> 25u)",
            },
        ],
    ),
    mutation(
        "a digit of points on the film lost",
        &[
            SOBOL_FINDS_CONSTANT,
            Patch {
                file: SOBOL,
                text: "reversed_sobol(uvec2(number, other)), bits)) >> 16u",
                mutated: "reversed_sobol(uvec2(number, other)), bits)) >> (MUTATED ? 17u : 16u)",
            },
        ],
    ),
    mutation(
        "digits of points of a tile lost",
        &[Patch {
            file: BLUE_NOISE,
            text: ">> (32u - POINT_DIGITS)",
            mutated: ">> (32u - (MUTATED ? PLACE_DIGITS : POINT_DIGITS))",
        }],
    ),
    mutation(
        "rest of a random number not stretched",
        &[Patch {
            file: QUADTREE,
            text: "/ max(probability, 1.0e-30)",
            mutated: "/ (MUTATED ? 1.0 : max(probability, 1.0e-30))",
        }],
    ),
    mutation(
        "left and right of a square exchanged",
        &[Patch {
            file: QUADTREE_NODES,
            text: "share_of(flux.x, flux.y)",
            mutated: "(MUTATED ? share_of(flux.y, flux.x) : share_of(flux.x, flux.y))",
        }],
    ),
    mutation(
        "halves of a leaf in one tree",
        &[Patch {
            file: REFINE_QUADTREES,
            text: "plan.first + copy * plan.nodes",
            mutated: "plan.first + (MUTATED ? 0u : copy * plan.nodes)",
        }],
    ),
    mutation(
        "learning takes surfaces to be 5 % brighter",
        &[
            Patch {
                file: LEARNING,
                text: "return mean_rgb(light) + ",
                mutated: "return mean_rgb(light) + (MUTATED ? 1.05 : 1.0) * ",
            },
            Patch {
                file: EXPECTED_SARSA,
                text: "return mean_rgb(light) + ",
                mutated: "return mean_rgb(light) + (MUTATED ? 1.05 : 1.0) * ",
            },
            Patch {
                file: MONTE_CARLO,
                text: "collected = vertex.light + ",
                mutated: "collected = vertex.light + (MUTATED ? 1.05 : 1.0) * ",
            },
        ],
    ),
    mutation(
        "learning takes surfaces to be twice as bright",
        &[
            Patch {
                file: LEARNING,
                text: "return mean_rgb(light) + ",
                mutated: "return mean_rgb(light) + (MUTATED ? 2.0 : 1.0) * ",
            },
            Patch {
                file: EXPECTED_SARSA,
                text: "return mean_rgb(light) + ",
                mutated: "return mean_rgb(light) + (MUTATED ? 2.0 : 1.0) * ",
            },
            Patch {
                file: MONTE_CARLO,
                text: "collected = vertex.light + ",
                mutated: "collected = vertex.light + (MUTATED ? 2.0 : 1.0) * ",
            },
        ],
    ),
    mutation(
        "weights blind to the guide",
        &[Patch {
            file: CONNECTION,
            text: "float pdf = pdf_direction(scatterer, guide, wi);",
            mutated: "float pdf = pdf_direction(scatterer, guide, wi);\n    \
                  if (MUTATED) pdf = pdf_bsdf(scatterer.bsdf, scatterer.wo, wi, pdf_cosine_hemisphere(wi.z));",
        }],
    ),
    mutation(
        "light counted whole however it is found",
        &[Patch {
            file: LIGHT,
            text: "float ratio = other / own;",
            mutated: "if (MUTATED) return 1.0;\n    float ratio = other / own;",
        }],
    ),
    mutation(
        "light selection counts the light that it has drawn",
        &[Patch {
            file: LIGHT,
            text: "LightGroupRecord lights = load_light_group(chosen.group);",
            mutated: "if (MUTATED) chosen.group_probability = mix(chosen.group_probability, 1.0, 0.02);\n    \
                  LightGroupRecord lights = load_light_group(chosen.group);",
        }],
    ),
    mutation(
        "a light that is hit has the density within its group",
        &[Patch {
            file: LIGHT,
            text: "group_probability(cell, record.group_and_alias >> LIGHT_GROUP_SHIFT) * probability",
            mutated: "(MUTATED ? 1.0 : group_probability(cell, record.group_and_alias >> LIGHT_GROUP_SHIFT)) * probability",
        }],
    ),
    mutation(
        "holes that shadow rays do not pass",
        &[
            Patch {
                file: PASSAGE,
                text: "} else if (!may_pass(attribute_material(hit.primitive))) {",
                mutated: "} else if (MUTATED || !may_pass(attribute_material(hit.primitive))) {",
            },
            Patch {
                file: PASSAGE,
                text: "if (may_pass(surface.material)) {",
                mutated: "if (!MUTATED && may_pass(surface.material)) {",
            },
        ],
    ),
    mutation(
        "light that passes each surface twice",
        &[Patch {
            file: PASSAGE,
            text: "passage.share *= transmission.share;",
            mutated: "passage.share *= MUTATED ? transmission.share * transmission.share : transmission.share;",
        }],
    ),
    mutation(
        "the density at the last hole",
        &[Patch {
            file: VERTEX,
            text: "if (!straight && !refracted) path.previous_position = surface.position;\n        if (!through) ",
            mutated: "if ((!straight && !refracted) || MUTATED) path.previous_position = surface.position;\n        \
                      if (!through || MUTATED) ",
        }],
    ),
    mutation(
        "light that refraction does not weaken",
        &[Patch {
            file: STRAIGHT,
            text: "sheet = behind.weight;",
            mutated: "sheet = MUTATED ? vec3(1.0) : behind.weight;",
        }],
    ),
    mutation(
        "refracted light counted twice",
        &[Patch { file: VERTEX, text: "met = meets_light(", mutated: "met = !MUTATED && meets_light(" }],
    ),
    mutation(
        "the density of a refracted direction",
        &[Patch {
            file: VERTEX,
            text: "direction = path.setting_out;",
            mutated: "if (!MUTATED) direction = path.setting_out;",
        }],
    ),
    mutation(
        "refracted rays blocked by what lies on their straight line",
        &[Patch { file: PASSAGE, text: "any_hit = !bends_light();", mutated: "any_hit = MUTATED || !bends_light();" }],
    ),
    mutation(
        "facing disks turned to the last hole",
        &[Patch {
            file: PATH,
            text: "turn_disks(path.previous_position, ",
            mutated: "turn_disks(MUTATED ? path.ray.origin : path.previous_position, ",
        }],
    ),
    mutation(
        "media that dim sampled lights twice",
        &[Patch {
            file: MEDIUM,
            text: "transmittance(extinction_of(medium), distance);",
            mutated: "transmittance(extinction_of(medium), (MUTATED ? 2.0 : 1.0) * distance);",
        }],
    ),
    mutation(
        "grids that dim sampled lights twice",
        &[Patch {
            file: TRACKING,
            text: "share *= 1.0 - min(extinction * value / walk.majorant, 1.0);",
            mutated: "vec3 left_over = 1.0 - min(extinction * value / walk.majorant, 1.0);\n            \
                      share *= MUTATED ? left_over * left_over : left_over;",
        }],
    ),
    mutation(
        "majorants too low",
        &[Patch {
            file: VOLUME,
            text: "walk.majorant = uintBitsToFloat(texel_word(volume.majorants + index));",
            mutated: "walk.majorant = (MUTATED ? 0.7 : 1.0) * uintBitsToFloat(texel_word(volume.majorants + index));",
        }],
    ),
    mutation(
        "null collisions without a weight",
        &[Patch {
            file: TRACKING,
            text: "flight.weight *= factor;",
            mutated: "if (!MUTATED || flight.scatters) flight.weight *= factor;",
        }],
    ),
    mutation(
        "the medium of the other side",
        &[Patch {
            file: MEDIUM,
            text: "bool inside = dot(direction, surface.geometric_normal) < 0.0;",
            mutated: "bool inside = (dot(direction, surface.geometric_normal) < 0.0) != MUTATED;",
        }],
    ),
    mutation(
        "in media, the density of another phase function",
        &[Patch {
            file: VERTEX,
            text: "if (has_media()) path.medium = medium_beyond(surface, next.wi, path.medium);",
            mutated: "if (has_media()) path.medium = medium_beyond(surface, next.wi, path.medium);\n        \
                  if (MUTATED && surface.material == NONE) path.pdf = 0.5 * INV_TWO_PI;",
        }],
    ),
    mutation(
        "an instance turns normals like directions",
        &[Patch {
            file: SURFACE,
            text: "vec3 turned = placement.local * n;",
            mutated: "vec3 turned = (MUTATED ? placement.world : placement.local) * n;",
        }],
    ),
    mutation(
        "an instance turns normals of vertices like directions",
        &[Patch {
            file: SURFACE,
            text: "interpolated_normal(attributes.normals, hit.uv, s.geometric_normal, placement.local)",
            mutated: "interpolated_normal(attributes.normals, hit.uv, s.geometric_normal, MUTATED ? placement.world : placement.local)",
        }],
    ),
    mutation(
        "rays of unit length in instances",
        &[Patch {
            file: INSTANCE,
            text: "ray.direction * placement.local, ray.t_max)",
            mutated: "MUTATED ? normalize(ray.direction * placement.local) : ray.direction * placement.local, ray.t_max)",
        }],
    ),
    mutation(
        "motions turn the other way",
        &[Patch {
            file: MOTION,
            text: "sin_cos_turn(s * m.turns)",
            mutated: "sin_cos_turn(MUTATED ? -s * m.turns : s * m.turns)",
        }],
    ),
    mutation(
        "a lamp sampled at another time",
        &[Patch {
            file: LIGHT,
            text: "Surface s = sample_area_light(place.primitive, place.instance, from, u);",
            mutated: "float now = moment; if (MUTATED) moment = 1.0 - now; Surface s = sample_area_light(place.primitive, place.instance, from, u); moment = now;",
        }],
    ),
    mutation(
        "normals of a deforming mesh at the key before",
        &[Patch {
            file: DEFORMING,
            text: "interpolated_normal(after, uv, geometric_normal, transform), keys.way);",
            mutated: "interpolated_normal(after, uv, geometric_normal, transform), MUTATED ? 0.0 : keys.way);",
        }],
    ),
    mutation(
        "a deforming mesh goes back between its keys",
        &[Patch {
            file: DEFORMING,
            text: "load_key(first + KEY_TEXELS), way);",
            mutated: "load_key(first + KEY_TEXELS), MUTATED ? 1.0 - way : way);",
        }],
    ),
    mutation(
        "densities 5 % off",
        &[Patch {
            file: GUIDING,
            text: "eval_scatterer(scatterer, bsdf_sample.wi) / ",
            mutated: "eval_scatterer(scatterer, bsdf_sample.wi) / (MUTATED ? 1.05 : 1.0) / ",
        }],
    ),
    mutation(
        "densities 25 % off",
        &[Patch {
            file: GUIDING,
            text: "eval_scatterer(scatterer, bsdf_sample.wi) / ",
            mutated: "eval_scatterer(scatterer, bsdf_sample.wi) / (MUTATED ? 1.25 : 1.0) / ",
        }],
    ),
    mutation(
        "shadow rays through few surfaces",
        &[Patch {
            file: PASSAGE,
            text: "Passage(ray, vec3(1.0), medium, MAX_DEPTH - 1u - depth, true,",
            mutated: "Passage(ray, vec3(1.0), medium, MUTATED ? 16u : MAX_DEPTH - 1u - depth, true,",
        }],
    ),
    // Mitsuba 3 ends its shadow rays so early (its constant `ShadowEpsilon`, 15000 / 2^24).
    mutation(
        "shadow rays end before the light",
        &[Patch {
            file: LIGHT,
            text: "ray.direction = d / max(ray.t_max, 1.0e-30);",
            mutated: "ray.direction = d / max(ray.t_max, 1.0e-30);\n        \
                  ray.t_max *= MUTATED ? 1.0 - 15000.0 / 16777216.0 : 1.0;",
        }],
    ),
    // Mitsuba 3 lets rays start so far off (its constant `RayEpsilon`, 1500 / 2^24).
    mutation(
        "rays start far off",
        &[Patch {
            file: SURFACE,
            text: "return Ray(s.position + s.epsilon * off, wi, MAX_DISTANCE);",
            mutated: "float far = max(s.epsilon, 1500.0 / 16777216.0 * (1.0 + max_abs(s.position)));\n    \
                  return Ray(s.position + (MUTATED ? far : s.epsilon) * off, wi, MAX_DISTANCE);",
        }],
    ),
    // The following changes must not matter.
    mutation(
        "digits flipped whatever comes before",
        &[
            SOBOL_FINDS_CONSTANT,
            Patch { file: SOBOL, text: "(1u + (x >> 2u))", mutated: "(1u + (MUTATED ? uvec4(0u) : x >> 2u))" },
            Patch { file: SOBOL, text: "(3u + (x >> 1u))", mutated: "(3u + (MUTATED ? uvec4(0u) : x >> 1u))" },
        ],
    ),
    mutation(
        "coarser squares of directions",
        &[Patch {
            file: QUADTREE_REFINEMENT,
            text: "const float FLUX_SHARE = 0.01;",
            mutated: "const float FLUX_SHARE = MUTATED ? 0.03 : 0.01;",
        }],
    ),
    mutation(
        "cells in another order",
        &[Patch {
            file: CELLS,
            text: "return cell_word((place.z * scene().grid_size.y + place.y) * scene().grid_size.x + place.x);",
            mutated: "uint cell = cell_word((place.z * scene().grid_size.y + place.y) * scene().grid_size.x + place.x);\n    \
                  return MUTATED ? scene().cell_count - 1u - cell : cell;",
        }],
    ),
    mutation(
        "normalizers summed backwards",
        &[Patch {
            file: NORMALIZATION,
            text: "for (uint bin = 0u; bin < direction_bin_count(); ++bin) {",
            mutated: "for (uint place = 0u; place < direction_bin_count(); ++place) {\n        \
                  uint bin = MUTATED ? direction_bin_count() - 1u - place : place;",
        }],
    ),
    mutation(
        "workgroups in another order",
        &[Patch {
            file: SLICE,
            text: "workgroup * slice.workgroup_stride",
            mutated: "workgroup * (MUTATED ? 1u : slice.workgroup_stride)",
        }],
    ),
    mutation(
        "other random blocks",
        &[
            Patch {
                file: RANDOM,
                text: "#define RANDOM_GLSL",
                mutated: "#define RANDOM_GLSL\n#include \"shared/variant.glsl\"",
            },
            Patch {
                file: RANDOM,
                text: "const uint RANDOM_TRIES = 1u;",
                mutated: "const uint RANDOM_TRIES = MUTATED ? 9u : 1u;",
            },
        ],
    ),
    mutation(
        "computed heights tilt to the wrong side",
        &[Patch {
            file: PROGRAM,
            text: "return (heights.yz - heights.x) / steps;",
            mutated: "return (MUTATED ? heights.x - heights.yz : heights.yz - heights.x) / steps;",
        }],
    ),
    mutation(
        "another multiplier of leftover bits",
        &[Patch { file: RANDOM, text: "* 0x9e3779b9u)", mutated: "* (MUTATED ? 0x85ebca6bu : 0x9e3779b9u))" }],
    ),
    mutation(
        "roulette ends more paths",
        &[Patch {
            file: ROULETTE,
            text: "const float MOST_SURVIVAL = 0.95;",
            mutated: "const float MOST_SURVIVAL = MUTATED ? 0.93 : 0.95;",
        }],
    ),
    mutation(
        "another window of roulette",
        &[Patch {
            file: ROULETTE,
            text: "if (NEE) safe_part = SAFE_PART_WITH_LIGHT;",
            mutated: "if (NEE) safe_part = SAFE_PART_WITH_LIGHT;\n    if (MUTATED) safe_part = 1.0;",
        }],
    ),
    mutation(
        "the balance heuristic",
        &[Patch {
            file: LIGHT,
            text: "return 1.0 / (1.0 + ratio * ratio);",
            mutated: "return 1.0 / (1.0 + ratio * (MUTATED ? 1.0 : ratio));",
        }],
    ),
];
