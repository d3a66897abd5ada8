//! Elastic matter of nodes without cells.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Expr, Mat3, Vec3, Vector};
use diffuse_contact_codegen::graph::Limits;

/// Rows and columns of a symmetric matrix's entries.
const PLACES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];

/// Energy μ ‖U − 1‖² + ½ λ tr(U − 1)² of the stretch U in F = R U: the deformation gradient F fits the nodes' positions x from their
/// positions X at rest best, with weights w, and U is the symmetric root of U² = Fᵀ F, six unknowns.
pub fn co_rotated<'g>(m: &ElementModel<'g>) {
    m.title("Energy of the stretch that fits nodes of any number best, by six equations.");
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let (x, X): (Vec3<'g>, Vec3<'g>) = (m.node_variable("x"), m.node_parameter("X"));
    let w: Expr<'g> = m.node_parameter("w");

    let centre = |x: Vec3<'g>| x.map(|x| (w * x).sum() / w.sum());
    let (x, X) = (x - m.define("centre", centre(x)), X - m.define("centre_at_rest", centre(X)));
    let moments = |x: Vec3<'g>, y: Vec3<'g>| Mat3::from_fn(|i, j| (w * x[i] * y[j]).sum());
    let F = m.define("F", moments(x, X) * moments(X, X).inverse());
    let C = m.define("C", F.transpose() * F);

    let (zero, one) = (m.sheet().zero(), m.sheet().one());
    let limits = Limits { longest_step: 0.5, evaluations: 40 };
    let at_rest = Vector([one, one, one, zero, zero, zero]);
    let stretch = m.root_from("stretch", at_rest, limits, |u| {
        let square = symmetric(u) * symmetric(u);
        Vector(PLACES.map(|(i, j)| square[i][j] - C[i][j]))
    });
    let strain = symmetric(Vector::from_fn(|k| stretch.unknowns[k] - at_rest[k]));
    m.energy(mu * strain.double_dot(strain) + 0.5 * lambda * strain.trace().powi(2));

    m.value("stretch", stretch.unknowns);
    m.value("residual", stretch.residual);
    m.describe("stretch", "11, 22, 33, 23, 31 and 12 of U.");
    m.describe("residual", "Of its equations: above 10⁻¹² there is no stretch.");
}

/// A symmetric matrix from its entries at [`PLACES`].
fn symmetric<'g>(u: Vector<'g, 6>) -> Mat3<'g> {
    let [a, b, c, d, e, f] = u.0;
    Mat3::from_columns([[a, f, e], [f, b, d], [e, d, c]].map(Vector))
}
