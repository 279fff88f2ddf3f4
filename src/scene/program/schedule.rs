//! Order and registers of a program's instructions.

use glam::Vec3;

use super::graph::{Graph, Operand};
use super::operation::Operation;
use crate::generated::constants::{MAX_PROGRAM_LENGTH, PROGRAM_REGISTERS};

/// Place of an instruction's operand.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum Place {
    /// Register, below [`PROGRAM_REGISTERS`].
    Register(u8),
    /// Constant.
    Constant(Vec3),
    /// Texture coordinates of the surface.
    Uv,
    /// Position in world space.
    Position,
    /// Geometric normal in world space.
    Normal,
    /// Shading normal in world space.
    ShadingNormal,
    /// Unit vector to where the surface is seen from, in world space.
    Incoming,
}

/// Operation whose value goes to a register.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Instruction {
    /// The operation.
    pub operation: Operation,
    /// Operands, at most three.
    pub operands: Vec<Place>,
    /// Numbers that are the same everywhere; floats as bits.
    pub numbers: Vec<u32>,
    /// Register that takes the value.
    pub output: u8,
}

/// Texture that is computed.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Program {
    /// Instructions; the last gives the program's value.
    pub instructions: Vec<Instruction>,
    /// Approximate mean value.
    pub mean: Vec3,
    /// Limits to which kernels clamp the value.
    pub limits: [f32; 2],
}

impl Program {
    /// Whether the value depends on the position.
    pub fn reads_position(&self) -> bool {
        self.instructions.iter().any(|instruction| instruction.operands.contains(&Place::Position))
    }

    /// Whether the value depends on texture coordinates.
    pub fn reads_uv(&self) -> bool {
        self.instructions.iter().any(|instruction| instruction.operands.contains(&Place::Uv))
    }

    /// Indices of the textures that the program looks up.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut u32> {
        let images = self.instructions.iter_mut().filter(|instruction| instruction.operation == Operation::Image);
        images.filter_map(|instruction| instruction.numbers.first_mut())
    }
}

/// Instructions of the graph's part that `root` needs. The error says which limit it exceeds.
pub fn schedule(graph: &Graph, root: Operand, limits: [f32; 2]) -> Result<Program, String> {
    let order = order(graph, root);
    // What is no operation becomes one that changes nothing.
    let identity = (Operation::Multiply, vec![root, Operand::Constant(Vec3::ONE)], Vec::new());
    let mut list: Vec<_> = order
        .iter()
        .map(|&node| {
            let node = &graph.nodes()[node as usize];
            (node.operation, node.inputs.clone(), node.numbers.clone())
        })
        .collect();
    if list.is_empty() {
        list.push(identity);
    }
    if list.len() > MAX_PROGRAM_LENGTH as usize {
        return Err(format!(
            "this texture takes {} operations, more than {MAX_PROGRAM_LENGTH}; simplify it or bake it to an image",
            list.len()
        ));
    }
    let mut last_use = vec![usize::MAX; graph.nodes().len()];
    for (at, (_, inputs, _)) in list.iter().enumerate() {
        nodes_of(inputs).for_each(|node| last_use[node as usize] = at);
    }
    let mut registers = vec![0u8; graph.nodes().len()];
    let mut free: Vec<u8> = (0..PROGRAM_REGISTERS as u8).rev().collect();
    let mut instructions = Vec::with_capacity(list.len());
    for (at, (operation, inputs, numbers)) in list.into_iter().enumerate() {
        let operands = inputs.iter().map(|&input| place(input, &registers)).collect();
        let mut ended: Vec<u32> = nodes_of(&inputs).filter(|&node| last_use[node as usize] == at).collect();
        ended.sort_unstable();
        ended.dedup();
        free.extend(ended.into_iter().map(|node| registers[node as usize]));
        let output = free.pop().ok_or_else(|| {
            format!(
                "this texture needs more than {PROGRAM_REGISTERS} values at the same time; simplify it or bake it to an image"
            )
        })?;
        if let Some(&node) = order.get(at) {
            registers[node as usize] = output;
        }
        instructions.push(Instruction { operation, operands, numbers, output });
    }
    Ok(Program { instructions, mean: graph.mean(root).clamp(Vec3::splat(limits[0]), Vec3::splat(limits[1])), limits })
}

