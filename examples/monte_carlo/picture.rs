//! Error against number of samples, both logarithmic, one panel an integral.

use plotters::prelude::*;
use std::error::Error;

/// One integral.
pub(crate) struct Panel {
    /// Its name.
    pub(crate) title: String,
    /// Its estimators.
    pub(crate) series: Vec<Series>,
}

/// One estimator.
pub(crate) struct Series {
    /// Its name.
    pub(crate) name: String,
    /// (samples, error).
    pub(crate) points: Vec<(f64, f64)>,
}

/// Width and height in pixels.
const SIZE: (u32, u32) = (1100, 860);
/// Told apart by all kinds of colour vision (M. Okabe and K. Ito).
const COLORS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];

/// Writes `panels`, two in a row, to the SVG file `path`.
pub(crate) fn draw(path: &str, panels: &[Panel; 4]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    for (panel, area) in panels.iter().zip(root.split_evenly((2, 2))) {
        panel.draw(&area)?;
    }
    Ok(root.present()?)
}

/// Relative errors up to here are rounding: sums of f64 and the error function.
const ROUNDING: f64 = 1e-12;

impl Series {
    /// Whether the estimator has an error at all: one whose density is proportional to the integrand has none.
    fn errs(&self) -> bool {
        self.points.iter().all(|p| p.1 > ROUNDING)
    }
}

impl Panel {
    /// The decades that hold all errors.
    fn decades(&self) -> [f64; 2] {
        let errors = self.series.iter().filter(|s| s.errs()).flat_map(|s| &s.points).map(|p| p.1);
        let (low, high) = errors.fold((f64::MAX, 0.0), |(a, b): (f64, f64), e| (a.min(e), b.max(e)));
        [low.log10().floor(), high.log10().ceil()].map(|decade| 10f64.powf(decade))
    }

    fn draw(&self, area: &DrawingArea<SVGBackend, plotters::coord::Shift>) -> Result<(), Box<dyn Error>> {
        let [low, high] = self.decades();
        let points = &self.series.iter().find(|s| s.errs()).unwrap_or(&self.series[0]).points;
        let (first, last) = (points[0].0, points[points.len() - 1].0);
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 18))
            .margin(14)
            .x_label_area_size(36)
            .y_label_area_size(66)
            .build_cartesian_2d((first..last).log_scale(), (low..high).log_scale())?;
        let power_of_ten = |y: &f64| format!("1e{}", y.log10().round());
        chart
            .configure_mesh()
            .x_desc("samples n")
            .y_desc("relative RMS error")
            .x_label_formatter(&power_of_ten)
            .y_label_formatter(&power_of_ten)
            .light_line_style(WHITE)
            .draw()?;
        for (series, color) in self.series.iter().zip(COLORS) {
            let key = move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2));
            let drawn = if series.errs() { &series.points[..] } else { &[] };
            let name = if series.errs() { series.name.clone() } else { format!("{}: no error", series.name) };
            chart.draw_series(LineSeries::new(drawn.iter().copied(), color.stroke_width(2)))?.label(name).legend(key);
        }
        // Through the first point of the first estimator that errs: what independent samples do.
        let slope = points.iter().map(|p| (p.0, points[0].1 * (p.0 / first).powf(-0.5))).filter(|p| p.1 >= low);
        let key = |(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.4));
        chart.draw_series(LineSeries::new(slope, BLACK.mix(0.4)))?.label("n^-1/2").legend(key);
        let position = SeriesLabelPosition::LowerLeft;
        chart
            .configure_series_labels()
            .position(position)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.2))
            .draw()?;
        Ok(())
    }
}
