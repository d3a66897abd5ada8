//! The table the demonstration ends with.

use std::fmt;
use std::path::Path;

use super::sampling::SmoothSurface;
use crate::surface::report;
use crate::words::{counted, row};

/// Everything the table speaks of.
pub struct Report<'a> {
    /// What `surface` says.
    pub contact: &'a report::Report<'a>,
    /// The sampled surface.
    pub smooth: &'a SmoothSurface,
    /// The picture, if one was written.
    pub picture: Option<&'a Path>,
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.contact)?;
        let smooth = self.smooth;
        let without = if smooth.left_out > 0 {
            format!(", {} more without a foot", counted(smooth.left_out, "point"))
        } else {
            String::new()
        };
        row(
            f,
            "smooth surface",
            &format!(
                "{}, each facet in {side}×{side} pieces{without}",
                counted(smooth.samples.len(), "point"),
                side = smooth.subdivisions
            ),
        )?;
        let heights = smooth.samples.iter().map(|sample| sample.facet_height);
        let (below, above) = heights.fold((0.0_f64, 0.0_f64), |(low, high), h| (low.min(h), high.max(h)));
        row(f, "facets", &format!("up to {:.2e} below and {above:.2e} above the smooth surface", -below))?;
        if let Some(picture) = self.picture {
            row(f, "picture", &format!("{}, for any browser", picture.display()))?;
        }
        writeln!(f)?;
        writeln!(f, "To look at it, open the file in ParaView and apply the filter Threshold on `part`:")?;
        writeln!(
            f,
            "  0  slave nodes       colour by gap, or by outcome (0 is contact); Representation: Points"
        )?;
        writeln!(f, "  1  master facets     Representation: Surface With Edges")?;
        writeln!(f, "  2  smooth surface    colour by facet_height, the height of the facets over it")
    }
}
