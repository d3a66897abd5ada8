//! Unknowns in the formulas of an element: of equations, at minima and stationary values, and those whose values are known.

use super::element::ElementModel;
use super::error::ElementError;
use super::signature::Quantity;
use crate::expr::{Expr, Matrix, Vector, total};
use crate::graph::{ExprId, Iteration, Limits, RootFigure, Scope, SymmetricSystem};
use crate::structure::{Elimination, Implicit, sums_in};

/// Where equations are solved, see [`ElementModel::root`], [`ElementModel::root_from`], [`ElementModel::minimum`],
/// [`ElementModel::stationary_from`] and [`ElementModel::solve`].
#[derive(Clone, Copy, Debug)]
pub struct Root<'g, const N: usize> {
    /// The unknowns.
    pub unknowns: Vector<'g, N>,
    /// Largest residual, or 10⁻⁶ of the last step, over the largest starting residual or unknown, whichever is larger; below 10⁻¹², or
    /// there is no root near the start. So equations and unknowns have to share a scale. It is infinite, and no NaN, where the Jacobian is
    /// singular or an equation is no number.
    pub residual: Expr<'g>,
    /// Evaluations of the equations.
    pub iterations: Expr<'g>,
}

/// Where a quadratic function is stationary, see [`ElementModel::stationary`].
#[derive(Clone, Copy, Debug)]
pub struct Stationary<'g, const N: usize> {
    /// The unknowns.
    pub unknowns: Vector<'g, N>,
    /// Smallest pivot of the function's second derivative relative to its diagonal, and of conditions relative to what makes them up: 0,
    /// but for rounding, where there is no single such place. Go on only where it is above 10⁻⁷: it may be NaN where inputs are.
    pub pivot_ratio: Expr<'g>,
}

