//! Products of derivatives with a vector, against the derivatives times the vector: those of single elements, of batches, and of a body
//! that is assembled.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::witnesses::{difference, random};
use crate::{average, cohesive, fitted_contact, hex8_neo_hooke, tet4_neo_hooke};

/// A symmetric matrix, given as its packed lower triangle, times a vector.
fn packed_times(packed: &[f64], v: &[f64]) -> Vec<f64> {
    let entry = |i: usize, j: usize| packed[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
    (0..v.len()).map(|i| (0..v.len()).map(|j| entry(i, j) * v[j]).sum()).collect()
}

/// Tetrahedra of a cube, by its corners' numbers x + 2 y + 4 z; all share the diagonal.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

#[test]
fn products_of_tetrahedra_add_up_to_the_assembled_tangent_times_the_vector() {
    let mut random = random(0.43);
    let X: [[f64; 3]; 8] = std::array::from_fn(|k| [k & 1, k >> 1 & 1, k >> 2].map(|x| x as f64));
    let x = X.map(|X| X.map(|X| X + 0.2 * random()));
    let v: Vec<f64> = (0..24).map(|_| random()).collect();

    let of = |corners: [usize; 4]| tet4_neo_hooke::Inputs {
        x: corners.map(|k| x[k]),
        X: corners.map(|k| X[k]),
        lambda: 1.2,
        mu: 0.8,
    };
    let inputs = TETRAHEDRA.map(of);
    let places =
        TETRAHEDRA.map(|corners| -> [usize; 12] { std::array::from_fn(|i| 3 * corners[i / 3] + i % 3) });
    let mut tangent = vec![vec![0.0; 24]; 24];
    for (inputs, places) in inputs.iter().zip(&places) {
        let of_one = tet4_neo_hooke::evaluate(Mode::Hessian, inputs);
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            tangent[places[i]][places[j]] += of_one.hessian_at(i, j);
        }
    }
    let expected: Vec<f64> = tangent.iter().map(|row| row.iter().zip(&v).map(|(x, v)| x * v).sum()).collect();

    let directions = places.map(|places| places.map(|place| v[place]));
    for isa in Isa::available() {
        let mut products = [tet4_neo_hooke::Products::ZERO; 6];
        tet4_neo_hooke::multiply_batch(isa, &inputs, &directions, &mut products);
        let mut found = vec![0.0; 24];
        for (product, places) in products.iter().zip(&places) {
            product.hessian_product.iter().zip(places).for_each(|(x, &place)| found[place] += x);
        }
        let worst = difference(&found, &expected);
        assert!(worst < 1e-13, "{isa}: {worst:e}");
    }
    for ((inputs, direction), product) in inputs.iter().zip(&directions).zip({
        let mut products = [tet4_neo_hooke::Products::ZERO; 6];
        tet4_neo_hooke::multiply_batch(Isa::SCALAR, &inputs, &directions, &mut products);
        products
    }) {
        let single = tet4_neo_hooke::multiply(inputs, direction);
        assert!(difference(&single.hessian_product, &product.hessian_product) < 1e-15);
    }
}

#[test]
fn a_sum_over_points_is_multiplied_point_by_point() {
    let mut random = random(0.29);
    let X: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let x = X.map(|X| X.map(|X| X + 0.2 * random()));
    let inputs = hex8_neo_hooke::Inputs { x, X, lambda: 1.2, mu: 0.8 };
    let v: [f64; 24] = std::array::from_fn(|_| random());
    let expected = packed_times(&hex8_neo_hooke::evaluate(Mode::Hessian, &inputs).hessian, &v);
    for isa in Isa::available() {
        let mut products = [hex8_neo_hooke::Products::ZERO; 5];
        hex8_neo_hooke::multiply_batch(isa, &[inputs; 5], &[v; 5], &mut products);
        for found in products.iter().chain([&hex8_neo_hooke::multiply(&inputs, &v)]) {
            let worst = difference(&found.hessian_product, &expected);
            assert!(worst < 1e-13, "{isa}: {worst:e}");
        }
    }
}

