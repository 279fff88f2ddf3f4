//! Graph of operations. Constants are folded and equal parts are joined as operations are added; a node has only earlier ones
//! as inputs, so there are no cycles.

use std::collections::HashMap;

use glam::Vec3;

use super::operation::Operation;

/// Input of an operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Operand {
    /// Three finite numbers, everywhere.
    Constant(Vec3),
    /// Texture coordinates of the surface; the third component is 0.
    Uv,
    /// Position in world space.
    Position,
    /// Geometric normal in world space.
    Normal,
    /// Shading normal in world space.
    ShadingNormal,
    /// Unit vector to where the surface is seen from, in world space.
    Incoming,
    /// Value of the graph's node of that number.
    Node(u32),
}

impl Operand {
    /// Words that tell operands apart.
    fn key(self) -> [u32; 4] {
        match self {
            Self::Constant(value) => {
                let [x, y, z] = value.to_array().map(f32::to_bits);
                [0, x, y, z]
            }
            Self::Uv => [1, 0, 0, 0],
            Self::Position => [2, 0, 0, 0],
            Self::Normal => [3, 0, 0, 0],
            Self::Node(node) => [4, node, 0, 0],
            Self::ShadingNormal => [5, 0, 0, 0],
            Self::Incoming => [6, 0, 0, 0],
        }
    }
}

/// Operation with its inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The operation.
    pub operation: Operation,
    /// Inputs, as many as the operation's row has.
    pub inputs: Vec<Operand>,
    /// Numbers that are the same everywhere; floats as bits.
    pub numbers: Vec<u32>,
}

type Key = (Operation, Vec<[u32; 4]>, Vec<u32>);

/// Graph of operations.
#[derive(Debug, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    known: HashMap<Key, u32>,
}

impl Graph {
    /// Nodes; each stands behind its inputs.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Adds an operation, or finds an equal one. What is known before the render is folded.
    pub fn add(&mut self, operation: Operation, inputs: &[Operand], numbers: &[u32]) -> Operand {
        if let Some(simple) = self.simpler(operation, inputs, numbers) {
            return simple;
        }
        if let (Operation::Transform, [Operand::Node(inner)]) = (operation, inputs)
            && self.nodes[*inner as usize].operation == Operation::Transform
        {
            let Node { inputs, numbers: first, .. } = self.nodes[*inner as usize].clone();
            return self.add(operation, &inputs, &product(numbers, &first));
        }
        let key = (operation, inputs.iter().map(|input| input.key()).collect(), numbers.to_vec());
        let nodes = &mut self.nodes;
        let index = *self.known.entry(key).or_insert_with(|| {
            nodes.push(Node { operation, inputs: inputs.to_vec(), numbers: numbers.to_vec() });
            nodes.len() as u32 - 1
        });
        Operand::Node(index)
    }

    /// Operand that has the operation's value; `None` where there is none.
    fn simpler(&self, operation: Operation, inputs: &[Operand], numbers: &[u32]) -> Option<Operand> {
        let constants: Option<Vec<Vec3>> = inputs
            .iter()
            .map(|input| match input {
                Operand::Constant(value) => Some(*value),
                _ => None,
            })
            .collect();
        let value = constants.and_then(|constants| operation.value(&constants, numbers));
        if let Some(value) = value.filter(|value| value.is_finite()) {
            return Some(Operand::Constant(value));
        }
        let (zero, one) = (Operand::Constant(Vec3::ZERO), Operand::Constant(Vec3::ONE));
        match (operation, inputs) {
            (Operation::Multiply, [other, factor] | [factor, other]) if *factor == one => Some(*other),
            (Operation::Multiply, [_, factor] | [factor, _]) if *factor == zero => Some(zero),
            (Operation::Add, [other, term] | [term, other]) if *term == zero => Some(*other),
            (Operation::Subtract, [other, term]) if *term == zero => Some(*other),
            (Operation::Divide | Operation::Power, [other, by]) if *by == one => Some(*other),
            (Operation::Mix, [a, _, weight]) if *weight == zero => Some(*a),
            (Operation::Mix, [_, b, weight]) if *weight == one => Some(*b),
            (Operation::Mix, [a, b, _]) if a == b => Some(*a),
            (Operation::Transform, [point]) if numbers == identity() => Some(*point),
            _ => None,
        }
    }

