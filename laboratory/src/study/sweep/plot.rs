//! Gap and force over a stretch of the path, as a picture.

use diffuse_contact::Point;
use plotters::prelude::*;

use super::run::{self, State};
use super::scene::DEPTH;
use crate::study::plot::{COLOURS, Chart, Curve, Mark, Scale, ranges, svg_of};
use crate::study::{StudyError, dot, norm};

/// Size of the picture.
const SIZE: (u32, u32) = (960, 720);
/// Length of the stretch that is shown: short enough to tell one facet from the next.
const STRETCH: f64 = 20.0;

/// The picture of named curves as SVG.
pub fn draw(named: &[(&str, &run::Curve)]) -> Result<String, StudyError> {
    let gap = ["Gap of a slave node swept at constant depth d below the exact surface", "g / d"];
    let legend = SeriesLabelPosition::UpperRight;
    let gap = chart(named, gap, -1.0, |state, _| state.gap / DEPTH, Some(legend));
    // A frictionless surface does not push along it.
    let push = ["Contact force along the path, which is tangent to the exact surface", "F·t / (ε d) in %"];
    let push = chart(named, push, 0.0, |state, along| 100.0 * dot(state.force, along) / DEPTH, None);
    svg_of(&[gap, push], SIZE)
}

/// One half of the picture. `exact`: what the value, of a state and the direction of the path, is on the exact surface.
fn chart(
    named: &[(&str, &run::Curve)],
    [title, quantity]: [&'static str; 2],
    exact: f64,
    value: impl Fn(&State, Point) -> f64,
    legend: Option<SeriesLabelPosition>,
) -> Chart {
    let line = Curve::new("exact", BLACK, Mark::Line, [0.0, STRETCH].map(|x| (x, exact)));
    let mut curves = vec![Curve { style: BLACK.stroke_width(1), ..line }];
    let coloured = named.iter().zip(COLOURS);
    curves.extend(coloured.map(|((label, curve), colour)| {
        let points = points(curve, &value);
        Curve::new(*label, colour, Mark::Line, points)
    }));
    let [_, [low, high]] = ranges(&curves);
    let margin = 0.05 * (high - low);
    // The legend has the upper part to itself.
    let headroom = if legend.is_some() { 0.45 * (high - low) } else { margin };
    Chart {
        title: title.to_owned(),
        axes: ["length of the path", quantity],
        x_range: 0.0..STRETCH,
        y_range: Scale::Linear(low - margin..high + headroom),
        curves,
        legend,
        left: 64,
    }
}

/// A value over the length of the path.
fn points(curve: &run::Curve, value: impl Fn(&State, Point) -> f64) -> Vec<(f64, f64)> {
    let mut length = 0.0;
    let mut points = Vec::new();
    for pair in curve.states.windows(2) {
        let [state, next] = pair else { continue };
        let step: Point = std::array::from_fn(|axis| next.position[axis] - state.position[axis]);
        let size = norm(step);
        points.push((length, value(state, step.map(|x| x / size))));
        length += size;
        if length > STRETCH {
            break;
        }
    }
    points
}
