//! Curves on logarithmic axes as SVG. The colours in the drawing are placeholders that the page's style sheet replaces,
//! so that one drawing serves light and dark pages.

use maud::{Markup, PreEscaped, html};
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::fmt::Write;
use std::ops::Range;

/// Size of the drawing in user units; the page scales it.
const SIZE: (u32, u32) = (960, 720);
/// Height of labels: legible when the drawing is scaled to a phone.
const TEXT: u32 = 32;
/// Number of colours; with `DASHES` it bounds the distinct series, beyond which styles repeat.
const HUES: usize = 8;
const DASHES: [&str; 4] = ["none", "16 9", "4 7", "20 7 4 7"];

/// A curve with its error band.
pub struct Series {
    /// Its name.
    pub label: String,
    /// Index of its colour.
    pub hue: usize,
    /// Index of its dash pattern.
    pub dash: usize,
    /// Points (x, y) from left to right. Those that are not positive and finite are left out.
    pub curve: Vec<[f64; 2]>,
    /// Lower and upper end of the band at each point; may be empty.
    pub band: Vec<[f64; 2]>,
}

/// A log-log plot of y over x.
pub struct Plot<'a> {
    /// Alternative text.
    pub title: &'a str,
    /// Name of the horizontal axis.
    pub x: &'a str,
    /// Name of the vertical axis.
    pub y: &'a str,
    /// The curves.
    pub series: &'a [Series],
    /// Slope of a guide line, if any.
    pub guide: Option<f64>,
}

type Failure = DrawingAreaErrorKind<std::io::Error>;

impl Plot<'_> {
    /// Draws the plot.
    pub fn draw(&self) -> Markup {
        let mut svg = String::new();
        // Drawing into a string fails only for invalid ranges, which `span` does not produce.
        if self.draw_into(&mut svg).is_err() {
            return html! { p.soft { "There is nothing to plot." } };
        }
        let open =
            html! { svg.plot role="img" aria-label=(self.title) viewBox=(format!("0 0 {} {}", SIZE.0, SIZE.1)) {} }
                .into_string();
        let open = open.trim_end_matches("</svg>");
        let body = svg.find('>').map_or("", |end| &svg[end + 1..]);
        PreEscaped(format!("{open}{body}"))
    }

    fn draw_into(&self, svg: &mut String) -> Result<(), Failure> {
        let points = || self.series.iter().flat_map(|s| s.curve.iter().filter_map(log_point));
        let bands =
            || self.series.iter().flat_map(|s| s.band.iter().flatten()).filter(|v| is_loggable(v)).map(|v| v.log10());
        let (x, y) = (span(points().map(|p| p[0])), span(points().map(|p| p[1]).chain(bands())));
        let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .margin(14)
            .x_label_area_size(86)
            .y_label_area_size(138)
            .build_cartesian_2d(LogAxis(x.clone()), LogAxis(y.clone()))?;
        let text = ("sans-serif", TEXT).into_font().color(&INK);
        chart
            .configure_mesh()
            .axis_style(AXIS)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .label_style(text.clone())
            .axis_desc_style(text)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .x_desc(self.x)
            .y_desc(self.y)
            .draw()?;
        if let (Some(slope), Some(from)) = (self.guide, points().next()) {
            let line = [x.start, x.end].map(|at| (at, from[1] + slope * (at - from[0])));
            chart.draw_series(LineSeries::new(clipped(line, &y, slope), GUIDE.stroke_width(2)))?;
        }
        for series in self.series {
            let color = color(series);
            let curve: Vec<(f64, f64)> = series.curve.iter().filter_map(log_point).map(|p| (p[0], p[1])).collect();
            chart.draw_series(band(series).map(|outline| Polygon::new(outline, color.mix(0.18))))?;
            chart.draw_series(LineSeries::new(curve.iter().copied(), color.stroke_width(4)))?;
            chart.draw_series(curve.iter().map(|&at| Circle::new(at, 6, color.filled())))?;
        }
        drop(chart);
        area.present()
    }
}

/// A logarithmic axis with our labels.
struct LogAxis(Range<f64>);

impl Ranged for LogAxis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.0.start) / (self.0.end - self.0.start);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { ticks(&self.0) }
    }

    fn range(&self) -> Range<f64> {
        self.0.clone()
    }
}

const AXIS: RGBColor = RGBColor(11, 0, 0);
const INK: RGBColor = RGBColor(11, 0, 1);
const GRID: RGBColor = RGBColor(11, 0, 2);
const GUIDE: RGBColor = RGBColor(11, 0, 3);

fn color(series: &Series) -> RGBColor {
    RGBColor(10, (series.hue % HUES) as u8, (series.dash % DASHES.len()) as u8)
}

/// Returns the style sheet that maps the placeholders to colours.
pub(super) fn css() -> String {
    let mut css = String::new();
    let mut rule = |RGBColor(r, g, b): RGBColor, value: &str, dash: &str| {
        let _ = write!(
            css,
            "[fill=\"#{r:02X}{g:02X}{b:02X}\"]{{fill:{value}}}[stroke=\"#{r:02X}{g:02X}{b:02X}\"]{{stroke:{value};stroke-dasharray:{dash}}}"
        );
    };
    for (color, value, dash) in [
        (AXIS, "var(--soft)", "none"),
        (INK, "var(--ink)", "none"),
        (GRID, "var(--line)", "none"),
        (GUIDE, "var(--soft)", "3 9"),
    ] {
        rule(color, value, dash);
    }
    for hue in 0..HUES {
        for (at, dash) in DASHES.iter().enumerate() {
            rule(RGBColor(10, hue as u8, at as u8), &format!("var(--h{hue})"), dash);
        }
    }
    css
}

