//! Domains of influence in the master's first configuration, where they stay what they are.

use super::average_plane::AveragePlane;
use super::weight::Weight;
use crate::expr::{Expr, Matrix, Sheet, Values, Vec3, Vector};
use crate::graph::Scope;
use crate::structure::{CoordinateMap, Elimination};

/// Names of the inputs of node scope: the node's offset X_k − Ξ from the slave's place in the first configuration, and the upper
/// triangle U of its metric, row by row.
pub(crate) const MATERIAL_INPUTS: [&str; 9] = [
    "material_x",
    "material_y",
    "material_z",
    "metric_xx",
    "metric_xy",
    "metric_xz",
    "metric_yy",
    "metric_yz",
    "metric_zz",
];

/// Where a node is in the first configuration, seen from the slave's place Ξ there.
#[derive(Clone, Copy)]
pub(super) struct Material<'g> {
    /// X_k − Ξ, as variables that move with Ξ.
    offset: Vec3<'g>,
    /// The same as an input.
    input: Vec3<'g>,
    /// r = |U (X_k − Ξ)|
    pub r: Expr<'g>,
    /// ω(r)
    pub omega: Expr<'g>,
}

impl<'g> Material<'g> {
    #[expect(non_snake_case, reason = "the symbol of docs/equations.md")]
    pub fn declare(sheet: &'g Sheet, weight: &Weight) -> Self {
        let [x, y, z, xx, xy, xz, yy, yz, zz] = MATERIAL_INPUTS.map(|name| sheet.input(name, Scope::Node));
        let offset = ["x_from_place", "y_from_place", "z_from_place"];
        let offset = Vector(offset.map(|name| sheet.input(name, Scope::Node)));
        let o = sheet.zero();
        let U = Matrix([[xx, xy, xz], [o, yy, yz], [o, o, zz]]);
        let r = (U * offset).norm().named("r");
        Self { offset, input: Vector([x, y, z]), r, omega: weight.fitting(r).named("plane_weight") }
    }

    /// Values of the offsets where Ξ has not moved.
    pub fn values(self) -> Values<'g> {
        self.offset.set_to(self.input)
    }

    /// Ξ as an unknown beside the turn and the height of the plane. It is the affine fit of the nodes' first positions by their
    /// positions in the plane, with the weights ω, taken at the slave [T18]:
    ///
    /// ```text
    /// Σ ω (1 + β·a_k) a_k = 0,   Σ ω (1 + β·a_k) (X_k − Ξ) = 0
    /// ```
    pub fn follow(
        self,
        plane: AveragePlane<'g>,
        coordinates: CoordinateMap<'g>,
    ) -> (AveragePlane<'g>, CoordinateMap<'g>) {
        let Self { offset, input, omega, .. } = self;
        let AveragePlane { mut block, system, position, mut moving, mut values } = plane;
        let a = Vector([position[0], position[1]]);
        let beta = omega.sheet().variables(["place_beta_1", "place_beta_2"]);
        // What Ξ has moved by.
        let shift = omega.sheet().variables(["place_x", "place_y", "place_z"]);
        moving.extend(offset.set_to(input - shift));
        values.extend(shift.set_to(Vector::zero(omega.sheet())));

        let affine = (1.0 + beta.dot(a)).named("place_affine");
        let weighted = (omega * affine).named("place_weight");
        let equations = [(weighted * a).to_vec(), (weighted * offset).to_vec()].concat();
        block.groups.push(equations.len());
        block.residual.extend(equations);
        block.unknowns.extend(beta.0.into_iter().chain(shift.0));

        // β is where the first two of them are zero: Σ ω a aᵀ β = −Σ ω a
        let second = (omega * a.outer(a)).at(&values).map(Expr::sum);
        let first = (omega * a).at(&values).map(Expr::sum);
        values.extend(beta.set_to(second.solve(-first).bind("place_slope")));

        let coordinates = coordinates.with_moving(&moving, &values);
        let equations = (&block.unknowns[..], &block.residual[..]);
        block.system = Elimination::of_residuals("place", equations, &coordinates, &values);
        (AveragePlane { block, system, position, moving, values }, coordinates)
    }
}
