//! Tests of the `gpu` module on any device, always under the validation layer.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::process::Command;
use std::sync::Arc;
use std::{env, thread};

use lodestar::gpu::{
    BindingKind, BindingShape, Buffer, BufferKind, Clock, Context, ContextOptions, DescriptorSet, Kernel, KernelSource,
    SetShape, StructurePart, list_devices,
};

/// Runs a test and fails it for any message of the validation layer, including messages about leaks.
fn validated(test: impl FnOnce(&Arc<Context>)) {
    assert_eq!(messages_of(test), [""; 0]);
}

fn messages_of(test: impl FnOnce(&Arc<Context>)) -> Vec<String> {
    let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
    let log = context.validation_log();
    test(&context);
    assert_eq!(Arc::strong_count(&context), 1, "the test keeps nothing alive");
    assert_eq!(context.allocated_bytes(), 0);
    drop(context);
    log.messages()
}

fn storage(context: &Arc<Context>, name: &str, values: &[u32]) -> Arc<Buffer> {
    let bytes = size_of_val(values) as u64;
    let buffer = Buffer::new(context, name, bytes, BufferKind::Storage).expect("a buffer");
    buffer.upload(0, values).expect("an upload");
    buffer
}

fn refusal(device: &str) -> String {
    let options = ContextOptions { device: Some(device.into()), validate: true };
    Context::new(&options).map(|_| ()).expect_err("a refusal").to_string()
}

#[test]
fn devices_are_listed_and_taken_by_index_and_name() {
    let devices = list_devices().expect("devices");
    let usable = devices.iter().find(|device| device.refused.is_none()).expect("a usable device");
    for wanted in [usable.index.to_string(), usable.name.to_uppercase()] {
        let options = ContextOptions { device: Some(wanted), validate: true };
        let context = Context::new(&options).expect("that device");
        assert_eq!(context.device().name, usable.name);
        assert_eq!(context.validation_messages(), [""; 0]);
    }
    let json = serde_json::to_value(usable).expect("JSON");
    assert_eq!(json["pipeline_cache_uuid"].as_str().map(str::len), Some(32));
    assert!(json["limits"]["max_storage_buffer_bytes"].as_u64() >= Some(128 << 20));
    assert!(usable.limits.subgroup_size >= 1 && usable.limits.device_local_bytes > 0);
}

#[test]
fn an_unknown_device_is_a_sentence_that_lists_the_known() {
    for unknown in ["no such device", "4096"] {
        let sentence = refusal(unknown);
        assert!(sentence.starts_with(&format!("no Vulkan device is called `{unknown}`; there ")), "{sentence}");
        assert!(sentence.contains("0: "), "{sentence}");
    }
}

