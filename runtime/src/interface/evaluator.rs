//! One element at the positions of the moment.

use diffuse_contact_kernels::support::{ElementInputs, Masters};

use super::anchors::Anchor;
use super::contacts::Tracked;
use super::nodal::Nodal;
use super::pairings::Paired;
use super::scratch::ElementScratch;
use super::{ContactElement, InterfaceOptions, NoContact};
use crate::affine::Carrier;
use crate::element::nearest_in_plane;
use crate::surface::{BorderScratch, Creases, MasterSurface, OwnSurface, Shape};
use crate::vector::Vector3;
use crate::{
    AffinePoint, ContactPoint, Domains, Element, ElementError, FacetElement, Frame, FrameDerivative,
    Generated, Mode, Point, Weight,
};

/// In facets: a slave as deep as this whose own place is as far beyond the border has no foot inside.
const FAR: f64 = 0.5;

/// What every element of an interface has in common.
#[derive(Clone, Copy, Debug)]
pub struct Evaluator<'a> {
    pub surface: &'a MasterSurface,
    pub creases: &'a Creases,
    /// Of all nodes.
    pub positions: &'a [Point],
    pub options: &'a InterfaceOptions,
    /// The domains of the surface's nodes, if the options ask for them.
    pub nodal: Option<&'a Nodal>,
    /// Where slaves stuck, if slips are tracked.
    pub anchors: Option<&'a [Option<Anchor>]>,
    /// Those of the last accepted step.
    pub committed: Option<&'a [Option<Anchor>]>,
    /// What slaves may touch, if the surface is in contact with itself.
    pub own: Option<&'a OwnSurface>,
}