    /// Approximate mean of an operand's value. It is accurate enough to share out samples.
    pub fn mean(&self, operand: Operand) -> Vec3 {
        let mut means: Vec<Vec3> = Vec::with_capacity(self.nodes.len());
        let of = |means: &[Vec3], operand: Operand| match operand {
            Operand::Constant(value) => value,
            Operand::Uv => Vec3::splat(0.5),
            Operand::Position | Operand::Normal | Operand::ShadingNormal | Operand::Incoming => Vec3::ZERO,
            Operand::Node(node) => means.get(node as usize).copied().unwrap_or_default(),
        };
        for Node { operation, inputs, numbers } in &self.nodes {
            let inputs: Vec<Vec3> = inputs.iter().map(|&input| of(&means, input)).collect();
            let known = operation.row().mean.map(Vec3::splat);
            means.push(known.or_else(|| operation.value(&inputs, numbers)).unwrap_or_default());
        }
        let mean = of(&means, operand);
        if mean.is_finite() { mean } else { Vec3::ZERO }
    }

    /// Image that an operand shows where the surface's coordinates lead to it, and its factor; `None` for all else.
    pub fn image(&self, operand: Operand) -> Option<(u32, Vec3)> {
        let Operand::Node(node) = operand else { return None };
        let Node { operation, inputs, numbers } = &self.nodes[node as usize];
        match (operation, &inputs[..]) {
            (Operation::Image, [Operand::Uv]) => Some((*numbers.first()?, Vec3::ONE)),
            (Operation::Multiply, [image, Operand::Constant(factor)] | [Operand::Constant(factor), image]) => {
                let (texture, first) = self.image(*image)?;
                (factor.min_element() >= 0.0).then_some((texture, first * *factor))
            }
            _ => None,
        }
    }
}

/// Numbers of the map that changes nothing.
fn identity() -> [u32; 12] {
    [1.0f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_bits)
}

/// Numbers of an affine map after another.
fn product(second: &[u32], first: &[u32]) -> Vec<u32> {
    let rows = |numbers: &[u32]| -> [[f64; 4]; 4] {
        let number = |at: usize| numbers.get(at).map_or(0.0, |&bits| f64::from(f32::from_bits(bits)));
        let mut rows = [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| number(4 * row + column)));
        rows[3] = [0.0, 0.0, 0.0, 1.0];
        rows
    };
    let (second, first) = (rows(second), rows(first));
    let entry = |row: usize, column: usize| (0..4).map(|k| second[row][k] * first[k][column]).sum::<f64>() as f32;
    (0..12).map(|at| entry(at / 4, at % 4).to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(value: f32) -> Operand {
        Operand::Constant(Vec3::splat(value))
    }

    #[test]
    fn constants_are_folded() {
        let mut graph = Graph::default();
        let sum = graph.add(Operation::Add, &[constant(2.0), constant(3.0)], &[]);
        let product = graph.add(Operation::Multiply, &[sum, constant(4.0)], &[]);
        assert_eq!((product, graph.nodes().len()), (constant(20.0), 0));
        let quotient = graph.add(Operation::Divide, &[constant(1.0), constant(0.0)], &[]);
        assert_eq!(quotient, constant(0.0));
        let same = graph.add(Operation::Mix, &[Operand::Uv, Operand::Position, constant(0.0)], &[]);
        assert_eq!(same, Operand::Uv);
        assert_eq!(graph.add(Operation::Transform, &[Operand::Position], &identity()), Operand::Position);
    }

    #[test]
    fn equal_parts_are_one() {
        let mut graph = Graph::default();
        let noise = |graph: &mut Graph, octaves| graph.add(Operation::Fbm, &[Operand::Position], &[octaves, 0]);
        let (first, second, other) = (noise(&mut graph, 3), noise(&mut graph, 3), noise(&mut graph, 4));
        assert!(first == second && first != other && graph.nodes().len() == 2);
    }

    #[test]
    fn transforms_are_multiplied() {
        let mut graph = Graph::default();
        let moved = [1.0f32, 0.0, 0.0, 5.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_bits);
        let scaled = [2.0f32, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0].map(f32::to_bits);
        let first = graph.add(Operation::Transform, &[Operand::Position], &moved);
        let Operand::Node(both) = graph.add(Operation::Transform, &[first], &scaled) else { panic!("a node") };
        let node = &graph.nodes()[both as usize];
        assert_eq!((&node.inputs[..], f32::from_bits(node.numbers[3])), (&[Operand::Position][..], 10.0));
    }

    #[test]
    fn one_image_is_no_program() {
        let mut graph = Graph::default();
        let image = graph.add(Operation::Image, &[Operand::Uv], &[7]);
        let scaled = graph.add(Operation::Multiply, &[constant(0.5), image], &[]);
        assert_eq!(graph.image(scaled), Some((7, Vec3::splat(0.5))));
        let other = graph.add(Operation::Image, &[Operand::Position], &[7]);
        assert_eq!(graph.image(other), None);
    }
}