/// Runs a test of this file in a process of its own, because the environment belongs to the process.
fn rerun(test: &str, variable: &str, value: impl AsRef<OsStr>) -> String {
    let this = env::current_exe().expect("this program");
    let mut command = Command::new(this);
    command.args(["--exact", test, "--nocapture", "--ignored"]).env(variable, value);
    let output = command.env_remove("VK_ICD_FILENAMES").output().expect("a run");
    assert!(output.status.success());
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
#[ignore = "run by the tests below in a broken environment"]
fn print_why_there_is_no_context() {
    match Context::new(&ContextOptions { device: None, validate: true }) {
        Ok(_) => println!("there is one"),
        Err(error) => println!("{error}"),
    }
}

#[test]
fn a_missing_driver_is_a_sentence() {
    let output = rerun("print_why_there_is_no_context", "VK_DRIVER_FILES", "/nonexistent");
    assert!(output.contains("no Vulkan driver found: install"), "{output}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_missing_loader_is_a_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("libvulkan.so.1"), "no library").expect("a file");
    let output = rerun("print_why_there_is_no_context", "LD_LIBRARY_PATH", folder.path());
    assert!(output.contains("no Vulkan loader found: install it"), "{output}");
}

#[test]
fn a_missing_validation_layer_is_a_sentence() {
    let output = rerun("print_why_there_is_no_context", "VK_LAYER_PATH", "/nonexistent");
    assert!(output.contains("the validation layer VK_LAYER_KHRONOS_validation is not installed"), "{output}");
}

#[test]
fn buffers_begin_as_zeros_and_give_back_what_they_got() {
    validated(|context| {
        for kind in [BufferKind::Storage, BufferKind::TexelFloat, BufferKind::TexelUint, BufferKind::TexelUint1] {
            for (asked, rounded) in [(0, 16), (1, 16), (16, 16), (17, 32), (1_000_003, 1_000_016)] {
                let buffer = Buffer::new(context, "round trip", asked, kind).expect("a buffer");
                assert_eq!((buffer.len_bytes(), buffer.kind()), (rounded, kind));
                assert!(buffer.read::<u8>(0, rounded as usize).expect("a read").iter().all(|&byte| byte == 0));
                let values: Vec<u8> = (0..asked).map(|i| (i % 253) as u8).collect();
                buffer.upload(rounded - asked, &values).expect("an upload");
                assert!(buffer.read::<u8>(rounded - asked, asked as usize).expect("a read") == values);
            }
        }
    });
}

#[test]
fn bytes_are_counted() {
    validated(|context| {
        let a = Buffer::new(context, "a", 1 << 20, BufferKind::Storage).expect("a buffer");
        let b = Buffer::new(context, "b", 1 << 21, BufferKind::Storage).expect("a buffer");
        assert!(context.allocated_bytes() >= 3 << 20);
        drop(a);
        assert!((2 << 20..3 << 20).contains(&context.allocated_bytes()));
        drop(b);
        assert!((3 << 20..4 << 20).contains(&context.peak_allocated_bytes()));
    });
}

#[test]
fn a_buffer_too_large_is_a_sentence() {
    validated(|context| {
        let limits = context.device().limits;
        let sizes = [
            (BufferKind::Storage, limits.max_storage_buffer_bytes + 1, "storage buffer"),
            (BufferKind::TexelUint, limits.max_texel_elements * 16 + 1, ""),
            (BufferKind::TexelUint1, limits.max_texel_elements * 4 + 1, ""),
            (BufferKind::Storage, u64::MAX, "storage buffer"),
        ];
        for (kind, bytes, what) in sizes {
            let sentence = Buffer::new(context, "heap", bytes, kind).map(|_| ()).expect_err("a refusal").to_string();
            assert!(sentence.starts_with("the buffer `heap` needs ") && sentence.contains(what), "{sentence}");
        }
    });
}

#[test]
#[should_panic(expected = "8 bytes at 12 are outside a buffer of 16")]
fn an_upload_past_the_end_panics() {
    validated(|context| {
        let buffer = Buffer::new(context, "short", 16, BufferKind::Storage).expect("a buffer");
        buffer.upload(12, &[1_u32, 2]).expect("never");
    });
}

#[test]
fn fills_and_copies_follow_each_other_in_order() {
    validated(|context| {
        let (a, b) = (storage(context, "a", &[1, 2, 3, 4, 5, 6, 7, 8]), storage(context, "b", &[9; 8]));
        let done = context.submit("copies", |recorder| {
            recorder.copy(&a, 4, &b, 8, 12);
            recorder.barrier();
            recorder.fill_zero(&a);
            recorder.barrier();
            recorder.copy(&b, 8, &a, 0, 8);
        });
        let done = done.expect("a submission");
        assert!(done.device.is_none_or(|device| device <= done.wall * 2), "{done:?}");
        assert_eq!(b.read::<u32>(0, 8).expect("a read"), [9, 9, 2, 3, 4, 9, 9, 9]);
        assert_eq!(a.read::<u32>(0, 8).expect("a read"), [2, 3, 0, 0, 0, 0, 0, 0]);
    });
}

const NO_BINDINGS: SetShape = SetShape { set: 0, bindings: &[] };

const VALUES: SetShape =
    SetShape { set: 0, bindings: &[BindingShape { binding: 0, kind: BindingKind::StorageBuffer, name: "values" }] };

const TEXELS: SetShape = SetShape {
    set: 1,
    bindings: &[
        BindingShape { binding: 2, kind: BindingKind::TexelBufferUint, name: "words" },
        BindingShape { binding: 5, kind: BindingKind::TexelBufferFloat, name: "floats" },
    ],
};

const SUMS: SetShape =
    SetShape { set: 2, bindings: &[BindingShape { binding: 1, kind: BindingKind::StorageBuffer, name: "sums" }] };

fn fill_source() -> KernelSource {
    KernelSource {
        name: "fill",
        file: "fill.spv",
        spirv: Cow::Borrowed(bytemuck::cast_slice(&FILL_SPIRV)),
        sets: &[VALUES],
        push_constant_bytes: 8,
        specialization_ids: &[3],
    }
}

fn texel_source() -> KernelSource {
    KernelSource {
        name: "texel",
        file: "texel.spv",
        spirv: Cow::Borrowed(bytemuck::cast_slice(&TEXEL_SPIRV)),
        sets: &[NO_BINDINGS, TEXELS, SUMS],
        push_constant_bytes: 0,
        specialization_ids: &[],
    }
}

#[test]
fn dispatches_are_timed_where_asked() {
    validated(|context| {
        let values = storage(context, "values", &[1000; 200]);
        let set = DescriptorSet::new(context, "values", &VALUES, &[&values]).expect("a set");
        let kernel = Kernel::new(context, &fill_source(), &[]).expect("a kernel");
        let dispatch = || {
            let done = context.submit("many kernels", |recorder| {
                for _ in 0..40 {
                    recorder.dispatch(&kernel, &[&set], bytemuck::bytes_of(&[150_u32, 7]), [3, 1, 1]);
                    recorder.barrier();
                }
            });
            done.expect("a submission");
        };
        dispatch();
        assert!(context.take_timings().is_empty(), "nobody has asked yet");
        let clock = context.record_timings();
        dispatch();
        let timings = context.take_timings();
        assert_eq!((timings.len(), timings[0].dispatches.len()), (1, 40));
        let spans: Vec<_> = timings[0].dispatches.iter().filter_map(|dispatch| dispatch.span).collect();
        assert_eq!(spans.len(), if clock == Clock::Device { 32 } else { 0 }, "the first dispatches have queries");
        assert!(spans.iter().all(|(from, to)| from <= to) && spans.windows(2).all(|pair| pair[0].1 <= pair[1].0));
        assert_eq!(context.record_timings_by(Clock::Host), Clock::Host);
        dispatch();
        let timings = context.take_timings();
        assert!(
            timings[0].dispatches.iter().all(|d| d.kernel == "fill" && d.workgroups == [3, 1, 1] && d.span.is_none())
        );
        assert!(context.take_timings().is_empty());
    });
}

#[test]
fn kernels_see_specialization_and_push_constants() {
    validated(|context| {
        let values = storage(context, "values", &[1000; 200]);
        let set = DescriptorSet::new(context, "values", &VALUES, &[&values]).expect("a set");
        // Id 7 belongs to another kernel, and 3 comes after it.
        let times_five = Kernel::new(context, &fill_source(), &[(7, 99), (3, 5)]).expect("a kernel");
        let times_one = Kernel::new(context, &fill_source(), &[]).expect("a kernel");
        let push = [150_u32, 7];
        let done = context.submit("two kernels", |recorder| {
            recorder.dispatch(&times_five, &[&set], bytemuck::bytes_of(&push), [3, 1, 1]);
            recorder.barrier();
            recorder.dispatch(&times_one, &[&set], bytemuck::bytes_of(&push), [3, 1, 1]);
        });
        done.expect("a submission");
        let expected: Vec<u32> = (0..200).map(|i| if i < 150 { 1000 + 6 * i + 14 } else { 1000 }).collect();
        assert_eq!(values.read::<u32>(0, 200).expect("a read"), expected);
    });
}

#[test]
fn kernels_read_texels_past_an_empty_set() {
    validated(|context| {
        let words = Buffer::new(context, "words", 64 * 16, BufferKind::TexelUint).expect("a buffer");
        let floats = Buffer::new(context, "floats", 64 * 16, BufferKind::TexelFloat).expect("a buffer");
        let sums = storage(context, "sums", &[0; 64]);
        words.upload(0, &(0..64).map(|i| [i, 1000, 1000, 100]).collect::<Vec<[u32; 4]>>()).expect("an upload");
        floats.upload(0, &(0..64).map(|i| [9.0, i as f32, 0.25, 9.0]).collect::<Vec<[f32; 4]>>()).expect("an upload");
        let kernel = Kernel::new(context, &texel_source(), &[]).expect("a kernel");
        let empty = DescriptorSet::new(context, "nothing", &NO_BINDINGS, &[]).expect("a set");
        let texels = DescriptorSet::new(context, "texels", &TEXELS, &[&words, &floats]).expect("a set");
        let results = DescriptorSet::new(context, "sums", &SUMS, &[&sums]).expect("a set");
        drop((words, floats));
        let done = context.submit("texels", |recorder| {
            recorder.dispatch(&kernel, &[&empty, &texels, &results], &[], [1, 1, 1]);
        });
        done.expect("a submission");
        let expected: Vec<f32> = (0..64).map(|i| 100.25 + 2.0 * i as f32).collect();
        assert_eq!(sums.read::<f32>(0, 64).expect("a read"), expected);
    });
}

/// The twin that must fail: a missing barrier is reported, so the other tests would notice one. (The layer does not
/// report two dispatches that both write, because they may write to different places.)
#[test]
fn a_missing_barrier_is_reported_with_the_names_of_the_objects() {
    let messages = messages_of(|context| {
        let values = storage(context, "values", &[0; 64]);
        let set = DescriptorSet::new(context, "values of the test", &VALUES, &[&values]).expect("a set");
        let kernel = Kernel::new(context, &fill_source(), &[]).expect("a kernel");
        let push = [64_u32, 0];
        let done = context.submit("a race", |recorder| {
            recorder.fill_zero(&values);
            recorder.dispatch(&kernel, &[&set], bytemuck::bytes_of(&push), [1, 1, 1]);
        });
        done.expect("a submission");
    });
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD") && m.contains("values of the test")), "{messages:?}");
}

/// Acceleration structures are built where the device has ray queries, also of nothing and of one part, and refused elsewhere.
#[test]
fn acceleration_structures_need_ray_queries() {
    let triangle = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    let parts = [
        StructurePart::OpaqueTriangles(&triangle),
        StructurePart::Triangles(&[]),
        StructurePart::Boxes(&[[[0.0; 3], [1.0; 3]]]),
    ];
    validated(|context| {
        for parts in [&parts[..], &parts[1..2], &[]] {
            let built = Buffer::acceleration_structure(context, "test", parts).map(|buffer| buffer.len_bytes());
            match context.device().limits.has_ray_queries {
                true => assert!(built.expect("a structure") > 0),
                false => assert!(built.expect_err("a refusal").to_string().contains("has no ray queries")),
            }
        }
    });
}

#[test]
#[should_panic(expected = "is made with an acceleration structure only")]
fn a_buffer_of_the_kind_of_structures_panics() {
    let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
    let _ = Buffer::new(&context, "test", 64, BufferKind::AccelerationStructure);
}

/// An acceleration structure holds addresses that the device follows, so nothing else may write there.
#[test]
fn nothing_writes_to_a_structure() {
    let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
    let Ok(structure) = Buffer::acceleration_structure(&context, "test", &[]) else {
        println!("skipped: {} has no ray queries", context.device().name);
        return;
    };
    let upload = std::panic::AssertUnwindSafe(|| structure.upload(0, &[1_u32]));
    assert!(std::panic::catch_unwind(upload).is_err());
}

#[test]
fn threads_share_a_context() {
    validated(|context| {
        let kernel = Kernel::new(context, &fill_source(), &[(3, 1)]).expect("a kernel");
        let shared = storage(context, "shared", &[0; 64]);
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let set = DescriptorSet::new(context, "shared", &VALUES, &[&shared]).expect("a set");
                    for _ in 0..25 {
                        let push = [64_u32, 1];
                        let done = context.submit("a thread's", |recorder| {
                            recorder.dispatch(&kernel, &[&set], bytemuck::bytes_of(&push), [1, 1, 1]);
                        });
                        done.expect("a submission");
                        shared.read::<u32>(0, 64).expect("a read");
                    }
                });
            }
        });
        let expected: Vec<u32> = (0..64).map(|i| 100 * (i + 1)).collect();
        assert_eq!(shared.read::<u32>(0, 64).expect("a read"), expected);
    });
}