impl Evaluator<'_> {
    /// The anchor of a slave, if it has one.
    pub fn anchor(&self, k: usize) -> Option<&Anchor> {
        self.anchors.and_then(|anchors| anchors[k].as_ref())
    }

    /// The same, and that of the last accepted step, which a contact that opens goes back to.
    pub fn anchors_of(&self, k: usize) -> impl Iterator<Item = &Anchor> {
        let committed = self.committed.and_then(|anchors| anchors[k].as_ref());
        self.anchor(k).into_iter().chain(committed)
    }

    /// Where an anchor is now.
    pub fn anchor_position(&self, anchor: &Anchor) -> Point {
        anchor.point.position(|carrier| self.place_of(carrier))
    }

    /// P_ν of the way from a point of the master to the slave with this contact, length.
    pub fn slip_from(&self, point: &AffinePoint, contact: &ContactPoint) -> Vector3 {
        let (at, normal) = (Vector3::from(contact.foot), Vector3::from(contact.normal));
        let way = at - Vector3::from(point.position(|carrier| self.place_of(carrier)));
        way - normal * normal.dot(&way)
    }

    /// What an evaluation notes of a slip from this anchor.
    pub fn tracked(&self, anchor: &Anchor, half_square: f64, contact: &ContactPoint) -> Tracked {
        // What a multiplier is worth is no slip.
        let since_stuck = match &anchor.origin {
            Some(origin) => self.slip_from(origin, contact).norm(),
            None => (2.0 * half_square).sqrt(),
        };
        Tracked { is_anchored: true, half_square, since_stuck, opening: anchor.opening }
    }

    /// Where a node is, or an image of one.
    pub fn place_of(&self, carrier: Carrier) -> Point {
        self.image_of(carrier.image, self.positions[carrier.node as usize])
    }

    /// A point, or its image with this number.
    pub fn image_of(&self, number: Option<u32>, x: Point) -> Point {
        match (self.nodal, number) {
            (Some(nodal), Some(number)) => nodal.symmetry.image(number).of(x),
            _ => x,
        }
    }

    /// What a kernel reads of a paired slave.
    pub fn inputs<'s>(&'s self, paired: &Paired<'s>, frame: &Frame, weight: Weight) -> ElementInputs<'s> {
        let slave = self.positions[paired.slave];
        let support_radius = paired.record.support_radius;
        let pole = if weight.is_interpolating() {
            nearest_in_plane(slave, self.masters(paired), frame, |_| support_radius)
        } else {
            0
        };
        ElementInputs {
            slave,
            masters: Masters::Indexed { positions: self.positions, nodes: paired.masters },
            domains: Domains::Shared,
            plane_reach: frame.reach,
            t1: frame.t1,
            t2: frame.t2,
            normal: frame.normal,
            support_radius,
            point: [0.0; 2],
            anchor: [0.0; 3],
            pole,
        }
    }

    /// Positions of the masters.
    fn masters<'s>(&'s self, paired: &Paired<'s>) -> impl ExactSizeIterator<Item = Point> + Clone + 's {
        paired.masters.iter().map(|&node| self.positions[node as usize])
    }

    /// One element without nodal domains, N into `gradient` and M into `hessian` as far as the mode asks for them.
    pub fn element(
        &self,
        paired: &Paired<'_>,
        mode: Mode,
        gradient: &mut [f64],
        hessian: &mut [f64],
        scratch: &mut ElementScratch,
    ) -> Result<ContactPoint, NoContact> {
        let slave = self.positions[paired.slave];
        if let ContactElement::Diffuse { weight, .. } = self.options.element {
            let (frame, masters) = (self.current_frame(paired)?, self.gather(paired, scratch));
            let (support_radius, basis) = (paired.record.support_radius, paired.record.basis);
            let element =
                Element::new(slave, masters, frame, support_radius).with_basis(basis).with_weight(weight);
            let point = Generated.gap_into(&element, mode, gradient, hessian);
            return self.within_border(paired, point, &mut scratch.border);
        }
        let element = FacetElement { slave, corners: self.gather_corners(paired, scratch) };
        let found = Generated.facet_gap_into(&element, mode, gradient, hessian)?;
        // Off its facet, the foot may lie over a neighbour or beyond the neighbour's end.
        if !element.contains(found.natural, 0.0) {
            let ElementScratch { corners, patch, border, .. } = scratch;
            corners.clear();
            corners.extend_from_slice(self.corners_of(paired));
            corners.sort_unstable();
            self.creases.patch(self.surface, paired.record.facet, corners, patch);
            let foot = found.point.foot;
            self.check_border(self.creases.beyond(self.surface, self.positions, patch, foot, border))?;
        }
        Ok(found.point)
    }

    /// The result of a diffuse element, if its foot lies on its patch.
    pub fn within_border(
        &self,
        paired: &Paired<'_>,
        point: Result<ContactPoint, ElementError>,
        border: &mut BorderScratch,
    ) -> Result<ContactPoint, NoContact> {
        if let (Some(own), Ok(found)) = (self.own, &point)
            && !own.may_rest_on(self.surface, self.positions, paired.slave, paired.record.facet, found)
        {
            return Err(NoContact::NothingOver { limit: own.limit() });
        }
        if !paired.patch.is_empty() {
            let slave = self.positions[paired.slave];
            let mut beyond_border =
                |x: Point| self.creases.beyond(self.surface, self.positions, paired.patch, x, border);
            let beyond = match &point {
                Ok(point) if !self.is_over(paired, point) => beyond_border(slave),
                Ok(point) => {
                    let beyond = beyond_border(point.foot);
                    // The fit of a slave far beyond the border may come back and put the foot inside, far below the slave.
                    let is_deep = point.gap < -FAR * self.facet(paired).extent();
                    let own = if is_deep { beyond_border(slave) } else { 0.0 };
                    if own > FAR { beyond.max(own) } else { beyond }
                }
                Err(error @ ElementError::BeyondCentreOfCurvature { .. }) => return Err((*error).into()),
                // A slave that has slid far beyond the border has no fit any more: the border is the reason.
                Err(_) => beyond_border(slave),
            };
            self.check_border(beyond)?;
        }
        point.map_err(NoContact::from)
    }

    /// The facet of a pairing as it lies now.
    pub fn facet(&self, paired: &Paired<'_>) -> Shape {
        self.surface.shape(paired.record.facet as usize, self.positions)
    }

    /// Whether the surface at the foot looks where the slave's facet does, within the angle that ends a patch.
    fn is_over(&self, paired: &Paired<'_>, point: &ContactPoint) -> bool {
        self.facet(paired).normal().dot(&point.normal.into())
            >= self.options.feature_angle_degrees.to_radians().cos()
    }

    fn check_border(&self, beyond: f64) -> Result<(), NoContact> {
        let tolerance = self.options.border_tolerance;
        if beyond > tolerance { Err(NoContact::BeyondBorder { distance: beyond, tolerance }) } else { Ok(()) }
    }

    /// The frame of a diffuse element: the one that is held, or the average plane of the masters, outward where the
    /// slave's facet is now.
    pub fn current_frame(&self, paired: &Paired<'_>) -> Result<Frame, NoContact> {
        if let Some(frame) = paired.frame {
            return Ok(*frame);
        }
        let outward = self.facet(paired).normal().into();
        Ok(Frame::average_plane_of(self.masters(paired).map(|x| (x, 1.0)), 0.0, outward)?)
    }

    /// The corners of a node-to-facet element's facet among the listed nodes.
    pub fn corners_of<'s>(&self, paired: &Paired<'s>) -> &'s [u32] {
        &paired.masters[..self.surface.facet(paired.record.facet as usize).corners().len()]
    }

    pub fn gather_corners<'s>(&self, paired: &Paired<'_>, scratch: &'s mut ElementScratch) -> &'s [Point] {
        self.gather(&Paired { masters: self.corners_of(paired), ..*paired }, scratch)
    }

    pub fn gather<'s>(&self, paired: &Paired<'_>, scratch: &'s mut ElementScratch) -> &'s [Point] {
        scratch.masters.clear();
        scratch.masters.extend(paired.masters.iter().map(|&node| self.positions[node as usize]));
        &scratch.masters
    }

    /// What stands in the place of the held frame of a slave without a pairing, so that frames are found by the
    /// number of the slave.
    pub fn stand_in_frame(&self) -> Option<Frame> {
        let [t1, t2, normal] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.holds_frames().then_some(Frame {
            origin: [0.0; 3],
            t1,
            t2,
            normal,
            derivative: FrameDerivative::Held,
            reach: 0.0,
        })
    }

    /// The frame that is held from now on for these masters, if frames are held.
    pub fn held_frame(&self, paired: &Paired<'_>) -> Result<Option<Frame>, NoContact> {
        if !self.holds_frames() {
            return Ok(None);
        }
        Ok(Some(self.current_frame(&Paired { frame: None, ..*paired })?.held()))
    }

    const fn holds_frames(&self) -> bool {
        matches!(self.options.element, ContactElement::Diffuse { frame: FrameDerivative::Held, .. })
    }
}
