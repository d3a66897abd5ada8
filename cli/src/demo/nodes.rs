//! Every slave node: paired, evaluated with all derivatives, judged.

use std::time::{Duration, Instant};

use diffuse_contact::pairing::{Pairing, PairingRule, pair};
use diffuse_contact::{Backend, Gap, Mode, Point};

use super::status;
use super::surfaces::Surfaces;
use crate::progress::progress;

/// What is known of one slave node.
pub struct SlaveNode {
    /// Its position.
    pub position: Point,
    /// One of the codes of [`status`].
    pub status: i32,
    /// The pairing, unless that failed.
    pub pairing: Option<Pairing>,
    /// Gap and unit normal, if the element was evaluated: also beyond the border.
    pub contact: Option<Contact>,
}

/// The two results a picture shows.
#[derive(Clone, Copy)]
pub struct Contact {
    /// Signed gap.
    pub gap: f64,
    /// Unit normal of the smooth surface at the foot.
    pub normal: Point,
}

/// All slave nodes, and how long one evaluation took.
pub struct SlaveNodes {
    /// In the order of the slave set.
    pub nodes: Vec<SlaveNode>,
    /// Mean time of one evaluation in Hessian mode, pairing not included.
    pub time_per_element: Duration,
}

impl SlaveNodes {
    /// Gaps of the nodes that face the master surface.
    pub fn gaps(&self) -> Vec<f64> {
        let facing = self.nodes.iter().filter(|node| node.status == status::OK);
        facing.filter_map(|node| node.contact).map(|contact| contact.gap).collect()
    }
}

/// Pairs and evaluates every slave node.
pub fn evaluate(backend: &dyn Backend, surfaces: &Surfaces, rule: &PairingRule) -> SlaveNodes {
    let bar = progress("slave nodes", surfaces.slaves.len());
    let mut time = Duration::ZERO;
    let mut evaluations = 0;
    let nodes = surfaces
        .slaves
        .iter()
        .map(|&position| {
            bar.inc(1);
            let pairing = match pair(backend, &surfaces.master, &surfaces.normals, position, rule) {
                Ok(pairing) => pairing,
                Err(error) => {
                    return SlaveNode { position, status: status::of(&error), pairing: None, contact: None };
                }
            };
            let start = Instant::now();
            let outcome = backend.gap(&pairing.element(position), Mode::Hessian);
            time += start.elapsed();
            evaluations += 1;
            let (status, contact) = match outcome {
                Ok(gap) => (facing(&pairing, &gap), Some(Contact { gap: gap.gap, normal: gap.normal })),
                Err(error) => (status::of(&error), None),
            };
            SlaveNode { position, status, pairing: Some(pairing), contact }
        })
        .collect();
    bar.finish_and_clear();
    SlaveNodes { nodes, time_per_element: time / evaluations.max(1) }
}

/// Whether the foot lies on the master surface or beyond its border.
fn facing(pairing: &Pairing, gap: &Gap) -> i32 {
    if pairing.is_beyond_border(gap.foot) { status::BEYOND_BORDER } else { status::OK }
}
