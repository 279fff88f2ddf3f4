//! Vulkan compute: devices, buffers, descriptor sets, kernels, submissions. This module knows nothing of rendering.
//!
//! Only this module names `ash`, and only it and `denoise/library.rs` contain `unsafe`. Every public function here is safe to call. Three invariants make
//! it so, and every `// SAFETY:` comment cites the ones that it rests on.
//!
//! 1. **One owner per handle.** Each Vulkan handle is created by, stored in and destroyed by exactly one value whose
//!    type is neither `Copy` nor `Clone`, and whose fields are private to this module. So a handle reached through a
//!    reference is alive, was made by the device that the value holds, and is destroyed once. Handles that are passed
//!    to a call for its duration (a shader module, a staging buffer) are owned by a local of the caller. Pointers
//!    handed to Vulkan point into locals that outlive the call. Vulkan keeps only one of them: the message log, which
//!    is owned by the instance and freed after it. Data that Vulkan hands to that log is valid for the duration of the
//!    callback, and is read only then.
//! 2. **Children hold their parents.** Every value with a handle holds an `Arc` of the context that made it, or of the
//!    logical device, which holds the instance, which holds the loaded library. (The library that the system calls the
//!    Vulkan loader is trusted to be one.) Rust drops a value's fields after its `Drop` has run, in order of
//!    declaration, so children are always destroyed first. A descriptor set holds its buffers. An acceleration
//!    structure holds the structures whose addresses it contains. Values of two contexts are never mixed: each function that takes several asserts that they have one context. Command buffers, fences and
//!    queries are reused by later submissions. While idle they belong to the context's `IdleSlots`, which holds the
//!    device. They are reset before their next use, and destroyed after a failure. A pipeline is owned by a `Pipeline`,
//!    which kernels and the context's `Pipelines` share. It does not need the layout that it was built with.
//! 3. **`submit` waits.** A command buffer is recorded, submitted and waited for inside one call of
//!    [`Context::submit`]. Everything it uses is borrowed for a lifetime that the caller chose, hence for longer than
//!    that call, so nothing in use can drop or move. The queue's lock is held from submission to completion, and by
//!    every access of the host to mapped memory, so host and device never touch a buffer at once. If a submission
//!    cannot be waited for although the device lives, the process is ended.
//!
//! The invariants cover the host's calls. Two guards cover what a kernel does. First, its SPIR-V is either the
//! compiler's output ([`KernelSource`] is written by `build.rs`) or a file that the user has asked for by name,
//! validated and of the built-in kernel's interface ([`crate::spirv::replace`]). Second, devices are opened with robust
//! buffer access, so an index out of range reaches no memory outside the buffer. Robust access does not cover acceleration structures. So
//! only their builder writes to them.

#![deny(clippy::undocumented_unsafe_blocks)]

mod backing;
mod buffer;
mod commands;
mod context;
mod debug;
mod device;
mod device_info;
mod diagnosis;
mod executables;
mod fault;
mod fault_injection;
mod idle_slots;
mod instance;
mod kernel;
mod layout;
mod limits;
mod memory;
mod needs;
mod pipeline_cache;
mod pipelines;
mod queries;
mod ray_queries;
mod selection;
mod sets;
mod slot;
mod structure;
mod structure_builder;
mod submission;
mod survey;
mod timing;

pub use buffer::{Buffer, BufferKind};
pub use commands::Recorder;
pub use context::{Context, ContextOptions, list_devices};
pub use debug::ValidationLog;
pub use device_info::{DeviceInfo, DeviceKind};
pub use executables::{Executable, PipelineReport, Representation, Statistic, StatisticValue};
pub use kernel::Kernel;
pub use limits::Limits;
pub use sets::DescriptorSet;
pub use structure_builder::StructurePart;
pub use submission::Submission;
pub use survey::{Survey, survey};
pub use timing::{Clock, DispatchTime, SubmissionTime};

pub use crate::generated::interface::{BindingKind, BindingShape, KernelSource, SetShape};
