//! Counts of a module's instructions, by class and by line of the GLSL.

use std::collections::{BTreeMap, HashMap};

use rspirv::dr::{Instruction, Operand};
use rspirv::grammar::GLSL_STD_450_INSTRUCTION_TABLE;
use rspirv::spirv::{Op, StorageClass};
use serde::Serialize;

use crate::spirv::module::{Module, literal, operand_id};

/// Classes of instructions, by what they do as far as cost is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Load from a storage buffer.
    LoadBuffer,
    /// Load from a uniform buffer or push constants.
    LoadUniform,
    /// Load from a workgroup's shared memory.
    LoadShared,
    /// Load from a variable of the invocation, such as an array that was not turned into values.
    LoadLocal,
    /// Load from a texel buffer.
    TexelFetch,
    /// Store to a storage buffer.
    StoreBuffer,
    /// Store to a workgroup's shared memory.
    StoreShared,
    /// Store to a variable of the invocation.
    StoreLocal,
    /// Atomic read, change and write.
    Atomic,
    /// Barrier of execution or memory.
    Barrier,
    /// Head of a loop.
    Loop,
    /// Conditional jump.
    Branch,
    /// Unconditional jump.
    Jump,
    /// Function call.
    Call,
    /// Sine, exponential, logarithm, power or the inverse of one.
    Transcendental,
    /// Square root, or a length that needs one.
    Root,
    /// Quotient or remainder.
    Division,
    /// Other floating-point arithmetic.
    Float,
    /// Other integer arithmetic.
    Integer,
    /// Shift, mask or other operation on bits.
    Bits,
    /// Comparison or logic.
    Comparison,
    /// Choice between values.
    Select,
    /// Merge of values that come from several blocks.
    Phi,
    /// Conversion between types.
    Conversion,
    /// Making or splitting of composites; often free.
    Composite,
    /// Address of an element within a buffer.
    Address,
    /// Any other instruction.
    Other,
}

/// Number of instructions and of scalars.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Count {
    /// Number of instructions.
    pub instructions: u64,
    /// Number of scalars that the instructions make, store or multiply: 3 for the sum of two `vec3`.
    pub scalars: u64,
}

/// Instructions that come from one line of GLSL.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SourceLine {
    /// Path of the GLSL file.
    pub file: String,
    /// Line number, counted from 1.
    pub line: u32,
    /// Text of the line, where the module has it.
    pub text: String,
    /// Count of all instructions.
    pub total: Count,
    /// Counts by class.
    pub classes: BTreeMap<Class, Count>,
}

/// Instructions of a module.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Histogram {
    /// Count of all instructions.
    pub total: Count,
    /// Counts by class.
    pub classes: BTreeMap<Class, Count>,
    /// Number of instructions by name; extended instructions by their own names.
    pub operations: BTreeMap<String, u64>,
    /// Counts by line of the GLSL, the largest first. Inlined code counts for the line in its own function.
    pub lines: Vec<SourceLine>,
}

impl Class {
    /// Description of the class in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::LoadBuffer => "loads from storage buffers",
            Self::LoadUniform => "loads of uniforms, push blocks",
            Self::LoadShared => "loads from shared memory",
            Self::LoadLocal => "loads of local variables",
            Self::TexelFetch => "texel fetches",
            Self::StoreBuffer => "stores to storage buffers",
            Self::StoreShared => "stores to shared memory",
            Self::StoreLocal => "stores to local variables",
            Self::Atomic => "atomics",
            Self::Barrier => "barriers",
            Self::Loop => "loops",
            Self::Branch => "branches",
            Self::Jump => "jumps",
            Self::Call => "calls",
            Self::Transcendental => "sin, exp, log, pow, ...",
            Self::Root => "square roots, lengths",
            Self::Division => "divisions, remainders",
            Self::Float => "other float arithmetic",
            Self::Integer => "other integer arithmetic",
            Self::Bits => "shifts and masks",
            Self::Comparison => "comparisons, logic",
            Self::Select => "selects",
            Self::Phi => "phis",
            Self::Conversion => "conversions",
            Self::Composite => "making, splitting composites",
            Self::Address => "addresses",
            Self::Other => "others",
        }
    }
}

impl Count {
    fn add(&mut self, scalars: u64) {
        self.instructions += 1;
        self.scalars += scalars;
    }
}

impl Histogram {
    /// Counts every instruction that can cost something, which leaves out declarations, labels, names and lines.
    pub fn of(module: &Module) -> Self {
        let mut counter = Counter::new(module);
        for function in &module.parsed.functions {
            for block in &function.blocks {
                // A line instruction is valid to the end of its block.
                counter.line = None;
                block.instructions.iter().for_each(|instruction| counter.see(instruction));
            }
        }
        counter.finish()
    }

    /// Count of one class.
    pub fn class(&self, class: Class) -> Count {
        self.classes.get(&class).copied().unwrap_or_default()
    }

