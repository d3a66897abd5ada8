//! Charts one above the other, as SVG.

use plotters::prelude::*;

use crate::study::StudyError;
use crate::study::plot::{Area, FONT, Failure, builder, legend, svg};

/// Width, and height of a chart.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 360;

/// A chart of several curves.
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// What runs to the right.
    pub abscissa: &'static str,
    /// What runs up.
    pub ordinate: &'static str,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A curve with its place in the legend.
pub struct Curve {
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: RGBColor,
    /// Dots, not a line.
    pub dotted: bool,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

/// The picture as SVG.
pub fn draw(charts: &[Chart]) -> Result<String, StudyError> {
    svg((WIDTH, HEIGHT * charts.len() as u32), |area| {
        let parts = area.split_evenly((charts.len(), 1));
        charts.iter().zip(&parts).try_for_each(|(chart, part)| chart.draw(part))
    })
}

impl Chart {
    fn draw<'a>(&self, area: &Area<'a>) -> Result<(), Failure<'a>> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let [left, right] = range(points().map(|point| point.0));
        let [low, high] = range(points().map(|point| point.1));
        let margin = 0.06 * (high - low);
        // The legend has the upper part to itself.
        let headroom = 0.12 * self.curves.len() as f64 * (high - low);
        let mut chart =
            builder(area, &self.title, 78).build_cartesian_2d(left..right, low - margin..high + headroom)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(self.abscissa)
            .y_desc(self.ordinate)
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .draw()?;
        for curve in &self.curves {
            let colour = curve.colour;
            if curve.dotted {
                let dots = curve.points.iter().map(|&point| Circle::new(point, 3, colour.filled()));
                let series = chart.draw_series(dots)?;
                series.label(&curve.label).legend(move |(x, y)| Circle::new((x + 10, y), 3, colour.filled()));
            } else {
                let style = colour.stroke_width(2);
                let series = chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
                series
                    .label(&curve.label)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)
    }
}

/// Smallest and largest; some range for no values or equal ones.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    match high - low {
        width if width > 0.0 => [low, high],
        0.0 => [low - 0.5, high + 0.5],
        _ => [0.0, 1.0],
    }
}