#[test]
#[should_panic(expected = "`set.words` is TexelBufferUint, but `floats` is TexelFloat")]
fn a_buffer_of_the_wrong_kind_panics() {
    validated(|context| {
        let floats = Buffer::new(context, "floats", 16, BufferKind::TexelFloat).expect("a buffer");
        let _ = DescriptorSet::new(context, "set", &TEXELS, &[&floats, &floats]);
    });
}

#[test]
#[should_panic(expected = "the set `set` has 2 bindings, but 0 buffers were given")]
fn a_missing_buffer_panics() {
    validated(|context| drop(DescriptorSet::new(context, "set", &TEXELS, &[])));
}

fn dispatch(sets: impl FnOnce(&Arc<Context>) -> Vec<DescriptorSet>, push: &[u8], groups: [u32; 3]) {
    validated(|context| {
        let kernel = Kernel::new(context, &fill_source(), &[]).expect("a kernel");
        let sets = sets(context);
        let sets: Vec<_> = sets.iter().collect();
        context.submit("a mistake", |recorder| recorder.dispatch(&kernel, &sets, push, groups)).expect("never");
    });
}

fn values_set(context: &Arc<Context>) -> Vec<DescriptorSet> {
    vec![DescriptorSet::new(context, "values", &VALUES, &[&storage(context, "values", &[0; 4])]).expect("a set")]
}