fn place(operand: Operand, registers: &[u8]) -> Place {
    match operand {
        Operand::Constant(value) => Place::Constant(value),
        Operand::Uv => Place::Uv,
        Operand::Position => Place::Position,
        Operand::Normal => Place::Normal,
        Operand::ShadingNormal => Place::ShadingNormal,
        Operand::Incoming => Place::Incoming,
        Operand::Node(node) => Place::Register(registers[node as usize]),
    }
}

fn nodes_of(operands: &[Operand]) -> impl Iterator<Item = u32> + '_ {
    operands.iter().filter_map(|operand| match operand {
        Operand::Node(node) => Some(*node),
        _ => None,
    })
}

/// Nodes that `root` needs, each behind its inputs. Of two inputs, the one that needs more registers comes first (Sethi and Ullman
/// 1970).
fn order(graph: &Graph, root: Operand) -> Vec<u32> {
    let mut needs: Vec<u32> = Vec::with_capacity(graph.nodes().len());
    for node in graph.nodes() {
        let mut of_inputs: Vec<u32> = nodes_of(&node.inputs).map(|input| needs[input as usize]).collect();
        of_inputs.sort_unstable_by(|a, b| b.cmp(a));
        needs.push(of_inputs.iter().zip(0..).map(|(need, held)| need + held).max().unwrap_or(1));
    }
    let (mut order, mut done) = (Vec::new(), vec![false; graph.nodes().len()]);
    let Operand::Node(root) = root else { return order };
    // Nodes on the way, and whether their inputs stand above them.
    let mut open = vec![(root, false)];
    while let Some((node, is_ready)) = open.pop() {
        if done[node as usize] {
            continue;
        }
        if is_ready {
            done[node as usize] = true;
            order.push(node);
            continue;
        }
        open.push((node, true));
        let mut inputs: Vec<u32> = nodes_of(&graph.nodes()[node as usize].inputs).collect();
        inputs.sort_by_key(|&input| needs[input as usize]);
        open.extend(inputs.into_iter().map(|input| (input, false)));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [f32; 2] = [0.0, 1.0];

    fn noise(graph: &mut Graph, octaves: u32) -> Operand {
        graph.add(Operation::Fbm, &[Operand::Position], &[octaves, 0])
    }

    #[test]
    fn a_chain_takes_two_registers() {
        let mut graph = Graph::default();
        let mut sum = noise(&mut graph, 0);
        for octaves in 1..100 {
            let next = noise(&mut graph, octaves);
            sum = graph.add(Operation::Add, &[next, sum], &[]);
        }
        let program = schedule(&graph, sum, ALL).unwrap();
        assert_eq!(program.instructions.len(), 199);
        assert!(program.instructions.iter().all(|instruction| instruction.output < 2));
        assert!(program.reads_position());
    }

    #[test]
    fn dead_parts_are_gone() {
        let mut graph = Graph::default();
        let wanted = noise(&mut graph, 1);
        noise(&mut graph, 2);
        assert_eq!(schedule(&graph, wanted, ALL).unwrap().instructions.len(), 1);
        let constant = schedule(&graph, Operand::Uv, ALL).unwrap();
        assert_eq!(constant.instructions[0].operands, [Place::Uv, Place::Constant(Vec3::ONE)]);
    }

    /// Sums of all pairs of `count` values need all of them at the same time.
    fn pairs(count: u32) -> Result<Program, String> {
        let mut graph = Graph::default();
        let values: Vec<Operand> = (0..count).map(|octaves| noise(&mut graph, octaves)).collect();
        let mut sum = Operand::Constant(Vec3::ZERO);
        for step in 1..values.len() {
            for (at, &first) in values.iter().enumerate() {
                let pair = graph.add(Operation::Multiply, &[first, values[(at + step) % values.len()]], &[]);
                sum = graph.add(Operation::Add, &[sum, pair], &[]);
            }
        }
        schedule(&graph, sum, ALL)
    }

    #[test]
    fn what_needs_too_much_is_refused() {
        assert!(pairs(10).is_ok());
        assert!(pairs(17).unwrap_err().contains("operations"));
        let mut graph = Graph::default();
        let values: Vec<Operand> = (0..20).map(|octaves| noise(&mut graph, octaves)).collect();
        let mut rising = values[0];
        let mut falling = values[19];
        for at in 1..20 {
            rising = graph.add(Operation::Add, &[rising, values[at]], &[]);
            falling = graph.add(Operation::Multiply, &[falling, values[19 - at]], &[]);
        }
        let both = graph.add(Operation::Add, &[rising, falling], &[]);
        assert!(schedule(&graph, both, ALL).unwrap_err().contains("more than 16 values"));
    }
}
