//! The nodes that are within reach of a slave at the positions of the moment.

use std::ops::Range;

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::NoContact;
use super::evaluator::{ElementScratch, Evaluator};
use super::fold::Source;
use super::pairings::Paired;
use crate::affine::Carrier;
use crate::element::nearest_in_material;
use crate::material::{SearchScratch, Sought, places as side_by_side};
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
    /// Places of the points' nodes among the listed ones.
    listed: Vec<u32>,
    /// Domains of the points.
    domains: Vec<MaterialDomain>,
    /// Slaves whose points are known, …
    sought: Vec<Sought>,
    /// … and their places.
    places: Vec<Result<MaterialPlace, ElementError>>,
    search: SearchScratch,
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
    fn clear(&mut self) {
        self.points.clear();
        self.nodes.clear();
        self.sources.clear();
        self.listed.clear();
        self.domains.clear();
        self.sought.clear();
        self.elements.clear();
    }

    /// The places of an element's points among the listed nodes of its slave, if it has no images. None of a slave without an element.
    pub fn listed(&self, slave: usize) -> &[u32] {
        self.elements[slave].as_ref().map_or(&[], |element| &self.listed[element.range.clone()])
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
    /// The points of paired slaves' elements: those of their nodes, and of their images, that are within reach at these positions, in
    /// their order. Which others are listed makes no difference.
    pub fn gather_within_reach<'p>(
        &self,
        slaves: impl Iterator<Item = Result<Paired<'p>, NoContact>> + Clone,
        weight: Weight,
        all: &mut WithinReach,
    ) {
        all.clear();
        for paired in slaves.clone().flatten() {
            self.list(&paired, all);
        }
        let WithinReach { points, nodes, sources, listed, domains, sought, places, search, elements, .. } =
            all;
        side_by_side(sought, (points, domains), weight, search, places);
        let mut kept = 0;
        let mut found = sought.iter().zip(&*places);
        for paired in slaves {
            let element = paired.and_then(|paired| {
                let (sought, place) = found.next().ok_or(NoContact::NotPaired)?;
                let MaterialPlace { place, frame, .. } = (*place)?;
                let (start, mut square) = (kept, 0.0_f64);
                for k in sought.range.clone() {
                    let node = domains[k].from(place);
                    if node.square() < 1.0 {
                        (points[kept], sources[kept]) = (points[k], sources[k]);
                        square = square.max(distance_squared(points[kept], sought.slave));
                        nodes.push(node);
                        listed.push(sources[kept].listed);
                        kept += 1;
                    }
                }
                let (count, needed) = (kept - start, paired.record.basis.size());
                if count < needed {
                    kept = start;
                    nodes.truncate(start);
                    listed.truncate(start);
                    return Err(ElementError::TooFewNodes { found: count, needed }.into());
                }
                Ok(Gathered { frame, range: start..kept, unit: square.sqrt() })
            });
            elements.push(element);
        }
    }

    /// The element of one paired slave, in the place of all others.
    pub fn gather_one(
        &self,
        paired: &Paired<'_>,
        weight: Weight,
        all: &mut WithinReach,
    ) -> Result<Gathered, NoContact> {
        self.gather_within_reach(std::iter::once(Ok(*paired)), weight, all);
        all.elements.pop().unwrap_or(Err(NoContact::NotPaired))
    }

    /// Adds the listed nodes of a slave, and their images.
    fn list(&self, paired: &Paired<'_>, all: &mut WithinReach) {
        let WithinReach { points, sources, domains, sought, .. } = all;
        let Some(nodal) = self.nodal else { return };
        let start = points.len();
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
        let outward = self.surface.shape(paired.record.facet as usize, self.positions).normal().into();
        sought.push(Sought { slave: self.positions[paired.slave], outward, range: start..points.len() });
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
        let WithinReach { points, domains, sought, places, search, .. } = &mut scratch.within_reach;
        let Some(nodal) = self.nodal else { return Err(NoContact::NotPaired) };
        points.clear();
        domains.clear();
        for &Listed { place, image } in listed {
            let x = self.positions[self.surface.nodes()[place as usize] as usize];
            points.push(self.image_of((image != NONE).then_some(image), x));
            domains.push(nodal.domain(place, image));
        }
        let outward = self.surface.shape(facet as usize, self.positions).normal().into();
        sought.clear();
        sought.push(Sought { slave: self.positions[slave], outward, range: 0..points.len() });
        side_by_side(sought, (points, domains), weight, search, places);
        match places[..] {
            [ref place] => Ok((*place)?.place.into()),
            _ => Err(NoContact::NotPaired),
        }
    }

    /// A copy of the points of a paired slave's element.
    pub fn points_within_reach(
        &self,
        paired: &Paired<'_>,
        weight: Weight,
        scratch: &mut ElementScratch,
    ) -> Result<PointsWithinReach, NoContact> {
        let all = &mut scratch.within_reach;
        let Gathered { frame, unit, range } = self.gather_one(paired, weight, all)?;
        let sources = &all.sources[range.clone()];
        let listed = sources.iter().map(|source| source.listed).collect();
        let carrier =
            |&Source { listed, image }: &Source| Carrier { node: paired.masters[listed as usize], image };
        let carriers = sources.iter().map(carrier).collect();
        let (positions, nodes) = (all.points[range].to_vec(), all.nodes.clone());
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
        Element::new(self.positions[paired.slave], &all.points[found.range.clone()], found.frame, found.unit)
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

fn distance_squared(x: Point, y: Point) -> f64 {
    let [a, b, c] = [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
    a * a + b * b + c * c
}
