//! Pictures with their layers, as arrays.

use std::path::PathBuf;

use lodestar::denoise::{DenoiseOptions, Denoiser, DeviceKind};
use lodestar::film::{self, Precision};
use lodestar::image::canvas::{Canvas, Format};
use lodestar::image::{ToneCurve, png};
use lodestar::{Error, files};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyBytes;

use crate::arrays::frozen;
use crate::errors::{raised, refused};
use crate::shared::detached;

/// A picture with its layers. Arrays have the shape (height, width) or (height, width, 3), rows from the top, and cannot be written
/// to; `picture.radiance.copy()` can.
#[pyclass(frozen, module = "lodestar")]
pub struct Picture {
    pub picture: lodestar::Picture,
    /// Names and values of the EXR file's header.
    pub attributes: Vec<(String, String)>,
    stats: Option<Py<PyAny>>,
    ending: Option<&'static str>,
    arrays: [PyOnceLock<Py<PyAny>>; 8],
}

impl Picture {
    /// A picture; statistics and the reason of the end are known where it was rendered just now.
    pub fn new(
        picture: lodestar::Picture,
        attributes: Vec<(String, String)>,
        stats: Option<Py<PyAny>>,
        ending: Option<&'static str>,
    ) -> Self {
        Self { picture, attributes, stats, ending, arrays: [const { PyOnceLock::new() }; 8] }
    }

    /// The picture itself.
    pub fn picture(&self) -> &lodestar::Picture {
        &self.picture
    }

    /// Array number `at`, made once.
    fn array<T: numpy::Element + Copy>(&self, py: Python<'_>, at: usize, values: &[T]) -> PyResult<Py<PyAny>> {
        let lodestar::Picture { width, height, .. } = self.picture;
        let (width, height) = (width as usize, height as usize);
        let channels = values.len() / (width * height).max(1);
        let make = || match channels {
            1 => frozen(py, values, [height, width]),
            _ => frozen(py, values, [height, width, channels]),
        };
        self.arrays[at].get_or_try_init(py, make).map(|array| array.clone_ref(py))
    }
}

