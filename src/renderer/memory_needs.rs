//! Memory that a render takes, and advice where a device has less.

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::query_geometry::QueryGeometry;
use crate::encode::surfaces::Shading;
use crate::gpu::{DeviceInfo, DeviceKind};
use crate::renderer::film_store::pages::{MOST_WHOLE_PIXELS, film_bytes, host_film_bytes, padded_pixels};
use crate::renderer::guide_cells::guide_bytes;
use crate::renderer::trace::wave_memory::wave_bytes;
use crate::settings::{Settings, Traversal};
use crate::{Error, Result, quoted};

/// Bytes of a render's parts on the device.
#[derive(Debug, Clone)]
pub(super) struct MemoryNeeds {
    parts: [Part; 5],
    /// Bytes that reading the film back takes on the host.
    host_bytes: u64,
    /// Whether the device's memory is the host's own.
    is_cpu: bool,
}

#[derive(Debug, Clone, Copy)]
struct Part {
    name: &'static str,
    bytes: u64,
    /// Advice that makes the part smaller.
    remedy: &'static str,
}

impl MemoryNeeds {
    pub fn new(device: &DeviceInfo, shading: &Shading, bvh: &Bvh, cells: &Cells, settings: &Settings) -> Self {
        let records = size_of_val(&bvh.primitives[..]) + size_of_val(&bvh.attributes[..]);
        let hierarchy = match settings.traversal {
            Traversal::Query => QueryGeometry::estimated_bytes(bvh),
            _ => size_of_val(&bvh.nodes[..]) as u64,
        };
        let is_cpu = device.kind == DeviceKind::Cpu;
        let part = |name, bytes, remedy| Part { name, bytes, remedy };
        Self {
            parts: [
                part("the film", film_bytes(settings), "smaller with --width, --height or --crop"),
                part("the BVH", records as u64 + hierarchy, "smaller for fewer triangles"),
                part("textures and lights", shading.bytes(), "smaller for smaller images"),
                part(
                    "the grids",
                    guide_bytes(settings, cells, shading.lights.group_count()),
                    "smaller with --grid, --directions, --normals or --light-selection power",
                ),
                part("paths under way", wave_bytes(device, settings), "none with --execution megakernel"),
            ],
            host_bytes: host_film_bytes(settings, is_cpu),
            is_cpu,
        }
    }

    /// Needs of the same render with the film of these settings.
    pub fn with_film(&self, settings: &Settings) -> Self {
        let mut parts = self.parts;
        parts[0].bytes = film_bytes(settings);
        Self { parts, host_bytes: host_film_bytes(settings, self.is_cpu), is_cpu: self.is_cpu }
    }

