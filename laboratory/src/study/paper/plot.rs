//! The figures.

use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use crate::study::StudyError;
use crate::study::plot::{Area, FONT, Failure, builder, legend, svg};

const SIZE: (u32, u32) = (800, 480);

/// Colours that stay apart for the colour-blind.
const COLOURS: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// One curve of a figure.
pub struct Curve {
    /// In the legend.
    pub label: String,
    pub points: Vec<(f64, f64)>,
}

/// Curves over one axis.
pub struct Figure<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub curves: Vec<Curve>,
    /// Powers of ten upward; all values are positive.
    pub is_logarithmic: bool,
    /// Where the curves leave room.
    pub legend: SeriesLabelPosition,
}

impl Figure<'_> {
    /// As SVG.
    pub fn draw(&self) -> Result<String, StudyError> {
        svg(SIZE, |area| {
            let all = || self.curves.iter().flat_map(|curve| &curve.points);
            let end = all().map(|(x, _)| *x).fold(0.0, f64::max);
            let (low, high) = all()
                .map(|(_, y)| *y)
                .fold((f64::INFINITY, 0.0_f64), |(low, high), y| (low.min(y), high.max(y)));
            if self.is_logarithmic {
                let range = 10_f64.powf(low.log10().floor())..10_f64.powf(high.log10().ceil());
                self.on(area, end, range.log_scale())
            } else {
                self.on(area, end, 0.0..1.1 * high)
            }
        })
    }

    fn on<'a, Y>(&self, area: &Area<'a>, end: f64, y: Y) -> Result<(), Failure<'a>>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let mut chart = builder(area, self.title, 76).build_cartesian_2d(0.0..end, y)?;
        let scientific = |value: &f64| format!("{value:.0e}");
        let plain = |value: &f64| format!("{value}");
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(self.x)
            .y_desc(self.y)
            .y_label_formatter(if self.is_logarithmic { &scientific } else { &plain })
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .draw()?;
        for (curve, colour) in self.curves.iter().zip(COLOURS.iter().cycle()) {
            let style = colour.stroke_width(2);
            chart
                .draw_series(LineSeries::new(curve.points.iter().copied(), style).point_size(3))?
                .label(&curve.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
        }
        legend(&mut chart, self.legend.clone())
    }
}

/// A line through points, in the colour of its number.
pub type Outline = (usize, Vec<(f64, f64)>);

/// Outlines of faces in the plane, one picture beside the other.
pub struct Shapes<'a> {
    pub title: &'a str,
    /// Heading and outlines of each picture.
    pub pictures: Vec<(String, Vec<Outline>)>,
}

impl Shapes<'_> {
    /// As SVG, lengths the same in both directions.
    pub fn draw(&self) -> Result<String, StudyError> {
        const WIDTH: f64 = 320.0;
        let all = || self.pictures.iter().flat_map(|(_, outlines)| outlines).flat_map(|(_, outline)| outline);
        let (right, top) =
            all().fold((0.0_f64, 0.0_f64), |(right, top), (x, y)| (right.max(*x), top.max(*y)));
        let (low, margin) = (all().map(|(_, y)| *y).fold(0.0, f64::min), 16.0);
        let height = (WIDTH - 2.0 * margin) * (top - low) / right;
        let count = self.pictures.len();
        let size = ((WIDTH * count as f64) as u32, (height + 3.0 * margin + 40.0) as u32);
        svg(size, |area| {
            let area = area.titled(self.title, (FONT, 18))?;
            for (part, (heading, outlines)) in area.split_evenly((1, count)).iter().zip(&self.pictures) {
                let mut chart = ChartBuilder::on(part)
                    .caption(heading, (FONT, 14))
                    .margin(margin as u32)
                    .build_cartesian_2d(0.0..right, low..top)?;
                for (colour, outline) in outlines {
                    let path =
                        PathElement::new(outline.clone(), COLOURS[colour % COLOURS.len()].stroke_width(1));
                    chart.draw_series([path])?;
                }
            }
            Ok(())
        })
    }
}
