//! The summary, as a table and as JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::legend;
use super::nodes::{Counts, SlaveNodes};
use super::slaves::Surfaces;
use crate::contact_mesh::SetArguments;
use crate::contact_options::ElementDescription;
use crate::words::{counted, duration, number, row};

/// Everything the summary speaks of.
pub struct Report<'a> {
    /// The two surfaces.
    pub surfaces: &'a Surfaces,
    /// Their names.
    pub sets: &'a SetArguments,
    /// Results.
    pub nodes: &'a SlaveNodes,
    /// The element.
    pub element: ElementDescription,
    /// How long the mesh took to read.
    pub read: Duration,
    /// How long the file took to write.
    pub write: Duration,
    /// The file that was written.
    pub file: &'a Path,
}

/// The summary for programs.
#[derive(Debug, Serialize)]
pub struct Summary {
    slaves: usize,
    contacts: usize,
    penetrating: usize,
    /// Slaves deeper below the master than a tenth of the facets' size.
    deep: usize,
    smallest_gap: Option<f64>,
    largest_gap: Option<f64>,
    without: BTreeMap<&'static str, usize>,
    fallbacks: BTreeMap<&'static str, usize>,
    times_s: BTreeMap<&'static str, f64>,
    element: ElementDescription,
}

impl Report<'_> {
    /// The summary for programs.
    pub fn summary(&self) -> Summary {
        let Counts { contacts, penetrating, deep, gaps, without, fallbacks, .. } = self.nodes.counts();
        Summary {
            slaves: self.nodes.nodes.len(),
            contacts,
            penetrating,
            deep,
            smallest_gap: gaps.map(|[smallest, _]| smallest),
            largest_gap: gaps.map(|[_, largest]| largest),
            without,
            fallbacks: fallbacks.into(),
            times_s: self.times().map(|(name, time)| (name, time.as_secs_f64())).into(),
            element: self.element,
        }
    }

    fn times(&self) -> [(&'static str, Duration); 5] {
        let times = &self.nodes.times;
        [
            ("read", self.read),
            ("connect", times.connect),
            ("refresh", times.refresh),
            ("evaluate", times.evaluate),
            ("write", self.write),
        ]
    }
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { surfaces, sets, nodes, .. } = self;
        let counts = nodes.counts();
        row(f, "mesh", &surfaces.name)?;
        let (facets, masters) = (surfaces.master.len(), nodes.master_nodes);
        let counts_of = |facets, nodes| format!("{}, {}", counted(facets, "facet"), counted(nodes, "node"));
        row(f, "master surface", &format!("set \"{}\": {}", sets.master, counts_of(facets, masters)))?;
        let (facets, slaves) = (surfaces.slave_facets.len(), surfaces.slaves.len());
        row(f, "slave surface", &format!("set \"{}\": {}", sets.slave, counts_of(facets, slaves)))?;
        let area: f64 = nodes.nodes.iter().map(|node| node.area).sum();
        let area =
            if surfaces.has_areas { number(area, 6) } else { "none: not all nodes have facets".into() };
        row(f, "slave area", &area)?;
        row(f, "element", &self.element.to_string())?;
        row(f, "contact", &format!("{} of {}", counts.contacts, counted(slaves, "slave node")))?;
        for (code, count) in &counts.without {
            let (number, meaning) = legend::describe(code);
            row(f, "  no contact", &format!("{count} with outcome {number}, {code}: {meaning}"))?;
        }
        if let Some([fewest, most]) = counts.masters {
            row(f, "master nodes", &format!("{fewest} to {most} for each slave node"))?;
        }
        for (name, count) in counts.fallbacks.into_iter().filter(|&(name, count)| name != "none" && count > 0)
        {
            let meaning =
                if name == "linear" { "a linear basis" } else { "more master nodes than asked for" };
            row(f, "  fallback", &format!("{} with {meaning}", counted(count, "slave node")))?;
        }
        match counts.gaps {
            Some([smallest, largest]) => {
                let unit = "(length unit of the mesh; negative: penetrating)";
                let [smallest, largest] = [smallest, largest].map(|gap| number(gap, 6));
                row(f, "gap", &format!("{smallest} to {largest} {unit}"))?;
                row(f, "penetrating", &counted(counts.penetrating, "slave node"))?;
                if 2 * counts.deep > counts.contacts {
                    let meaning =
                        "deeper than a tenth of the facets' size: does the master face the wrong way?";
                    row(f, "  warning", &format!("{} {meaning}", counted(counts.deep, "slave node")))?;
                }
            }
            None => row(f, "gap", "none")?,
        }
        let times = self.times().map(|(name, time)| format!("{name} {}", duration(time)));
        row(f, "time", &times.join(", "))?;
        row(f, "wrote", &self.file.display().to_string())
    }
}
