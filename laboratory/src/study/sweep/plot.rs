//! Gap and force over a stretch of the path, as a picture.

use diffuse_contact::Point;
use plotters::prelude::*;

use super::run::{Curve, State, dot, norm};
use super::scene::DEPTH;
use crate::study::StudyError;
use crate::study::plot::{Area, FONT, Failure, builder, legend, svg};

/// Size of the picture.
const SIZE: (u32, u32) = (960, 720);
/// Length of the stretch that is shown: short enough to tell one facet from the next.
const STRETCH: f64 = 20.0;

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
    svg(SIZE, |area| {
        let (upper, lower) = area.split_vertically(SIZE.1 / 2);
        let gap = Panel {
            title: "Gap of a slave node swept at constant depth d below the exact surface",
            quantity: "g / d",
            value: &|state, _| state.gap / DEPTH,
            exact: -1.0,
            has_legend: true,
        };
        // A frictionless surface does not push along it.
        let push = Panel {
            title: "Contact force along the path, which is tangent to the exact surface",
            quantity: "F·t / (ε d) in %",
            value: &|state, along| 100.0 * dot(state.force, along) / DEPTH,
            exact: 0.0,
            has_legend: false,
        };
        gap.draw(&upper, lines)?;
        push.draw(&lower, lines)
    })
}

/// One half of the picture.
struct Panel<'a> {
    title: &'a str,
    quantity: &'a str,
    /// Of a state and the direction of the path.
    value: &'a dyn Fn(&State, Point) -> f64,
    /// What it is on the exact surface.
    exact: f64,
    has_legend: bool,
}

impl Panel<'_> {
    fn draw<'a>(&self, area: &Area<'a>, lines: &[Line<'_>]) -> Result<(), Failure<'a>> {
        let data: Vec<Vec<(f64, f64)>> = lines.iter().map(|line| self.points(line.curve)).collect();
        let all = data.iter().flatten().map(|(_, value)| *value).chain([self.exact]);
        let (low, high) =
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let margin = 0.05 * (high - low);
        // The legend has the upper part to itself.
        let headroom = if self.has_legend { 0.45 * (high - low) } else { margin };
        let mut chart =
            builder(area, self.title, 64).build_cartesian_2d(0.0..STRETCH, low - margin..high + headroom)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_desc("length of the path")
            .y_desc(self.quantity)
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .draw()?;
        let exact = vec![(0.0, self.exact), (STRETCH, self.exact)];
        let curves =
            lines.iter().zip(data).map(|(line, points)| (line.label, line.colour.stroke_width(2), points));
        for (label, style, points) in std::iter::once(("exact", BLACK.stroke_width(1), exact)).chain(curves) {
            let series = chart.draw_series(LineSeries::new(points, style))?;
            if self.has_legend {
                series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
        if self.has_legend {
            legend(&mut chart, SeriesLabelPosition::UpperRight)?;
        }
        Ok(())
    }

    /// The quantity over the length of the path.
    fn points(&self, curve: &Curve) -> Vec<(f64, f64)> {
        let mut length = 0.0;
        let mut points = Vec::new();
        for pair in curve.states.windows(2) {
            let [state, next] = pair else { continue };
            let step: Point = std::array::from_fn(|axis| next.position[axis] - state.position[axis]);
            let size = norm(step);
            points.push((length, (self.value)(state, step.map(|x| x / size))));
            length += size;
            if length > STRETCH {
                break;
            }
        }
        points
    }
}
