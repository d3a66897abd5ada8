//! The table the demonstration ends with.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use super::cross_check::CrossCheck;
use super::nodes::SlaveNodes;
use super::sampling::SmoothSurface;
use super::status;
use super::surfaces::Surfaces;
use crate::words::{counted, duration, row};

/// Relative difference beyond which the table warns: far above rounding, far below any error of derivation.
const AGREEMENT: f64 = 1e-9;

/// Everything the table speaks of.
pub struct Report<'a> {
    /// Mesh and sets.
    pub surfaces: &'a Surfaces,
    /// Results of the slave nodes.
    pub nodes: &'a SlaveNodes,
    /// Comparison with automatic differentiation.
    pub check: &'a CrossCheck,
    /// The sampled surface.
    pub smooth: &'a SmoothSurface,
    /// The file that was written.
    pub file: &'a Path,
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.inputs(f)?;
        self.outcomes(f)?;
        self.gaps(f)?;
        self.derivatives(f)?;
        self.picture(f)
    }
}

impl Report<'_> {
    fn inputs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let surfaces = self.surfaces;
        row(f, "mesh", &surfaces.mesh)?;
        row(
            f,
            "master surface",
            &format!(
                "set \"{}\": {}, {}",
                surfaces.master_set,
                counted(surfaces.facets.len(), "facet"),
                counted(surfaces.master.points().len(), "node")
            ),
        )?;
        row(
            f,
            "slave nodes",
            &format!("set \"{}\": {}", surfaces.slave_set, counted(surfaces.slaves.len(), "node")),
        )
    }

    fn outcomes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = &self.nodes.nodes;
        let neighbours = nodes.iter().filter_map(|node| node.pairing.as_ref()).map(|p| p.masters.len());
        if let (Some(fewest), Some(most)) = (neighbours.clone().min(), neighbours.max()) {
            let count = if fewest == most { format!("{most}") } else { format!("{fewest} to {most}") };
            row(f, "neighbours", &format!("{count} nearest master nodes per slave node"))?;
            row(f, "local frame", "their average plane, co-moving: N and M follow its turn")?;
        }
        let mut counts = BTreeMap::new();
        for node in nodes {
            *counts.entry(node.status).or_insert(0) += 1;
        }
        let evaluated = counts.remove(&status::OK).unwrap_or(0);
        row(f, "evaluated", &format!("{evaluated} of {}", counted(nodes.len(), "slave node")))?;
        for (number, count) in counts {
            let (name, meaning) = status::describe(number);
            row(f, "  no contact", &format!("{count} with status {number}, {name}: {meaning}"))?;
        }
        Ok(())
    }

    fn gaps(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gaps = self.nodes.gaps();
        let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let penetrating = gaps.iter().filter(|gap| **gap < 0.0).count();
        if smallest > largest {
            return row(f, "gap", "none");
        }
        row(
            f,
            "gap",
            &format!("{smallest:.6} to {largest:.6} (length unit of the mesh; negative: penetrating)"),
        )?;
        row(f, "penetrating", &counted(penetrating, "slave node"))
    }

    fn derivatives(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let check = self.check;
        if check.elements == 0 {
            return row(f, "difference to AD", "not compared: no element was evaluated");
        }
        row(
            f,
            "difference to AD",
            &format!(
                "g {:.1e}, N {:.1e}, M {:.1e}, relative to the largest entry: worst of {}",
                check.gap,
                check.gradient,
                check.hessian,
                counted(check.elements, "element")
            ),
        )?;
        if check.worst() > AGREEMENT {
            row(f, "  WARNING", "the generated kernels and AD do not agree to working precision")?;
        }
        if check.disagreements > 0 {
            row(f, "  one of both fails", &counted(check.disagreements, "element"))?;
        }
        row(
            f,
            "time per element",
            &format!(
                "{} generated, {} AD (gap, gradient and Hessian)",
                duration(self.nodes.time_per_element),
                duration(check.reference_time)
            ),
        )
    }

    fn picture(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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
        row(f, "wrote", &self.file.display().to_string())?;
        writeln!(f)?;
        writeln!(f, "To look at it, open the file in ParaView and apply the filter Threshold on `part`:")?;
        writeln!(f, "  0  slave nodes       colour by gap, or by status (0 is ok); Representation: Points")?;
        writeln!(f, "  1  master facets     Representation: Surface With Edges")?;
        writeln!(f, "  2  smooth surface    colour by facet_height, the height of the facets over it")
    }
}