    /// Refuses a film that memory cannot hold beside the other parts, which it holds already.
    pub fn check_film(&self, device: &DeviceInfo, [width, height]: [u32; 2]) -> Result<()> {
        if device.kind != DeviceKind::Cpu {
            return self.check(device);
        }
        let needed = self.parts[0].bytes.saturating_add(self.host_bytes);
        match available_memory() {
            Some(available) if needed > available => {
                let [needed, available] = [needed, available].map(quoted::size);
                Err(Error::Settings(format!(
                    "a film of {width} x {height} pixels needs {needed} of memory, but {available} are free for {}; choose a smaller \
                     one",
                    device.name
                )))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a render that memory cannot hold, before a system without that memory ends the process.
    pub fn check(&self, device: &DeviceInfo) -> Result<()> {
        let on_cpu = device.kind == DeviceKind::Cpu;
        let available = if on_cpu { available_memory() } else { Some(device.limits.device_local_bytes) };
        let host_bytes = if on_cpu { self.host_bytes } else { 0 };
        available.map_or(Ok(()), |available| self.check_against(&device.name, host_bytes, available))
    }

    fn check_against(&self, device: &str, host_bytes: u64, available: u64) -> Result<()> {
        let needed = self.bytes().saturating_add(host_bytes);
        if needed <= available {
            return Ok(());
        }
        let read_back = match host_bytes {
            0 => String::new(),
            bytes => format!(", and reading the film back {}", quoted::size(bytes)),
        };
        let [needed, available] = [needed, available].map(quoted::size);
        Err(Error::Settings(format!(
            "the render needs {needed} of memory, but {available} are free for {device}: {}{read_back}",
            self.describe()
        )))
    }

    /// Sentence about the memory of a large render, for who begins it; `None` below a gigabyte.
    pub fn note(&self) -> Option<String> {
        let bytes = self.bytes();
        let [all, film, host] = [bytes, self.parts[0].bytes, self.host_bytes].map(quoted::size);
        (bytes >= 1_000_000_000).then(|| {
            format!(
                "the render takes {all} of memory on its device, of which the film takes {film}; reading the film back takes {host} more"
            )
        })
    }

    /// Whether a whole copy of the film of these settings lies in the host's memory while it is rendered.
    pub fn has_copies(&self, settings: &Settings) -> bool {
        !self.is_cpu || padded_pixels(settings) <= MOST_WHOLE_PIXELS
    }

    /// Bytes of all parts on the device.
    fn bytes(&self) -> u64 {
        self.parts.iter().map(|part| part.bytes).fold(0, u64::saturating_add)
    }

    /// Names each part with its bytes and with what makes it smaller.
    pub fn describe(&self) -> String {
        let describe = |Part { name, bytes, remedy }: &Part| format!("{name} {} ({remedy})", quoted::size(*bytes));
        let parts: Vec<_> = self.parts.iter().map(describe).collect();
        parts.join(", ")
    }

    /// Adds to an error that memory has run out what it went to.
    pub fn explain(&self, error: Error) -> Error {
        let is_out_of_memory = matches!(error, Error::OutOfDeviceMemory { .. });
        if is_out_of_memory {
            error.noting(&format!("memory that parts of the render need: {}", self.describe()))
        } else {
            error
        }
    }
}

/// Free memory of the system, where a file tells.
fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use glam::{UVec3, Vec2, Vec3};

    use super::*;
    use crate::scene::{FilmDescription, IntegratorDescription, Primitive, PrimitiveShape, ReconstructionFilter};

    /// Squares, one above the other, in all cells of the default grid.
    fn full_cells() -> Cells {
        let square = |layer: i32| Primitive {
            shape: PrimitiveShape::Parallelogram,
            origin: Vec3::new(0.0, 0.0, layer as f32),
            edge_u: Vec3::X * 8.0,
            edge_v: Vec3::Y * 8.0,
            normals: None,
            uvs: [Vec2::ONE; 3],
            flip_normal: false,
            front_only: false,
            unseen: false,
            material: 0,
            emitter: None,
        };
        let squares: Vec<_> = (0..=16).map(square).collect();
        Cells::new(&Bvh::build(&squares), &[], UVec3::splat(8))
    }

    #[test]
    fn a_guide_of_the_default_size_is_within_8_mib() {
        let film = FilmDescription { width: 8, height: 8, crop: None, filter: ReconstructionFilter::Box };
        let settings = Settings::for_film(&film, &IntegratorDescription::default());
        let cells = full_cells();
        assert_eq!(cells.count(), 512);
        // Scenes of more than sixteen lights need more.
        for (light_groups, most) in [(0, 8 << 20), (16, 8 << 20), (256, 11 << 20)] {
            let bytes = guide_bytes(&settings, &cells, light_groups);
            assert!(bytes <= most, "{light_groups} groups: {bytes}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_with_the_arithmetic() {
        let part = |name, bytes| Part { name, bytes, remedy: "smaller so" };
        let parts = [
            ("the film", 64_000),
            ("the BVH", 900_000),
            ("textures and lights", 0),
            ("the grids", 36_000),
            ("paths under way", 100_000),
        ];
        let parts = parts.map(|(name, bytes)| part(name, bytes));
        let needs = MemoryNeeds { parts, host_bytes: 100_000, is_cpu: false };
        assert!(needs.check_against("a device", 0, 1_100_000).is_ok());
        assert!(needs.check_against("a device", 100_000, 1_200_000).is_ok());
        assert_eq!(needs.note(), None);
        assert_eq!(
            needs.check_against("a device", 100_000, 1_199_999).expect_err("too little").to_string(),
            "the render needs 1.2 MB of memory, but 1.2 MB are free for a device: the film 64 kB (smaller so), \
             the BVH 900 kB (smaller so), textures and lights 0 bytes (smaller so), the grids 36 kB (smaller so), \
             paths under way 100 kB (smaller so), \
             and reading the film back 100 kB"
        );
        let huge = MemoryNeeds { parts: [part("the film", u64::MAX); 5], host_bytes: 0, is_cpu: false };
        assert!(huge.check_against("a device", 0, 1 << 60).is_err());
        assert!(huge.note().is_some_and(|note| note.contains("18 EB of memory")));
    }
}