#[test]
fn a_law_without_an_energy_has_the_product_with_its_jacobian() {
    let inputs =
        cohesive::Inputs { opening: [0.4, -0.2, 0.1], stiffness: 3.0, length: 0.7, damage_before: 0.2 };
    let v = [0.3, -0.7, 0.5];
    let jacobian = cohesive::evaluate(Mode::Gradient, &inputs).traction_jacobian;
    let expected: Vec<f64> =
        jacobian.chunks(3).map(|row| row.iter().zip(&v).map(|(x, v)| x * v).sum()).collect();
    let found = cohesive::multiply(&inputs, &v);
    assert!(difference(&found.traction_jacobian_product, &expected) < 1e-14);
}

/// Elements of different numbers of nodes in one batch, against their Hessians and Jacobians times the vectors.
#[test]
fn nodes_of_an_open_number_are_multiplied_node_by_node() {
    let mut random = random(0.61);
    let counts = [2, 7, 3, 7, 7, 2, 9, 7, 7];
    let nodes: Vec<Vec<average::Node<f64>>> = counts
        .iter()
        .map(|&count| {
            let node = |_| average::Node { X: [0; 3].map(|_| random()), w: 1.0 + random() };
            (0..count).map(node).collect()
        })
        .collect();
    let of = |nodes| average::Inputs { x: [0.3, 0.2, 0.1], compliance: 0.5, nodes };
    let inputs: Vec<average::Inputs<'_, f64>> = nodes.iter().map(|nodes| of(nodes)).collect();
    let v: Vec<f64> = (0..average::variables(9)).map(|_| random()).collect();
    let directions: Vec<&[f64]> = counts.iter().map(|&count| &v[..average::variables(count)]).collect();
    for isa in Isa::available() {
        let mut products = vec![average::Products::default(); counts.len()];
        average::multiply_batch(isa, &inputs, &directions, &mut products);
        for ((inputs, v), found) in inputs.iter().zip(&directions).zip(&products) {
            let of_one = average::evaluate(Mode::Hessian, inputs);
            assert!(difference(&found.hessian_product, &packed_times(&of_one.hessian, v)) < 1e-13, "{isa}");
            let rows = of_one.gap_jacobian.chunks(v.len());
            let expected: Vec<f64> = rows.map(|row| row.iter().zip(*v).map(|(x, v)| x * v).sum()).collect();
            assert!(difference(&found.gap_jacobian_product, &expected) < 1e-13, "{isa}");
            let single = average::multiply(inputs, v);
            assert!(difference(&found.hessian_product, &single.hessian_product) < 1e-14, "{isa}");
        }
    }
}

#[test]
fn a_fitted_surface_has_the_product_with_its_hessian() {
    let mut random = random(0.53);
    let node = |k: usize| {
        let (x, y) = ((k % 4) as f64 - 1.5, (k / 4) as f64 - 1.0);
        fitted_contact::Node { X: [x + 0.2 * random(), y + 0.2 * random(), 0.3 * random()], radius: 3.0 }
    };
    let nodes: Vec<fitted_contact::Node<f64>> = (0..12).map(node).collect();
    let axes = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let inputs = fitted_contact::Inputs { x: [0.05, -0.03, -0.5], axes, stiffness: 7.0, nodes: &nodes };
    let v: Vec<f64> = (0..fitted_contact::variables(nodes.len())).map(|_| random()).collect();
    let of_one = fitted_contact::evaluate(Mode::Hessian, &inputs);
    assert!(of_one.values.energy > 0.0);
    let expected = packed_times(&of_one.hessian, &v);
    let found = fitted_contact::multiply(&inputs, &v);
    let worst = difference(&found.hessian_product, &expected);
    assert!(worst < 1e-13, "{worst:e}");
}

#[test]
#[should_panic(expected = "as many vectors as inputs")]
fn a_batch_needs_a_vector_for_each_element() {
    tet4_neo_hooke::multiply_batch(Isa::SCALAR, &[crate::stretched(0.1)], &[], &mut []);
}
