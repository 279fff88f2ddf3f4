//! Scalar operations of a kernel's variant, grouped by the GLSL functions that they come from.

use std::ops::Range;

use lodestar::generated::kernels::Variant;
use lodestar::gpu::KernelSource;
use lodestar::spirv::inspect::{Class, Histogram, SourceLine, report};

const TRAVERSE: &str = include_str!("../../glsl/include/geometry/traverse.glsl");
const INTERSECT: &str = include_str!("../../glsl/include/geometry/intersect.glsl");
/// Functions that the visit of a node calls.
const OF_NODES: [&str; 3] = ["has_nodes", "intersect_node", "intersect_children4"];
/// Functions that the visit of a node calls for each child, in a loop over four children.
const OF_CHILDREN: [&str; 4] = ["child_bits", "byte_to_float", "max_as_int", "min_as_int"];
const CHILDREN: f64 = 4.0;
/// Number of lines of the loop over a node's primitives.
const PRIMITIVE_LOOP_LINES: u32 = 11;
/// Functions of `intersect.glsl` that a test of a primitive calls.
const OF_PRIMITIVES: [&str; 2] = ["intersect_flat", "intersect_sphere"];
/// Classes of instructions that count: arithmetic. Most conversions are changes of type without cost, so they do not
/// count.
const COUNTED: [Class; 9] = [
    Class::Float,
    Class::Integer,
    Class::Bits,
    Class::Comparison,
    Class::Select,
    Class::Division,
    Class::Root,
    Class::Transcendental,
    Class::Atomic,
];

/// Operations of a variant. Instructions outside of the traversal are counted statically, so a loop's body counts once.
#[derive(Debug, Clone, Copy)]
pub struct Operations {
    pub per_node: f64,
    pub per_primitive: f64,
    /// All other operations.
    pub rest: f64,
}

impl Operations {
    /// Counts the operations of a kernel that calls `traverse` at one place.
    pub fn of(source: &KernelSource, variant: &Variant) -> Self {
        let report = report(source, &variant.entries()).expect("a kernel");
        let specialized = report.specialized.as_ref().map(|specialized| &specialized.histogram);
        let histogram = specialized.unwrap_or_else(|fault| {
            println!("{}: operations are counted before constants are folded, too many: {fault}", source.name);
            &report.histogram
        });
        Self::of_histogram(histogram)
    }

    fn of_histogram(histogram: &Histogram) -> Self {
        let parts = Parts::new();
        let sum = |part: Part| {
            let own = histogram.lines.iter().filter(|line| parts.of(line) == part);
            own.map(scalars).sum::<f64>()
        };
        // A loop that the optimizer has unrolled contains all of its instructions.
        let is_rolled = histogram.lines.iter().any(|line| parts.is_loop_over_children(line));
        let per_node = sum(Part::Node) + sum(Part::Child) * if is_rolled { CHILDREN } else { 1.0 };
        let per_primitive = sum(Part::Primitive);
        assert!(per_node > 0.0 && per_primitive > 0.0, "traverse.glsl is not as it was");
        Self { per_node, per_primitive, rest: sum(Part::Rest) }
    }
}

/// Part of the traversal that a line belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Node,
    Child,
    Primitive,
    Rest,
}

/// Positions of the parts in `traverse.glsl`, and of the tests of primitives in `intersect.glsl`.
struct Parts {
    nodes: Vec<Range<u32>>,
    children: Vec<Range<u32>>,
    children_loop: Range<u32>,
    primitives: Vec<Range<u32>>,
    tests: Vec<Range<u32>>,
}

impl Parts {
    fn new() -> Self {
        let functions =
            |text, names: &[&str]| names.iter().map(|name| lines_of_function(text, name)).collect::<Vec<_>>();
        let traverse = lines_of_function(TRAVERSE, "traverse");
        let primitives = line_of(&traverse, "while (primitives != 0u)");
        let mut nodes = functions(TRAVERSE, &OF_NODES);
        nodes.push(line_of(&traverse, "while (has_nodes")..traverse.end);
        let mut of_primitives = functions(TRAVERSE, &["intersect_primitive"]);
        of_primitives.push(primitives..primitives + PRIMITIVE_LOOP_LINES);
        Self {
            nodes,
            children: functions(TRAVERSE, &OF_CHILDREN),
            children_loop: lines_of_function(TRAVERSE, "intersect_children4"),
            primitives: of_primitives,
            tests: functions(INTERSECT, &OF_PRIMITIVES),
        }
    }

    fn of(&self, line: &SourceLine) -> Part {
        let is_in = |ranges: &[Range<u32>]| ranges.iter().any(|range| range.contains(&line.line));
        if line.file.ends_with("/intersect.glsl") {
            return if is_in(&self.tests) { Part::Primitive } else { Part::Rest };
        }
        match line.file.ends_with("/traverse.glsl") {
            true if is_in(&self.primitives) => Part::Primitive,
            true if is_in(&self.children) => Part::Child,
            true if is_in(&self.nodes) => Part::Node,
            _ => Part::Rest,
        }
    }

    fn is_loop_over_children(&self, line: &SourceLine) -> bool {
        let is_there = line.file.ends_with("/traverse.glsl") && self.children_loop.contains(&line.line);
        is_there && line.classes.contains_key(&Class::Loop)
    }
}

fn scalars(line: &SourceLine) -> f64 {
    let counted = line.classes.iter().filter(|(class, _)| COUNTED.contains(class));
    counted.map(|(_, count)| count.scalars as f64).sum()
}

/// Lines of a function's definition, counted from 1.
fn lines_of_function(text: &str, name: &str) -> Range<u32> {
    let call = format!(" {name}(");
    let is_begin = |line: &str| line.contains(&call) && !line.starts_with([' ', '/']);
    let begin = text.lines().position(is_begin).unwrap_or_else(|| panic!("no function {name}")) as u32;
    let length = text.lines().skip(begin as usize).position(|line| line == "}").expect("its end") as u32;
    begin + 1..begin + length + 2
}

/// Line of `traverse.glsl`, counted from 1, that contains `part`, among the given lines.
fn line_of(among: &Range<u32>, part: &str) -> u32 {
    let mut lines = (1..).zip(TRAVERSE.lines()).filter(|(line, _)| among.contains(line));
    lines.find(|(_, text)| text.contains(part)).unwrap_or_else(|| panic!("traverse.glsl has no line with {part}")).0
}
