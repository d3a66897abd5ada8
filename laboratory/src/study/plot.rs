//! Charts, and what other pictures have in common with them.

use std::ops::Range;
use std::sync::LazyLock;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use serde::Deserialize;

use super::{StudyError, extremes};

/// Of all texts.
pub const FONT: &str = "sans-serif";

/// Colours by meaning, the same in all pictures of the book. They stay apart for the colour-blind.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Colours {
    pub facets: Colour,
    /// The surface of nodes, by the cubic weight and nodal domains.
    pub smooth: Colour,
    pub faces: Colour,
    pub interpolating: Colour,
    pub hull_layers: Colour,
    pub automatic_penalty: Colour,
    pub other: Colour,
}

/// Those of the table that the scripts beside it read, too.
pub static COLOURS: LazyLock<Colours> = LazyLock::new(|| {
    let table = include_str!("../../../docs/results/pictures/colours.json");
    serde_json::from_str(table).expect("the table of colours is sound")
});

/// Red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Colour(RGBColor);

impl TryFrom<String> for Colour {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let number = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        let number = number.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let [_, red, green, blue] = number.ok_or_else(|| format!("{text} is no colour"))?.to_be_bytes();
        Ok(Self(RGBColor(red, green, blue)))
    }
}

impl Colour {
    /// A line of it, so many pixels wide.
    pub fn line(self, width: u32) -> ShapeStyle {
        self.0.stroke_width(width)
    }
}

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Why it cannot be drawn.
pub type Failure<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

/// What a curve is drawn as.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    Line,
    Dashes,
    /// Short dashes, with its points.
    PointsDotted,
    PointsDashed,
    /// A line with its points.
    Points,
    /// Points alone.
    Dots,
    /// Hollow points alone.
    Rings,
}

impl Mark {
    /// Length of dashes and of what is between them, pixels.
    const fn dashes(self) -> Option<[i32; 2]> {
        match self {
            Self::Dashes | Self::PointsDashed => Some([9, 5]),
            Self::PointsDotted => Some([2, 4]),
            Self::Line | Self::Points | Self::Dots | Self::Rings => None,
        }
    }

    const fn has_line(self) -> bool {
        !matches!(self, Self::Dots | Self::Rings)
    }

    const fn has_points(self) -> bool {
        !matches!(self, Self::Line | Self::Dashes)
    }
}

/// A curve with its place in the legend.
pub struct Curve {
    /// In the legend; none without.
    pub label: String,
    pub style: ShapeStyle,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    pub fn new(
        label: impl Into<String>,
        colour: Colour,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self { label: label.into(), style: colour.line(2), mark, points: points.into_iter().collect() }
    }

    /// With another width of its line.
    pub fn wide(mut self, width: u32) -> Self {
        self.style.stroke_width = width;
        self
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
    /// With ticks at whole numbers only.
    Counts(Range<f64>),
    /// With ticks at powers of ten.
    Log(Range<f64>),
}

impl Scale {
    /// From one power of ten to another; all values are positive.
    pub fn decades([low, high]: [f64; 2]) -> Self {
        // A little more, for rounding not to leave out the ticks at the ends.
        Self::Log(0.999 * 10_f64.powf(low.log10().floor())..1.001 * 10_f64.powf(high.log10().ceil()))
    }
}

/// Curves over one axis.
pub struct Chart {
    pub title: String,
    /// What runs to the right and what runs up.
    pub axes: [&'static str; 2],
    /// Linear, or counts.
    pub x_range: Scale,
    pub y_range: Scale,
    pub curves: Vec<Curve>,
    /// Pixels for the legend, which is at the right of the curves; none without.
    pub legend: u32,
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

/// A number with the sign that is as wide as a plus, and no more digits than it has.
fn number(x: f64) -> String {
    let text = format!("{:.6}", x + 0.0);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

/// A power of ten; nothing for other numbers.
fn power(x: f64) -> String {
    let exponent = x.log10().round();
    if (x / 10_f64.powf(exponent) - 1.0).abs() > 1e-6 {
        return String::new();
    }
    let raised = |digit| match digit {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize - '0' as usize],
    };
    match exponent as i32 {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        exponent => std::iter::once("10".to_owned())
            .chain([exponent.to_string().chars().map(raised).collect()])
            .collect(),
    }
}

/// How many ticks an axis of counts may have: one for each at most.
fn most(range: &Range<f64>) -> usize {
    ((range.end - range.start) as usize + 1).min(MOST_TICKS)
}

const MOST_TICKS: usize = 11;
/// Of texts in a chart, and of its title.
const SIZE: u32 = 17;
pub const TITLE: u32 = 20;
/// Between lines of a legend, and of one entry.
const ENTRY: i32 = 27;
const LINE: i32 = 19;

impl Chart {
    fn draw<'a>(&self, area: &Area<'a>) -> Result<(), Failure<'a>> {
        let width = area.dim_in_pixel().0;
        let (area, side) = area.split_horizontally(width - self.legend);
        let ticks = |scale: &Scale| match scale {
            Scale::Counts(range) => most(range),
            Scale::Linear(_) | Scale::Log(_) => MOST_TICKS,
        };
        match &self.y_range {
            Scale::Linear(range) | Scale::Counts(range) => {
                self.over(&area, range.clone(), ticks(&self.y_range), &number)?;
            }
            Scale::Log(range) => self.over(&area, range.clone().log_scale(), MOST_TICKS, &power)?,
        }
        if self.legend > 0 { self.explain(&side) } else { Ok(()) }
    }

