//! What methods cost against how wrong they are, as SVG: time across, error up, each method's name beside its marks.

use std::fmt::Debug;

use anyhow::{Result, anyhow, ensure};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde_json::{Value, json};

use super::labels::{Area, Labels};
use super::span::Span;
use super::{Chart, Scale};

/// Points of the SVG's own coordinate system; it scales to any size.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 560;
const LEGEND_WIDTH: u32 = 210;
const LEGEND_LINE: i32 = 26;
/// The height of the row in which zeros are drawn, below the logarithmic part.
const ZERO_ROW: i32 = 44;
/// A label's size, and what one of its letters takes in the mean.
const LABEL: u32 = 14;
const LETTER: f64 = 7.3;
/// Half the width of a mark.
const MARK: i32 = 5;

/// Of Okabe and Ito (2008), distinct in any colour vision.
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(0, 158, 115), RGBColor(120, 120, 120), RGBColor(213, 94, 0)];

/// A method: a name, a group whose colour it has, its time, and a value for each kind of mark.
#[derive(Clone, Debug)]
struct Method {
    name: String,
    group: usize,
    time: f64,
    values: Vec<f64>,
}

/// Time against error: both axes logarithmic, zeros in a row of their own below.
#[derive(Clone, Debug)]
pub struct TradeChart {
    id: String,
    title: String,
    x: String,
    y: String,
    groups: Vec<String>,
    marks: Vec<String>,
    methods: Vec<Method>,
}

impl TradeChart {
    /// A chart without methods. Its `id` names its files; `title` stands above it; the labels of time and error name
    /// their units. At most four `groups`, a colour each; at most three `marks`, a shape each.
    #[must_use]
    pub fn new<const G: usize, const M: usize>(
        id: impl Into<String>,
        title: impl Into<String>,
        [x, y]: [&str; 2],
        groups: [&str; G],
        marks: [&str; M],
    ) -> Self {
        const { assert!(G <= COLOURS.len() && M <= 3) };
        Self {
            id: id.into(),
            title: title.into(),
            x: x.to_owned(),
            y: y.to_owned(),
            groups: groups.map(str::to_owned).to_vec(),
            marks: marks.map(str::to_owned).to_vec(),
            methods: Vec::new(),
        }
    }

    /// Adds a method of a group: its time, and its value for each mark.
    ///
    /// # Errors
    /// A time that is not positive, a value that is negative, one that is not finite, another number of values
    /// than marks, no such group.
    pub fn push(&mut self, name: &str, group: usize, time: f64, values: &[f64]) -> Result<()> {
        ensure!(
            time > 0.0 && time.is_finite(),
            "chart `{}`, `{name}`: a time of {time:e}",
            self.id
        );
        for (&value, mark) in values.iter().zip(&self.marks) {
            let has_place = value >= 0.0 && value.is_finite();
            ensure!(has_place, "chart `{}`, `{name}`: {mark} is {value:e}", self.id);
        }
        let fits = values.len() == self.marks.len() && group < self.groups.len();
        ensure!(fits, "chart `{}`, `{name}`: {} values, group {group}", self.id, values.len());
        let method = Method { name: name.to_owned(), group, time, values: values.to_vec() };
        self.methods.push(method);
        Ok(())
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let canvas = SVGBackend::with_string(svg, (WIDTH, HEIGHT)).into_drawing_area();
        canvas.fill(&WHITE)?;
        let root = canvas.titled(&self.title, ("sans-serif", 19))?;
        let (plot, legend) = root.split_horizontally(WIDTH - LEGEND_WIDTH);
        let times = self.methods.iter().map(|method| method.time);
        let x = Span::over(Scale::Logarithmic, times.flat_map(|time| [time / 2.0, time * 2.0]));
        let values = self.methods.iter().flat_map(|method| method.values.iter().copied());
        let y = ZeroAndSpan(Span::over(Scale::Logarithmic, values.filter(|&value| value > 0.0)));
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
            .bold_line_style(RGBColor(232, 232, 232))
            .axis_style(RGBColor(110, 110, 110))
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_desc(&self.x)
            .y_desc(&self.y)
            .draw()?;
        // Marks and names stand at pixels of the whole canvas.
        let pixels = chart.plotting_area().get_pixel_range();
        let mut labels = Labels::within(Area {
            left: pixels.0.start,
            right: pixels.0.end,
            top: pixels.1.start,
            bottom: pixels.1.end,
        });
        let at = |time: f64, value: f64| chart.backend_coord(&(time, value));
        let mut tops = Vec::new();
        for method in &self.methods {
            let colour = COLOURS[method.group];
            let places: Vec<_> =
                method.values.iter().map(|&value| at(method.time, value)).collect();
            if let (Some(top), Some(bottom)) =
                (places.iter().min_by_key(|at| at.1), places.iter().max_by_key(|at| at.1))
            {
                canvas.draw(&PathElement::new([*top, *bottom], colour.mix(0.5).stroke_width(2)))?;
                labels
                    .keep_clear(Area::round(*top, MARK + 1).joined(Area::round(*bottom, MARK + 1)));
                tops.push((method, *top, *bottom));
            }
            for (kind, &place) in places.iter().enumerate() {
                draw_mark(&canvas, kind, place, colour)?;
            }
        }
        for (method, top, bottom) in tops {
            let width = (method.name.chars().count() as f64 * LETTER).ceil() as i32;
            let place = labels.place([top, bottom], (width, LABEL as i32));
            let colour = COLOURS[method.group];
            if let Some(from) = place.leader {
                canvas.draw(&PathElement::new(
                    [from, place.anchor],
                    colour.mix(0.4).stroke_width(1),
                ))?;
            }
            let style = ("sans-serif", LABEL).into_text_style(&canvas).color(&colour);
            let style = style.pos(Pos::new(HPos::Left, VPos::Top));
            canvas.draw(&Text::new(method.name.as_str(), place.corner, style))?;
        }
        self.draw_legend(&legend)?;
        root.present()?;
        Ok(())
    }

