//! Vulkan compute, and nothing of rendering: devices, buffers, descriptor sets, kernels, submissions.
//!
//! The only module with `unsafe` and the only one that names `ash`. Everything public here is safe to call; what makes it
//! so are three invariants, and every `// SAFETY:` comment cites the one it leans on.
//!
//! 1. **One owner per handle.** Each Vulkan handle is created by, stored in and destroyed by exactly one value whose type
//!    is neither `Copy` nor `Clone`, and whose fields are private to this module. So a handle reached through a reference
//!    is alive, was made by the device that the value holds, and is destroyed once. Handles that are passed to a call for
//!    its duration (a shader module, a staging buffer) are owned by a local of the caller. Pointers handed to Vulkan point
//!    into locals that outlive the call; Vulkan keeps none of them (the message log, which it does keep, is owned by the
//!    instance and freed after it). Likewise what Vulkan hands to that log is valid for that call, and only then is it read.
//! 2. **Children hold their parents.** Every value with a handle holds an `Arc` of the context that made it (or of the
//!    logical device, which holds the instance, which holds the loaded library: the system's Vulkan loader, which we trust
//!    to be one). Rust drops a value's fields after its `Drop` has run and in order of declaration, so children are always
//!    destroyed first. A descriptor set holds its buffers. Values of two contexts are never mixed: each meeting point
//!    asserts that both have the same. What a submission needs of the driver goes from one to the next: while idle it belongs to
//!    the context's `IdleSlots`, which holds the device; it is reset before its next use, and destroyed after a failure.
//! 3. **`submit` waits.** A command buffer is recorded, submitted and waited for inside one call of
//!    [`Context::submit`]. What it uses is borrowed for a lifetime that the caller chose, hence for longer than that call,
//!    so nothing in use can drop or move. The queue's lock is held from submission to completion, and by every access of
//!    the host to mapped memory, so host and device never touch a buffer at once. A submission that cannot be waited for,
//!    though the device lives, ends the process.
//!
//! The three argue about the host's calls. What a kernel does is its own affair, with two guards: its SPIR-V is the
//! compiler's output ([`KernelSource`] is written by `build.rs`), or a user's who has asked for it by name and whose driver
//! it is, of the same interface and validated ([`crate::spirv::replace`]); and devices are opened with robust buffer
//! access, so an index out of range reaches no memory outside the buffer's.

#![deny(clippy::undocumented_unsafe_blocks)]

mod backing;
mod buffer;
mod commands;
mod context;
mod debug;
mod device;
mod device_info;
mod executables;
mod fault;
mod fault_injection;
mod instance;
mod interface;
mod kernel;
mod layout;
mod memory;
mod needs;
mod pipeline_cache;
mod queries;
mod selection;
mod sets;
mod slots;
mod submission;
mod timing;

pub use buffer::{Buffer, BufferKind};
pub use commands::Recorder;
pub use context::{Context, ContextOptions, list_devices};
pub use debug::ValidationLog;
pub use device_info::{DeviceInfo, DeviceKind, Limits};
pub use executables::{Executable, PipelineReport, Representation, Statistic, StatisticValue};
pub use interface::{BindingKind, BindingShape, KernelSource, SetShape};
pub use kernel::Kernel;
pub use sets::DescriptorSet;
pub use submission::Submission;
pub use timing::{Clock, DispatchTime, SubmissionTime};
