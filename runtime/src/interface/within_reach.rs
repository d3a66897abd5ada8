//! The nodes that are within reach of a slave at the positions of the moment.

use std::ops::Range;

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::NoContact;
use super::evaluator::{ElementScratch, Evaluator};
use super::fold::Source;
use super::pairings::{Paired, Record};
use crate::affine::Carrier;
use crate::element::nearest_in_material;
use crate::surface::{Listed, NONE};
use crate::vector::Vector3;
use crate::{
    Domains, Element, ElementError, Frame, MaterialDomain, MaterialNode, MaterialPlace, Point, Weight,
};

/// The points within reach of slaves that are evaluated together.
#[derive(Clone, Debug, Default)]
pub struct WithinReach {
    /// Positions, of an image its own.
    pub points: Vec<Point>,
    /// The same in the first configuration, seen from the slave's place there.
    pub nodes: Vec<MaterialNode>,
    pub sources: Vec<Source>,
    /// Domains of the points of one slave, …
    domains: Vec<MaterialDomain>,
    /// … and their weights.
    weights: Vec<f64>,
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
        self.elements.clear();
    }

    /// What a kernel reads.
    pub fn inputs<'s>(
        &'s self,
        evaluator: &Evaluator<'_>,
        paired: &Paired<'_>,
        element: &Gathered,
        weight: Weight,
    ) -> ElementInputs<'s> {
        let slave = evaluator.positions[paired.slave];
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
    /// Their nodes, by place among the slave's.
    pub listed: Vec<u32>,
    /// The nodes that they are, or are images of.
    pub carriers: Vec<Carrier>,
    pub frame: Frame,
    /// What lengths are divided by.
    pub unit: f64,
}

impl Evaluator<'_> {
    /// The points of a paired slave's element: those of its nodes, and of their images, that are within reach at these positions, in
    /// their order. Which others are listed makes no difference.
    pub fn gather_within_reach(
        &self,
        paired: &Paired<'_>,
        weight: Weight,
        all: &mut WithinReach,
    ) -> Result<Gathered, NoContact> {
        let WithinReach { points, nodes, sources, domains, weights, .. } = all;
        let Some(nodal) = self.nodal else { return Err(NoContact::NotPaired) };
        let start = points.len();
        let slave = self.positions[paired.slave];
        domains.clear();
        let mut images = paired.images.as_chunks::<2>().0.iter().peekable();
        for (listed, (&node, &place)) in paired.masters.iter().zip(paired.places).enumerate() {
            if place == NONE {
                // It only carries the slave's anchor.
                continue;
            }
            let x = self.positions[node as usize];
            points.push(x);
            domains.push(nodal.domain(place, NONE));
            sources.push(Source { listed: listed as u32, image: None });
            while let Some([_, number]) = images.next_if(|image| image[0] == listed as u32) {
                let image = Some(*number);
                points.push(self.image_of(image, x));
                domains.push(nodal.domain(place, *number));
                sources.push(Source { listed: listed as u32, image });
            }
        }
        let Record { basis, facet, .. } = *paired.record;
        let outward = self.surface.shape(facet as usize, self.positions).normal().into();
        let fitting = |r| weight.fitting(r);
        let found = MaterialPlace::iterate(slave, &points[start..], domains, weights, fitting, outward)
            .inspect_err(|_| {
                points.truncate(start);
                sources.truncate(start);
            })?;
        let (mut kept, mut unit) = (start, 0.0_f64);
        for (k, domain) in domains.iter().enumerate() {
            let node = domain.from(found.place);
            if node.distance() < 1.0 {
                (points[kept], sources[kept]) = (points[start + k], sources[start + k]);
                unit = unit.max(distance(points[kept], slave));
                nodes.push(node);
                kept += 1;
            }
        }
        points.truncate(kept);
        sources.truncate(kept);
        let (count, needed) = (kept - start, basis.size());
        if count < needed {
            points.truncate(start);
            sources.truncate(start);
            nodes.truncate(start);
            return Err(ElementError::TooFewNodes { found: count, needed }.into());
        }
        Ok(Gathered { frame: found.frame, range: start..kept, unit })
    }

    /// The place in the first configuration of a slave over a facet, among the nodes listed there.
    pub fn place_among(
        &self,
        listed: &[Listed],
        slave: usize,
        facet: u32,
        weight: Weight,
        scratch: &mut ElementScratch,
    ) -> Result<Vector3, NoContact> {
        let WithinReach { points, domains, weights, .. } = &mut scratch.within_reach;
        let Some(nodal) = self.nodal else { return Err(NoContact::NotPaired) };
        points.clear();
        domains.clear();
        for &Listed { place, image } in listed {
            let x = self.positions[self.surface.nodes()[place as usize] as usize];
            points.push(self.image_of((image != NONE).then_some(image), x));
            domains.push(nodal.domain(place, image));
        }
        let outward = self.surface.shape(facet as usize, self.positions).normal().into();
        let fitting = |r| weight.fitting(r);
        let slave = self.positions[slave];
        Ok(MaterialPlace::iterate(slave, points, domains, weights, fitting, outward)?.place.into())
    }

    /// A copy of the points of a paired slave's element.
    pub fn points_within_reach(
        &self,
        paired: &Paired<'_>,
        weight: Weight,
        scratch: &mut ElementScratch,
    ) -> Result<PointsWithinReach, NoContact> {
        let all = &mut scratch.within_reach;
        all.clear();
        let Gathered { frame, unit, .. } = self.gather_within_reach(paired, weight, all)?;
        let listed = all.sources.iter().map(|source| source.listed).collect();
        let carrier =
            |&Source { listed, image }: &Source| Carrier { node: paired.masters[listed as usize], image };
        let carriers = all.sources.iter().map(carrier).collect();
        let (positions, nodes) = (all.points.clone(), all.nodes.clone());
        Ok(PointsWithinReach { positions, nodes, listed, carriers, frame, unit })
    }

    /// The element of a slave whose points were the only ones gathered.
    pub fn element_of<'s>(
        &self,
        paired: &Paired<'_>,
        all: &'s WithinReach,
        found: &Gathered,
        weight: Weight,
    ) -> Element<'s> {
        Element::new(self.positions[paired.slave], &all.points, found.frame, found.unit)
            .with_domains(Domains::Material(&all.nodes))
            .with_basis(paired.record.basis)
            .with_weight(weight)
    }

    /// Where a node is, or an image of one.
    pub fn place_of(&self, carrier: Carrier) -> Point {
        self.image_of(carrier.image, self.positions[carrier.node as usize])
    }

    /// A point, or its image with this number.
    fn image_of(&self, number: Option<u32>, x: Point) -> Point {
        match (self.nodal, number) {
            (Some(nodal), Some(number)) => nodal.symmetry.image(number).of(x),
            _ => x,
        }
    }
}

fn distance(x: Point, y: Point) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|axis| x[axis] - y[axis]);
    (a * a + b * b + c * c).sqrt()
}
