//! Charts one above the other, as SVG.

use plotters::prelude::SeriesLabelPosition;

use crate::study::StudyError;
use crate::study::plot::{self, Chart, Curve, Scale, ranges};

/// Width, and height of a chart.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 360;

/// The picture as SVG.
pub fn draw(charts: &[Chart]) -> Result<String, StudyError> {
    plot::svg_of(charts, (WIDTH, HEIGHT * charts.len() as u32))
}

/// A chart with its legend.
pub fn chart(title: impl Into<String>, axes: [&'static str; 2], curves: Vec<Curve>) -> Chart {
    let [[left, right], [low, high]] = ranges(&curves).map(widened);
    let margin = 0.06 * (high - low);
    // The legend has the upper part to itself.
    let headroom = 0.12 * curves.len() as f64 * (high - low);
    Chart {
        title: title.into(),
        axes,
        x_range: left..right,
        y_range: Scale::Linear(low - margin..high + headroom),
        curves,
        legend: Some(SeriesLabelPosition::UpperRight),
        left: 78,
    }
}

/// Some range for no values or equal ones.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    match high - low {
        width if width > 0.0 => [low, high],
        0.0 => [low - 0.5, high + 0.5],
        _ => [0.0, 1.0],
    }
}