#[test]
#[should_panic(expected = "`fill` takes 8 bytes of push constants, not 4")]
fn push_constants_of_the_wrong_size_panic() {
    dispatch(values_set, &[0; 4], [1, 1, 1]);
}

#[test]
#[should_panic(expected = "the kernel `fill` needs set 0, but 0 were given")]
fn a_missing_set_panics() {
    dispatch(|_| Vec::new(), &[0; 8], [1, 1, 1]);
}

#[test]
#[should_panic(expected = "set 0 does not fit the kernel `fill`")]
fn a_set_of_another_shape_panics() {
    let empty = |context: &_| vec![DescriptorSet::new(context, "nothing", &NO_BINDINGS, &[]).expect("a set")];
    dispatch(empty, &[0; 8], [1, 1, 1]);
}

#[test]
#[should_panic(expected = "workgroups of `fill` are more than the device's")]
fn more_groups_than_the_device_allows_panic() {
    let most = list_devices().expect("devices").iter().map(|device| device.limits.max_workgroup_count[1]).max();
    // A device without a limit has nothing to test. The panic stands for the expected one.
    let more = most.and_then(|most| most.checked_add(1)).expect("workgroups of `fill` are more than the device's");
    dispatch(values_set, &[0; 8], [1, more, 1]);
}

