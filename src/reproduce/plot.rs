//! Line plots as SVG. Only this module names `plotters`.

use std::ops::Range;

use plotters::prelude::*;

use crate::{Error, Result};

const SIZE: (u32, u32) = (720, 480);
/// Margin at either end of an axis, as a share of the axis.
const MARGIN: f64 = 0.04;
/// Height of the legend, as a share of the axis.
const LEGEND_SHARE: f64 = 0.3;
/// Colors that people with color vision deficiencies can distinguish (Okabe and Ito 2008).
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 0, 0),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];

/// Axis of a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// Quantity that the axis shows.
    pub title: &'static str,
    /// Whether the axis is logarithmic.
    pub is_logarithmic: bool,
}

/// Series of points, joined by lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points from left to right.
    pub points: Vec<[f64; 2]>,
}

/// Line plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Title above the plot.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Series to show.
    pub series: Vec<Series>,
}

impl Axis {
    /// Linear axis.
    pub const fn linear(title: &'static str) -> Self {
        Self { title, is_logarithmic: false }
    }

    /// Logarithmic axis. Its numbers must be positive.
    pub const fn logarithmic(title: &'static str) -> Self {
        Self { title, is_logarithmic: true }
    }

    fn place(self, value: f64) -> f64 {
        if self.is_logarithmic { value.log10() } else { value }
    }

    fn label(self, place: f64) -> String {
        let value = if self.is_logarithmic { 10.0_f64.powf(place) } else { place };
        match value.abs() {
            0.0 => "0".into(),
            ..1.0e-3 => format!("{value:.0e}"),
            ..1.0 => format!("{value:.3}"),
            ..100.0 => format!("{value:.1}"),
            _ => format!("{value:.0}"),
        }
    }

    fn range(self, values: impl Iterator<Item = f64>) -> Range<f64> {
        let fit = values.map(|value| self.place(value)).filter(|place| place.is_finite());
        let (low, high) = fit.fold((f64::MAX, f64::MIN), |(low, high), place| (low.min(place), high.max(place)));
        if low > high {
            return 0.0..1.0;
        }
        // A linear axis includes 0, so that lengths can be compared.
        let low = if self.is_logarithmic { low } else { low.min(0.0) };
        let room = (high - low).max(1.0e-6);
        low - MARGIN * room..high + MARGIN * room
    }
}

impl Plot {
    /// Plot as SVG.
    ///
    /// # Errors
    /// Fails if the plotting library rejects the numbers.
    pub fn svg(&self) -> Result<String> {
        let mut text = String::new();
        let drawn = self.draw(&mut text);
        drawn.map_err(|error| Error::Render(format!("the plot `{}` cannot be drawn: {error}", self.title)))?;
        Ok(text)
    }

    fn draw(&self, text: &mut String) -> std::result::Result<(), Box<dyn std::error::Error + '_>> {
        let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (x, y) = (self.x, self.y);
        let values =
            |axis: usize| self.series.iter().flat_map(move |series| series.points.iter().map(move |p| p[axis]));
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 18))
            .margin(16)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(x.range(values(0)), with_headroom(y.range(values(1))))?;
        chart
            .configure_mesh()
            .x_desc(x.title)
            .y_desc(y.title)
            .x_label_formatter(&|place| x.label(*place))
            .y_label_formatter(&|place| y.label(*place))
            .light_line_style(TRANSPARENT)
            .draw()?;
        for (series, color) in self.series.iter().zip(COLORS.iter().cycle()) {
            let points = series.points.iter().map(|p| (x.place(p[0]), y.place(p[1])));
            let finite = points.filter(|(x, y)| x.is_finite() && y.is_finite());
            chart
                .draw_series(LineSeries::new(finite, color.stroke_width(2)))?
                .label(&series.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        area.present()?;
        Ok(())
    }
}

/// Range with room for the legend above all lines.
fn with_headroom(range: Range<f64>) -> Range<f64> {
    range.start..range.end + LEGEND_SHARE * (range.end - range.start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_names_its_series_and_axes() {
        let points = vec![[1.0e-4, 0.1], [0.5, 0.02], [1.0, f64::NAN]];
        let series =
            vec![Series { name: "rejection-mix".into(), points }, Series { name: "bsdf".into(), points: vec![] }];
        let (x, y) = (Axis::logarithmic("share e"), Axis::linear("MAE"));
        let svg = Plot { title: "kitchen".into(), x, y, series }.svg().expect("a plot");
        for word in ["<svg", "kitchen", "rejection-mix", "bsdf", "share e", "MAE", "polyline"] {
            assert!(svg.contains(word), "{word}");
        }
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn labels_are_the_values() {
        let axis = Axis::logarithmic("");
        assert_eq!([-4.0, -1.0, 0.0, 3.0].map(|place| axis.label(place)), ["1e-4", "0.100", "1.0", "1000"]);
        assert_eq!(Axis::linear("").range([2.0, 4.0].into_iter()), -0.16..4.16);
        assert_eq!(Axis::linear("").range(std::iter::empty()), 0.0..1.0);
    }
}
