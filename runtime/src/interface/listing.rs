//! Lists of the nodes that slaves may need, with nodal domains, and how far slaves and masters may move before others are listed.

use super::anchors::{join, list_carriers};
use super::evaluator::Evaluator;
use super::nodal::Nodal;
use super::pairings::Record;
use super::refresh::{FARTHEST_BEYOND, Refresh, RefreshScratch};
use super::{ContactElement, NoContact};
use crate::neighbourhood::{Fallback, NeighbourhoodError};
use crate::surface::{Carried, Closest, Listed, NONE, Symmetry};
use crate::vector::Vector3;
use crate::{Basis, Point, Weight};

/// A listed node may be outside its domain by this fraction of it: lists hold while nobody has moved by half of it.
const SKIN: f64 = 0.12;

/// Corners as far above a facet's plane as this part of an extent lie in it.
const EVEN: f64 = 1e-9;

/// The cosine of 25°. On rollers of 12 facets and fewer a place was seen to leave the skin before the slave did, on 13 and more not.
const COARSE: f64 = 0.906_307_787_036_65;

/// Facets beside which a node of self contact slides may turn by as much, in the cosine, before it is listed anew.
const TURNED: f64 = 0.25;

/// An auxiliary point that may come within reach of a slave.
#[derive(Clone, Copy, Debug)]
pub struct ListedAuxiliary {
    /// The nodes that carry it.
    ends: [u32; 2],
    /// Its number among the domains.
    number: u32,
    /// The number of its image, or [`NONE`].
    image: u32,
}

