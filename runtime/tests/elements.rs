//! Elements that are refused: one by one, and beside others.

use diffuse_contact::{
    Backend, Basis, BatchScratch, Domains, Element, ElementError, Frame, GapSlot, Generated, Mode, Point,
    Weight,
};

/// An element that no kernel can evaluate costs the others nothing, whatever is missing of it.
#[test]
fn an_element_with_too_few_domains_is_refused_beside_others() {
    let masters: Vec<Point> = (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
    let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap();
    let radii = [2.0; 9];
    for weight in [Weight::Cubic, Weight::CubicInterpolating] {
        let element = |count: usize| {
            Element::new([0.1, 0.2, 0.25], &masters, frame, 2.0)
                .with_basis(Basis::Quadratic)
                .with_weight(weight)
                .with_domains(Domains::Each(&radii[..count]))
        };
        let elements = [element(9), element(8), element(0), element(9)];
        let slots = (0..4).map(|_| GapSlot::default());
        let found = Generated.gap_batch(&elements, Mode::Value, slots, &mut BatchScratch::default());
        for (element, found) in elements.iter().zip(found) {
            let alone = Generated.gap(element, Mode::Value);
            match (found, alone) {
                (Ok(found), Ok(alone)) => assert!((found.gap - alone.gap).abs() < 1e-14),
                (Err(found), Err(alone)) => {
                    assert_eq!(found, alone);
                    assert!(matches!(found, ElementError::WrongNumberOfDomains { .. }), "{found}");
                }
                (found, alone) => panic!("{found:?} {alone:?}"),
            }
        }
    }
}

#[test]
fn axes_that_are_not_finite_are_no_frame() {
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    for number in [f64::NAN, f64::INFINITY] {
        for axis in 0..3 {
            for place in 0..3 {
                let mut axes = [x, y, z];
                axes[axis][place] = number;
                let frame = Frame::given([0.0; 3], axes[0], axes[1], axes[2], None);
                assert!(matches!(frame, Err(ElementError::InvalidFrame { .. })), "{axes:?} {frame:?}");
            }
        }
    }
    assert!(Frame::given([0.0; 3], [2.0, 0.0, 0.0], [0.0, f64::NAN, 0.0], z, None).is_err());
}