#[pymethods]
impl Picture {
    /// Reads an EXR file that Lodestar has written, with all layers.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let (picture, attributes) = detached(py, || film::read_picture(&path))?.map_err(raised)?;
        Ok(Self::new(picture, attributes, None, None))
    }

    /// Width in pixels of the rendered window.
    #[getter]
    fn width(&self) -> u32 {
        self.picture.width
    }

    /// Height in pixels of the rendered window.
    #[getter]
    fn height(&self) -> u32 {
        self.picture.height
    }

    /// Mean radiance, (height, width, 3) float32: linear sRGB, W/(m^2 sr).
    #[getter]
    fn radiance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 0, self.picture.radiance.as_flattened())
    }

    /// Variance of the mean radiance, (height, width, 3) float32, computed as if samples were independent.
    #[getter]
    fn variance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 1, self.picture.variance.as_flattened())
    }

    /// Number of samples taken, (height, width) uint32.
    #[getter]
    fn samples(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 2, &self.picture.sample_count)
    }

    /// Number of samples whose camera ray hit a surface, (height, width) uint32.
    #[getter]
    fn hits(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 3, &self.picture.hit_count)
    }

    /// Mean albedo of the first hit, (height, width, 3) float32 in [0, 1]; a miss counts as 0.
    #[getter]
    fn albedo(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 4, self.picture.albedo().as_flattened())
    }

    /// Mean shading normal of the first hit, (height, width, 3) float32, world space, not normalized.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 5, self.picture.normal().as_flattened())
    }

    /// Mean distance from the camera to the first hit, (height, width) float32, in scene units; infinite where no sample hit.
    #[getter]
    fn depth(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, 6, self.picture.depth())
    }

    /// Opaque share of each pixel, (height, width) float32 in [0, 1].
    #[getter]
    fn alpha(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let alpha: Vec<f32> = (0..self.picture.radiance.len()).map(|at| self.picture.alpha(at)).collect();
        self.array(py, 7, &alpha)
    }

    /// All numbers about the render, as `--stats` writes them: settings, device, times in seconds, sums over all steps under
    /// `totals`, and the steps. None for a picture that was read from a file or merged.
    #[getter]
    fn stats(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        self.stats.as_ref().map(|stats| stats.clone_ref(py))
    }

    /// Reason why the render ended: `samples`, `time`, `noise`, or `stopped` by Ctrl-C or a callback. None for a picture of a
    /// render that goes on, and for one that was read from a file or merged.
    #[getter]
    fn ending(&self) -> Option<&'static str> {
        self.ending
    }

    /// Settings, sample numbers, device and scene as the EXR file's header has them, all texts.
    #[getter]
    fn attributes(&self) -> std::collections::BTreeMap<String, String> {
        self.attributes.iter().cloned().collect()
    }

    /// Writes the picture, whole or not at all.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     A name in `.exr` keeps all layers and the header, a name in `.png`, `.jpg` or `.tif` is for viewers, and a name in `.hdr` has
    ///     linear colors.
    /// tone : 'srgb', 'paper', 'agx', 'filmic' or 'aces'
    ///     Tone curve of a file for viewers.
    /// exposure : float
    ///     Exposure of a file for viewers in stops.
    /// half : bool
    ///     Whether the colors of an EXR file are half floats.
    #[pyo3(signature = (path, *, tone = "srgb", exposure = 0.0, half = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, tone: &str, exposure: f32, half: bool) -> PyResult<()> {
        let tone = tone_of(tone)?;
        let write = || match Format::of(&path) {
            Some(format) => {
                let lodestar::Picture { width, height, ref radiance, .. } = self.picture;
                Canvas::new(format, [width, height], tone, exposure).write(&path, radiance, &mut |_| {})
            }
            None if files::has_extension(&path, "exr") => {
                let precision = if half { Precision::Half } else { Precision::Float };
                film::write_picture_as(&path, &self.picture, &self.attributes, precision)
            }
            None => {
                let message = "the name must end in .exr, .png, .jpg, .tif or .hdr";
                Err(Error::Settings(format!("{}: {message}", path.display())))
            }
        };
        detached(py, write)?.map_err(raised)
    }

    /// Radiance without its noise, (height, width, 3) float32: linear sRGB, by Intel's Open Image Denoise 2.x with the layers albedo and
    /// normal. A denoised picture is biased.
    ///
    /// Parameters
    /// ----------
    /// oidn : path
    ///     Folder of the library. Default: the variable `LODESTAR_OIDN`, then where the system has libraries.
    /// device : 'cpu', 'sycl', 'cuda', 'hip' or 'metal'
    ///     Kind of device that denoises. The bits of `cpu` are the same in each run.
    #[pyo3(signature = (*, oidn = None, device = "cpu"))]
    fn denoise(&self, py: Python<'_>, oidn: Option<PathBuf>, device: &str) -> PyResult<Py<PyAny>> {
        let device = match device {
            "cpu" => DeviceKind::Cpu,
            "sycl" => DeviceKind::Sycl,
            "cuda" => DeviceKind::Cuda,
            "hip" => DeviceKind::Hip,
            "metal" => DeviceKind::Metal,
            _ => {
                return Err(refused(format!(
                    "invalid value '{device}' for `device`: give one of cpu, sycl, cuda, hip, metal"
                )));
            }
        };
        let denoise = || {
            let denoiser = Denoiser::open(&DenoiseOptions { folder: oidn, device })?;
            denoiser.denoise_picture(&self.picture)
        };
        let denoised = detached(py, denoise)?.map_err(raised)?;
        let lodestar::Picture { width, height, .. } = self.picture;
        frozen(py, denoised.pixels.as_flattened(), [height as usize, width as usize, 3])
    }

    /// The picture as a PNG file in memory.
    #[pyo3(signature = (*, tone = "srgb", exposure = 0.0))]
    fn png<'py>(&self, py: Python<'py>, tone: &str, exposure: f32) -> PyResult<Bound<'py, PyBytes>> {
        let tone = tone_of(tone)?;
        let mut bytes = Vec::new();
        let encoded = detached(py, || png::encode(&mut bytes, &self.picture.image(), tone, exposure))?;
        encoded.map_err(|error| refused(format!("no PNG can be made of this picture: {error}")))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The picture for a notebook.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py, "srgb", 0.0)
    }

    fn __repr__(&self) -> String {
        let lodestar::Picture { width, height, sample_count, .. } = &self.picture;
        let samples = sample_count.iter().max().copied().unwrap_or(0);
        format!("<lodestar.Picture: {width} x {height} pixels, {samples} samples per pixel>")
    }
}

fn tone_of(name: &str) -> PyResult<ToneCurve> {
    match name {
        "srgb" => Ok(ToneCurve::Srgb),
        "paper" => Ok(ToneCurve::Paper),
        "agx" => Ok(ToneCurve::Agx),
        "filmic" => Ok(ToneCurve::Filmic),
        "aces" => Ok(ToneCurve::Aces),
        _ => Err(refused(format!("invalid value '{name}' for `tone`: give one of srgb, paper, agx, filmic, aces"))),
    }
}