impl Refresh<'_> {
    /// Lists the nodes of the slave's sheet that may come within reach, with their images.
    pub(super) fn list(
        &self,
        nodal: &Nodal,
        k: usize,
        closest: &Closest,
        scratch: &mut RefreshScratch,
    ) -> Result<Record, NoContact> {
        let facet = closest.facet;
        let (basis, fallback) = self.basis_over(nodal, facet)?;
        let support_radius = self.list_reachable(nodal, k, facet, scratch);
        self.list_ends_and_carriers(k, facet, scratch);
        Ok(Record { support_radius, basis, fallback, facet })
    }

    /// The basis that the nodes around a facet carry.
    fn basis_over(&self, nodal: &Nodal, facet: u32) -> Result<(Basis, Fallback), NoContact> {
        let (wanted, falls_back) = match self.evaluator.options.element {
            ContactElement::Diffuse { search, .. } => (search.basis, search.linear_fallback),
            ContactElement::NodeToFacet => (Basis::Linear, false),
        };
        match (wanted, nodal.domains.carried(facet)) {
            (Basis::Quadratic, Carried::Linear) if falls_back => {
                Ok((Basis::Linear, Fallback::Linear { quadratic_regularity: 0.0 }))
            }
            (Basis::Quadratic, Carried::Quadratic) | (Basis::Linear, Carried::Linear) => {
                Ok((wanted, Fallback::None))
            }
            _ => {
                let reason = NeighbourhoodError::NoCandidate { found: 0, needed: wanted.size() };
                Err(NoContact::NoCandidate { reason })
            }
        }
    }

    /// Lists what of a facet's points may come within reach of the `k`-th slave. Returns the shortest half axis of a listed domain, or less
    /// where a short one is near; infinite where nothing is listed.
    fn list_reachable(&self, nodal: &Nodal, k: usize, facet: u32, scratch: &mut RefreshScratch) -> f64 {
        let node = self.old.layout.slave(k);
        let Evaluator { surface, options, .. } = self.evaluator;
        let RefreshScratch { masters, sheet_nodes, images, between, element, .. } = scratch;
        let weight = match options.element {
            ContactElement::Diffuse { weight, .. } => weight,
            ContactElement::NodeToFacet => Weight::default(),
        };
        // A slave far beyond a border may have no place: all are listed then, and the evaluation says why there is no contact.
        let listed = nodal.domains.listed(facet);
        let place = self.evaluator.place_among(listed, node, facet, weight, element).ok();
        let (mut shortest, mut beyond) = (f64::INFINITY, f64::INFINITY);
        for &Listed { node: listed, image } in listed {
            let domain = nodal.domain(listed, image);
            let length = place.map_or(0.0, |place| domain.length(Vector3::from(domain.position) - place));
            if length >= 1.0 + SKIN {
                // How much shorter a listed domain would have to be for the list to last as long as this one is out of reach.
                beyond = beyond.min((length - 1.0) / SKIN * domain.shortest());
                continue;
            }
            shortest = shortest.min(domain.shortest());
            if nodal.domains.is_auxiliary(listed) {
                let ends = nodal.domains.places_of(listed).map(|place| surface.nodes()[place as usize]);
                between.push(ListedAuxiliary { ends, number: listed, image });
                continue;
            }
            if sheet_nodes.last() != Some(&listed) {
                sheet_nodes.push(listed);
                masters.push(surface.nodes()[nodal.domains.place(listed) as usize]);
            }
            if image != NONE {
                images.extend([sheet_nodes.len() as u32 - 1, image]);
            }
        }
        if shortest.is_finite() { shortest.min(beyond) } else { shortest }
    }

    /// Lists the nodes that carry the `k`-th slave's auxiliary points and anchors, and where its patch ends.
    fn list_ends_and_carriers(&self, k: usize, facet: u32, scratch: &mut RefreshScratch) {
        let Evaluator { surface, creases, .. } = self.evaluator;
        let RefreshScratch { masters, sheet_nodes, images, between, auxiliary, patch, .. } = scratch;
        for &node in between.iter().flat_map(|between| &between.ends) {
            join(node, masters, sheet_nodes, images);
        }
        creases.patch_with_end(surface, facet, masters, patch);
        list_carriers(self.evaluator.anchors_of(k), masters, sheet_nodes, images);
        let place = |node: u32| masters.partition_point(|&master| master < node) as u32;
        for &ListedAuxiliary { ends: [one, other], number, image } in &*between {
            auxiliary.extend([place(one), place(other), number, image]);
        }
    }

    /// The least stretch of a facet and those beside it, at most 1: domains, and the skin around them, lie in the first configuration,
    /// where a slave's place moves by as much more.
    fn squeezed(&self, nodal: &Nodal, facet: u32) -> f64 {
        let beside = self.evaluator.surface.across(facet as usize).iter().copied();
        let facets = beside.filter(|&other| other != NONE).chain([facet]);
        facets.map(|facet| self.least_stretch(nodal, facet)).fold(1.0, f64::min)
    }

    /// The least singular value of the deformation gradient at the corners of a facet, 0 where there is none.
    fn least_stretch(&self, nodal: &Nodal, facet: u32) -> f64 {
        let places = self.evaluator.surface.corners_of(facet as usize);
        let now = self.index.shape(facet);
        let first: Vec<Vector3> =
            places.iter().map(|&place| Vector3::from(nodal.domains.first_position(place))).collect();
        // Products of the two edges at a corner.
        let metric = |corners: &[Vector3], k: usize| {
            let beside = |by: usize| corners[(k + by) % corners.len()] - corners[k];
            let (one, other) = (beside(1), beside(corners.len() - 1));
            [one.dot(&one), one.dot(&other), other.dot(&other)]
        };
        let at_corner = |k: usize| {
            let ([a, b, c], [d, e, f]) = (metric(&first, k), metric(now.corners(), k));
            let area = a * c - b * b;
            let trace = (a * f - 2.0 * b * e + c * d) / area;
            let determinant = (d * f - e * e) / area;
            let largest = 0.5 * (trace + (trace * trace - 4.0 * determinant).max(0.0).sqrt());
            let stretch = (determinant.max(0.0) / largest).sqrt();
            if stretch.is_nan() { 0.0 } else { stretch }
        };
        // A triangle has one.
        let count = if places.len() == 3 { 1 } else { places.len() };
        (0..count).map(at_corner).fold(f64::INFINITY, f64::min)
    }
}