/// Formats the legend: the names of the series, each with a sample of its line.
pub fn key(series: &[Series]) -> Markup {
    html! {
        ul.key {
            @for one in series {
                li {
                    @let RGBColor(r, g, b) = color(one);
                    svg viewBox="0 0 78 24" aria-hidden="true" {
                        line x1="0" y1="12" x2="78" y2="12" stroke-width="5" stroke=(format!("#{r:02X}{g:02X}{b:02X}")) {}
                    }
                    (one.label)
                }
            }
        }
    }
}

fn is_loggable(v: &f64) -> bool {
    v.is_finite() && *v > 0.0
}

fn log_point(p: &[f64; 2]) -> Option<[f64; 2]> {
    p.iter().all(is_loggable).then(|| p.map(f64::log10))
}

/// Returns the outline of a series' band, if it has one.
fn band(series: &Series) -> Option<Vec<(f64, f64)>> {
    let edge =
        |side: usize| series.curve.iter().zip(&series.band).filter_map(move |(p, b)| log_point(&[p[0], b[side]]));
    let (low, high): (Vec<_>, Vec<_>) = (edge(0).collect(), edge(1).collect());
    let outline: Vec<_> = low.into_iter().chain(high.into_iter().rev()).map(|p| (p[0], p[1])).collect();
    (outline.len() > 2).then_some(outline)
}

/// Clips a falling line to the vertical range `y`.
fn clipped([a, b]: [(f64, f64); 2], y: &Range<f64>, slope: f64) -> [(f64, f64); 2] {
    let onto = |(px, py): (f64, f64)| {
        let height = py.clamp(y.start, y.end);
        (px + (height - py) / slope, height)
    };
    [onto(a), onto(b)]
}

/// Returns a range of logarithms that contains `values`, at least half a decade.
fn span(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let pad = (0.25 - 0.5 * (high - low)).max(0.06 * (high - low));
    low - pad..high + pad
}

/// Returns the label positions: 1, 2 and 5 times powers of ten on short axes, powers of ten on long ones. Their number
/// is bounded.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.end - range.start;
    let step = (decades / 6.0).ceil().max(1.0) as i32;
    let parts: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let powers = (range.start.floor() as i32..=range.end.ceil() as i32).filter(|k| k.rem_euclid(step) == 0);
    let all = powers.flat_map(|k| parts.iter().map(move |p| f64::from(k) + p.log10()));
    all.filter(|t| range.contains(t)).collect()
}

/// Formats the number with the logarithm `log`.
#[allow(clippy::trivially_copy_pass_by_ref)] // as plotters wants it
fn label(log: &f64) -> String {
    let (power, value) = (log.floor() as i32, 10_f64.powf(*log));
    if (-2..4).contains(&power) { format!("{}", (value * 1e4).round() / 1e4) } else { format!("{value:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short_and_right() {
        for (value, text) in [(1.0, "1"), (0.05, "0.05"), (200.0, "200"), (0.002, "2e-3"), (5e4, "5e4"), (0.01, "0.01")]
        {
            assert_eq!(label(&f64::log10(value)), text);
        }
    }

    #[test]
    fn ticks_lie_in_the_range_and_are_neither_none_nor_many() {
        for (low, high) in [(0.3, 0.9), (1e-3, 2e-3), (1e-7, 1.0), (1.0, 1e20), (4.0, 4.0)] {
            let range = span([f64::log10(low), f64::log10(high)].into_iter());
            let ticks = ticks(&range);
            assert!((1..=8).contains(&ticks.len()), "{low} {high}: {ticks:?}");
            assert!(ticks.iter().all(|t| range.contains(t)));
        }
    }

    #[test]
    fn plots_take_all_colours_from_css() {
        let series = [Series {
            label: "a".into(),
            hue: 9,
            dash: 5,
            curve: vec![[1.0, 1.0], [8.0, 0.1]],
            band: vec![[0.9, 1.1], [0.0, 0.2]],
        }];
        let svg = Plot { title: "t", x: "x", y: "y", series: &series, guide: Some(-1.0) }.draw().into_string();
        let css = css();
        for part in svg.split("=\"#").skip(1) {
            assert!(css.contains(&format!("fill=\"#{}\"", &part[..6])), "#{}", &part[..6]);
        }
        assert!(svg.contains("#0A0101") && svg.contains("<circle"), "{svg}");
    }

    #[test]
    fn a_plot_of_nothing_is_still_a_page() {
        let series = [Series { label: "a".into(), hue: 0, dash: 0, curve: vec![[-1.0, f64::NAN]], band: Vec::new() }];
        let plot = Plot { title: "t", x: "x", y: "y", series: &series, guide: Some(-1.0) };
        assert!(plot.draw().into_string().contains("svg"));
    }
}