#[test]
#[should_panic(expected = "`stranger` belongs to another context")]
fn two_contexts_do_not_mix() {
    validated(|context| {
        let other = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
        let stranger = storage(&other, "stranger", &[0]);
        context.submit("a mix", |recorder| recorder.fill_zero(&stranger)).expect("never");
    });
}

#[test]
fn what_is_not_spirv_is_an_error() {
    let context = Context::new(&ContextOptions { device: None, validate: true }).expect("a device");
    let source = KernelSource { spirv: Cow::Borrowed(&[1, 2, 3, 4, 5, 6, 7, 8]), ..fill_source() };
    let sentence = Kernel::new(&context, &source, &[]).map(|_| ()).expect_err("a refusal").to_string();
    assert!(sentence.starts_with("loading the kernel `fill` failed: "), "{sentence}");
}

// The two kernels, compiled with `glslangValidator --target-env vulkan1.2 -V` and `spirv-opt -O`.
//
// fill.comp:
//     #version 460
//     layout(local_size_x = 64) in;
//     layout(constant_id = 3) const uint factor = 1;
//     layout(set = 0, binding = 0) buffer Values { uint values[]; };
//     layout(push_constant) uniform Push { uint count; uint offset; };
//     void main() {
//         uint i = gl_GlobalInvocationID.x;
//         if (i < count) values[i] += factor * i + offset;
//     }
//
// texel.comp:
//     #version 460
//     layout(local_size_x = 64) in;
//     layout(set = 1, binding = 2) uniform usamplerBuffer words;
//     layout(set = 1, binding = 5) uniform samplerBuffer floats;
//     layout(set = 2, binding = 1) writeonly buffer Sums { float sums[]; };
//     void main() {
//         int i = int(gl_GlobalInvocationID.x);
//         uvec4 w = texelFetch(words, i);
//         vec4 f = texelFetch(floats, i);
//         sums[i] = float(w.x + w.w) + f.y + f.z;
//     }
#[rustfmt::skip]
static FILL_SPIRV: [u32; 252] = [
    0x7230203, 0x10500, 0x8000b, 0x31, 0x0, 0x20011, 0x1, 0x6000b, 0x1, 0x4c534c47, 0x6474732e, 0x3035342e, 0x0,
    0x3000e, 0x0, 0x1, 0x8000f, 0x5, 0x4, 0x6e69616d, 0x0, 0xb, 0x13, 0x20, 0x60010, 0x4, 0x11, 0x40, 0x1, 0x1,
    0x40047, 0xb, 0xb, 0x1c, 0x50048, 0x11, 0x0, 0x23, 0x0, 0x50048, 0x11, 0x1, 0x23, 0x4, 0x30047, 0x11, 0x2,
    0x40047, 0x1d, 0x6, 0x4, 0x50048, 0x1e, 0x0, 0x23, 0x0, 0x30047, 0x1e, 0x2, 0x40047, 0x20, 0x22, 0x0, 0x40047,
    0x20, 0x21, 0x0, 0x40047, 0x22, 0x1, 0x3, 0x40047, 0x30, 0xb, 0x19, 0x20013, 0x2, 0x30021, 0x3, 0x2, 0x40015, 0x6,
    0x20, 0x0, 0x40017, 0x9, 0x6, 0x3, 0x40020, 0xa, 0x1, 0x9, 0x4003b, 0xa, 0xb, 0x1, 0x4002b, 0x6, 0xc, 0x0,
    0x40020, 0xd, 0x1, 0x6, 0x4001e, 0x11, 0x6, 0x6, 0x40020, 0x12, 0x9, 0x11, 0x4003b, 0x12, 0x13, 0x9, 0x40015,
    0x14, 0x20, 0x1, 0x4002b, 0x14, 0x15, 0x0, 0x40020, 0x16, 0x9, 0x6, 0x20014, 0x19, 0x3001d, 0x1d, 0x6, 0x3001e,
    0x1e, 0x1d, 0x40020, 0x1f, 0xc, 0x1e, 0x4003b, 0x1f, 0x20, 0xc, 0x40032, 0x6, 0x22, 0x1, 0x4002b, 0x14, 0x25, 0x1,
    0x40020, 0x29, 0xc, 0x6, 0x4002b, 0x6, 0x2e, 0x40, 0x4002b, 0x6, 0x2f, 0x1, 0x6002c, 0x9, 0x30, 0x2e, 0x2f, 0x2f,
    0x50036, 0x2, 0x4, 0x0, 0x3, 0x200f8, 0x5, 0x50041, 0xd, 0xe, 0xb, 0xc, 0x4003d, 0x6, 0xf, 0xe, 0x50041, 0x16,
    0x17, 0x13, 0x15, 0x4003d, 0x6, 0x18, 0x17, 0x500b0, 0x19, 0x1a, 0xf, 0x18, 0x300f7, 0x1c, 0x0, 0x400fa, 0x1a,
    0x1b, 0x1c, 0x200f8, 0x1b, 0x50084, 0x6, 0x24, 0x22, 0xf, 0x50041, 0x16, 0x26, 0x13, 0x25, 0x4003d, 0x6, 0x27,
    0x26, 0x50080, 0x6, 0x28, 0x24, 0x27, 0x60041, 0x29, 0x2a, 0x20, 0x15, 0xf, 0x4003d, 0x6, 0x2b, 0x2a, 0x50080,
    0x6, 0x2c, 0x2b, 0x28, 0x3003e, 0x2a, 0x2c, 0x200f9, 0x1c, 0x200f8, 0x1c, 0x100fd, 0x10038,
];

