//! Memory that a render takes, and advice where a device has less.

use crate::encode::bvh::Bvh;
use crate::encode::cells::Cells;
use crate::encode::query_geometry::QueryGeometry;
use crate::encode::surfaces::Shading;
use crate::gpu::{DeviceInfo, DeviceKind};
use crate::renderer::film_store::pages::{film_bytes, has_copies, host_film_bytes, padded_pixels};
use crate::renderer::guide_cells::guide_bytes;
use crate::renderer::trace::wave_memory::wave_bytes;
use crate::settings::{Settings, Traversal};
use crate::{Error, Result, quoted};

/// Work on the picture besides writing it, as far as it takes memory of the host.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PictureWork {
    /// Whether the last picture is denoised. A denoiser needs the whole picture.
    pub is_denoised: bool,
    /// Whether the picture is compared with a reference, which memory holds already.
    pub is_compared: bool,
    /// Whether its exposure is chosen by its pixels.
    pub has_auto_exposure: bool,
}

/// Bytes of a pixel that the denoiser takes besides the picture: two features without noise, the color, its buffers of color, albedo,
/// normal and result, and the layer.
const DENOISED_PIXEL_BYTES: u64 = 8 * 12;
/// Bytes of a pixel of a tile that Open Image Denoise takes besides, and most pixels of a tile; measured with version 2.5 on a CPU.
const DENOISER_TILE_BYTES: u64 = 720;
const DENOISER_TILE: u64 = 2160 * 2160;
/// Bytes of its weights and of the library itself, measured like them.
const DENOISER_BYTES: u64 = 32_000_000;
/// Bytes of a pixel of the reference.
const REFERENCE_PIXEL_BYTES: u64 = 12;
/// Bytes of a pixel in a comparison: its relative error.
const COMPARED_PIXEL_BYTES: u64 = 8;
/// Bytes of a pixel by which an exposure is chosen: its luminance.
const EXPOSED_PIXEL_BYTES: u64 = 8;

/// Bytes of a render's parts on the device, and of what is done with the picture on the host.
#[derive(Debug, Clone)]
pub(super) struct MemoryNeeds {
    parts: [Part; 5],
    host: HostNeeds,
    work: PictureWork,
    /// Whether the device's memory is the host's own.
    is_cpu: bool,
}

/// Bytes on the host. The film is read for each work, but works follow each other.
#[derive(Debug, Clone, Copy, Default)]
struct HostNeeds {
    reading: u64,
    /// The denoiser's buffers and its scratch.
    denoising: u64,
    /// The reference, which memory holds already when needs are checked.
    reference: u64,
    /// Errors of the pixels.
    comparing: u64,
    /// Luminances of the pixels.
    exposing: u64,
}

impl HostNeeds {
    fn new(settings: &Settings, work: &PictureWork, is_cpu: bool) -> Self {
        let pixels = padded_pixels(settings);
        let of = |is_wanted: bool, bytes: u64| if is_wanted { pixels.saturating_mul(bytes) } else { 0 };
        let scratch = DENOISER_BYTES + DENOISER_TILE_BYTES * pixels.min(DENOISER_TILE);
        let scratch = if work.is_denoised { scratch } else { 0 };
        Self {
            reading: host_film_bytes(settings, is_cpu, work.is_denoised),
            denoising: of(work.is_denoised, DENOISED_PIXEL_BYTES).saturating_add(scratch),
            reference: of(work.is_compared, REFERENCE_PIXEL_BYTES),
            comparing: of(work.is_compared, COMPARED_PIXEL_BYTES),
            exposing: of(work.has_auto_exposure, EXPOSED_PIXEL_BYTES),
        }
    }

    /// Bytes that are not taken yet when needs are checked.
    fn bytes(&self) -> u64 {
        self.reading.saturating_add(self.denoising.max(self.comparing).max(self.exposing))
    }

    /// Names each part, such as `reading the film back 17 MB`.
    fn describe(&self) -> String {
        let Self { reading, denoising, reference, comparing, exposing } = *self;
        let all = [
            ("reading the film back", reading, ""),
            ("denoising it", denoising, " (none without --denoise)"),
            ("the reference", reference, " (none without --reference)"),
            ("comparing the picture with it", comparing, ""),
            ("choosing the exposure", exposing, " (none with --exposure 0)"),
        ];
        let all = all.into_iter().filter(|&(name, bytes, _)| bytes > 0 || name == all[0].0);
        all.map(|(name, bytes, remedy)| format!("{name} {}{remedy}", quoted::size(bytes)))
            .collect::<Vec<_>>()
            .join(", ")
    }
}

#[derive(Debug, Clone, Copy)]
struct Part {
    name: &'static str,
    bytes: u64,
    /// Advice that makes the part smaller.
    remedy: &'static str,
}