impl Refresh<'_> {
    /// Whether facets around this one meet one another or their images, with no sharp edge in between, at an angle at which a slave's place
    /// moves farther than the slave.
    fn is_coarse(&self, facet: u32, symmetry: &Symmetry) -> bool {
        let Evaluator { surface, creases, .. } = self.evaluator;
        let normals = self.index.normals();
        let cosine = |one: u32, edge: usize, other: u32| match other {
            NONE => {
                let ends = self.index.shape(one).edge(edge).map(Point::from);
                symmetry.cosine_across(ends, normals[one as usize])
            }
            other => normals[one as usize].dot(&normals[other as usize]),
        };
        let around = surface.corners_of(facet as usize).iter();
        around.flat_map(|&place| surface.facets_of_place(place as usize)).any(|&one| {
            let across = surface.across(one as usize).iter().enumerate();
            let mut within = across.filter(|&(edge, _)| !creases.ends_at(one as usize, edge));
            within.any(|(edge, &other)| !(cosine(one, edge, other) >= COARSE))
        })
    }

    /// How far the `k`-th slave and the masters together may move, length, before its pairing may be another one. Zero where that is
    /// not known, and by other rules than nodal domains; next to nothing on coarse facets.
    ///
    /// Until then the list is complete, and no facet of another sheet comes to be the closest: that is farther away by twice as much, or
    /// lies beyond a convex edge whose other side the slave is as much higher above.
    pub(super) fn slack(
        &self,
        k: usize,
        closest: Result<&Closest, NoContact>,
        record: Result<&Record, NoContact>,
    ) -> f64 {
        let (Some(nodal), Evaluator { positions, own, .. }) = (self.evaluator.nodal, self.evaluator) else {
            return 0.0;
        };
        let node = self.old.layout.slave(k);
        let slave = positions[node];
        let skin = match record {
            // Where no node is listed it is infinite.
            // At the very positions the list is what it was.
            Ok(Record { facet, .. }) if self.facets.is_none() && self.is_coarse(*facet, &nodal.symmetry) => {
                return f64::MIN_POSITIVE;
            }
            Ok(Record { support_radius, facet, .. }) if support_radius.is_finite() => {
                0.5 * SKIN * support_radius * self.squeezed(nodal, *facet)
            }
            Err(NoContact::TooFar { distance, limit }) => {
                let known = self.knowledge.map_or(f64::INFINITY, |knowledge| knowledge.radius(slave));
                return distance.min(known) - limit;
            }
            Err(NoContact::BeyondWindow { .. }) => 0.0,
            // Until it is paired again.
            Err(NoContact::BeyondBorder { distance, tolerance }) => {
                let height = closest.map_or(0.0, |closest| self.index.shape(closest.facet).least_height());
                let skin = 0.5 * SKIN * nodal.domains.shortest();
                return skin.min((distance - tolerance - FARTHEST_BEYOND) * height);
            }
            _ => 0.5 * SKIN * nodal.domains.shortest(),
        };
        if self.facets.is_some() {
            // The facets are given.
            return skin;
        }
        let distance = match (closest, own) {
            (Ok(closest), _) => closest.distance,
            // Where there is nothing to touch within the limit.
            (Err(_), Some(own)) => own.limit(),
            (Err(_), None) => return 0.0,
        };
        let known = self.knowledge.map_or(f64::INFINITY, |knowledge| knowledge.radius(slave) - distance);
        let mut lead = known.min(2.0 * skin);
        let may_touch = own.zip(self.evaluator.surface.nodes().binary_search(&(node as u32)).ok());
        // Facets turn on the way.
        let may_touch =
            may_touch.map(|(own, place)| own.may_touch(self.index, Some(&nodal.domains), place, TURNED));
        let is_candidate = |facet: u32| {
            may_touch.as_ref().is_none_or(|may_touch| may_touch(facet))
                && !closest.is_ok_and(|closest| self.lists_alike(nodal, closest.facet, facet))
        };
        let seen = (Vector3::from(slave), distance);
        for (facet, from_box) in self.index.within(slave, distance + lead) {
            // Another facet is as close: no way is left.
            if lead <= 0.0 {
                break;
            }
            // What was near when the search began need not be near enough now. A lead is no less than how much farther away the facet is.
            let is_near = || !(self.index.shape(facet).at_least(seen.0) - distance >= lead);
            if from_box < distance + lead && is_near() && is_candidate(facet) {
                lead = lead.min(self.lead(seen, closest.ok(), facet));
            }
        }
        0.5 * lead.max(0.0)
    }

    /// Whether it makes no difference which of two facets is the closest one.
    pub(super) fn lists_alike(&self, nodal: &Nodal, facet: u32, other: u32) -> bool {
        let corners = self.evaluator.surface.corners_of(other as usize);
        nodal.domains.carried(facet) == nodal.domains.carried(other)
            && corners.iter().all(|&place| {
                let [one, two] = [facet, other].map(|facet| nodal.domains.listed_at(facet, place));
                one.is_some() && one == two
            })
    }

    /// Twice how far a slave at this distance may be moved before another facet is the closest.
    fn lead(&self, (slave, distance): (Vector3, f64), closest: Option<&Closest>, other: u32) -> f64 {
        let shape = self.index.shape(other);
        let foot = shape.closest(slave);
        let nearer = foot.distance - distance;
        let Some(closest) = closest else { return nearer };
        let corners = |facet: u32| self.evaluator.surface.corners_of(facet as usize);
        let normal = self.index.normals()[closest.facet as usize];
        let height = normal.dot(&(slave - closest.point));
        let is_below = |corner: &Vector3| normal.dot(&(*corner - closest.point)) <= EVEN * shape.extent();
        let meet = corners(closest.facet).iter().any(|place| corners(other).contains(place));
        if height > 0.0 && meet && shape.corners().iter().all(is_below) {
            // Over a convex edge, where facets are equally close, the one is paired whose plane is farther away.
            nearer.max(height - self.index.normals()[other as usize].dot(&(slave - foot.point)))
        } else {
            nearer
        }
    }
}
