//! The slip of a contact with friction [T16].
//!
//! A material point of the master is remembered by an *anchor*, an affine combination x^a of master nodes that an earlier foot
//! was at. With d = x^c − x^a and the unit normal ν at the foot of today,
//!
//! ```text
//! q = ½ |P_ν d|² = ½ |ν × d|²,   P_ν = 1 − ν νᵀ
//! ```
//!
//! is half the square of the slip: smooth also where there is none, and invariant under rigid motions of all that it depends on.

use super::average_plane::turned_back;
use super::diffuse::{AtFoot, Diffuse};
use crate::expr::{Expr, Values, Vec3, Vector, all_at};
use crate::graph::Scope;
use crate::structure::{CoordinateMap, Follower, Functional, PointDependence};

/// The slip as a functional of the coefficients at the foot and of the anchor.
pub(super) struct Slip<'g> {
    pub functional: Functional<'g>,
    /// q
    pub half_square: Expr<'g>,
    /// φ_k, a node's part in the foot.
    pub foot_weight: Expr<'g>,
}

/// Where the anchor is, seen from the slave.
struct AnchorPoint<'g> {
    /// Its offset over R in the frame; where the frame moves, variables that move with it.
    position: Vec3<'g>,
    coordinates: CoordinateMap<'g>,
    /// Values of the variables.
    values: Values<'g>,
}

impl<'g> Diffuse<'g> {
    fn anchor(&self) -> AnchorPoint<'g> {
        let sheet = self.sheet();
        let point = sheet.vector("anchor", Scope::Element);
        let from_slave = (point - self.slave()).named("anchor_from_slave");
        let names = ["anchor_local_a", "anchor_local_b", "anchor_local_z"];
        let offset = Vector::from_fn(|k| from_slave.dot(self.axis(k)).bind(names[k]));
        let coordinates = CoordinateMap::new(&offset.0, point, self.slave());
        let Some(plane) = self.plane() else {
            return AnchorPoint { position: offset, coordinates, values: Vec::new() };
        };
        let theta = Vector([plane.block.unknowns[0], plane.block.unknowns[1]]);
        let position = sheet.variables(["anchor_a_turned", "anchor_b_turned", "anchor_z_turned"]);
        let moving = position.set_to(turned_back(theta, offset));
        let values = [&plane.values[..], &position.set_to(offset)].concat();
        let coordinates = coordinates.with_moving(&moving, &values);
        AnchorPoint { position, coordinates, values }
    }

    /// q as a stationary value: with the foot equations F(δ, α) = 0 and their adjoint μ, q + μ·F changes with neither δ nor μ to first
    /// order, so that its first derivatives by α and y are partial ones.
    #[expect(non_snake_case, reason = "the symbols of the foot equations")]
    pub fn slip(&self, at: &AtFoot<'g>) -> Slip<'g> {
        let sheet = self.sheet();
        let &AtFoot { ref fit, delta, surface, equations: F, jacobian: J, .. } = at;
        let AnchorPoint { position: y, coordinates, values } = self.anchor();
        let R = self.support_radius();

        // n = (−f_1, −f_2, 1): ν × d = −R n × y / |n|.
        let n = Vector([-surface.slopes[0], -surface.slopes[1], sheet.one()]);
        let cross = n.cross(y);
        let q = 0.5 * R * R * cross.dot(cross) / n.dot(n);

        let mu = sheet.variables(["slip_mu_1", "slip_mu_2"]);
        let stationary = q + mu.dot(F);
        let at_delta = delta.set_to(Vector::zero(sheet));
        // Jᵀ μ = −∂q/∂δ
        let J_at_foot = J.at(&at_delta).transpose();
        let mu_value = J_at_foot.solve(-q.gradient(delta).at(&at_delta));
        let mu_at_anchor = mu_value.at(&values).bind("slip_adjoint");
        let at_foot = [&at_delta[..], &mu.set_to(mu_at_anchor), &values].concat();

        let inverse_transposed = J_at_foot.inverse().named("slip_inverse");
        let adjoint_equations = stationary.gradient(delta);
        let unknowns = fit.problem.unknowns();
        let first: Vec<Expr<'g>> = unknowns.iter().map(|&alpha| stationary.by(alpha)).collect();
        let follower = |&alpha: &Expr<'g>| {
            let mut follower = Follower::new(alpha);
            let step = J.at(&at_delta).solve(-F.by(alpha).at(&at_delta));
            follower.follow(delta.set_to(step));
            follower.follow_root(mu, adjoint_equations, inverse_transposed, &at_foot);
            follower
        };
        let followers: Vec<Follower<'g>> = unknowns.iter().map(follower).collect();
        let second = first
            .iter()
            .map(|&first| followers.iter().map(|by| by.total_derivative(first).at(&at_foot)).collect());
        let second = second.collect();

        let of_anchor = [&at_delta[..], &mu.set_to(mu_value)].concat();
        let point = PointDependence {
            value: q.at(&at_delta),
            by_unknowns: all_at(&first, &of_anchor),
            coordinates,
            values,
        };
        let half_square = point.value.at(&point.values);
        let first = all_at(&first, &at_foot);
        let functional = Functional { name: "slip".to_owned(), first, second, point: Some(point) };
        Slip { functional, half_square, foot_weight: self.foot_weight(at) }
    }

    /// φ_k = ∂f(u)/∂z_k: the foot is Σ φ_k x_k [T15].
    fn foot_weight(&self, at: &AtFoot<'g>) -> Expr<'g> {
        let at_foot = at.delta.set_to(Vector::zero(self.sheet()));
        let first: Vec<Expr<'g>> =
            at.fit.problem.unknowns().iter().map(|&alpha| at.surface.value.by(alpha).at(&at_foot)).collect();
        at.fit.problem.sensitivity("foot", &first, self.height())
    }
}
