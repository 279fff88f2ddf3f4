//! Averages pictures of one scene, rendered from disjoint samples, into one picture.

use std::path::PathBuf;

use crate::film::Picture;
use crate::film::features::{FEATURES, MeanOver};
use crate::film::identity::{Identity, merged_attributes};
use crate::film::picture_file::PRECISION;
use crate::film::ranges::SampleRanges;
use crate::{Error, Result};

/// Picture made from some of a render's samples.
#[derive(Debug, Clone)]
pub struct PartialPicture {
    /// Path of the picture's file.
    pub path: PathBuf,
    /// The picture itself.
    pub picture: Picture,
    /// Attributes of the file's header, as names and values.
    pub attributes: Vec<(String, String)>,
}

impl PartialPicture {
    fn error(&self, message: String) -> Error {
        Error::image(&self.path, message)
    }

    /// Value of an attribute.
    fn value(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(found, _)| found == name).map(|(_, value)| &value[..])
    }

    fn ranges(&self) -> Result<SampleRanges> {
        let ranges = self.value("sample_ranges").and_then(|text| text.parse().ok());
        ranges.ok_or_else(|| self.error("it does not say which samples it holds; render it again".into()))
    }
}

/// Averages the parts, each pixel weighted by its number of samples. Returns the picture and the attributes of the
/// whole. The result does not depend on the order of the parts.
///
/// # Errors
/// [`Error::Image`] where a part shows another scene or window than the first, or holds samples that another part holds
/// too.
pub fn merge(parts: &[PartialPicture]) -> Result<(Picture, Vec<(String, String)>)> {
    let mut ranged: Vec<_> = parts.iter().map(|part| Ok((part.ranges()?, part))).collect::<Result<_>>()?;
    // Floating-point sums depend on the order of their terms, so the order is fixed.
    ranged.sort_by_key(|(ranges, _)| ranges.first());
    let has_sums = parts.iter().all(|part| !part.picture.sums.is_empty());
    let mut all = SampleRanges::default();
    for (at, (ranges, part)) in ranged.iter().enumerate() {
        check_same(part, ranged[0].1)?;
        check_even(part)?;
        check_precise(part, has_sums)?;
        if let Some(overlap) = all.overlap(ranges) {
            let other = ranged[..at].iter().find(|(other, _)| other.overlap(ranges).is_some());
            let other = other.map(|(_, other)| other.path.display().to_string()).unwrap_or_default();
            return Err(part.error(format!(
                "{other} also holds samples {overlap} (seed:first..end); merge parts with different samples"
            )));
        }
        all = all.union(ranges.clone());
    }
    let parts: Vec<_> = ranged.into_iter().map(|(_, part)| part).collect();
    let attributes = merged_attributes(&parts.iter().map(|part| &part.attributes[..]).collect::<Vec<_>>(), &all);
    Ok((average(&parts.iter().map(|part| &part.picture).collect::<Vec<_>>()), attributes))
}

/// Refuses parts whose sample counts depend on the samples themselves: their average would be biased however many parts
/// it had.
fn check_even(part: &PartialPicture) -> Result<()> {
    if let Some(target) = part.value("noise").filter(|&target| target != "null") {
        return Err(part.error(format!(
            "--noise {target} ended its pixels after different numbers of samples; render every part with --spp"
        )));
    }
    Ok(())
}

/// Refuses parts whose radiance was rounded to half floats. Integer sums are not rounded; `has_sums` says whether all parts have
/// them.
fn check_precise(part: &PartialPicture, has_sums: bool) -> Result<()> {
    if part.value(PRECISION).is_some() && !has_sums {
        let message =
            "its colors were rounded to half floats, and so would be their average; render every part without --half";
        return Err(part.error(message.into()));
    }
    Ok(())
}

fn check_same(part: &PartialPicture, first: &PartialPicture) -> Result<()> {
    let shape = |picture: &Picture| {
        let Picture { width, height, offset: [x, y], full_size: [full_width, full_height], .. } = picture;
        format!("{width} x {height} pixels at {x},{y} of {full_width} x {full_height}")
    };
    let (theirs, ours) = (shape(&first.picture), shape(&part.picture));
    let other = first.path.display();
    if theirs != ours {
        return Err(
            part.error(format!("it shows {ours}, but {other} shows {theirs}; merge pictures of the same window"))
        );
    }
    match Identity::of_picture(&first.attributes).difference(&Identity::of_picture(&part.attributes)) {
        Some(difference) => Err(part.error(format!("{other} belongs to another render: {difference}"))),
        None => Ok(()),
    }
}

