//! The portability floor: features and limits that a device must offer.

use ash::vk;

use super::limits::Limits;

/// Properties of a device that are not limits.
pub(super) struct Capabilities {
    pub(super) api_version: u32,
    pub(super) has_compute_queue: bool,
    pub(super) has_scalar_block_layout: bool,
}

/// Needs that a device lacks, as a clause that begins with "it lacks"; `None` where it can be used.
pub(super) fn lacking(capabilities: &Capabilities, limits: &Limits) -> Option<String> {
    let mut lacks = Vec::new();
    if capabilities.api_version < vk::API_VERSION_1_2 {
        lacks.push(format!("Vulkan 1.2 (it offers {})", version_text(capabilities.api_version)));
    }
    if !capabilities.has_compute_queue {
        lacks.push("a compute queue".into());
    }
    if !capabilities.has_scalar_block_layout {
        lacks.push("scalar block layout".into());
    }
    for (have, need, what) in limits_needed(limits) {
        if have < need {
            lacks.push(format!("{need} {what} (it offers {have})"));
        }
    }
    (!lacks.is_empty()).then(|| format!("it lacks {}", lacks.join(", ")))
}

fn limits_needed(limits: &Limits) -> [(u64, u64, &'static str); 6] {
    [
        (limits.max_bound_sets.into(), 4, "bound descriptor sets"),
        (limits.max_storage_buffers.into(), 24, "storage buffers per kernel"),
        (limits.max_texel_buffers.into(), 16, "texel buffers per kernel"),
        (limits.max_storage_buffer_bytes, 128 << 20, "bytes in a storage buffer"),
        (limits.max_workgroup_invocations.into(), 256, "invocations per workgroup"),
        (limits.max_push_constant_bytes.into(), 128, "bytes of push constants"),
    ]
}

/// Vulkan version as text, such as `1.3.230`.
pub(super) fn version_text(version: u32) -> String {
    let [major, minor, patch] =
        [vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version)];
    format!("{major}.{minor}.{patch}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor() -> (Capabilities, Limits) {
        let capabilities =
            Capabilities { api_version: vk::API_VERSION_1_2, has_compute_queue: true, has_scalar_block_layout: true };
        let limits = Limits {
            max_bound_sets: 4,
            max_storage_buffers: 24,
            max_texel_buffers: 16,
            max_storage_buffer_bytes: 128 << 20,
            max_workgroup_invocations: 256,
            max_push_constant_bytes: 128,
            ..Limits::default()
        };
        (capabilities, limits)
    }

    #[test]
    fn a_device_at_the_floor_is_taken() {
        let (capabilities, limits) = floor();
        assert_eq!(lacking(&capabilities, &limits), None);
    }

    #[test]
    fn every_need_is_checked_and_named() {
        type Spoil = fn(&mut Capabilities, &mut Limits);
        let cases: [(Spoil, &str); 9] = [
            (|c, _| c.api_version = vk::API_VERSION_1_1, "it lacks Vulkan 1.2 (it offers 1.1.0)"),
            (|c, _| c.has_compute_queue = false, "it lacks a compute queue"),
            (|c, _| c.has_scalar_block_layout = false, "it lacks scalar block layout"),
            (|_, l| l.max_bound_sets = 3, "it lacks 4 bound descriptor sets (it offers 3)"),
            (|_, l| l.max_storage_buffers = 16, "it lacks 24 storage buffers per kernel (it offers 16)"),
            (|_, l| l.max_texel_buffers = 0, "it lacks 16 texel buffers per kernel (it offers 0)"),
            (
                |_, l| l.max_storage_buffer_bytes = 65536,
                "it lacks 134217728 bytes in a storage buffer (it offers 65536)",
            ),
            (|_, l| l.max_workgroup_invocations = 128, "it lacks 256 invocations per workgroup (it offers 128)"),
            (|_, l| l.max_push_constant_bytes = 64, "it lacks 128 bytes of push constants (it offers 64)"),
        ];
        for (spoil, sentence) in cases {
            let (mut capabilities, mut limits) = floor();
            spoil(&mut capabilities, &mut limits);
            assert_eq!(lacking(&capabilities, &limits).as_deref(), Some(sentence));
        }
    }
}