impl<'g> ElementModel<'g> {
    /// A quantity that is held while derivatives are taken: it has its value, and changes with nothing. A length that others are divided
    /// by is one where it cancels; so is the place an iteration has found, where [`stationary_at`](Self::stationary_at) says how it
    /// moves.
    #[must_use]
    pub fn held<Q: Quantity<'g>>(&self, name: &str, quantity: Q) -> Q {
        self.check_name(name);
        quantity.changed(name, &mut |entry, x| {
            if x.value().is_some() {
                return x;
            }
            self.check_symbol(entry);
            self.sheet.make(|g| g.bind_held(entry, x.id()))
        })
    }

    /// Unknowns u, one to eight, that have known values, such as the foot of a distance, and in which the function is stationary that
    /// derivatives are taken of: it does not change to first order while u follows the equations r(u) = 0, which hold at the values.
    /// Its gradient is then that at fixed u, and its Hessian needs du/dx = −r_u⁻¹ r_x only. Values are held. Equations may contain unknowns
    /// that were made before.
    ///
    /// Nothing checks the claims but a test: `Config::test` compares with automatic differentiation, which moves u by the equations.
    #[must_use]
    pub fn stationary_at<const N: usize>(
        &self,
        name: &str,
        values: Vector<'g, N>,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Vector<'g, N> {
        self.check_name(name);
        if N == 0 || N > Iteration::MOST_EQUATIONS {
            self.fail(ElementError::Root { root: name.to_owned(), equations: N });
            return values;
        }
        self.known.borrow_mut().get_or_insert_with(|| name.to_owned());
        let values = self.held(&format!("{name}_value"), values);
        let unknowns = self.unknowns(name);
        let equations = equations(unknowns);
        self.check_sought(&equations.0, &unknowns.0);
        let equations = self.vector_written_out(equations);
        self.check_equations(name, equations);
        let (_, at) = self
            .sheet
            .edit(|g| g.add_known_root(name, &unknowns.ids(), equations.ids().to_vec(), &values.ids()));
        self.define(name, Vector::from_fn(|k| self.sheet.expr(at[k])))
    }

    /// Unknowns at the root of as many equations r(u) = 0, one to eight, such as the natural coordinates of a foot point: by a damped
    /// Newton iteration from u = 0, with steps of at most ½. Derivatives are those of the implicit function theorem.
    ///
    /// Whoever uses the kernels has to know whether there is a root: state [`Root::residual`] as a value.
    #[must_use]
    pub fn root<const N: usize>(
        &self,
        name: &str,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        let iteration = if N == 2 { Iteration::Newton } else { Iteration::Within(Limits::default()) };
        self.root_by(iteration, name, equations)
    }

    /// The same from a start, within chosen limits: for unknowns that are not of order one, such as those of a state before.
    #[must_use]
    pub fn root_from<const N: usize>(
        &self,
        name: &str,
        start: Vector<'g, N>,
        limits: Limits,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        self.check_limits(name, limits);
        // The iteration starts at zero: it finds the way from the start.
        let way = self.root_by(Iteration::Within(limits), &format!("{name}_way"), |way| {
            equations(Vector::from_fn(|k| start[k] + way[k]))
        });
        let unknowns = self.define(name, Vector::from_fn(|k| start[k] + way.unknowns[k]));
        Root { unknowns, ..way }
    }

    /// Unknowns, one to eight, at which any smooth function is stationary, by a damped Newton iteration from a start that is near. What
    /// is quadratic has [`stationary`](Self::stationary).
    #[must_use]
    pub fn stationary_from<const N: usize>(
        &self,
        name: &str,
        start: Vector<'g, N>,
        limits: Limits,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Root<'g, N> {
        self.check_limits(name, limits);
        let way = self.root_by(Iteration::Within(limits), &format!("{name}_way"), |way| {
            let function = function(Vector::from_fn(|k| start[k] + way[k]));
            self.check_sought(&[function], &way.0);
            let function = self.with_bound_sums(function, &way.0);
            way.map(|u| function.by(u))
        });
        let unknowns = self.define(name, Vector::from_fn(|k| start[k] + way.unknowns[k]));
        Root { unknowns, ..way }
    }

    /// Unknowns u of linear equations A u = b, one to eight, without symmetry. Pivots are searched for in the kernel, in each lane by
    /// itself. [`Root::residual`] is above 10⁻¹², mostly infinite, where A is singular, unless rounding leaves it a pivot: unknowns of 10¹⁵ are none.
    #[must_use]
    pub fn solve<const N: usize>(
        &self,
        name: &str,
        matrix: Matrix<'g, N, N>,
        right_hand_side: Vector<'g, N>,
    ) -> Root<'g, N> {
        self.root_by(Iteration::Within(Limits::LINEAR), name, |u| {
            Vector::from_fn(|i| total((0..N).map(|j| matrix[i][j] * u[j])) - right_hand_side[i])
        })
    }

    /// Unknowns at a minimum of a function, such as half a squared distance: from u = 0 by steps down to it, Newton's where the function
    /// is convex, each of at most ½ and half of the way already made. [`Root::residual`] is that of the function's derivatives.
    #[must_use]
    pub fn minimum<const N: usize>(
        &self,
        name: &str,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Root<'g, N> {
        self.root_by(Iteration::Descent, name, |unknowns| {
            let function = function(unknowns);
            self.check_sought(&[function], &unknowns.0);
            let function = self.with_bound_sums(function, &unknowns.0);
            unknowns.map(|u| -function.by(u))
        })
    }

    fn root_by<const N: usize>(
        &self,
        iteration: Iteration,
        name: &str,
        equations: impl FnOnce(Vector<'g, N>) -> Vector<'g, N>,
    ) -> Root<'g, N> {
        self.check_name(name);
        if !iteration.takes(N) {
            self.fail(ElementError::Root { root: name.to_owned(), equations: N });
            return self.no_root(name);
        }
        if let Iteration::Within(limits) = iteration {
            self.check_limits(name, limits);
        }
        let unknowns = self.unknowns(name);
        let equations = equations(unknowns);
        self.check_sought(&equations.0, &unknowns.0);
        if self.has_failed() {
            return self.no_root(name);
        }
        let equations =
            self.vector_written_out(equations.map(|equation| self.with_bound_sums(equation, &unknowns.0)));
        self.check_equations(name, equations);
        let (root, values) = self.sheet.root_by(iteration, name, unknowns, equations);
        let values = self.define(name, values);
        if self.has_nodes() {
            let at = unknowns.set_to(values);
            let equations = equations.at(&at);
            let jacobian: Vec<Vec<Expr<'g>>> =
                equations.iter().map(|r| values.iter().map(|&u| r.by(u)).collect()).collect();
            self.implicit.borrow_mut().push(Implicit {
                unknowns: values.to_vec(),
                equations: equations.to_vec(),
                jacobian: Elimination::Inverse(
                    self.sheet.inverse_general(&format!("{name}_inverse"), &jacobian),
                ),
            });
        }
        let figure = |figure| self.sheet.root_figure(root, figure);
        Root {
            unknowns: values,
            residual: figure(RootFigure::Residual),
            iterations: figure(RootFigure::Iterations),
        }
    }

    /// Unknowns at which a function is stationary that is quadratic in them, such as the coefficients of a least squares fit: where
    /// ½ Σ w e² is least for errors e that are linear in the coefficients. A function with a value for each node is summed over them. With
    /// multipliers for conditions, linear in the unknowns, it is stationary under these: multipliers come last.
    ///
    /// Derivatives are those of the implicit function theorem, with one row for each unknown however many sums there are in the system.
    #[must_use]
    pub fn stationary<const N: usize>(
        &self,
        name: &str,
        function: impl FnOnce(Vector<'g, N>) -> Expr<'g>,
    ) -> Stationary<'g, N> {
        self.check_name(name);
        let unknowns: Vector<'g, N> = self.unknowns(name);
        let function = function(unknowns);
        self.check_sought(&[function], &unknowns.0);
        let function = if function.scope() == Scope::Node { function.sum() } else { function };
        let function = self.written_out(vec![self.with_bound_sums(function, &unknowns.0)], &[])[0];
        // What a sum is multiplied by with it may be free of unknowns now.
        let equations = unknowns.map(|u| self.with_bound_sums(function.by(u), &unknowns.0));
        let lower: Vec<Vec<Expr<'g>>> =
            (0..N).map(|i| (0..=i).map(|j| equations[i].by(unknowns[j])).collect()).collect();
        let is_multiplier = |row: &usize| lower[*row][*row].is_zero();
        let is_quadratic = !lower.iter().flatten().any(|x| unknowns.iter().any(|&u| x.contains(u)));
        let (multipliers, others): (Vec<usize>, Vec<usize>) = (0..N).partition(is_multiplier);
        if !is_quadratic || others.is_empty() || self.has_failed() {
            self.fail(match is_quadratic {
                true => ElementError::NoCurvature { unknowns: name.to_owned() },
                false => ElementError::NotQuadratic { unknowns: name.to_owned() },
            });
            // Symbols, so that what follows does not hide the error.
            return Stationary { unknowns: self.stand_ins(name), pivot_ratio: self.stand_in(name, "ratio") };
        }
        let order = others.into_iter().chain(multipliers.iter().copied()).collect();
        let system = SymmetricSystem::of(&format!("{name}_system"), &lower, order);
        // A diagonal entry may be zero: then so is its pivot, and their ratio, not 0/0.
        let references = (0..N).map(|k| (lower[k][k] + f64::MIN_POSITIVE).id()).collect();
        let system = self.sheet.system(system.with_references(references).with_multipliers(multipliers));
        let at_zero = equations.at(&unknowns.set_to(Vector::zero(self.sheet)));
        let solution = system.solve(&at_zero.map(|x| -x).0);
        let values = self.define(name, Vector::from_fn(|k| solution[k]));
        if self.has_nodes() {
            self.implicit.borrow_mut().push(Implicit {
                unknowns: values.to_vec(),
                equations: equations.at(&unknowns.set_to(values)).to_vec(),
                jacobian: Elimination::Symmetric(system),
            });
        }
        Stationary { unknowns: values, pivot_ratio: system.pivot_ratio() }
    }

    fn vector_written_out<const N: usize>(&self, vector: Vector<'g, N>) -> Vector<'g, N> {
        let entries = self.written_out(vector.to_vec(), &[]);
        Vector::from_fn(|k| entries[k])
    }

    /// Symbols in the place of a root that is refused, so that what follows does not hide the error.
    fn no_root<const N: usize>(&self, name: &str) -> Root<'g, N> {
        let [residual, iterations] = ["residual", "iterations"].map(|figure| self.stand_in(name, figure));
        Root { unknowns: self.stand_ins(name), residual, iterations }
    }

    fn stand_in(&self, name: &str, what: &str) -> Expr<'g> {
        self.sheet.input_once(&format!("{name}_failed_{what}"), Scope::Element)
    }

    fn stand_ins<const N: usize>(&self, name: &str) -> Vector<'g, N> {
        Vector::from_fn(|k| self.stand_in(name, &(k + 1).to_string()))
    }

    /// Limits that an iteration can keep.
    fn check_limits(&self, name: &str, limits: Limits) {
        if !(limits.longest_step > 0.0) || limits.evaluations == 0 {
            self.fail(ElementError::Limits {
                root: name.to_owned(),
                longest_step: limits.longest_step.to_string(),
                evaluations: limits.evaluations,
            });
        }
    }

    /// Equations are those of the element, and their unknowns stand in no sum.
    fn check_equations<const N: usize>(&self, name: &str, equations: Vector<'g, N>) {
        if equations.iter().any(|equation| equation.scope() != Scope::Element) {
            self.fail(ElementError::Scope { output: name.to_owned() });
        }
        if equations.iter().any(|&equation| !sums_in(equation).is_empty()) {
            self.fail(ElementError::RootInSum { root: name.to_owned() });
        }
    }

    /// What the unknowns are sought by contains them openly, and in no definition.
    fn check_sought(&self, sought_by: &[Expr<'g>], unknowns: &[Expr<'g>]) {
        let unknowns: Vec<ExprId> = unknowns.iter().map(|u| u.id()).collect();
        let definition = {
            let graph = self.sheet.graph();
            sought_by.iter().find_map(|x| graph.definition_with(x.id(), &unknowns))
        };
        if let Some((quantity, unknown)) = definition {
            let [quantity, unknown] = [quantity, unknown].map(|x| self.sheet.expr(x).symbol_name());
            self.fail(ElementError::Sought { quantity, unknown });
        }
    }

    /// Variables for the unknowns of equations.
    fn unknowns<const N: usize>(&self, name: &str) -> Vector<'g, N> {
        Vector::from_fn(|k| self.sheet.variable(&format!("{name}_unknown_{}", k + 1)))
    }
}