/// Averages pictures of one size, exactly where all of them hold sums.
fn average(pictures: &[&Picture]) -> Picture {
    let average = match pictures.iter().all(|picture| !picture.sums.is_empty()) {
        true => sum(pictures),
        false => average_of_means(pictures),
    };
    // The background of a part whose samples all hit a surface is not known from its file.
    Picture { has_background: pictures.iter().any(|picture| picture.has_background), ..average }
}

/// Adds up the pictures' integer sums, so neither their number nor their order changes a bit.
fn sum(pictures: &[&Picture]) -> Picture {
    let mut sum = pictures[0].clone();
    for at in 0..sum.sums.len() {
        let mut pixel = sum.sums[at];
        pictures[1..].iter().for_each(|picture| pixel.add(&picture.sums[at]));
        sum.set_pixel(at, &pixel.means());
        sum.sums[at] = pixel;
    }
    sum
}

fn average_of_means(pictures: &[&Picture]) -> Picture {
    let mut average = Picture { sums: Vec::new(), ..pictures[0].clone() };
    for at in 0..average.radiance.len() {
        let samples = Weights::new(pictures, |picture| picture.sample_count[at]);
        let hits = Weights::new(pictures, |picture| picture.hit_count[at]);
        for channel in 0..3 {
            let mean = samples.mean(|picture| picture.radiance[at][channel]);
            average.radiance[at][channel] = mean as f32;
            average.variance[at][channel] =
                samples.variance(mean, |picture| (picture.radiance[at][channel], picture.variance[at][channel])) as f32;
        }
        for (number, feature) in FEATURES.iter().enumerate() {
            let weights = if feature.mean == MeanOver::Samples { &samples } else { &hits };
            for value in (0..feature.channels.len()).map(|channel| at * feature.channels.len() + channel) {
                let mean = || weights.mean(|picture| picture.features[number][value]) as f32;
                average.features[number][value] = if weights.total > 0.0 { mean() } else { feature.mean.of_nothing() };
            }
        }
        (average.sample_count[at], average.hit_count[at]) = (samples.total_count(), hits.total_count());
    }
    average
}

/// Weight of each picture in the average of one pixel.
struct Weights<'a> {
    counted: Vec<(&'a Picture, f64)>,
    total: f64,
}

impl<'a> Weights<'a> {
    fn new(pictures: &[&'a Picture], count: impl Fn(&Picture) -> u32) -> Self {
        let counted: Vec<_> = pictures.iter().map(|&picture| (picture, f64::from(count(picture)))).collect();
        // The value of a pixel without samples may not be a number.
        let counted: Vec<_> = counted.into_iter().filter(|&(_, count)| count > 0.0).collect();
        let total = counted.iter().map(|(_, count)| count).sum();
        Self { counted, total }
    }

    fn total_count(&self) -> u32 {
        // The count saturates: disjoint samples of several seeds may be more than 2^32.
        self.total as u32
    }

    fn mean(&self, value: impl Fn(&Picture) -> f32) -> f64 {
        let sum: f64 = self.counted.iter().map(|&(picture, count)| count * f64::from(value(picture))).sum();
        if self.total > 0.0 { sum / self.total } else { 0.0 }
    }

    /// Variance of the mean of all samples, from each picture's mean and variance of the mean (Chan, Golub and LeVeque
    /// 1979).
    fn variance(&self, mean: f64, mean_and_variance: impl Fn(&Picture) -> (f32, f32)) -> f64 {
        let squared_deviation = |&(picture, count): &(&Picture, f64)| {
            let (part_mean, variance) = mean_and_variance(picture);
            let within = f64::from(variance) * count * (count - 1.0);
            within + count * (f64::from(part_mean) - mean).powi(2)
        };
        let sum: f64 = self.counted.iter().map(squared_deviation).sum();
        if self.total > 1.0 { sum / (self.total * (self.total - 1.0)) } else { 0.0 }
    }
}
