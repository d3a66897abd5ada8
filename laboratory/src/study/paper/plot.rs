//! The figures.

use plotters::prelude::*;

use crate::study::StudyError;
use crate::study::plot::{Chart, Curve, FONT, Scale, TITLE, ranges, svg, svg_of};

const SIZE: (u32, u32) = (1000, 420);
/// Of the width, for the legend.
const LEGEND: u32 = 262;

/// The axes of a figure.
pub struct Axes {
    pub names: [&'static str; 2],
    pub x: fn([f64; 2]) -> Scale,
    /// From the smallest to the largest value.
    pub y: fn([f64; 2]) -> Scale,
}

/// Curves with their legend, as SVG.
pub fn figure(title: &str, axes: &Axes, curves: Vec<Curve>) -> Result<String, StudyError> {
    let [x, y] = ranges(&curves);
    let chart = Chart {
        title: title.to_owned(),
        axes: axes.names,
        x_range: (axes.x)(x),
        y_range: (axes.y)(y),
        curves,
        legend: LEGEND,
        left: 76,
    };
    svg_of(&[chart], SIZE)
}

/// What a line is drawn around.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Body {
    Pipe,
    Plate,
}

/// A face in the plane.
pub type Face = (Body, Vec<(f64, f64)>);

/// Bodies at several times, one headed picture beside the other over a note of two lines, as SVG. Lengths are the same in both
/// directions.
pub fn shapes(title: &str, pictures: &[(String, Vec<Face>)], note: [&str; 2]) -> Result<String, StudyError> {
    const WIDTH: f64 = 320.0;
    /// Heights of title, headings and note.
    const HEADS: f64 = 92.0;
    const NOTE: f64 = 52.0;
    /// Length of the bar, mm.
    const BAR: f64 = 50.0;
    let all = || pictures.iter().flat_map(|(_, faces)| faces).flat_map(|(_, outline)| outline);
    let (right, top) = all().fold((0.0_f64, 0.0_f64), |(right, top), (x, y)| (right.max(*x), top.max(*y)));
    let (low, margin) = (all().map(|(_, y)| *y).fold(0.0, f64::min), 16.0);
    let height = (WIDTH - 2.0 * margin) * (top - low) / right;
    let size = ((WIDTH * pictures.len() as f64) as u32, (height + HEADS + NOTE) as u32);
    svg(size, |area| {
        let (area, foot) = area.split_vertically(size.1 - NOTE as u32);
        for (line, k) in note.into_iter().zip(0..) {
            foot.draw(&Text::new(line, (margin as i32, 8 + 19 * k), (FONT, 17)))?;
        }
        let area = area.titled(title, (FONT, TITLE))?;
        let parts = area.split_evenly((1, pictures.len()));
        for (k, (part, (heading, faces))) in parts.iter().zip(pictures).enumerate() {
            let mut chart = ChartBuilder::on(part)
                .caption(heading, (FONT, 17))
                .margin(margin as u32)
                .build_cartesian_2d(0.0..right, low..top)?;
            for (body, outline) in faces {
                let fill = if *body == Body::Pipe { BLACK.mix(0.18) } else { BLACK.mix(0.0) };
                chart.draw_series([Polygon::new(outline.clone(), fill)])?;
                chart.draw_series([PathElement::new(outline.clone(), BLACK.stroke_width(1))])?;
            }
            if k > 0 {
                continue;
            }
            // Names and a scale, where the bodies of the first picture leave room.
            let middle = |body: Body| {
                let of = || faces.iter().filter(|face| face.0 == body).flat_map(|(_, outline)| outline);
                let count = of().count().max(1) as f64;
                of().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count))
            };
            let (x, y) = middle(Body::Pipe);
            let label = |text: &'static str, place| Text::new(text, place, (FONT, 17));
            chart.draw_series([
                label("pipe, the master", (0.25 * x, 0.85 * y)),
                label("plate", (0.8 * right, middle(Body::Plate).1 - 0.22 * top)),
            ])?;
            let bar = [(0.0, 0.06 * top), (BAR, 0.06 * top)];
            chart.draw_series([PathElement::new(bar, BLACK.stroke_width(3))])?;
            chart.draw_series([label("50 mm", (0.0, 0.16 * top))])?;
        }
        Ok(())
    })
}
