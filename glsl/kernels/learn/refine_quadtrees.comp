// Refines the quadtrees at the end of a learning iteration (Mueller, Gross and Novak 2017). Leaves of the spatial tree
// are split where many paths have passed, and squares of directions are split where much flux has arrived. The refined
// trees are sampled from now on, and all sums are cleared. Prefix sums assign the memory, so that the order in which
// invocations run does not change any bit.
//
// The refinement has four stages, each one dispatch. Stage "measure" measures every leaf. Stage "place" assigns memory.
// Stage "draft" builds a new quadtree for every leaf. Stage "settle" copies the drafts to the memory that is sampled,
// once for each leaf that replaces the old one.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "film/frame.glsl"
#include "guide/samplers/quadtree_refinement.glsl"

// Push constants: part of an iteration of the refinement.
struct RefinePush {
    uint stage;      // REFINE_*
    uint iteration;  // number k of the iteration; iteration k has 2^k steps
};
layout(push_constant, scalar) uniform Push { RefinePush push; };

// Numbers of new nodes and of leaves, by the number of levels into which their leaf is to be split.
shared uint nodes_by_splits[MOST_SPLITS + 1u];
shared uint leaves_by_splits[MOST_SPLITS + 1u];
// Numbers of nodes and of leaves that each lane places.
shared uint lane_nodes[WORKGROUP_SIZE];
shared uint lane_leaves[WORKGROUP_SIZE];

// ---- measure: an invocation per leaf

// Sums up a node's flux for each quarter. The nodes below it must be summed up already. Returns the number of the
// node's own targets.
float measure_node(uint first, uint node) {
    uint links = radiance_node(node).w;
    float targets = 0.0;
    for (uint quarter = 0u; quarter < 4u; ++quarter) {
        uint index = 4u * node + quarter;
        bool is_leaf = !has_node(links, quarter);
        uint below = is_leaf ? node : first + linked_node(links, quarter);
        float flux = is_leaf ? sum_of_targets(index, scene().target_limit) : sum_of_quarters(flux_of_quarters(below));
        if (is_leaf) targets += number_of_targets(index);
        store_quarter_flux(index, flux);
    }
    return targets;
}

// Number of nodes that a square with this flux needs from a level where there were no nodes. Its quarters have equal
// shares.
uint nodes_of_square(float flux, float threshold, uint level) {
    uint nodes = 0u;
    uint squares = 1u;
    for (; flux > threshold && level < QUADTREE_LEVELS; ++level) {
        nodes += squares;
        squares *= 4u;
        flux *= 0.25;
    }
    return nodes;
}

// Number of new nodes that replace this node and the squares below its quarters that have no node yet.
uint nodes_of_node(uint node, bool is_first, float threshold) {
    uint links = radiance_node(node).w;
    vec4 flux = flux_of_quarters(node);
    uint nodes = 1u;
    for (uint quarter = 0u; quarter < 4u; ++quarter) {
        if (!has_node(links, quarter)) nodes += nodes_of_square(flux[quarter], threshold, level_of(links) + 1u);
    }
    return is_first || sum_of_quarters(flux) > threshold ? nodes : 0u;
}

// Number of levels into which a leaf is to be split.
uint splits_of(float targets, uint level) {
    float most = LEAF_TARGETS * sqrt(exp2(float(push.iteration)));
    uint splits = 0u;
    for (; targets > most && splits < MOST_SPLITS && level + splits < SPATIAL_LEVELS; ++splits) targets *= 0.5;
    return splits;
}

void measure(uint index) {
    Leaf leaf = leaf_of(radiance_node(leaf_place(index)));
    float targets = 0.0;
    for (uint i = 0u; i <= leaf.last; ++i) targets += measure_node(leaf.first, leaf.first + leaf.last - i);
    float threshold = FLUX_SHARE * sum_of_quarters(flux_of_quarters(leaf.first));
    uint nodes = 0u;
    for (uint i = 0u; i <= leaf.last; ++i) nodes += nodes_of_node(leaf.first + i, i == 0u, threshold);
    store_plan(index, Plan(nodes, splits_of(targets, leaf.level), 0u, 0u));
}

// ---- place: one workgroup

