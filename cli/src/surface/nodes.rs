//! All slave nodes: paired, evaluated with all derivatives, counted.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use diffuse_contact::interface::{ContactInterface, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::{MasterSurface, SymmetryPlane};
use diffuse_contact::{ContactPoint, Mode};

use super::slaves::Surfaces;
use crate::contact_mesh::SetArguments;
use crate::error::CliError;
use crate::progress::progress;

/// A slave that lies deeper below the master than this part of its facets' size is more than a mesh that does not quite fit.
const DEEP: f64 = 0.1;

/// What is known of one slave node.
pub struct SlaveNode {
    /// Whether it has contact.
    pub outcome: Outcome,
    /// Gap, foot and normal; zero without contact.
    pub point: ContactPoint,
    /// Number of master nodes that its gap depends on.
    pub masters: usize,
    /// Tributary area; 1 if the slave set has no facets.
    pub area: f64,
    /// Size of its facets, length; of all facets of the master if the slave set has none.
    pub size: f64,
}

/// All slave nodes, and how long it took.
pub struct SlaveNodes {
    /// In the order of the slaves.
    pub nodes: Vec<SlaveNode>,
    /// Number of nodes of the master surface.
    pub master_nodes: usize,
    /// Times of the steps.
    pub times: Times,
}

/// How long the steps took.
pub struct Times {
    /// Checking and connecting the master surface, areas.
    pub connect: Duration,
    /// Pairing every slave.
    pub refresh: Duration,
    /// Gap, N and M of every slave.
    pub evaluate: Duration,
}

/// What came out, in numbers.
pub struct Counts {
    /// Slaves with a gap.
    pub contacts: usize,
    /// Of these: with a negative one.
    pub penetrating: usize,
    /// Of these: deeper below the master than a tenth of the facets' size.
    pub deep: usize,
    /// Smallest and largest gap, if there is any.
    pub gaps: Option<[f64; 2]>,
    /// Fewest and most masters of a slave with contact.
    pub masters: Option<[usize; 2]>,
    /// Slaves without contact, by code.
    pub without: BTreeMap<&'static str, usize>,
    /// What the searches of the slaves with contact gave up: nothing, more nodes, the quadratic basis.
    pub fallbacks: [(&'static str, usize); 3],
}

/// Pairs and evaluates every slave node.
pub fn evaluate(
    surfaces: &Surfaces,
    sets: &SetArguments,
    options: InterfaceOptions,
    planes: &[SymmetryPlane],
) -> Result<SlaveNodes, CliError> {
    let positions = surfaces.mesh.nodes();
    let refused = |error| surfaces.interface_error(sets, error);
    let start = Instant::now();
    let master = MasterSurface::new(positions, surfaces.master.clone())
        .map_err(|error| surfaces.master_error(&sets.master, error))?;
    let master_nodes = master.nodes().len();
    let options = options.with_areas(surfaces.has_areas);
    let (slaves, facets) = (surfaces.slaves.clone(), &surfaces.slave_facets);
    let mut interface = ContactInterface::new(master, slaves, facets, positions, options).map_err(refused)?;
    if !planes.is_empty() {
        interface.set_symmetry(planes).map_err(|error| surfaces.symmetry_error(sets, planes, error))?;
    }
    let connect = start.elapsed();

    let start = Instant::now();
    interface.refresh_pairing(positions).map_err(refused)?;
    let refresh = start.elapsed();

    let start = Instant::now();
    let bar = progress("slave nodes", surfaces.slaves.len());
    let mut nodes = Vec::with_capacity(surfaces.slaves.len());
    let of_master = (!surfaces.has_areas).then(|| surfaces.master_size());
    let streamed = interface.for_each(Mode::Hessian, |contact| {
        nodes.push(SlaveNode {
            outcome: contact.outcome,
            point: contact.point,
            masters: contact.gradient.as_chunks::<3>().0.iter().skip(1).filter(|n| **n != [0.0; 3]).count(),
            area: contact.area,
            size: of_master.unwrap_or_else(|| contact.area.sqrt()),
        });
        bar.inc(1);
    });
    bar.finish_and_clear();
    streamed.map_err(refused)?;
    Ok(SlaveNodes { nodes, master_nodes, times: Times { connect, refresh, evaluate: start.elapsed() } })
}

impl SlaveNodes {
    /// Counts outcomes and gaps.
    pub fn counts(&self) -> Counts {
        let mut without = BTreeMap::new();
        let mut fallbacks = [("none", 0), ("extended", 0), ("linear", 0)];
        for node in &self.nodes {
            match node.outcome {
                Outcome::Contact { fallback } => fallbacks[place(fallback)].1 += 1,
                Outcome::None(reason) => *without.entry(reason.code()).or_default() += 1,
            }
        }
        let contacts = || self.nodes.iter().filter(|node| node.outcome.is_contact());
        let gaps = || contacts().map(|node| node.point.gap);
        let masters = || contacts().map(|node| node.masters);
        Counts {
            contacts: contacts().count(),
            penetrating: gaps().filter(|&gap| gap < 0.0).count(),
            deep: contacts().filter(|node| node.point.gap < -DEEP * node.size).count(),
            gaps: gaps().min_by(f64::total_cmp).zip(gaps().max_by(f64::total_cmp)).map(Into::into),
            masters: masters().min().zip(masters().max()).map(Into::into),
            without,
            fallbacks,
        }
    }
}

const fn place(fallback: Fallback) -> usize {
    match fallback {
        Fallback::Linear { .. } => 2,
        Fallback::Extended { .. } => 1,
        _ => 0,
    }
}
