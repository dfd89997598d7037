//! Charts as SVG: lines over linear or logarithmic axes, published ones dashed; and what methods cost against how
//! wrong they are ([`TradeChart`]).

mod labels;
mod span;
mod trade;

use anyhow::{Result, anyhow, ensure};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde_json::{Value, json};

use crate::table::Origin;
use span::Span;
pub use trade::TradeChart;

/// What a report shows as a picture.
pub trait Chart: std::fmt::Debug {
    /// The name of its files.
    fn id(&self) -> &str;
    /// What stands above it.
    fn title(&self) -> &str;
    /// All that it shows.
    fn to_json(&self) -> Value;
    /// The chart as an SVG document.
    ///
    /// # Errors
    /// What the drawing library refuses.
    fn to_svg(&self) -> Result<String>;
}

/// Points of the SVG's own coordinate system; it scales to any size.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;
/// The legend stands beside the chart, so that it never hides a line.
const LEGEND_WIDTH: u32 = 230;
const LEGEND_LINE: i32 = 24;

/// Colours of Okabe and Ito (2008), distinct in any colour vision, without their yellow, which is
/// too pale for a line; then a brown for charts with many series.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
    RGBColor(148, 103, 70),
];

/// How an axis spaces its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly, from zero.
    Linear,
    /// By their logarithm; only positive values have a place on it.
    Logarithmic,
}

/// What an axis shows.
#[derive(Clone, Debug)]
pub struct Axis {
    label: String,
    scale: Scale,
}

/// Points under one name, joined by a line.
#[derive(Clone, Debug)]
pub struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    origin: Origin,
}

/// A line chart.
#[derive(Clone, Debug)]
pub struct Figure {
    id: String,
    title: String,
    axes: [Axis; 2],
    series: Vec<Series>,
}

impl Axis {
    /// An axis that starts at zero. The label names the quantity and its unit.
    #[must_use]
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// A logarithmic axis.
    #[must_use]
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Logarithmic }
    }
}

impl Series {
    /// What we measured.
    #[must_use]
    pub fn measured(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.into(), points, origin: Origin::Measured }
    }

    /// What the paper prints: dashed, in the colour of the measured series of the same name.
    #[must_use]
    pub fn published(
        name: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { origin: Origin::Published, ..Self::measured(name, points) }
    }

    fn legend(&self) -> String {
        let origin = if self.origin == Origin::Published { " (paper)" } else { "" };
        format!("{}{origin}", self.name)
    }
}

impl Figure {
    /// A chart without series. Its `id` names its files; `title` stands above it.
    #[must_use]
    pub fn new(id: impl Into<String>, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { id: id.into(), title: title.into(), axes: [x, y], series: Vec::new() }
    }

    /// Adds a series.
    ///
    /// # Errors
    /// A point that is not finite, or not positive on a logarithmic axis.
    pub fn push(&mut self, series: Series) -> Result<()> {
        for (index, &(x, y)) in series.points.iter().enumerate() {
            for (axis, value) in self.axes.iter().zip([x, y]) {
                let has_place = value.is_finite() && (axis.scale == Scale::Linear || value > 0.0);
                ensure!(
                    has_place,
                    "figure `{}`, series `{}`, point {index}: {value} has no place on the axis `{}`",
                    self.id,
                    series.name,
                    axis.label
                );
            }
        }
        self.series.push(series);
        Ok(())
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let root = SVGBackend::with_string(svg, (WIDTH, HEIGHT)).into_drawing_area();
        root.fill(&WHITE)?;
        let root = root.titled(&self.title, ("sans-serif", 19))?;
        let (plot, legend) = root.split_horizontally(WIDTH - LEGEND_WIDTH);
        let [x, y] = [0, 1].map(|axis| self.range(axis));
        let mut chart = ChartBuilder::on(&plot)
            .margin(12)
            .x_label_area_size(48)
            .y_label_area_size(76)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .x_labels(10)
            .y_labels(10)
            .max_light_lines(0)
            .bold_line_style(RGBColor(226, 226, 226))
            .axis_style(RGBColor(110, 110, 110))
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_desc(&self.axes[0].label)
            .y_desc(&self.axes[1].label)
            .draw()?;

        for (index, series) in self.series.iter().enumerate() {
            let colour = self.colour(index);
            let points = series.points.iter().copied();
            match series.origin {
                Origin::Measured => {
                    chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
                    chart.draw_series(points.map(|at| Circle::new(at, 3, colour.filled())))?;
                }
                Origin::Published => {
                    let line = colour.stroke_width(2);
                    chart.draw_series(DashedLineSeries::new(points.clone(), 7, 5, line))?;
                    chart.draw_series(points.map(|at| Circle::new(at, 4, colour)))?;
                }
            }
            let top = 24 + LEGEND_LINE * i32::try_from(index)?;
            legend_line(&legend, top, series.origin, colour)?;
            let beside = Pos::new(HPos::Left, VPos::Center);
            let style = ("sans-serif", 14).into_text_style(&legend).pos(beside);
            legend.draw(&Text::new(series.legend(), (48, top), style))?;
        }
        root.present()?;
        Ok(())
    }