void count_plans() {
    for (uint i = gl_LocalInvocationIndex; i <= MOST_SPLITS; i += WORKGROUP_SIZE) {
        nodes_by_splits[i] = 0u;
        leaves_by_splits[i] = 0u;
    }
    barrier();
    for (uint leaf = gl_LocalInvocationIndex; leaf < leaf_count(); leaf += WORKGROUP_SIZE) {
        Plan plan = plan_of(leaf);
        atomicAdd(nodes_by_splits[plan.splits], plan.nodes);
        atomicAdd(leaves_by_splits[plan.splits], 1u);
    }
    barrier();
}

uint fewer_splits(uint splits, uint fewer) {
    return splits > fewer ? splits - fewer : 0u;
}

// Whether the memory suffices if every leaf is split into `fewer` fewer levels.
bool has_room(uint fewer) {
    float nodes = 0.0;
    float leaves = 0.0;
    for (uint splits = 0u; splits <= MOST_SPLITS; ++splits) {
        float copies = float(1u << fewer_splits(splits, fewer));
        nodes += copies * float(nodes_by_splits[splits]);
        leaves += copies * float(leaves_by_splits[splits]);
    }
    return nodes <= float(QUADTREE_NODES) && leaves <= float(leaf_limit());
}

// Number of nodes of a new tree. If the memory is full, no tree grows. The tree of the first iteration may use all
// memory.
uint nodes_in_room(uint leaf, uint nodes, bool is_full) {
    uint room = leaf_count() == 1u ? QUADTREE_NODES : leaf_of(radiance_node(leaf_place(leaf))).last + 1u;
    return is_full ? min(nodes, room) : nodes;
}

// Assigns places to a lane's leaves, from the leaf number `leaves` and the node number `nodes` on.
void place_leaves(uint begin, uint end, uint fewer, bool is_full, uint leaves, uint nodes) {
    for (uint leaf = begin; leaf < end; ++leaf) {
        Plan plan = plan_of(leaf);
        uint splits = fewer_splits(plan.splits, fewer);
        Plan placed = Plan(nodes_in_room(leaf, plan.nodes, is_full), splits, leaves, nodes);
        store_plan(leaf, placed);
        leaves += 1u << splits;
        nodes += placed.nodes << splits;
    }
}

