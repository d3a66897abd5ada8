//! One element by itself: no handle, nothing remembered, any number of threads.

use std::mem::offset_of;

use runtime::assembly::ContactView;
use runtime::{
    Basis, ContactPoint, Element, ElementError, Frame, FrameDerivative, Generated, Mode, Point, Weight,
};

use crate::border::{self, Plain, Versioned, disjoint, input, read_sized, reserved, roomy, target, wanted};
use crate::choice::{self, dc_basis, dc_frame};
use crate::law::{self, dc_law};
use crate::outcome::{self, dc_outcome};
use crate::status::{DC_BAD_OPTION, DC_BAD_SIZE, Failure, dc_status};

/// What one element is besides its nodes. A field that is 0 has the value named first.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct dc_element {
    /// sizeof(dc_element), set by the caller.
    pub size: usize,
    /// dc_basis; 0 is DC_QUADRATIC.
    pub basis: i32,
    /// dc_weight: DC_CUBIC, ...
    pub weight: i32,
    /// dc_frame: DC_CO_MOVING, ...
    pub frame: i32,
    /// 0.
    pub reserved: i32,
    /// Radius of the domain of influence around the slave, length.
    pub support_radius: f64,
    /// A direction to the outward side of the master. DC_GIVEN: looked at only if it is not zero.
    pub outward: [f64; 3],
    /// DC_GIVEN only: the directions of the frame, orthonormal, `normal` outward.
    pub t1: [f64; 3],
    pub t2: [f64; 3],
    pub normal: [f64; 3],
}

// SAFETY: numbers, the first one is the size.
unsafe impl Versioned for dc_element {
    const NAME: &'static str = "dc_element";
    const FIRST: usize = offset_of!(Self, normal) + 24;
}

/// Where an element touches.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct dc_point {
    /// dc_outcome; only for DC_CONTACT are the numbers valid, else they are 0.
    pub outcome: i32,
    /// 0.
    pub reserved: i32,
    /// Signed gap, length: positive apart, negative penetrating.
    pub gap: f64,
    /// Foot on the surface.
    pub foot: [f64; 3],
    /// Unit normal there, outward.
    pub normal: [f64; 3],
}

/// What an element chooses by number.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    basis: Basis,
    weight: Weight,
    /// `None` for a frame that is given.
    frame: Option<FrameDerivative>,
}

// SAFETY: numbers, no padding.
unsafe impl Plain for dc_point {}

impl dc_point {
    pub fn new(result: Result<ContactPoint, ElementError>) -> Self {
        match result {
            Ok(ContactPoint { gap, foot, normal }) => {
                Self { outcome: dc_outcome::DC_CONTACT as i32, reserved: 0, gap, foot, normal }
            }
            Err(error) => Self { outcome: outcome::with_code(error.code()) as i32, ..Self::default() },
        }
    }
}

impl dc_element {
    /// # Safety
    /// As [`read_sized`].
    #[inline]
    pub unsafe fn read(element: *const Self) -> Result<Self, Failure> {
        // A field that is 0 has its default.
        let element = unsafe { read_sized(element, border::zeros)? };
        reserved("dc_element", element.reserved)?;
        Ok(element)
    }

    /// What is chosen by number.
    #[inline]
    pub fn kind(&self) -> Result<Kind, Failure> {
        let basis = if self.basis == 0 { dc_basis::DC_QUADRATIC as i32 } else { self.basis };
        let frames = [
            (dc_frame::DC_CO_MOVING as i32, Some(FrameDerivative::CoMoving)),
            (dc_frame::DC_HELD as i32, Some(FrameDerivative::Held)),
            (dc_frame::DC_GIVEN as i32, None),
        ];
        Ok(Kind {
            basis: choice::read(basis)?,
            weight: choice::read(self.weight)?,
            frame: choice::choose("frame", self.frame, &frames)?,
        })
    }

    /// As the runtime has it.
    #[inline]
    pub fn with_nodes<'a>(
        &self,
        kind: &Kind,
        slave: Point,
        masters: &'a [Point],
    ) -> Result<Element<'a>, ElementError> {
        let &Kind { basis, weight, frame } = kind;
        let frame = match frame {
            None => {
                let outward = Some(self.outward).filter(|outward| *outward != [0.0; 3]);
                Frame::given(slave, self.t1, self.t2, self.normal, outward)?
            }
            Some(derivative) => Frame { derivative, ..self.average_plane(masters)? },
        };
        Ok(Element::new(slave, masters, frame, self.support_radius).with_basis(basis).with_weight(weight))
    }

    fn average_plane(&self, masters: &[Point]) -> Result<Frame, ElementError> {
        if !self.outward.iter().all(|x| x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "outward", index: 0 });
        }
        Frame::average_plane(masters, self.outward)
    }
}

/// Entries of N and M that a mode asks for; `None` if there are more than can be counted.
pub fn sizes(masters: usize, mode: Mode) -> Option<[usize; 2]> {
    let freedoms = masters.checked_add(1)?.checked_mul(3)?;
    let packed = freedoms.checked_mul(freedoms.checked_add(1)?)? / 2;
    let wanted = |level, size| if mode >= level { size } else { 0 };
    Some([wanted(Mode::Gradient, freedoms), wanted(Mode::Hessian, packed)])
}

