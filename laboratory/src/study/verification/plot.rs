//! Charts one above the other, as SVG.

use crate::study::StudyError;
use crate::study::plot::{self, Chart, Curve, Scale, ranges};

/// Width, and height of a chart.
const WIDTH: u32 = 1000;
const HEIGHT: u32 = 360;
/// Of that, for the legend.
const LEGEND: u32 = 236;

/// The picture as SVG.
pub fn draw(charts: &[Chart]) -> Result<String, StudyError> {
    plot::svg_of(charts, (WIDTH, HEIGHT * charts.len() as u32))
}

/// A chart with its legend.
pub fn chart(title: impl Into<String>, axes: [&'static str; 2], curves: Vec<Curve>) -> Chart {
    let [[left, right], [low, high]] = ranges(&curves).map(widened);
    let margin = 0.06 * (high - low);
    Chart {
        title: title.into(),
        axes,
        x_range: Scale::Linear(left..right),
        y_range: Scale::Linear(low - margin..high + margin),
        curves,
        legend: LEGEND,
        left: 78,
    }
}

/// One whose y is positive and logarithmic. What is below `least` is drawn there.
pub fn decades(
    title: impl Into<String>,
    axes: [&'static str; 2],
    least: f64,
    mut curves: Vec<Curve>,
) -> Chart {
    for (_, y) in curves.iter_mut().flat_map(|curve| &mut curve.points) {
        *y = y.max(least);
    }
    let y_range = Scale::decades(widened(ranges(&curves)[1]));
    Chart { y_range, ..chart(title, axes, curves) }
}

/// Some range for no values or equal ones.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    match high - low {
        width if width > 0.0 => [low, high],
        0.0 => [low - 0.5, high + 0.5],
        _ => [0.0, 1.0],
    }
}
