//! What pictures of all studies have in common.

use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;

use super::StudyError;

/// Of all texts.
pub const FONT: &str = "sans-serif";

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Why it cannot be drawn.
pub type Failure<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

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

/// A chart to be built, with so many pixels for the numbers at its left.
pub fn builder<'r, 'a>(area: &'r Area<'a>, title: &str, left: u32) -> ChartBuilder<'r, 'r, SVGBackend<'a>> {
    let mut builder = ChartBuilder::on(area);
    builder
        .caption(title, (FONT, 18))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(44)
        .y_label_area_size(left);
    builder
}

/// Draws the legend of a chart.
pub fn legend<'r, 'a: 'r, C: CoordTranslate>(
    chart: &mut ChartContext<'r, SVGBackend<'a>, C>,
    position: SeriesLabelPosition,
) -> Result<(), Failure<'a>> {
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font((FONT, 14))
        .draw()
}