    /// The next free colour, or that of the measured series of the same name.
    fn colour(&self, index: usize) -> RGBColor {
        let own = &self.series[index];
        let first = self.series.iter().position(|series| series.name == own.name);
        let first = first.unwrap_or(index);
        let names_before =
            (0..first).filter(|&k| !self.series[..k].iter().any(|s| s.name == self.series[k].name));
        COLOURS[names_before.count() % COLOURS.len()]
    }

    /// The range of an axis that shows all points.
    fn range(&self, axis: usize) -> Span {
        let values = self.series.iter().flat_map(|series| &series.points);
        let values = values.map(|&(x, y)| [x, y][axis]);
        Span::over(self.axes[axis].scale, values)
    }
}

impl Chart for Figure {
    fn id(&self) -> &str {
        &self.id
    }

    fn title(&self) -> &str {
        &self.title
    }

    fn to_json(&self) -> Value {
        let [x, y] = &self.axes;
        let series: Vec<Value> = self
            .series
            .iter()
            .map(|series| json!({ "name": series.legend(), "points": series.points }))
            .collect();
        json!({ "title": self.title, "x": x.label, "y": y.label, "series": series })
    }

    fn to_svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|error| anyhow!("figure `{}`: {error}", self.id))?;
        Ok(svg)
    }
}

fn legend_line<D: DrawingBackend>(
    area: &DrawingArea<D, plotters::coord::Shift>,
    top: i32,
    origin: Origin,
    colour: RGBColor,
) -> Result<(), DrawingAreaErrorKind<D::ErrorType>> {
    let pieces: &[(i32, i32)] = match origin {
        Origin::Measured => &[(8, 40)],
        Origin::Published => &[(8, 15), (20, 27), (32, 39)],
    };
    for &(from, to) in pieces {
        area.draw(&PathElement::new([(from, top), (to, top)], colour.stroke_width(2)))?;
    }
    match origin {
        Origin::Measured => area.draw(&Circle::new((24, top), 3, colour.filled())),
        Origin::Published => area.draw(&Circle::new((24, top), 4, colour)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runtimes(y: Axis) -> Result<Figure> {
        let mut figure = Figure::new("fig1", "Runtime", Axis::logarithmic("objects N"), y);
        figure.push(Series::measured("tree", [(10.0, 0.2), (100.0, 3.0), (1000.0, 50.0)]))?;
        figure.push(Series::measured("brute force < all", [(10.0, 0.1), (1000.0, 900.0)]))?;
        figure.push(Series::published("tree", [(10.0, 0.4), (1000.0, 70.0)]))?;
        Ok(figure)
    }

    #[test]
    fn the_svg_names_axes_ticks_and_series_as_text() -> Result<()> {
        for y in [Axis::linear("time [ms]"), Axis::logarithmic("time [ms]")] {
            let svg = runtimes(y)?.to_svg()?;
            assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
            let texts = ["time [ms]", "objects N", "brute force &lt; all", "tree (paper)", "1,000"];
            for text in texts {
                assert!(svg.contains(text), "{text}");
            }
        }
        Ok(())
    }

    #[test]
    fn a_published_series_shares_the_colour_of_ours() -> Result<()> {
        let figure = runtimes(Axis::linear("ms"))?;
        let colours = [0, 1, 2].map(|index| figure.colour(index));
        assert_eq!(colours, [COLOURS[0], COLOURS[1], COLOURS[0]]);
        Ok(())
    }

    #[test]
    fn a_point_without_a_place_is_refused_with_its_index() -> Result<()> {
        let mut figure = runtimes(Axis::logarithmic("time"))?;
        let zero = figure.push(Series::measured("zero", [(1.0, 1.0), (1.0, 0.0)]));
        let message = zero.map_err(|error| error.to_string());
        let expected = "figure `fig1`, series `zero`, point 1: 0 has no place on the axis `time`";
        assert_eq!(message, Err(expected.to_owned()));
        assert!(figure.push(Series::measured("nan", [(f64::NAN, 1.0)])).is_err());
        Ok(())
    }

    #[test]
    fn a_figure_without_points_and_one_of_one_point_are_drawn() -> Result<()> {
        let empty = || Figure::new("f", "", Axis::linear("x"), Axis::logarithmic("y"));
        assert!(empty().to_svg()?.contains("</svg>"));
        let mut one = empty();
        one.push(Series::measured("one", [(0.0, 1.0)]))?;
        assert!(one.to_svg()?.contains("<circle"));
        Ok(())
    }
}
