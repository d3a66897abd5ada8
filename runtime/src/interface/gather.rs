//! The search for the nodes within reach of slaves.

use super::NoContact;
use super::evaluator::Evaluator;
use super::fold::Source;
use super::pairings::Paired;
use super::scratch::ElementScratch;
use super::within_reach::{Gathered, PointsWithinReach, WithinReach};
use crate::material::{Sought, places as side_by_side};
use crate::surface::{Listed, NONE, between};
use crate::vector::{Vector3, squared_distance};
use crate::{Domains, Element, ElementError, MaterialPlace, Weight};

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
                        square = square.max(squared_distance(points[kept], sought.slave));
                        nodes.push(node);
                        listed.push(sources[kept].ends[0]);
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

    /// Adds the listed nodes of a slave, auxiliary points between them, and images of both.
    fn list(&self, paired: &Paired<'_>, all: &mut WithinReach) {
        let WithinReach { points, sources, domains, sought, .. } = all;
        let Some(nodal) = self.nodal else { return };
        let start = points.len();
        let mut images = paired.images.as_chunks::<2>().0.iter().peekable();
        for (listed, (&node, &sheet_node)) in paired.masters.iter().zip(paired.sheet_nodes).enumerate() {
            if sheet_node == NONE {
                // It only carries the slave's anchor.
                continue;
            }
            let x = self.positions[node as usize];
            points.push(x);
            domains.push(nodal.domain(sheet_node, NONE));
            sources.push(Source::node(listed as u32, None));
            while let Some([_, number]) = images.next_if(|image| image[0] == listed as u32) {
                let image = Some(*number);
                points.push(self.image_of(image, x));
                domains.push(nodal.domain(sheet_node, *number));
                sources.push(Source::node(listed as u32, image));
            }
        }
        for &[one, other, number, image] in paired.auxiliary.as_chunks().0 {
            let x = [one, other].map(|listed| self.positions[paired.masters[listed as usize] as usize]);
            let part = nodal.domains.part(number);
            points.push(self.image_of((image != NONE).then_some(image), between(part, x)));
            domains.push(nodal.domain(number, image));
            sources.push(Source { ends: [one, other], part, image: (image != NONE).then_some(image) });
        }
        let outward = self.facet(paired).normal().into();
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
        for &Listed { node, image } in listed {
            let position = |place: u32| self.positions[self.surface.nodes()[place as usize] as usize];
            let x = between(nodal.domains.part(node), nodal.domains.places_of(node).map(position));
            points.push(self.image_of((image != NONE).then_some(image), x));
            domains.push(nodal.domain(node, image));
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
        let sources = all.sources[range.clone()].iter().map(|source| source.point(paired.masters)).collect();
        let (positions, nodes) = (all.points[range].to_vec(), all.nodes.clone());
        Ok(PointsWithinReach { positions, nodes, sources, frame, unit })
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
}
