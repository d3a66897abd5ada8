//! Charts, and what other pictures have in common with them.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use super::{StudyError, extremes};

/// Of all texts.
pub const FONT: &str = "sans-serif";

/// Colours that stay apart for the colour-blind.
pub const COLOURS: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Why it cannot be drawn.
pub type Failure<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

/// What a curve is drawn as.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    Line,
    /// A line with its points.
    Points,
    /// Points alone.
    Dots,
}

/// A curve with its place in the legend.
pub struct Curve {
    pub label: String,
    pub style: ShapeStyle,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    pub fn new(
        label: impl Into<String>,
        colour: RGBColor,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let style = if mark == Mark::Dots { colour.filled() } else { colour.stroke_width(2) };
        Self { label: label.into(), style, mark, points: points.into_iter().collect() }
    }
}

/// Smallest and largest x and y of curves.
pub fn ranges(curves: &[Curve]) -> [[f64; 2]; 2] {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    [extremes(points().map(|point| point.0)), extremes(points().map(|point| point.1))]
}

/// What an axis covers, and how.
pub enum Scale {
    Linear(Range<f64>),
    /// With numbers as short as they can be.
    Counts(Range<f64>),
    Log(Range<f64>),
}

/// Curves over one axis.
pub struct Chart {
    pub title: String,
    /// What runs to the right and what runs up.
    pub axes: [&'static str; 2],
    pub x_range: Range<f64>,
    pub y_range: Scale,
    pub curves: Vec<Curve>,
    /// Where the curves leave room.
    pub legend: Option<SeriesLabelPosition>,
    /// Pixels for the numbers at the left.
    pub left: u32,
}

/// Charts one above the other, as SVG.
pub fn svg_of(charts: &[Chart], size: (u32, u32)) -> Result<String, StudyError> {
    svg(size, |area| {
        let parts = area.split_evenly((charts.len(), 1));
        charts.iter().zip(&parts).try_for_each(|(chart, part)| chart.draw(part))
    })
}

/// A picture on white, as SVG.
pub fn svg(
    size: (u32, u32),
    draw: impl for<'a> FnOnce(&Area<'a>) -> Result<(), Failure<'a>>,
) -> Result<String, StudyError> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE)
            .and_then(|()| draw(&area))
            .and_then(|()| area.present())
            .map_err(|error| StudyError::Plot { reason: error.to_string() })?;
    }
    Ok(svg)
}

impl Chart {
    fn draw<'a>(&self, area: &Area<'a>) -> Result<(), Failure<'a>> {
        match &self.y_range {
            Scale::Linear(range) => self.over(area, range.clone(), None),
            Scale::Counts(range) => self.over(area, range.clone(), Some(&|y| y.to_string())),
            Scale::Log(range) => self.over(area, range.clone().log_scale(), Some(&|y| format!("{y:.0e}"))),
        }
    }

    /// Draws it over an axis, its numbers written as usual or by `number`.
    fn over<'a, Y>(
        &self,
        area: &Area<'a>,
        y: Y,
        number: Option<&dyn Fn(&f64) -> String>,
    ) -> Result<(), Failure<'a>>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 18))
            .margin(12)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(self.left)
            .build_cartesian_2d(self.x_range.clone(), y)?;
        let mut mesh = chart.configure_mesh();
        if let Some(number) = number {
            mesh.y_label_formatter(number);
        }
        mesh.light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .draw()?;
        for &Curve { ref label, style, mark, ref points } in &self.curves {
            let points = points.iter().copied();
            if mark == Mark::Dots {
                let series = chart.draw_series(points.map(|point| Circle::new(point, 3, style)))?;
                series.label(label).legend(move |(x, y)| Circle::new((x + 10, y), 3, style));
            } else {
                let size = if mark == Mark::Points { 3 } else { 0 };
                let series = chart.draw_series(LineSeries::new(points, style).point_size(size))?;
                series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
        let Some(position) = self.legend.clone() else { return Ok(()) };
        chart
            .configure_series_labels()
            .position(position)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font((FONT, 14))
            .draw()
    }
}
