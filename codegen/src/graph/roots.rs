//! Small systems of equations, solved by iteration or known beforehand.

use rustc_hash::FxHashMap;

use super::{ExprId, Graph, Iteration, Limits, Op, Root, RootFigure, RootId, SymbolId};

impl Graph {
    /// What a root's equations depend on besides its own unknowns: their largest subexpressions that contain
    /// none of them.
    pub(crate) fn dependencies_of_root(&self, root: RootId) -> &[ExprId] {
        &self.parameters[root.index()]
    }

    fn parameters_of(&self, root: &Root) -> Vec<ExprId> {
        let mut varies = FxHashMap::default();
        let mut parameters = Vec::new();
        for &expr in root.residuals.iter().chain(root.jacobian.iter().flatten()) {
            if !self.varies_with(expr, &root.unknowns, &mut varies, &mut parameters) {
                parameters.push(expr);
            }
        }
        parameters.retain(|&x| self.constant_value(x).is_none());
        parameters.sort_unstable();
        parameters.dedup();
        parameters
    }

    fn varies_with(
        &self,
        expr: ExprId,
        unknowns: &[SymbolId],
        varies: &mut FxHashMap<ExprId, bool>,
        parameters: &mut Vec<ExprId>,
    ) -> bool {
        if let Some(&known) = varies.get(&expr) {
            return known;
        }
        let result = match self.op(expr) {
            Op::Symbol(symbol) => unknowns.contains(&symbol),
            _ => {
                let operands = self.operands(expr);
                let by_operand: Vec<bool> =
                    operands.iter().map(|&x| self.varies_with(x, unknowns, varies, parameters)).collect();
                let any = by_operand.contains(&true);
                if any {
                    parameters
                        .extend(operands.iter().zip(&by_operand).filter(|(_, v)| !**v).map(|(&x, _)| x));
                }
                any
            }
        };
        varies.insert(expr, result);
        result
    }

    /// Adds a small system of equations; returns its unknowns at the root.
    pub fn add_root(
        &mut self,
        name: &str,
        unknowns: &[ExprId],
        residuals: Vec<ExprId>,
        iteration: Iteration,
    ) -> (RootId, Vec<ExprId>) {
        let jacobian = self.jacobian(unknowns, &residuals);
        self.add_root_with_jacobian(name, unknowns, residuals, jacobian, iteration)
    }

    /// Adds a small system of equations whose root is known: nothing is solved for the values, which the unknowns have; the equations
    /// say how these change.
    ///
    /// # Panics
    /// If there is not one value for each unknown.
    pub fn add_known_root(
        &mut self,
        name: &str,
        unknowns: &[ExprId],
        residuals: Vec<ExprId>,
        known: &[ExprId],
    ) -> (RootId, Vec<ExprId>) {
        assert_eq!(unknowns.len(), known.len(), "{name}: one value for each unknown");
        let jacobian = self.jacobian(unknowns, &residuals);
        let unknowns = unknowns.iter().map(|&u| self.symbol_of(u)).collect();
        let (name, known, iteration) =
            (self.root_name(name), known.to_vec(), Iteration::Within(Limits::LINEAR));
        self.push_root(Root { name, unknowns, residuals, jacobian, iteration, known })
    }

    fn jacobian(&mut self, unknowns: &[ExprId], residuals: &[ExprId]) -> Vec<Vec<ExprId>> {
        let unknowns: Vec<SymbolId> = unknowns.iter().map(|&u| self.symbol_of(u)).collect();
        let row = |&residual| unknowns.iter().map(|&u| self.derivative(residual, u)).collect();
        residuals.iter().map(row).collect()
    }

    /// As [`add_root`](Self::add_root), with the Jacobian ∂(residual)/∂(unknown) made elsewhere.
    pub fn add_root_with_jacobian(
        &mut self,
        name: &str,
        unknowns: &[ExprId],
        residuals: Vec<ExprId>,
        jacobian: Vec<Vec<ExprId>>,
        iteration: Iteration,
    ) -> (RootId, Vec<ExprId>) {
        let unknowns = unknowns.iter().map(|&u| self.symbol_of(u)).collect();
        self.push_root(Root {
            name: name.to_owned(),
            unknowns,
            residuals,
            jacobian,
            iteration,
            known: Vec::new(),
        })
    }

    fn push_root(&mut self, root: Root) -> (RootId, Vec<ExprId>) {
        let count = root.unknowns.len();
        self.parameters.push(self.parameters_of(&root));
        self.roots.push(root);
        let root = RootId(u32::try_from(self.roots.len() - 1).expect("fewer than 2³² roots"));
        (root, (0..count).map(|k| self.intern(Op::RootValue(root, k as u32))).collect())
    }

    /// Unknowns u of A u = b, with no symmetry: the root of linear equations, which kernels find with a search for pivots. The same
    /// equations are solved once.
    pub fn solve_general(
        &mut self,
        name: &str,
        matrix: &[Vec<ExprId>],
        right_hand_side: &[ExprId],
    ) -> (RootId, Vec<ExprId>) {
        let key = (matrix.to_vec(), right_hand_side.to_vec());
        if let Some(&root) = self.linear.get(&key) {
            return (root, (0..matrix.len()).map(|k| self.intern(Op::RootValue(root, k as u32))).collect());
        }
        // Roots are told apart by their names.
        let name = self.root_name(name);
        let unknowns: Vec<ExprId> =
            (0..matrix.len()).map(|k| self.variable(&format!("{name}_unknown_{}", k + 1))).collect();
        let residuals = matrix.iter().zip(right_hand_side).map(|(row, &b)| {
            let product = self.dot(row, &unknowns);
            self.sub(product, b)
        });
        let residuals = residuals.collect();
        let iteration = Iteration::Within(Limits::LINEAR);
        let (root, values) =
            self.add_root_with_jacobian(&name, &unknowns, residuals, matrix.to_vec(), iteration);
        self.linear.insert(key, root);
        (root, values)
    }

    fn root_name(&self, name: &str) -> String {
        let is_free = |name: &str| !self.roots.iter().any(|root| root.name == name);
        if is_free(name) {
            return name.to_owned();
        }
        (2..).map(|k| format!("{name}_{k}")).find(|name| is_free(name)).unwrap_or_default()
    }

    /// A figure of a root's iteration.
    pub fn root_figure(&mut self, root: RootId, figure: RootFigure) -> ExprId {
        self.intern(Op::RootFigure(root, figure))
    }
}
