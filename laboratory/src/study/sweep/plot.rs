//! Gap and force over a stretch of the path, as a picture.

use super::run::{self, State};
use super::scene::DEPTH;
use crate::study::plot::{COLOURS, Chart, Colour, Curve, Mark, Scale, ranges, svg_of};
use crate::study::{StudyError, dot, norm};
use diffuse_contact::Point;

/// Size of the picture.
const SIZE: (u32, u32) = (1040, 760);
/// Of its width, for the legend.
const LEGEND: u32 = 252;
/// Length of the stretch that is shown: short enough to tell one facet from the next.
const STRETCH: f64 = 20.0;

/// Name and colour of a curve.
pub type Named<'a> = (&'static str, Colour, &'a run::Curve);

/// The picture of named curves as SVG.
pub fn draw(named: &[Named]) -> Result<String, StudyError> {
    let gap = ["Gap g of a slave node swept at constant depth d below the exact surface", "g / d"];
    let gap = chart(named, gap, -1.0, |state, _| state.gap / DEPTH);
    // A frictionless surface does not push along it.
    let push = ["Contact force along the path, which is tangent to the exact surface", "F·t / (ε d), %"];
    let push = chart(named, push, 0.0, |state, along| 100.0 * dot(state.force, along) / DEPTH);
    svg_of(&[gap, push], SIZE)
}

/// One half of the picture. `exact`: what the value, of a state and the direction of the path, is on the exact surface.
fn chart(
    named: &[Named],
    [title, quantity]: [&'static str; 2],
    exact: f64,
    value: impl Fn(&State, Point) -> f64,
) -> Chart {
    let exact = [0.0, STRETCH].map(|x| (x, exact));
    let mut curves = vec![Curve::new("exact", COLOURS.other, Mark::Line, exact).wide(1)];
    let drawn = named.iter().map(|&(label, colour, curve)| (label, colour, points(curve, &value)));
    curves.extend(drawn.map(|(label, colour, points)| Curve::new(label, colour, Mark::Line, points)));
    let [_, [low, high]] = ranges(&curves);
    let margin = 0.05 * (high - low);
    Chart {
        title: title.to_owned(),
        axes: ["way along the path, sides of a cell: the first 20 of 109", quantity],
        x_range: Scale::Linear(0.0..STRETCH),
        y_range: Scale::Linear(low - margin..high + margin),
        curves,
        legend: LEGEND,
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
