//! Unknowns whose values are known, and in which a function is stationary.
//!
//! A function E(z, w) of variables z and unknowns w, which follow r(w, z) = 0, is stationary in w: E_w dw/dz = 0 wherever r = 0. Then
//!
//! ```text
//! dE/dz = E_z        d²E/dz² = E_zz + E_zw C        C = dw/dz = −r_w⁻¹ r_z
//! ```
//!
//! at the values that w has, which are put in before anything is computed: often most of r_w and E_zw is zero there. E_zz + E_zw C is
//! symmetric in exact arithmetic, but its rows are kept as they are. Those that belong to a vector then show what they have in common.

use super::definition::Intermediate;
use super::factors::{ScaledVector, common_factor};
use crate::expr::{Expr, dot};
use crate::graph::{Op, Root};

/// Roots whose values are known, each after those that its equations contain.
pub(super) struct Known<'g> {
    unknowns: Vec<Intermediate<'g>>,
    roots: Vec<Equations<'g>>,
    values: Vec<(Expr<'g>, Expr<'g>)>,
}

/// The equations of a root, in the symbols that its unknowns have elsewhere.
struct Equations<'g> {
    name: String,
    /// The symbols; where nothing depends on an unknown, that of the equations themselves.
    unknowns: Vec<Expr<'g>>,
    residuals: Vec<Expr<'g>>,
}

/// Whether an expression is an unknown whose value is known.
pub(super) fn is_known(x: Expr<'_>) -> bool {
    match x.operation() {
        Op::RootValue(root, _) => x.sheet().graph().root(root).is_known(),
        _ => false,
    }
}

impl<'g> Known<'g> {
    /// Of a level of them.
    pub fn new(level: &[Intermediate<'g>]) -> Self {
        let mut known = Self { unknowns: level.to_vec(), roots: Vec::new(), values: Vec::new() };
        let mut ids = Vec::new();
        for &Intermediate { symbol, definition } in level {
            let Op::RootValue(id, component) = definition.operation() else { continue };
            let sheet = symbol.sheet();
            let root = sheet.graph().root(id).clone();
            known.values.push((symbol, sheet.expr(root.known[component as usize])));
            let place = ids.iter().position(|&other| other == id).unwrap_or_else(|| {
                // Of unknowns that nothing depends on, too.
                let all = root.unknowns.iter().zip(&root.known);
                known.values.extend(all.map(|(&unknown, &value)| (sheet.symbol(unknown), sheet.expr(value))));
                known.roots.push(Equations::new(&root, symbol));
                ids.push(id);
                ids.len() - 1
            });
            known.roots[place].set(component as usize, symbol);
        }
        known
    }

    /// The same with equations that contain none of these intermediates, but what they are.
    pub fn without<'a>(mut self, intermediates: impl DoubleEndedIterator<Item = &'a Intermediate<'g>>) -> Self
    where
        'g: 'a,
    {
        for v in intermediates.rev() {
            for residual in self.roots.iter_mut().flat_map(|root| &mut root.residuals) {
                *residual = residual.at(&[(v.symbol, v.definition)]);
            }
        }
        self
    }

    /// The symbols with their values.
    pub fn values(&self) -> Vec<(Expr<'g>, Expr<'g>)> {
        self.values.clone()
    }

    /// C at the values: of each unknown its derivatives by the symbols below.
    pub fn rates(&self, below: &[Expr<'g>]) -> Vec<Vec<Expr<'g>>> {
        let mut rates: Vec<(Expr<'g>, Vec<Expr<'g>>)> = Vec::new();
        for root in &self.roots {
            let of_root = root.rates(below, &rates, &self.values);
            rates.extend(root.unknowns.iter().copied().zip(of_root));
        }
        let of_unknown = |v: &Intermediate<'g>| {
            let (_, rates) =
                rates.iter().find(|(unknown, _)| *unknown == v.symbol).expect("an unknown of a root");
            rates.clone()
        };
        self.unknowns.iter().map(of_unknown).collect()
    }
}

impl<'g> Equations<'g> {
    fn new(root: &Root, any: Expr<'g>) -> Self {
        let sheet = any.sheet();
        let unknowns = root.unknowns.iter().map(|&unknown| sheet.symbol(unknown)).collect();
        let (name, residuals) = (root.name.clone(), sheet.exprs(&root.residuals));
        Self { name, unknowns, residuals }
    }

    /// Writes the equations in the symbol that an unknown has elsewhere.
    fn set(&mut self, component: usize, symbol: Expr<'g>) {
        let unknown = std::mem::replace(&mut self.unknowns[component], symbol);
        for residual in &mut self.residuals {
            *residual = residual.at(&[(unknown, symbol)]);
        }
    }

    /// dw/dz = −r_w⁻¹ (r_z + Σ r_v dv/dz) at the values, v the unknowns of roots before; a row for each unknown w.
    fn rates(
        &self,
        below: &[Expr<'g>],
        before: &[(Expr<'g>, Vec<Expr<'g>>)],
        values: &[(Expr<'g>, Expr<'g>)],
    ) -> Vec<Vec<Expr<'g>>> {
        let jacobian: Vec<Vec<Expr<'g>>> = self
            .residuals
            .iter()
            .map(|r| self.unknowns.iter().map(|&w| r.by(w).at(values)).collect())
            .collect();
        let name = |i: usize, j: usize| format!("inverse_of_{}_{}_{}", self.name, i + 1, j + 1);
        let sheet = jacobian[0][0].sheet();
        let inverse: Vec<Vec<Expr<'g>>> = sheet
            .inverse_general(&format!("inverse_of_{}", self.name), &jacobian)
            .iter()
            .enumerate()
            .map(|(i, row)| row.iter().enumerate().map(|(j, x)| x.named(&name(i, j))).collect())
            .collect();
        let minus_change = |r: &Expr<'g>, place: usize| {
            let through = before.iter().fold(r.by(below[place]).at(values), |change, (v, rates)| {
                change + r.by(*v).at(values) * rates[place]
            });
            -through
        };
        // What all changes of an equation have in common, such as a scale, is put into the inverse.
        let changes: Vec<ScaledVector<'g>> = self
            .residuals
            .iter()
            .map(|r| common_factor(&(0..below.len()).map(|place| minus_change(r, place)).collect::<Vec<_>>()))
            .collect();
        let rates = |row: Vec<Expr<'g>>| {
            let scaled: Vec<Expr<'g>> =
                row.iter().zip(&changes).map(|(&x, change)| x * change.scale).collect();
            (0..below.len()).map(|place| dot(&scaled, changes.iter().map(|c| c.direction[place]))).collect()
        };
        inverse.into_iter().map(rates).collect()
    }
}
