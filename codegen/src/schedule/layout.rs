//! How the expressions of a piece of code are written: which get a name, and which products fuse with an addition.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Layout, MOST_DEPTH, Scheduler, Statement};
use crate::graph::{ExprId, Op};

impl<S: Clone> Scheduler<'_, S> {
    /// Decides which members get a name and which products fuse with an addition; returns the `let`s in order.
    /// `results` are used once more each by what follows the piece, `external` by other pieces.
    pub(super) fn lay_out(
        &self,
        members: &[ExprId],
        results: &[ExprId],
        external: &FxHashSet<ExprId>,
        layout: &mut Layout,
    ) -> Vec<Statement> {
        let inside: FxHashSet<ExprId> = members.iter().copied().collect();
        let mut users: FxHashMap<ExprId, Vec<ExprId>> = FxHashMap::default();
        for &x in members {
            if matches!(self.graph.op(x), Op::Sum(_)) {
                continue;
            }
            for operand in self.graph.operands(x) {
                users.entry(operand).or_default().push(x);
            }
        }
        let mut result_uses: FxHashMap<ExprId, usize> = FxHashMap::default();
        for &x in results {
            *result_uses.entry(x).or_insert(0) += 1;
        }
        self.fuse(members, external, &users, layout);

        let mut depth: FxHashMap<ExprId, usize> = FxHashMap::default();
        let mut statements = Vec::new();
        for &x in members {
            match self.graph.op(x) {
                Op::Constant(_) | Op::Symbol(_) | Op::Sum(_) => {
                    layout.bound.insert(x);
                    continue;
                }
                Op::RootValue(root, _) | Op::RootFigure(root, _) => {
                    layout.bound.insert(x);
                    if !statements.contains(&Statement::Solve(root)) {
                        statements.push(Statement::Solve(root));
                    }
                    continue;
                }
                _ => {}
            }
            let mine = users.get(&x).map_or(&[][..], Vec::as_slice);
            let nested = 1 + self
                .graph
                .operands(x)
                .iter()
                .filter(|y| inside.contains(y))
                .map(|y| depth.get(y).copied().unwrap_or(0))
                .max()
                .unwrap_or(0);
            let op = self.graph.op(x);
            let always_fused =
                !mine.is_empty() && mine.iter().all(|&user| self.is_fused_in(x, user, &users, layout));
            let is_sign = matches!(op, Op::Neg(_));
            let named = self.graph.name_of(x).is_some() && !matches!(op, Op::Mul(..) | Op::Neg(_));
            let as_result = result_uses.get(&x).copied().unwrap_or(0);
            // A product that all its users take in is written there, and nowhere else.
            let taken_in = always_fused && as_result == 0;
            let bind = external.contains(&x)
                || (!taken_in
                    && ((mine.len() + as_result > 1 && !is_sign)
                        || (named && !mine.is_empty())
                        || nested > MOST_DEPTH));
            if bind {
                layout.bound.insert(x);
                statements.push(Statement::Let(x));
            }
            depth.insert(x, if bind { 0 } else { nested });
        }
        statements
    }

    /// Whether `user` (or each sum the sign `user` stands in) takes the product `x` in fused.
    fn is_fused_in(
        &self,
        x: ExprId,
        user: ExprId,
        users: &FxHashMap<ExprId, Vec<ExprId>>,
        layout: &Layout,
    ) -> bool {
        match self.graph.op(user) {
            Op::Add(..) => layout.fused.get(&user) == Some(&x),
            Op::Neg(_) => users
                .get(&user)
                .is_some_and(|outer| outer.iter().all(|outer| layout.fused.get(outer) == Some(&user))),
            _ => false,
        }
    }

    /// Chooses for every addition the product fused with it. A product used by several additions is recomputed in
    /// each, which costs nothing, if all of them can take it in.
    fn fuse(
        &self,
        members: &[ExprId],
        external: &FxHashSet<ExprId>,
        users: &FxHashMap<ExprId, Vec<ExprId>>,
        layout: &mut Layout,
    ) {
        let inside: FxHashSet<ExprId> = members.iter().copied().collect();
        let is_product = |x: ExprId| {
            let x = self.graph.without_sign(x);
            matches!(self.graph.op(x), Op::Mul(..)) && inside.contains(&x) && !external.contains(&x)
        };
        let only_added = |x: ExprId| {
            users.get(&x).is_some_and(|mine| {
                mine.iter().all(|&user| match self.graph.op(user) {
                    Op::Add(..) => true,
                    Op::Neg(_) => {
                        !external.contains(&user)
                            && users.get(&user).is_some_and(|outer| {
                                outer.iter().all(|&outer| matches!(self.graph.op(outer), Op::Add(..)))
                            })
                    }
                    _ => false,
                })
            })
        };
        for &sum in members {
            let Op::Add(x, y) = self.graph.op(sum) else { continue };
            let candidates: Vec<ExprId> = [x, y]
                .into_iter()
                .filter(|&operand| is_product(operand) && only_added(self.graph.without_sign(operand)))
                .collect();
            // With two products to choose from, the one with more users, then the later one, is fused.
            let uses = |x: ExprId| users.get(&self.graph.without_sign(x)).map_or(0, Vec::len);
            if let Some(&best) = candidates.iter().max_by_key(|&&x| (uses(x), x)) {
                layout.fused.insert(sum, best);
            }
        }
    }
}