impl MemoryNeeds {
    pub fn new(
        device: &DeviceInfo,
        shading: &Shading,
        bvh: &Bvh,
        cells: &Cells,
        settings: &Settings,
        work: PictureWork,
    ) -> Self {
        let records = size_of_val(&bvh.primitives[..])
            + size_of_val(&bvh.attributes[..])
            + size_of_val(&bvh.keys[..])
            + size_of_val(&bvh.motions.records[..]);
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
            host: HostNeeds::new(settings, &work, is_cpu),
            work,
            is_cpu,
        }
    }

    /// Needs of the same render with the film of these settings.
    pub fn with_film(&self, settings: &Settings) -> Self {
        let mut parts = self.parts;
        parts[0].bytes = film_bytes(settings);
        Self { parts, host: HostNeeds::new(settings, &self.work, self.is_cpu), ..*self }
    }

    /// Refuses a film that memory cannot hold beside the other parts, which it holds already.
    pub fn check_film(&self, device: &DeviceInfo, [width, height]: [u32; 2]) -> Result<()> {
        if device.kind != DeviceKind::Cpu {
            return self.check(device);
        }
        let needed = self.parts[0].bytes.saturating_add(self.host.bytes());
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
        let host = on_cpu.then_some(self.host);
        available.map_or(Ok(()), |available| self.check_against(&device.name, host, available))
    }

    fn check_against(&self, device: &str, host: Option<HostNeeds>, available: u64) -> Result<()> {
        let needed = self.bytes().saturating_add(host.map_or(0, |host| host.bytes()));
        if needed <= available {
            return Ok(());
        }
        // The reference is among what is no longer free.
        let host = host.map(|host| HostNeeds { reference: 0, ..host }.describe());
        let host = host.map_or_else(String::new, |host| format!(", and {host}"));
        let [needed, available] = [needed, available].map(quoted::size);
        Err(Error::Settings(format!(
            "the render needs {needed} of memory, but {available} are free for {device}: {}{host}",
            self.describe()
        )))
    }

    /// Sentence about the memory of a large render, for who begins it; `None` below a gigabyte.
    pub fn note(&self) -> Option<String> {
        let HostNeeds { reference, .. } = self.host;
        let (bytes, on_host) = (self.bytes(), self.host.bytes().saturating_add(reference));
        let [all, film, host] = [bytes, self.parts[0].bytes, on_host].map(quoted::size);
        (bytes.saturating_add(on_host) >= 1_000_000_000).then(|| {
            format!(
                "the render takes {all} of memory on its device, of which the film takes {film}; its picture takes {host} more: {}",
                self.host.describe()
            )
        })
    }

    /// Work on the picture besides writing it.
    pub fn work(&self) -> PictureWork {
        self.work
    }

    /// Whether a whole copy of the film of these settings lies in the host's memory while it is rendered.
    pub fn has_copies(&self, settings: &Settings) -> bool {
        has_copies(settings, self.is_cpu)
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
        let host = HostNeeds { reading: 100_000, ..HostNeeds::default() };
        let needs = MemoryNeeds { parts, host, work: PictureWork::default(), is_cpu: false };
        assert!(needs.check_against("a device", None, 1_100_000).is_ok());
        assert!(needs.check_against("a device", Some(host), 1_200_000).is_ok());
        assert_eq!(needs.note(), None);
        assert_eq!(
            needs.check_against("a device", Some(host), 1_199_999).expect_err("too little").to_string(),
            "the render needs 1.2 MB of memory, but 1.2 MB are free for a device: the film 64 kB (smaller so), \
             the BVH 900 kB (smaller so), textures and lights 0 bytes (smaller so), the grids 36 kB (smaller so), \
             paths under way 100 kB (smaller so), \
             and reading the film back 100 kB"
        );
        let huge = MemoryNeeds {
            parts: [part("the film", u64::MAX); 5],
            host: HostNeeds::default(),
            work: PictureWork::default(),
            is_cpu: false,
        };
        assert!(huge.check_against("a device", None, 1 << 60).is_err());
        assert!(huge.note().is_some_and(|note| note.contains("18 EB of memory")));
    }

    fn settings(side: u32) -> Settings {
        let film = FilmDescription { width: side, height: side, crop: None, filter: ReconstructionFilter::Box };
        Settings::for_film(&film, &IntegratorDescription::default())
    }

    /// Work on a picture of 4096 x 4096 pixels on a CPU counts, each beside reading the film.
    #[test]
    fn work_on_the_picture_counts() {
        let settings = settings(4096);
        let pixels = 1 << 24;
        let needs = |work| HostNeeds::new(&settings, &work, true);
        let none = PictureWork::default();
        // Rows of 2^18 pixels.
        let rows = needs(none);
        assert_eq!(rows.bytes(), 64 << 18);
        // A GPU's film is read once for all files. It has a safety copy and the next one.
        assert!(has_copies(&settings, false) && !has_copies(&settings, true));
        assert_eq!(HostNeeds::new(&settings, &none, false).bytes(), 2 * 64 * pixels);
        assert_eq!(rows.describe(), "reading the film back 17 MB");
        let compared = needs(PictureWork { is_compared: true, ..none });
        assert_eq!((compared.bytes() - rows.bytes(), compared.reference), (8 * pixels, 12 * pixels));
        assert_eq!(
            compared.describe(),
            "reading the film back 17 MB, the reference 201 MB (none without --reference), comparing the picture with it 134 MB"
        );
        let exposed = needs(PictureWork { has_auto_exposure: true, ..none });
        assert_eq!(exposed.bytes() - rows.bytes(), 8 * pixels);
        // The whole picture, and eight of its layers.
        let denoised = needs(PictureWork { is_denoised: true, ..none });
        assert_eq!(denoised.bytes(), (64 + 96) * pixels + 32_000_000 + 720 * 2160 * 2160);
        let all = needs(PictureWork { is_denoised: true, is_compared: true, has_auto_exposure: true });
        assert_eq!(all.bytes(), denoised.bytes());
    }
}