    /// Draws it over an axis, its numbers written by `number_up`.
    fn over<'a, Y>(
        &self,
        area: &Area<'a>,
        y: Y,
        ticks: usize,
        number_up: &dyn Fn(f64) -> String,
    ) -> Result<(), Failure<'a>>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let (x, across) = match &self.x_range {
            Scale::Counts(range) => (range.clone(), most(range)),
            Scale::Linear(range) | Scale::Log(range) => (range.clone(), MOST_TICKS),
        };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, TITLE))
            .margin(12)
            .margin_right(24)
            .x_label_area_size(52)
            .y_label_area_size(self.left)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_labels(across)
            .y_labels(ticks)
            .x_label_formatter(&|x| number(*x))
            .y_label_formatter(&|y| number_up(*y))
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .label_style((FONT, SIZE))
            .axis_desc_style((FONT, SIZE))
            .draw()?;
        for &Curve { style, mark, ref points, .. } in &self.curves {
            if let Some([dash, gap]) = mark.dashes() {
                chart.draw_series(DashedLineSeries::new(points.iter().copied(), dash, gap, style))?;
            } else if mark.has_line() {
                chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
            }
            if mark.has_points() {
                let style = marker(style, mark);
                chart.draw_series(points.iter().map(|&point| Circle::new(point, 3, style)))?;
            }
        }
        Ok(())
    }

    /// Draws the legend.
    fn explain<'a>(&self, area: &Area<'a>) -> Result<(), Failure<'a>> {
        let (left, right, mut y) = (2, 38, 48);
        for Curve { label, style, mark, .. } in self.curves.iter().filter(|curve| !curve.label.is_empty()) {
            if let Some([dash, gap]) = mark.dashes() {
                let line = [(left, y), (right, y)];
                area.draw(&DashedPathElement::new(line, dash, gap, *style))?;
            } else if mark.has_line() {
                area.draw(&PathElement::new([(left, y), (right, y)], *style))?;
            }
            if mark.has_points() {
                area.draw(&Circle::new((i32::midpoint(left, right), y), 3, marker(*style, *mark)))?;
            }
            for (k, line) in (0..).zip(label.lines()) {
                area.draw(&Text::new(line, (right + 8, y - 7 + k * LINE), (FONT, SIZE)))?;
            }
            y += ENTRY + LINE * (label.lines().count() as i32 - 1);
        }
        Ok(())
    }
}

/// What points of a curve are drawn with.
fn marker(style: ShapeStyle, mark: Mark) -> ShapeStyle {
    if mark == Mark::Rings { style } else { style.filled() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!([-2.0, 0.0, -0.0, 1850.0, 0.1 + 0.2].map(number), ["−2", "0", "0", "1850", "0.3"]);
        assert_eq!([1e-12, 1.0, 10.0, 1e3, 2e3].map(power), ["10⁻¹²", "1", "10", "10³", ""]);
        assert_eq!([0.0..3.4, 1.0..40.0].map(|range| most(&range)), [4, MOST_TICKS]);
    }

    #[test]
    fn colours_are_those_of_the_table() {
        assert_eq!(COLOURS.facets, Colour(RGBColor(0xd5, 0x5e, 0x00)));
        assert!(
            ["#12345", "123456", "#12345g"].iter().all(|text| Colour::try_from((*text).to_owned()).is_err())
        );
    }
}
