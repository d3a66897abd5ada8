//! The nodes that are within reach of slaves at the positions of the moment.

use std::ops::Range;

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::NoContact;
use super::fold::{FitPoint, Source};
use crate::element::nearest_in_material;
use crate::material::{SearchScratch, Sought};
use crate::{Domains, ElementError, Frame, MaterialDomain, MaterialNode, MaterialPlace, Point, Weight};

/// The points within reach of slaves (nodes, auxiliary points, images) that are evaluated together.
#[derive(Clone, Debug, Default)]
pub struct WithinReach {
    /// Positions, of an image its own.
    pub points: Vec<Point>,
    /// The same in the first configuration, seen from the slave's place there.
    pub nodes: Vec<MaterialNode>,
    pub sources: Vec<Source>,
    /// Places of the points' nodes among the listed ones.
    pub listed: Vec<u32>,
    /// Domains of the points.
    pub domains: Vec<MaterialDomain>,
    /// Slaves whose points are known, …
    pub sought: Vec<Sought>,
    /// … and their places.
    pub places: Vec<Result<MaterialPlace, ElementError>>,
    pub search: SearchScratch,
    /// Of each slave.
    pub elements: Vec<Result<Gathered, NoContact>>,
}

/// The element of one slave.
#[derive(Clone, Debug)]
pub struct Gathered {
    pub frame: Frame,
    /// The distance of the farthest point: what lengths are divided by. It has to follow from the points, or lists would change bits.
    pub unit: f64,
    /// Its points.
    pub range: Range<usize>,
}

impl WithinReach {
    pub fn clear(&mut self) {
        self.points.clear();
        self.nodes.clear();
        self.sources.clear();
        self.listed.clear();
        self.domains.clear();
        self.sought.clear();
        self.elements.clear();
    }

    /// The places of an element's points among the listed nodes of its slave, if it has neither images nor auxiliary points. None of a slave without an element.
    pub fn listed(&self, slave: usize) -> &[u32] {
        self.elements[slave].as_ref().map_or(&[], |element| &self.listed[element.range.clone()])
    }

    /// What a kernel reads.
    pub fn inputs<'s>(&'s self, slave: Point, element: &Gathered, weight: Weight) -> ElementInputs<'s> {
        let Gathered { frame, range, unit } = element;
        let (points, nodes) = (&self.points[range.clone()], &self.nodes[range.clone()]);
        let pole = if weight.is_interpolating() { nearest_in_material(nodes) } else { 0 };
        ElementInputs {
            slave,
            masters: Masters::Positions(points),
            domains: Domains::Material(nodes),
            plane_reach: frame.reach,
            t1: frame.t1,
            t2: frame.t2,
            normal: frame.normal,
            support_radius: *unit,
            point: [0.0; 2],
            anchor: [0.0; 3],
            pole,
        }
    }
}

/// The points of one element.
pub struct PointsWithinReach {
    pub positions: Vec<Point>,
    pub nodes: Vec<MaterialNode>,
    /// The nodes that they are, or are images of, or lie between.
    pub sources: Vec<FitPoint>,
    pub frame: Frame,
    /// What lengths are divided by.
    pub unit: f64,
}
