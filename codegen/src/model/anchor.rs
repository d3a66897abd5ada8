//! The node whose interpolating weight may be infinite, as an unknown of the fit.

use crate::graph::{ExprId, Graph, NODE_INDEX, Scope, SymbolId};

/// The node nearest to the slave, whose interpolating weight (16) may be infinite. Its weight times its error,
/// σ = w_k e_k, is an unknown with the equation e_k = σ/w_k, smooth where 1/w_k = 0: what [T8] does by elimination. The
/// surface does not depend on which node is the anchor.
#[derive(Clone, Copy)]
pub(super) struct Anchor {
    /// 1 at the anchor, 0 at the other nodes.
    pub indicator: ExprId,
    /// 1/w at the anchor, 0 at the other nodes.
    pub compliance: ExprId,
    /// Its in-plane coordinates, held: the origin of the basis, so that p = e₀ there.
    pub origin: [ExprId; 2],
}

impl Anchor {
    /// The anchor, and the weight of the other nodes. The node with index `anchor` of the input is it.
    pub fn declare(g: &mut Graph, weight: ExprId, compliance: ExprId, offset: [ExprId; 3]) -> (ExprId, Self) {
        let (index, anchor) = (g.input(NODE_INDEX, Scope::Node), g.input("anchor", Scope::Element));
        let difference = g.sub(index, anchor);
        let square = g.mul(difference, difference);
        let (half, zero, one) = (g.constant(0.5), g.zero(), g.one());
        // The pole's infinity and its derivatives' NaN are in the branch that is not taken.
        let mut choose = |here: ExprId, elsewhere: ExprId| g.select_less(square, half, here, elsewhere);
        let weight = choose(zero, weight);
        let indicator = choose(one, zero);
        let compliance = choose(compliance, zero);
        let own = [choose(offset[0], zero), choose(offset[1], zero)];
        g.name(indicator, "is_anchor");
        g.name(compliance, "compliance");
        let mut origin = own;
        for (k, name) in ["anchor_a", "anchor_b"].into_iter().enumerate() {
            let sum = g.sum(own[k]);
            origin[k] = g.bind(name, sum);
        }
        (weight, Self { indicator, compliance, origin })
    }

    /// The row of σ in the system, −(p_k·α) − σ/w_k with p = e₀ at the anchor, and its right-hand side −z_k.
    pub fn equation(
        self,
        g: &mut Graph,
        row: usize,
        height: ExprId,
        values: &[(SymbolId, ExprId)],
    ) -> (Vec<ExprId>, ExprId) {
        let own_height = g.mul(self.indicator, height);
        let [compliance, height] = [self.compliance, own_height].map(|x| {
            let x = g.substitute(x, values);
            let sum = g.sum(x);
            g.neg(sum)
        });
        let (zero, minus_one) = (g.zero(), g.constant(-1.0));
        let mut entries = vec![zero; row + 1];
        entries[0] = minus_one;
        entries[row] = compliance;
        (entries, height)
    }
}
