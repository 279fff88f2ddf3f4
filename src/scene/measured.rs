//! Measured materials (Dupuy and Jakob 2018): tables of how a real surface scatters light.

use std::sync::Arc;

use super::parameter::{Parameter, Value};
use super::spectrum;
use super::tensor_file::TensorFile;
use super::texel_pages::PAGE_WORDS;
use crate::generated::constants::{MEASURED_GRID_WORDS, MEASURED_GRIDS, MEASURED_HEAD_WORDS};

/// Largest magnitude of a negative number that counts as 0, as a share of the largest number of its table.
const ROUNDING: f32 = 1.0e-3;
/// Largest number of a table. Sums and products of several stay in the range of single precision.
const LARGEST: f32 = 1.0e8;
/// Most azimuths, elevations, wavelengths, and points along a side of a grid.
const MOST: usize = 1 << 14;

/// Grids of numbers over the unit square, one for each direction of the viewer, or one for all.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Grids {
    /// Columns and rows, at least two each.
    pub size: [usize; 2],
    /// Numbers: a grid after the other, in each a row after the other.
    pub values: Vec<f32>,
}

/// Tables of a measured material. Grids of directions of the viewer are those of all elevations of the first azimuth, then those of the
/// next one.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Measured {
    /// Azimuths of the viewer, which increase, in radians from -pi to pi.
    pub phi: Vec<f32>,
    /// Angles of the viewer with the normal, which increase, in radians.
    pub theta: Vec<f32>,
    /// Density of the facets' normals.
    pub ndf: Grids,
    /// Projected area of the facets, by the direction of the viewer.
    pub sigma: Grids,
    /// Density of the normals that the viewer sees.
    pub vndf: Grids,
    /// Brightness of the samples of `vndf`.
    pub luminance: Grids,
    /// Colors of these samples in linear sRGB: grids of red, of green and of blue.
    pub colors: [Grids; 3],
}

/// Measured material as a scattering function. Materials of one file share its tables.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MeasuredBsdf {
    /// The tables.
    #[serde(serialize_with = "tables")]
    pub tables: Arc<Measured>,
}

fn tables<S: serde::Serializer>(tables: &Arc<Measured>, serializer: S) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&**tables, serializer)
}

/// The tables give all parameters, when they are made ready for kernels.
impl Parameter for MeasuredBsdf {
    fn visit<'a>(&'a mut self, _number: u32, _see: &mut dyn FnMut(u32, Value<'a>)) {}
}

impl Grids {
    /// Numbers of each grid.
    pub fn area(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Grids that have one number everywhere.
    fn constant(value: f32) -> Self {
        Self { size: [2; 2], values: vec![value; 4] }
    }
}

impl Measured {
    /// Reads a file. It takes at most eight times the memory of the file. The message of an error goes on after the file's name.
    ///
    /// # Errors
    /// Where the file is none of this format, or has numbers that no surface could have.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let file = TensorFile::new(bytes)?;
        let phi = angles(&file, "phi_i")?;
        let theta = angles(&file, "theta_i")?;
        let directions = [phi.len(), theta.len()];
        let (mut ndf, mut sigma) = (grids(&file, "ndf", &[])?, grids(&file, "sigma", &[])?);
        if file.bytes("jacobian")?.first() == Some(&0) {
            // The colors are then values of the whole function.
            (ndf, sigma) = (Grids::constant(1.0), Grids::constant(0.25));
        }
        let vndf = grids(&file, "vndf", &directions)?;
        if vndf.values.chunks_exact(vndf.area()).any(|grid| grid.iter().all(|&number| number == 0.0)) {
            return Err("has a direction in its field `vndf` from which nothing is seen".to_owned());
        }
        let mut luminance = grids(&file, "luminance", &directions)?;
        let colors = colors(&file, directions, luminance.size)?;
        complete(&mut luminance, &colors);
        let measured = Self { phi, theta, ndf, sigma, vndf, luminance, colors };
        match measured.word_count() {
            count if count <= PAGE_WORDS => Ok(measured),
            count => Err(format!("has tables of {count} numbers for a device; at most {PAGE_WORDS} are supported")),
        }
    }

    /// Whether the function does not change when the surface is turned.
    pub fn is_isotropic(&self) -> bool {
        self.phi.len() <= 2
    }

    /// Number of parts of the azimuths of which one was measured: 4 where a quarter of them stands for all, 2 for a half, otherwise 1. It is 0
    /// for an isotropic function.
    pub fn parts(&self) -> u32 {
        let [first, last] = [self.phi.first(), self.phi.last()].map(|angle| angle.copied().unwrap_or(0.0));
        match self.is_isotropic() {
            true => 0,
            false => (std::f32::consts::TAU / (last - first)).round_ties_even().clamp(1.0, 4.0) as u32,
        }
    }

