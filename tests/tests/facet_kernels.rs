//! What the kernels of facets return, as they are.

use diffuse_contact::{ElementError, FacetElement, Generated};
use diffuse_contact_kernels::gap_over_quadrilateral::{Inputs, evaluate_to};
use diffuse_contact_kernels::support::Mode;

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn a_square_is_the_measure_of_area() {
    let inputs = Inputs { slave: [0.25, 0.5, -0.125], corners: SQUARE };
    let values = evaluate_to(Mode::Hessian, &inputs, &mut [0.0; 15], &mut [0.0; 120]);
    assert_eq!((values.gap, values.natural, values.corner_area), (-0.125, [-0.5, 0.0], 1.0));
    assert_eq!(values.jacobian_determinant, 1.0);
}

#[test]
fn a_facet_without_area_has_a_figure() {
    let element = FacetElement { slave: [0.0, 0.0, 1.0], corners: &[[0.5; 3]; 3] };
    assert_eq!(Generated.facet_point(&element), Err(ElementError::DegenerateFacet { area: 0.0 }));
}

#[test]
fn every_result_has_to_be_finite() {
    // M is 1/length.
    let corners = SQUARE.map(|x| x.map(|x| 1e-310 * x));
    let element = FacetElement { slave: [0.2e-310, 0.2e-310, 0.1e-310], corners: &corners };
    assert!(Generated.facet_gap(&element, diffuse_contact::Mode::Hessian).is_err());
}

#[test]
#[should_panic(expected = "14 entries where 15 are needed")]
fn a_short_slice_is_refused() {
    let inputs = Inputs { slave: [0.0, 0.0, 1.0], corners: SQUARE };
    let _ = evaluate_to(Mode::Gradient, &inputs, &mut [0.0; 14], &mut []);
}
