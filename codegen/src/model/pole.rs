//! The node whose interpolating weight may be infinite, as an unknown of the fit.

use crate::expr::{Expr, Vec2, Vec3, Vector};
use crate::graph::{NODE_INDEX, Scope};

/// The node nearest to the slave, whose interpolating weight (16) may be infinite. Its weight times its error,
/// σ = w_k e_k, is an unknown with the equation e_k = σ/w_k, smooth where 1/w_k = 0. The surface does not depend on
/// which node is the pole.
#[derive(Clone, Copy)]
pub(super) struct Pole<'g> {
    /// 1 at the pole, 0 at the other nodes.
    pub indicator: Expr<'g>,
    /// 1/w at the pole, 0 at the other nodes.
    pub compliance: Expr<'g>,
    /// Its in-plane coordinates, held: the origin of the basis, so that p = e₀ there.
    pub origin: Vec2<'g>,
}

impl<'g> Pole<'g> {
    /// The pole, and the weight of the other nodes. The node with index `pole` of the input is it.
    pub fn declare(weight: Expr<'g>, compliance: Expr<'g>, offset: Vec3<'g>) -> (Expr<'g>, Self) {
        let sheet = weight.sheet();
        let (index, pole) = (sheet.input(NODE_INDEX, Scope::Node), sheet.input("pole", Scope::Element));
        let is_here = (index - pole).powi(2).less(0.5);
        let (zero, one) = (sheet.zero(), sheet.one());
        // The pole's infinity and its derivatives' NaN are in the branch that is not taken.
        let weight = is_here.select(zero, weight);
        let indicator = is_here.select(one, zero).named("is_pole");
        let compliance = is_here.select(compliance, zero).named("compliance");
        let [a, b] = [offset[0], offset[1]].map(|x| is_here.select(x, zero));
        let origin = Vector([a.sum().bind("pole_a"), b.sum().bind("pole_b")]);
        (weight, Self { indicator, compliance, origin })
    }

    /// The row of σ in the system, −(p_k·α) − σ/w_k with p = e₀ at the pole, and its right-hand side −z_k.
    pub fn equation(
        self,
        row: usize,
        height: Expr<'g>,
        values: &[(Expr<'g>, Expr<'g>)],
    ) -> (Vec<Expr<'g>>, Expr<'g>) {
        let [height, compliance] = [self.indicator * height, self.compliance].map(|x| -x.at(values).sum());
        let mut entries = vec![height.sheet().zero(); row + 1];
        entries[0] = height.sheet().number(-1.0);
        entries[row] = compliance;
        (entries, height)
    }
}