#[rustfmt::skip]
static TEXEL_SPIRV: [u32; 298] = [
    0x7230203, 0x10500, 0x8000b, 0x44, 0x0, 0x20011, 0x1, 0x20011, 0x2e, 0x6000b, 0x1, 0x4c534c47, 0x6474732e,
    0x3035342e, 0x0, 0x3000e, 0x0, 0x1, 0x9000f, 0x5, 0x4, 0x6e69616d, 0x0, 0xc, 0x18, 0x24, 0x2c, 0x60010, 0x4, 0x11,
    0x40, 0x1, 0x1, 0x40047, 0xc, 0xb, 0x1c, 0x40047, 0x18, 0x22, 0x1, 0x40047, 0x18, 0x21, 0x2, 0x40047, 0x24, 0x22,
    0x1, 0x40047, 0x24, 0x21, 0x5, 0x40047, 0x29, 0x6, 0x4, 0x40048, 0x2a, 0x0, 0x19, 0x50048, 0x2a, 0x0, 0x23, 0x0,
    0x30047, 0x2a, 0x2, 0x40047, 0x2c, 0x22, 0x2, 0x40047, 0x2c, 0x21, 0x1, 0x40047, 0x43, 0xb, 0x19, 0x20013, 0x2,
    0x30021, 0x3, 0x2, 0x40015, 0x6, 0x20, 0x1, 0x40015, 0x9, 0x20, 0x0, 0x40017, 0xa, 0x9, 0x3, 0x40020, 0xb, 0x1,
    0xa, 0x4003b, 0xb, 0xc, 0x1, 0x4002b, 0x9, 0xd, 0x0, 0x40020, 0xe, 0x1, 0x9, 0x40017, 0x12, 0x9, 0x4, 0x90019,
    0x15, 0x9, 0x5, 0x0, 0x0, 0x0, 0x1, 0x0, 0x3001b, 0x16, 0x15, 0x40020, 0x17, 0x0, 0x16, 0x4003b, 0x17, 0x18, 0x0,
    0x30016, 0x1d, 0x20, 0x40017, 0x1e, 0x1d, 0x4, 0x90019, 0x21, 0x1d, 0x5, 0x0, 0x0, 0x0, 0x1, 0x0, 0x3001b, 0x22,
    0x21, 0x40020, 0x23, 0x0, 0x22, 0x4003b, 0x23, 0x24, 0x0, 0x3001d, 0x29, 0x1d, 0x3001e, 0x2a, 0x29, 0x40020, 0x2b,
    0xc, 0x2a, 0x4003b, 0x2b, 0x2c, 0xc, 0x4002b, 0x6, 0x2d, 0x0, 0x4002b, 0x9, 0x37, 0x1, 0x40020, 0x40, 0xc, 0x1d,
    0x4002b, 0x9, 0x42, 0x40, 0x6002c, 0xa, 0x43, 0x42, 0x37, 0x37, 0x50036, 0x2, 0x4, 0x0, 0x3, 0x200f8, 0x5,
    0x50041, 0xe, 0xf, 0xc, 0xd, 0x4003d, 0x9, 0x10, 0xf, 0x4007c, 0x6, 0x11, 0x10, 0x4003d, 0x16, 0x19, 0x18,
    0x40064, 0x15, 0x1b, 0x19, 0x6005f, 0x12, 0x1c, 0x1b, 0x11, 0x2000, 0x4003d, 0x22, 0x25, 0x24, 0x40064, 0x21,
    0x27, 0x25, 0x5005f, 0x1e, 0x28, 0x27, 0x11, 0x50051, 0x9, 0x31, 0x1c, 0x0, 0x50051, 0x9, 0x34, 0x1c, 0x3,
    0x50080, 0x9, 0x35, 0x31, 0x34, 0x40070, 0x1d, 0x36, 0x35, 0x50051, 0x1d, 0x3a, 0x28, 0x1, 0x50081, 0x1d, 0x3b,
    0x36, 0x3a, 0x50051, 0x1d, 0x3e, 0x28, 0x2, 0x50081, 0x1d, 0x3f, 0x3b, 0x3e, 0x60041, 0x40, 0x41, 0x2c, 0x2d,
    0x11, 0x3003e, 0x41, 0x3f, 0x100fd, 0x10038,
];