    /// Counts by GLSL file, the largest first.
    pub fn files(&self) -> Vec<(String, Count)> {
        let mut files = BTreeMap::<&str, Count>::new();
        for line in &self.lines {
            let count = files.entry(&line.file).or_default();
            count.instructions += line.total.instructions;
            count.scalars += line.total.scalars;
        }
        let mut files: Vec<_> = files.into_iter().map(|(file, count)| (file.to_owned(), count)).collect();
        files.sort_by_key(|(_, count)| std::cmp::Reverse(count.instructions));
        files
    }
}

type Line = (u32, u32);

struct Counter<'a> {
    module: &'a Module,
    /// Type ids by result id, for results inside and outside functions.
    types: HashMap<u32, u32>,
    /// Index of the file's name, and the line.
    line: Option<Line>,
    total: Count,
    classes: BTreeMap<Class, Count>,
    operations: BTreeMap<String, u64>,
    lines: BTreeMap<Line, (Count, BTreeMap<Class, Count>)>,
}

impl<'a> Counter<'a> {
    fn new(module: &'a Module) -> Self {
        let typed = |i: &Instruction| Some((i.result_id?, i.result_type?));
        Self {
            module,
            types: module.parsed.all_inst_iter().filter_map(typed).collect(),
            line: None,
            total: Count::default(),
            classes: BTreeMap::new(),
            operations: BTreeMap::new(),
            lines: BTreeMap::new(),
        }
    }

    fn see(&mut self, instruction: &Instruction) {
        match instruction.class.opcode {
            Op::Line => self.line = operand_id(instruction, 0).zip(instruction.operands.get(1).and_then(literal)),
            Op::NoLine => self.line = None,
            _ => self.count(instruction),
        }
    }

    fn count(&mut self, instruction: &Instruction) {
        let extended = extended_name(instruction);
        let Some(class) = self.class(instruction, extended) else { return };
        let scalars = self.scalars(instruction);
        self.total.add(scalars);
        self.classes.entry(class).or_default().add(scalars);
        *self.operations.entry(extended.unwrap_or(instruction.class.opname).into()).or_default() += 1;
        if let Some(line) = self.line {
            let (total, classes) = self.lines.entry(line).or_default();
            total.add(scalars);
            classes.entry(class).or_default().add(scalars);
        }
    }

    fn class(&self, instruction: &Instruction, extended: Option<&str>) -> Option<Class> {
        match instruction.class.opcode {
            Op::Load => self.load_class(instruction),
            Op::Store => Some(self.store_class(instruction)),
            Op::ExtInst => Some(extended.map_or(Class::Other, extended_class)),
            opcode => class_of(opcode, instruction.class.opname),
        }
    }

    fn storage(&self, instruction: &Instruction) -> Option<StorageClass> {
        let pointer = operand_id(instruction, 0)?;
        self.module.storage_class(*self.types.get(&pointer)?)
    }

    /// Class of a load; `None` for the handle of a texel buffer.
    fn load_class(&self, instruction: &Instruction) -> Option<Class> {
        Some(match self.storage(instruction)? {
            StorageClass::UniformConstant => return None,
            StorageClass::StorageBuffer => Class::LoadBuffer,
            StorageClass::Uniform | StorageClass::PushConstant => Class::LoadUniform,
            StorageClass::Workgroup => Class::LoadShared,
            StorageClass::Function | StorageClass::Private => Class::LoadLocal,
            // Built-in inputs, such as the ids of invocation and workgroup.
            _ => Class::Other,
        })
    }

    fn store_class(&self, instruction: &Instruction) -> Class {
        match self.storage(instruction) {
            Some(StorageClass::StorageBuffer) => Class::StoreBuffer,
            Some(StorageClass::Workgroup) => Class::StoreShared,
            _ => Class::StoreLocal,
        }
    }

    fn scalars(&self, instruction: &Instruction) -> u64 {
        let of_operand = |place| operand_id(instruction, place).and_then(|id| self.types.get(&id));
        let ty = match instruction.class.opcode {
            Op::Store => of_operand(1),
            Op::Dot => of_operand(0),
            Op::MatrixTimesVector => of_operand(0),
            Op::VectorTimesMatrix => of_operand(1),
            Op::AccessChain | Op::InBoundsAccessChain => return 1,
            _ => instruction.result_type.as_ref(),
        };
        ty.map_or(0, |&ty| self.module.scalars(ty))
    }

    fn finish(self) -> Histogram {
        let sources = Sources::of(self.module);
        let mut lines: Vec<_> = self
            .lines
            .into_iter()
            .map(|((file, line), (total, classes))| SourceLine {
                file: sources.file(file),
                line,
                text: sources.text(file, line),
                total,
                classes,
            })
            .collect();
        lines.sort_by_key(|line| std::cmp::Reverse(line.total.instructions));
        Histogram { total: self.total, classes: self.classes, operations: self.operations, lines }
    }
}