    fn draw_legend<D: DrawingBackend>(
        &self,
        area: &DrawingArea<D, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<D::ErrorType>> {
        let beside = Pos::new(HPos::Left, VPos::Center);
        let style = ("sans-serif", 14).into_text_style(area).pos(beside);
        let mut top = 24;
        for (kind, mark) in self.marks.iter().enumerate() {
            draw_mark(area, kind, (16, top), RGBColor(60, 60, 60))?;
            area.draw(&Text::new(mark.as_str(), (32, top), style.clone()))?;
            top += LEGEND_LINE;
        }
        top += LEGEND_LINE / 2;
        for (group, colour) in self.groups.iter().zip(COLOURS) {
            area.draw(&Rectangle::new([(10, top - 6), (22, top + 6)], colour.filled()))?;
            area.draw(&Text::new(group.as_str(), (32, top), style.clone()))?;
            top += LEGEND_LINE;
        }
        Ok(())
    }
}

impl Chart for TradeChart {
    fn id(&self) -> &str {
        &self.id
    }

    fn title(&self) -> &str {
        &self.title
    }

    fn to_json(&self) -> Value {
        let method = |method: &Method| {
            let values: serde_json::Map<String, Value> = self
                .marks
                .iter()
                .cloned()
                .zip(method.values.iter().map(|&value| value.into()))
                .collect();
            json!({ "name": method.name, "group": self.groups[method.group], "time": method.time, "values": values })
        };
        let methods: Vec<Value> = self.methods.iter().map(method).collect();
        json!({ "title": self.title, "x": self.x, "y": self.y, "methods": methods })
    }

    fn to_svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|error| anyhow!("chart `{}`: {error}", self.id))?;
        Ok(svg)
    }
}

/// The first kind of mark is a filled disc, the second an open ring, the third a bar.
fn draw_mark<D: DrawingBackend>(
    area: &DrawingArea<D, plotters::coord::Shift>,
    kind: usize,
    (x, y): (i32, i32),
    colour: RGBColor,
) -> Result<(), DrawingAreaErrorKind<D::ErrorType>> {
    match kind {
        0 => area.draw(&Circle::new((x, y), MARK, colour.filled())),
        1 => area.draw(&Circle::new((x, y), MARK + 1, colour.stroke_width(2))),
        _ => {
            let ends = [(x - MARK - 2, y), (x + MARK + 2, y)];
            area.draw(&PathElement::new(ends, colour.stroke_width(3)))
        }
    }
}

/// A logarithmic axis above a row for zero.
#[derive(Clone, Debug)]
struct ZeroAndSpan(Span);

impl Ranged for ZeroAndSpan {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// The lower end is the first of the limits: pixels grow downwards.
    fn map(&self, value: &f64, (bottom, top): (i32, i32)) -> i32 {
        let up = (top - bottom).signum();
        if *value > 0.0 {
            self.0.map(value, (bottom + up * ZERO_ROW, top))
        } else {
            bottom + up * ZERO_ROW / 3
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let mut points = self.0.key_points(hint);
        points.insert(0, 0.0);
        points
    }

    fn range(&self) -> std::ops::Range<f64> {
        0.0..self.0.range().end
    }
}

impl ValueFormatter<f64> for ZeroAndSpan {
    fn format_ext(&self, value: &f64) -> String {
        if *value == 0.0 { "0".to_owned() } else { self.0.format_ext(value) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> TradeChart {
        let groups = ["packets", "one by one"];
        TradeChart::new(
            "trade",
            "Time against error",
            ["time [ns]", "wrong [%]"],
            groups,
            ["wrong", "open"],
        )
    }

    #[test]
    fn every_method_is_named_where_it_stands_and_zero_is_zero() -> Result<()> {
        let mut chart = chart();
        chart.push("certified", 0, 35.0, &[0.0, 0.0])?;
        chart.push("f32 < f64", 1, 600.0, &[0.1, 44.0])?;
        let svg = chart.to_svg()?;
        for text in ["certified", "f32 &lt; f64", "time [ns]", "wrong [%]", "open", "one by one"] {
            assert!(svg.contains(text), "{text}");
        }
        let at = |value: f64| {
            ZeroAndSpan(Span::over(Scale::Logarithmic, [0.1, 44.0].into_iter()))
                .map(&value, (400, 0))
        };
        assert!(at(0.0) > at(0.1) + MARK && at(0.1) > at(44.0));
        assert_eq!(chart.to_json()["methods"][0]["values"]["wrong"], json!(0.0));
        Ok(())
    }

    #[test]
    fn what_has_no_place_is_refused() {
        let mut chart = chart();
        assert!(chart.push("a", 0, 0.0, &[0.0, 0.0]).is_err());
        assert!(chart.push("a", 0, 1.0, &[-1.0, 0.0]).is_err());
        assert!(chart.push("a", 0, 1.0, &[f64::NAN, 0.0]).is_err());
        assert!(chart.push("a", 0, 1.0, &[0.0]).is_err());
        assert!(chart.push("a", 2, 1.0, &[0.0, 0.0]).is_err());
        assert!(chart.to_svg().is_ok());
    }
}