    /// Number of words that the tables take on a device.
    pub fn word_count(&self) -> u64 {
        let head = u64::from(MEASURED_HEAD_WORDS + MEASURED_GRIDS * MEASURED_GRID_WORDS);
        let angles = self.phi.len() + self.theta.len();
        let plain = [&self.ndf, &self.sigma].into_iter().chain(&self.colors).map(|grids| grids.values.len() as u64);
        // What is sampled has the distributions of the columns and of the rows, too.
        let sampled = [&self.luminance, &self.vndf].map(|grids| {
            let count = (grids.values.len() / grids.area()) as u64;
            2 * grids.values.len() as u64 + count * grids.size[1] as u64
        });
        head + angles as u64 + plain.chain(sampled).sum::<u64>()
    }
}

/// Reads angles, which increase.
fn angles(file: &TensorFile, name: &str) -> Result<Vec<f32>, String> {
    let (shape, angles) = file.numbers(name)?;
    if shape.len() != 1 || angles.len() > MOST {
        return Err(format!("has a field `{name}` that is no list of at most {MOST} angles"));
    }
    let increase = angles.windows(2).all(|pair| pair[0] < pair[1]);
    match increase && angles.iter().all(|angle| angle.abs() < 7.0) {
        true => Ok(angles),
        false => Err(format!("has angles in its field `{name}` that are not radians in increasing order")),
    }
}

/// Reads grids for these directions. No number is negative.
fn grids(file: &TensorFile, name: &str, directions: &[usize]) -> Result<Grids, String> {
    let (shape, mut values) = file.numbers(name)?;
    let size = size(name, shape, directions)?;
    let largest = values.iter().copied().fold(0.0, f32::max);
    // Measurements and their exporters round below 0.
    values.iter_mut().filter(|value| (-ROUNDING * largest..0.0).contains(*value)).for_each(|value| *value = 0.0);
    if let Some(value) = values.iter().find(|value| **value < 0.0 || **value > LARGEST) {
        return Err(format!("has the number {value} in its field `{name}`; it should lie in 0..{LARGEST:e}"));
    }
    Ok(Grids { size, values })
}

/// Columns and rows of a field that should begin with these dimensions.
fn size(name: &str, shape: &[usize], first: &[usize]) -> Result<[usize; 2], String> {
    let text = |sides: &[usize]| sides.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    match shape.strip_prefix(first) {
        Some(&[rows, columns]) if [rows, columns].iter().all(|side| (2..=MOST).contains(side)) => Ok([columns, rows]),
        _ => {
            let before = if first.is_empty() { String::new() } else { format!("{} x ", text(first)) };
            Err(format!(
                "has a field `{name}` of {} numbers; it should have {before}grids of 2 to {MOST} rows and columns",
                text(shape)
            ))
        }
    }
}

/// Reads the colors, or the spectra as colors under D65, the white point of linear sRGB. Colors outside the gamut are moved to its border.
fn colors(file: &TensorFile, [azimuths, elevations]: [usize; 2], size: [usize; 2]) -> Result<[Grids; 3], String> {
    let (name, weights) = match file.has("wavelengths") {
        true => ("spectra", weights(file)?),
        false if file.has("rgb") => ("rgb", vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        false => ("spectra", vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    };
    let (shape, values) = file.numbers(name)?;
    let found = self::size(name, shape, &[azimuths, elevations, weights.len()])?;
    if found != size {
        let [columns, rows] = size;
        return Err(format!("has a field `{name}` whose grids have not the {rows} x {columns} numbers of `luminance`"));
    }
    if let Some(value) = values.iter().find(|value| value.abs() > LARGEST) {
        return Err(format!("has the number {value} in its field `{name}`, which is too large"));
    }
    let area = size[0] * size[1];
    let of_channel = |channel: usize| {
        let mut sums = Vec::with_capacity(azimuths * elevations * area);
        for spectra in values.chunks_exact(weights.len() * area) {
            let sum = |at| {
                let terms = spectra.iter().skip(at).step_by(area).zip(&weights);
                terms.map(|(value, weight)| f64::from(*value) * weight[channel]).sum::<f64>()
            };
            sums.extend((0..area).map(|at| sum(at).max(0.0) as f32));
        }
        Grids { size, values: sums }
    };
    Ok([0, 1, 2].map(of_channel))
}

/// Share of each wavelength in red, green and blue. A spectrum goes on with its first and last value, as in Mitsuba. One that is the same
/// everywhere is white.
fn weights(file: &TensorFile) -> Result<Vec<[f64; 3]>, String> {
    let (shape, wavelengths) = file.numbers("wavelengths")?;
    let increase = wavelengths.windows(2).all(|pair| pair[0] < pair[1]);
    if shape.len() != 1
        || wavelengths.len() > MOST
        || !increase
        || wavelengths.iter().any(|&at| !(1.0..1.0e6).contains(&at))
    {
        return Err("has a field `wavelengths` that is no list of nanometers in increasing order".to_owned());
    }
    let wavelengths: Vec<_> = wavelengths.into_iter().map(f64::from).collect();
    let mut weights = spectrum::material_weights(&wavelengths);
    let sums = [0, 1, 2].map(|channel| weights.iter().map(|weight| weight[channel]).sum::<f64>());
    weights.iter_mut().for_each(|weight| weight.iter_mut().zip(sums).for_each(|(share, sum)| *share /= sum));
    Ok(weights)
}

/// Gives samples that reflect light but have no brightness the mean of their colors, so that they are drawn.
fn complete(luminance: &mut Grids, colors: &[Grids; 3]) {
    for (at, brightness) in luminance.values.iter_mut().enumerate().filter(|(_, brightness)| **brightness == 0.0) {
        *brightness = colors.iter().map(|channel| channel.values[at]).sum::<f32>() / 3.0;
    }
}