/// GLSL source text that a module carries.
struct Sources<'a> {
    names: HashMap<u32, &'a str>,
    texts: HashMap<u32, Vec<&'a str>>,
}

impl<'a> Sources<'a> {
    fn of(module: &'a Module) -> Self {
        let (mut names, mut texts) = (HashMap::new(), HashMap::new());
        for instruction in &module.parsed.debug_string_source {
            let string = instruction.operands.iter().find_map(|operand| match operand {
                Operand::LiteralString(text) => Some(text.as_str()),
                _ => None,
            });
            match (instruction.class.opcode, instruction.result_id, operand_id(instruction, 2), string) {
                (Op::String, Some(id), _, Some(name)) => drop(names.insert(id, name)),
                (Op::Source, _, Some(file), Some(text)) => drop(texts.insert(file, text.lines().collect())),
                _ => {}
            }
        }
        Self { names, texts }
    }

    fn file(&self, id: u32) -> String {
        self.names.get(&id).copied().unwrap_or_default().into()
    }

    fn text(&self, id: u32, line: u32) -> String {
        let lines = self.texts.get(&id);
        let text = lines.and_then(|lines| lines.get((line as usize).checked_sub(1)?));
        text.map(|text| text.trim().to_owned()).unwrap_or_default()
    }
}

/// Name of an instruction of GLSL.std.450, the only extended set that kernels use.
fn extended_name(instruction: &Instruction) -> Option<&'static str> {
    if instruction.class.opcode != Op::ExtInst {
        return None;
    }
    match instruction.operands.get(1) {
        Some(&Operand::LiteralExtInstInteger(number)) => {
            GLSL_STD_450_INSTRUCTION_TABLE.lookup_opcode(number).map(|entry| entry.opname)
        }
        _ => None,
    }
}

fn extended_class(name: &str) -> Class {
    match name {
        "Sqrt" | "InverseSqrt" | "Length" | "Distance" | "Normalize" => Class::Root,
        "Sin" | "Cos" | "Tan" | "Asin" | "Acos" | "Atan" | "Sinh" | "Cosh" | "Tanh" | "Asinh" | "Acosh" | "Atanh"
        | "Atan2" | "Pow" | "Exp" | "Log" | "Exp2" | "Log2" => Class::Transcendental,
        "SAbs" | "SSign" | "UMin" | "SMin" | "UMax" | "SMax" | "UClamp" | "SClamp" => Class::Integer,
        "FindILsb" | "FindSMsb" | "FindUMsb" => Class::Bits,
        _ if name.contains("pack") || name.contains("Pack") => Class::Conversion,
        _ => Class::Float,
    }
}

/// Class of an instruction; `None` for one without a cost, such as a declaration, label or merge.
fn class_of(opcode: Op, name: &str) -> Option<Class> {
    use Op::*;
    Some(match opcode {
        Variable | Label | SelectionMerge | Image | SampledImage | Nop | Undef | Return | ReturnValue | Unreachable
        | Kill => return None,
        LoopMerge => Class::Loop,
        BranchConditional | Switch => Class::Branch,
        Branch => Class::Jump,
        FunctionCall => Class::Call,
        ControlBarrier | MemoryBarrier => Class::Barrier,
        Op::Phi => Class::Phi,
        Op::Select => Class::Select,
        FDiv | FMod | FRem | SDiv | UDiv | SMod | UMod | SRem => Class::Division,
        FAdd | FSub | FMul | FNegate | Dot | VectorTimesScalar | MatrixTimesVector | VectorTimesMatrix
        | MatrixTimesMatrix | MatrixTimesScalar | OuterProduct => Class::Float,
        IAdd | ISub | IMul | SNegate | IAddCarry | ISubBorrow | UMulExtended | SMulExtended => Class::Integer,
        AccessChain | InBoundsAccessChain | ArrayLength => Class::Address,
        CompositeExtract | CompositeInsert | CompositeConstruct | VectorShuffle | VectorExtractDynamic
        | VectorInsertDynamic | CopyObject | CopyLogical | Transpose => Class::Composite,
        Bitcast => Class::Conversion,
        ImageRead | ImageFetch => Class::TexelFetch,
        _ if name.starts_with("Atomic") => Class::Atomic,
        _ if name.starts_with("Convert") || name.ends_with("Convert") => Class::Conversion,
        _ if name.starts_with("Bit") || name.starts_with("Shift") || opcode == Not => Class::Bits,
        _ if is_comparison(name) => Class::Comparison,
        _ => Class::Other,
    })
}

fn is_comparison(name: &str) -> bool {
    let begins = ["FOrd", "FUnord", "Logical", "IsNan", "IsInf"].iter().any(|begin| name.starts_with(begin));
    let ends = ["Equal", "LessThan", "GreaterThan"].iter().any(|end| name.ends_with(end));
    begins || ends || name == "Any" || name == "All"
}
