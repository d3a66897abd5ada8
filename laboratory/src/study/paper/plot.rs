//! The figures.

use plotters::prelude::*;

use crate::study::StudyError;
use crate::study::plot::{COLOURS, Chart, Curve, FONT, Mark, Scale, ranges, svg, svg_of};

const SIZE: (u32, u32) = (800, 480);

/// From 0 on.
pub fn counts([_, high]: [f64; 2]) -> Scale {
    Scale::Counts(0.0..1.1 * high)
}

/// From one power of ten to another; all values are positive.
pub fn decades([low, high]: [f64; 2]) -> Scale {
    Scale::Log(10_f64.powf(low.log10().floor())..10_f64.powf(high.log10().ceil()))
}

/// Curves from x = 0 on, named, as SVG. `scale` is that of y from the smallest to the largest.
pub fn figure(
    title: &str,
    axes: [&'static str; 2],
    scale: fn([f64; 2]) -> Scale,
    legend: SeriesLabelPosition,
    curves: impl Iterator<Item = (String, Vec<(f64, f64)>)>,
) -> Result<String, StudyError> {
    let coloured = curves.zip(COLOURS.into_iter().cycle());
    let curves: Vec<Curve> =
        coloured.map(|((label, points), colour)| Curve::new(label, colour, Mark::Points, points)).collect();
    let [[_, end], y] = ranges(&curves);
    let (title, x_range, y_range) = (title.to_owned(), 0.0..end, scale(y));
    svg_of(&[Chart { title, axes, x_range, y_range, curves, legend: Some(legend), left: 76 }], SIZE)
}

/// A line through points, in the colour of its number.
pub type Outline = (usize, Vec<(f64, f64)>);

/// Outlines of faces in the plane, one headed picture beside the other, as SVG. Lengths are the same in both directions.
pub fn shapes(title: &str, pictures: &[(String, Vec<Outline>)]) -> Result<String, StudyError> {
    const WIDTH: f64 = 320.0;
    let all = || pictures.iter().flat_map(|(_, outlines)| outlines).flat_map(|(_, outline)| outline);
    let (right, top) = all().fold((0.0_f64, 0.0_f64), |(right, top), (x, y)| (right.max(*x), top.max(*y)));
    let (low, margin) = (all().map(|(_, y)| *y).fold(0.0, f64::min), 16.0);
    let height = (WIDTH - 2.0 * margin) * (top - low) / right;
    let count = pictures.len();
    let size = ((WIDTH * count as f64) as u32, (height + 3.0 * margin + 40.0) as u32);
    svg(size, |area| {
        let area = area.titled(title, (FONT, 18))?;
        for (part, (heading, outlines)) in area.split_evenly((1, count)).iter().zip(pictures) {
            let mut chart = ChartBuilder::on(part)
                .caption(heading, (FONT, 14))
                .margin(margin as u32)
                .build_cartesian_2d(0.0..right, low..top)?;
            for (colour, outline) in outlines {
                let path = PathElement::new(outline.clone(), COLOURS[colour % COLOURS.len()].stroke_width(1));
                chart.draw_series([path])?;
            }
        }
        Ok(())
    })
}
