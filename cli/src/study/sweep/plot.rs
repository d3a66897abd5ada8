//! Gap and force over a stretch of the path, as a picture.

use plotters::prelude::*;

use super::run::{Curve, State, dot, norm};
use super::scene::DEPTH;
use crate::study::StudyError;

/// Size of the picture.
const SIZE: (u32, u32) = (960, 720);
/// Length of the stretch that is shown, cells: short enough to tell one facet from the next.
const STRETCH: f64 = 20.0;
const FONT: &str = "sans-serif";

/// One curve of the picture.
pub struct Line<'a> {
    /// What it is called in the legend.
    pub label: &'static str,
    /// Its colour.
    pub colour: RGBColor,
    /// The numbers.
    pub curve: &'a Curve,
}

/// The picture as SVG.
pub fn draw(lines: &[Line<'_>]) -> Result<String, StudyError> {
    let mut svg = String::new();
    let failed = |reason: String| StudyError::Plot { reason };
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(|error| failed(error.to_string()))?;
        let (upper, lower) = area.split_vertically(SIZE.1 / 2);
        let gap = |curve: &Curve| over_path(curve, |state, _| state.gap / DEPTH);
        let title = "Gap of a slave node swept at constant depth d below the exact surface";
        panel(&upper, title, "g / d", lines, &gap, Some(-1.0)).map_err(|error| failed(error.to_string()))?;
        // A frictionless surface does not push along it.
        let push = |curve: &Curve| over_path(curve, |state, along| 100.0 * dot(state.force, along) / DEPTH);
        let title = "Contact force along the path, which is tangent to the exact surface";
        panel(&lower, title, "F·t / (ε d) in %", lines, &push, Some(0.0))
            .map_err(|error| failed(error.to_string()))?;
        area.present().map_err(|error| failed(error.to_string()))?;
    }
    Ok(svg)
}

/// A quantity over the length of the path; it is given the direction of the path, too.
fn over_path(curve: &Curve, quantity: impl Fn(&State, [f64; 3]) -> f64) -> Vec<(f64, f64)> {
    let mut length = 0.0;
    let mut points = Vec::new();
    for pair in curve.states.windows(2) {
        let [state, next] = pair else { continue };
        let step: [f64; 3] = std::array::from_fn(|axis| next.position[axis] - state.position[axis]);
        let size = norm(step);
        points.push((length, quantity(state, step.map(|x| x / size))));
        length += size;
        if length > STRETCH {
            break;
        }
    }
    points
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Failure<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

fn panel<'a>(
    area: &Area<'a>,
    title: &str,
    quantity: &str,
    lines: &[Line<'_>],
    values: &dyn Fn(&Curve) -> Vec<(f64, f64)>,
    exact: Option<f64>,
) -> Result<(), Failure<'a>> {
    let data: Vec<Vec<(f64, f64)>> = lines.iter().map(|line| values(line.curve)).collect();
    let all = data.iter().flatten().map(|(_, value)| *value).chain(exact);
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    let margin = 0.05 * (high - low);
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 18))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..STRETCH, low - margin..high + margin)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.15))
        .x_desc("length of the path, in cells")
        .y_desc(quantity)
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 15))
        .draw()?;
    if let Some(exact) = exact {
        let style = BLACK.stroke_width(1);
        chart
            .draw_series(LineSeries::new([(0.0, exact), (STRETCH, exact)], style))?
            .label("exact")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    for (line, points) in lines.iter().zip(data) {
        let style = line.colour.stroke_width(2);
        chart
            .draw_series(LineSeries::new(points, style))?
            .label(line.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font((FONT, 14))
        .draw()
}