void place() {
    count_plans();
    uint fewer = 0u;
    for (; fewer < MOST_SPLITS && !has_room(fewer); ++fewer) {}
    bool is_full = !has_room(fewer);

    uint lane = gl_LocalInvocationIndex;
    uint per_lane = (leaf_count() + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    uint begin = min(lane * per_lane, leaf_count());
    uint end = min(begin + per_lane, leaf_count());
    uint nodes = 0u;
    uint leaves = 0u;
    for (uint leaf = begin; leaf < end; ++leaf) {
        Plan plan = plan_of(leaf);
        uint splits = fewer_splits(plan.splits, fewer);
        nodes += nodes_in_room(leaf, plan.nodes, is_full) << splits;
        leaves += 1u << splits;
    }
    lane_nodes[lane] = nodes;
    lane_leaves[lane] = leaves;
    barrier();
    uint first_node = 0u;
    uint first_leaf = 0u;
    for (uint before = 0u; before < lane; ++before) {
        first_node += lane_nodes[before];
        first_leaf += lane_leaves[before];
    }
    place_leaves(begin, end, fewer, is_full, first_leaf, first_node);
    if (lane == WORKGROUP_SIZE - 1u) {
        store_radiance_node(draft_leaf_count_place(), uvec4(first_leaf + leaves - 1u, leaf_count(), 0u, 0u));
    }
}

// ---- draft: an invocation per leaf

// Converts node `i` of a draft to the form that is sampled, and drafts the nodes of its quarters from the number `next`
// on. Returns the number of nodes drafted so far.
uint draft_node(Plan plan, uint old_first, uint i, uint next, float threshold) {
    Draft draft = draft_of(plan.first + i);
    bool is_new = draft.origin == NONE;
    uint origin = is_new ? old_first : draft.origin;
    uint old_links = is_new ? 0u : radiance_node(origin).w;
    vec4 flux = is_new ? vec4(0.25 * draft.flux) : flux_of_quarters(origin);
    uint quarters = 0u;
    uint first = next;
    for (uint quarter = 0u; quarter < 4u; ++quarter) {
        bool has_flux = flux[quarter] > threshold && draft.level + 1u < QUADTREE_LEVELS;
        if (has_flux && next < plan.nodes) {
            uint old = has_node(old_links, quarter) ? old_first + linked_node(old_links, quarter) : NONE;
            store_draft(plan.first + next, Draft(old, flux[quarter], draft.level + 1u));
            quarters |= 1u << quarter;
            ++next;
        }
    }
    uvec4 words = quadtree_words(flux, links_to(first, draft.level, quarters));
    store_radiance_node(draft_place(plan.first + i), words);
    return next;
}

void draft_tree(Leaf leaf, Plan plan) {
    float flux = sum_of_quarters(flux_of_quarters(leaf.first));
    store_draft(plan.first, Draft(leaf.first, flux, 0u));
    uint next = 1u;
    for (uint i = 0u; i < plan.nodes; ++i) {
        if (i < next) {
            next = draft_node(plan, leaf.first, i, next, FLUX_SHARE * flux);
        } else {
            store_radiance_node(draft_place(plan.first + i), uvec4(0u));
        }
    }
}

// Replaces a leaf by a tree of halves, stored as a heap.
void split_leaf(uint index, Leaf leaf, Plan plan) {
    // A spatial tree with n leaves has 2 n - 1 nodes. Each additional leaf that an earlier leaf splits into adds two
    // nodes.
    uint heap = 2u * leaf_count() - 1u + 2u * (plan.leaf - index);
    uint copies = 1u << plan.splits;
    if (copies > 1u) store_spatial_node(leaf.spatial_node, SPATIAL_SPLIT | heap);
    for (uint i = 0u; i + 2u < copies; ++i) store_spatial_node(heap + i, SPATIAL_SPLIT | (heap + 2u * i + 2u));
    for (uint copy = 0u; copy < copies; ++copy) {
        uint node = copies > 1u ? heap + copies - 2u + copy : leaf.spatial_node;
        uint first = plan.first + copy * plan.nodes;
        store_spatial_node(node, first);
        Leaf split = Leaf(node, leaf.level + plan.splits, first, plan.nodes - 1u);
        store_radiance_node(draft_leaf_place(plan.leaf + copy), leaf_words(split));
    }
}

void draft(uint index) {
    Leaf leaf = leaf_of(radiance_node(leaf_place(index)));
    Plan plan = plan_of(index);
    draft_tree(leaf, plan);
    split_leaf(index, leaf, plan);
}

// ---- settle: a workgroup per leaf

// First node of the draft for a leaf. Leaves that are halves of the same old leaf share its draft: that of the last
// plan that does not begin after the leaf's first node.
uint source_of(Leaf leaf, uint plans) {
    uint low = 0u;
    uint high = plans;
    for (uint i = 0u; high - low > 1u && i < 32u; ++i) {
        uint middle = (low + high) / 2u;
        bool is_behind = plan_of(middle).first > leaf.first;
        high = is_behind ? middle : high;
        low = is_behind ? low : middle;
    }
    return plan_of(low).first;
}

void settle_leaf(uint index, uint plans) {
    uvec4 words = radiance_node(draft_leaf_place(index));
    Leaf leaf = leaf_of(words);
    uint source = source_of(leaf, plans);
    for (uint i = gl_LocalInvocationIndex; i <= leaf.last; i += WORKGROUP_SIZE) {
        store_radiance_node(leaf.first + i, radiance_node(draft_place(source + i)));
        for (uint quarter = 0u; quarter < 4u; ++quarter) forget_targets(4u * (leaf.first + i) + quarter);
    }
    if (gl_LocalInvocationIndex == 0u) store_radiance_node(leaf_place(index), words);
}

void settle() {
    // The number of leaves comes from the draft, because this stage overwrites leaf_count().
    uvec4 counts = radiance_node(draft_leaf_count_place());
    for (uint leaf = gl_WorkGroupID.x; leaf <= counts.x; leaf += gl_NumWorkGroups.x) settle_leaf(leaf, counts.y);
    if (gl_GlobalInvocationID.x == 0u) store_radiance_node(leaf_count_place(), uvec4(counts.x, 0u, 0u, 0u));
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (push.stage == REFINE_MEASURE && index < leaf_count()) measure(index);
    if (push.stage == REFINE_PLACE) place();
    if (push.stage == REFINE_DRAFT && index < leaf_count()) draft(index);
    if (push.stage == REFINE_SETTLE) settle();
}