/// Gap, foot and normal of one element, and as far as `mode`, a dc_mode, asks for them N and M, in the order of dc_derivatives:
/// slave, master 1, ..., master n. `slave` has 3 numbers, `masters` 3 n. The order of the nodes of a pairing does not matter, but for
/// rounding.
///
/// DC_NO_CONTACT if the element has no result: point->outcome and dc_message() say why. The derivatives then hold anything, as they do
/// if the runtime refuses numbers of the element: DC_NOT_FINITE, DC_BAD_OPTION for a support radius or a frame, DC_BAD_SIZE for too few
/// masters; the outcome is DC_REFUSED then. (Masters that have no average plane, as two never have, are DC_NO_CONTACT.)
///
/// # Safety
/// The arrays have the given lengths, `element` as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_gap(
    element: *const dc_element,
    slave: *const f64,
    masters: *const f64,
    master_count: usize,
    mode: i32,
    point: *mut dc_point,
    gradient: *mut f64,
    gradient_size: usize,
    hessian: *mut f64,
    hessian_size: usize,
) -> dc_status {
    border::call(|| {
        let mode: Mode = choice::read(mode)?;
        let Some([freedoms, packed]) = sizes(master_count, mode) else {
            return Err(Failure::new(
                DC_BAD_SIZE,
                format!("bad-size: there cannot be {master_count} masters"),
            ));
        };
        let point = target("point", point, 1)?;
        let gradient = roomy("gradient", gradient, gradient_size, freedoms)?;
        let hessian = roomy("hessian", hessian, hessian_size, packed)?;
        disjoint([
            border::read("slave", slave, 3),
            border::read("masters", masters, 3 * master_count),
            point.span(),
            gradient.span(),
            hessian.span(),
        ])?;
        let (element, slave, masters) = unsafe {
            (
                dc_element::read(element)?,
                input("slave", slave, 3)?,
                input("masters", masters, 3 * master_count)?,
            )
        };
        let kind = element.kind()?;
        let slave = [slave[0], slave[1], slave[2]];
        // SAFETY: as the caller promises; nothing overlaps.
        let (gradient, hessian) = unsafe { (gradient.unspecified(), hessian.unspecified()) };
        let found = element
            .with_nodes(&kind, slave, masters.as_chunks::<3>().0)
            .and_then(|element| Generated.gap_into(&element, mode, gradient, hessian));
        unsafe { point.write([dc_point::new(found)]) };
        found.map(drop).map_err(Failure::from)
    })
}

/// Force and stiffness of one element from its gap and derivatives, over its own 3(n+1) coordinates: R = f N into `nodal_forces`, K = -dR/dx
/// into `tangent`, 3(n+1) square, both triangles. Zeros if it carries no force. `force` f. What is not wanted is NULL. `area` is the
/// slave's tributary area, 1 where the penalty is one per node. `hessian` may be NULL for DC_GAUSS_NEWTON or without `tangent`.
///
/// After a failure `nodal_forces` and `tangent` hold anything.
///
/// # Safety
/// `gradient` has 3(`master_count` + 1) entries, `hessian` those of its lower triangle, `nodal_forces` and `tangent` have the given
/// lengths; `law` as in dc_add_forces, with one multiplier or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_element_system(
    law: *const dc_law,
    gap: f64,
    area: f64,
    master_count: usize,
    gradient: *const f64,
    hessian: *const f64,
    force: *mut f64,
    nodal_forces: *mut f64,
    nodal_forces_size: usize,
    tangent: *mut f64,
    tangent_size: usize,
) -> dc_status {
    border::call(|| {
        let too_many =
            || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {master_count} masters"));
        let [freedoms, packed] = sizes(master_count, Mode::Hessian).ok_or_else(too_many)?;
        let square = freedoms.checked_mul(freedoms).ok_or_else(too_many)?;
        let force = wanted("force", force, 1, 1)?;
        let nodal_forces = wanted("nodal_forces", nodal_forces, nodal_forces_size, freedoms)?;
        let tangent = wanted("tangent", tangent, tangent_size, square)?;
        let packed = if hessian.is_null() { 0 } else { packed };
        unsafe { law::disjoint(law, [force.span(), nodal_forces.span(), tangent.span()])? };
        disjoint([
            border::read("gradient", gradient, freedoms),
            border::read("hessian", hessian, packed),
            force.span(),
            nodal_forces.span(),
            tangent.span(),
        ])?;
        // SAFETY: as the caller promises; nothing overlaps.
        let (law, gradient, hessian) = unsafe {
            (law::read(law)?, input("gradient", gradient, freedoms)?, input("hessian", hessian, packed)?)
        };
        let law = law.contact()?;
        if law.friction.is_some() {
            let message =
                "friction-of-one-element: a single element has no slip, friction is that of an interface";
            return Err(Failure::new(DC_BAD_OPTION, message));
        }
        // SAFETY: as the caller promises; nothing overlaps.
        let (nodal_forces, tangent) = unsafe { (nodal_forces.unspecified(), tangent.unspecified()) };
        let contact = ContactView { gap, area, gradient, hessian, slip: None };
        let found = law.element_system(&contact, nodal_forces, tangent)?;
        unsafe { force.write([found]) };
        Ok(())
    })
}
