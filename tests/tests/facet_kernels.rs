//! What the kernels of facets return, as they are.

use diffuse_contact_kernels::facet::{quadrilateral, triangle};
use diffuse_contact_kernels::support::{FacetInputs, FacetValues, Mode, Status};

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn values(slave: [f64; 3], corners: [[f64; 3]; 4]) -> FacetValues<f64> {
    quadrilateral(Mode::Hessian, &FacetInputs { slave, corners }, &mut [0.0; 15], &mut [0.0; 120])
}

#[test]
fn a_square_is_the_measure_of_area() {
    let values = values([0.25, 0.5, -0.125], SQUARE);
    assert_eq!(values.status(), Status::Ok);
    assert_eq!((values.gap, values.natural, values.corner_area), (-0.125, [-0.5, 0.0], 1.0));
    assert_eq!(values.jacobian_determinant, 1.0);
}

#[test]
fn every_result_is_in_the_checksum() {
    for (slave, corners) in [
        ([f64::NAN, 0.0, 1.0], SQUARE),
        ([0.0, 0.0, f64::INFINITY], SQUARE),
        // M is 1/length.
        ([0.2e-310, 0.2e-310, 0.1e-310], SQUARE.map(|x| x.map(|x| 1e-310 * x))),
    ] {
        let mut hessian = [0.0; 120];
        let inputs = FacetInputs { slave, corners };
        let values = quadrilateral(Mode::Hessian, &inputs, &mut [0.0; 15], &mut hessian);
        assert_ne!(values.status(), Status::Ok);
    }
}

#[test]
fn a_facet_without_area_has_a_figure() {
    let inputs = FacetInputs { slave: [0.0, 0.0, 1.0], corners: [[0.5; 3]; 3] };
    let values = triangle(Mode::Value, &inputs, &mut [], &mut []);
    assert_eq!(values.status(), Status::DegenerateFacet { area: 0.0 });
}

#[test]
#[should_panic(expected = "14 entries where 15 are needed")]
fn a_short_slice_is_refused() {
    let inputs = FacetInputs { slave: [0.0, 0.0, 1.0], corners: SQUARE };
    let _ = quadrilateral(Mode::Gradient, &inputs, &mut [0.0; 14], &mut []);
}
