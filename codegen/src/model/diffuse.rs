//! The diffuse contact element, as formulas.
//!
//! "(n)" is equation n of Chamoret, Rassineux, Bergheau (2008). Everything is made dimensionless with the support
//! radius R, so that the moment matrix has entries of order one in any length unit; outputs carry their units
//! again. "[Tn]" are formulas of `docs/equations.md`. All derivatives in here are asked from the derivative engine.

use super::average_plane::{AveragePlane, turned_back};
use super::basis::Basis;
use super::contact_kernel::FrameRule;
use super::material::Material;
use super::pole::Pole;
use super::weight::{DOMAIN_RATIO, NodeWeight, PLANE_REACH, Weight};
use crate::expr::{
    Expr, Mat2, Mat3, Matrix, Sheet, System, Values, Vec2, Vec3, Vector, all_at, bind_all, dot, ids,
};
use crate::graph::{RootFigure, RootId, Scope, SymmetricSystem};
use crate::structure::{Block, CoordinateMap, Elimination, Follower, Functional, NodeProblem};

/// What all kernels share: inputs, local offsets and weights.
pub(super) struct Diffuse<'g> {
    basis: Basis,
    slave: Vec3<'g>,
    /// Q, with t1, t2, n̂ as rows.
    frame: Mat3<'g>,
    support_radius: Expr<'g>,
    inverse_radius: Expr<'g>,
    /// (a, b, z): a node's offset from the slave over R, in the frame; where the frame moves, variables that move with
    /// it.
    position: Vec3<'g>,
    /// w; where the weight has a pole, without the pole's.
    weight: Expr<'g>,
    pole: Option<Pole<'g>>,
    coordinates: CoordinateMap<'g>,
    plane: Option<AveragePlane<'g>>,
}

/// The surface about the foot point.
pub(super) struct AtFoot<'g> {
    /// The fit with its basis about the foot.
    pub fit: Fit<'g>,
    /// The slave's foot u in the plane.
    pub foot: Vec2<'g>,
    /// Offset δ from the foot, variables.
    pub delta: Vec2<'g>,
    /// f at u + δ.
    pub surface: SurfacePoint<'g>,
    /// The foot equations at u + δ.
    pub equations: Vec2<'g>,
    /// Their Jacobian by δ.
    pub jacobian: Mat2<'g>,
    pub root: RootId,
}

/// A fit.
#[expect(non_snake_case, reason = "the paper's symbol")]
pub(super) struct Fit<'g> {
    pub problem: NodeProblem<'g>,
    /// Origin of its basis.
    origin: Vec2<'g>,
    /// Moment matrix A as assembled, lower triangle.
    A: Vec<Vec<Expr<'g>>>,
}

/// Value and derivatives of the fitted surface at one point.
#[derive(Clone, Copy)]
pub(super) struct SurfacePoint<'g> {
    pub value: Expr<'g>,
    pub slopes: Vec2<'g>,
    /// f_11, f_12, f_22
    pub curvatures: Vec3<'g>,
}

/// The foot point and what is defined there.
pub(super) struct Contact<'g> {
    pub functional: Functional<'g>,
    pub gap: Expr<'g>,
    pub foot: Vec3<'g>,
    pub normal: Vec3<'g>,
    pub distance: Expr<'g>,
    pub determinant: Expr<'g>,
    pub trace: Expr<'g>,
}

/// First derivatives of a quantity at the foot.
pub(super) struct FootQuantity<'g> {
    pub name: &'static str,
    /// By the unknowns.
    pub by_alpha: Vec<Expr<'g>>,
    /// By those of the plane, of which the turn turns the frame; none of a quantity with the plane held.
    pub by_theta: Option<Vec<Expr<'g>>>,
}

impl<'g> Diffuse<'g> {
    /// Inputs and what follows from them before any unknown: offsets (a, b, z) and weights w.
    pub fn declare(sheet: &'g Sheet, basis: Basis, weight: &Weight, frame_rule: FrameRule) -> Self {
        let slave = sheet.vector("slave", Scope::Element);
        let node = sheet.vector("master", Scope::Node);
        let frame = Matrix(["t1", "t2", "normal"].map(|row| sheet.vector(row, Scope::Element).0));
        let support_radius = sheet.input("support_radius", Scope::Element);
        // R/R_k: a node's domain of influence has a radius of its own [T14].
        let ratio = sheet.input(DOMAIN_RATIO, Scope::Node);
        let inverse_radius = (1.0 / support_radius).bind("inverse_radius");

        // (a, b, z)_i = Q (x^i − x^c) / R
        let from_slave = (node - slave).named("from_slave");
        let offset = Vector::from_fn(|k| {
            let name = ["a", "b", "z"][k];
            let axis = (frame.row(k) * inverse_radius).named(&format!("axis_{name}"));
            from_slave.dot(axis).bind(name)
        });
        let coordinates = CoordinateMap::new(&offset.0, node, slave);
        // (14) w = w(r), r = √(a² + b²) R/R_k
        let in_plane = |x: Vec3<'g>| Vector([x[0] * ratio, x[1] * ratio]).norm().named("r");
        let (r, coordinates, plane) = match frame_rule {
            FrameRule::Held => (in_plane(offset), coordinates, None),
            FrameRule::CoMoving => {
                // ω_k = ω(ρ), ρ = |x^k − x^c|/R_k; a reach of 0 makes all of them equal.
                let reach = sheet.input(PLANE_REACH, Scope::Element);
                let rho = (offset * (ratio * reach)).norm();
                let omega = weight.fitting(rho).named("plane_weight");
                let plane = AveragePlane::declare(offset, omega, Vec::new());
                let coordinates = coordinates.with_moving(&plane.moving, &plane.values);
                (in_plane(plane.position), coordinates, Some(plane))
            }
            FrameRule::Material => {
                let material = Material::declare(sheet, weight);
                let plane = AveragePlane::declare(offset, material.omega, material.values());
                let (plane, coordinates) = material.follow(plane, coordinates);
                (material.r, coordinates, Some(plane))
            }
        };
        let position = plane.as_ref().map_or(offset, |plane| plane.position);

        let (weight, pole) = match weight.evaluate(r) {
            NodeWeight::Fitting(weight) => (weight, None),
            NodeWeight::Interpolating { weight, compliance } => {
                let (weight, pole) = Pole::declare(weight, compliance, offset);
                (weight, Some(pole))
            }
        };
        let weight = weight.named("w");
        Self {
            basis,
            slave,
            frame,
            support_radius,
            inverse_radius,
            position,
            weight,
            pole,
            coordinates,
            plane,
        }
    }

    pub fn sheet(&self) -> &'g Sheet {
        self.weight.sheet()
    }

    pub fn slave(&self) -> Vec3<'g> {
        self.slave
    }

    pub fn support_radius(&self) -> Expr<'g> {
        self.support_radius
    }

    /// The average plane, where the frame moves with it.
    pub fn plane(&self) -> Option<&AveragePlane<'g>> {
        self.plane.as_ref()
    }

    /// z of a node, a symbol.
    pub fn height(&self) -> Expr<'g> {
        self.position[2]
    }

    /// An axis of the frame over R.
    pub fn axis(&self, k: usize) -> Vec3<'g> {
        self.frame.row(k) * self.inverse_radius
    }

    /// The slave's in-plane point, (0, 0).
    pub fn slave_point(&self) -> Vec2<'g> {
        Vector::zero(self.sheet())
    }

    /// (13) A α = β with A = Σ w p pᵀ, β = Σ w z p, p = p(a − o₁, b − o₂), o = `origin`, or the pole where there is one.
    #[expect(non_snake_case, reason = "the paper's symbols")]
    pub fn fit(&self, origin: Vec2<'g>) -> Fit<'g> {
        let origin = self.pole.map_or(origin, |pole| pole.origin);
        let p = self.basis_about(origin);
        let z = self.position[2];
        let values = self.values();
        let w_p: Vec<Expr<'g>> =
            p.iter().enumerate().map(|(k, &p)| (self.weight * p).named(&format!("w_p_{k}"))).collect();
        let sum = |x: Expr<'g>, name: String| x.at(&values).sum().named(&name);
        let moment = |i: usize, j: usize| sum(w_p[i] * p[j], format!("moment_{i}_{j}"));
        let mut A: Vec<Vec<Expr<'g>>> =
            (0..p.len()).map(|i| (0..=i).map(|j| moment(i, j)).collect()).collect();
        let mut beta: Vec<Expr<'g>> = (0..p.len()).map(|i| sum(w_p[i] * z, format!("beta_{i}"))).collect();
        let diagonal: Vec<Expr<'g>> = A.iter().filter_map(|row| row.last().copied()).collect();
        let references = self.basis.pivot_references(&diagonal);
        let mut order = self.basis.elimination_order();
        let multiplier = p.len();
        if let Some(pole) = self.pole {
            let (row, right_hand_side) = pole.equation(multiplier, z, &values);
            A.push(row);
            beta.push(right_hand_side);
            // α₀ and σ first: their 2 × 2 block is regular whatever the compliance, and what is left after it is
            // positive definite also for as many nodes as coefficients.
            order.retain(|&k| k != 0);
            order.splice(0..0, [0, multiplier]);
        }
        let multipliers = self.pole.iter().map(|_| multiplier).collect();
        let system = SymmetricSystem::of("l", &A, order).with_multipliers(multipliers);
        let system = self.sheet().system(system.with_references(ids(&references)));
        let mut solution = system.solve(&beta);
        let sigma = self.pole.and_then(|_| solution.pop());
        let mut unknowns = bind_all("alpha", &solution);
        unknowns.extend(sigma.map(|sigma| sigma.bind("sigma")));
        let problem = self.problem(&p, unknowns, system);
        problem.check_system();
        Fit { problem, origin, A }
    }

    /// The same fit with the origin of its basis moved to `origin`: p(a − o) = T p(a), so A becomes T A Tᵀ, and α
    /// the Taylor coefficients of f at the new origin. The surface stays what it is, so `origin` is held while
    /// differentiating. With an pole the basis stays there.
    #[expect(non_snake_case, reason = "the paper's symbols")]
    fn recentred(&self, fit: Fit<'g>, origin: Vec2<'g>) -> Fit<'g> {
        if self.pole.is_some() {
            return fit;
        }
        let shift = self.sheet().variables(["shift_a", "shift_b"]);
        let size = self.basis.size();
        let (at_minus_origin, at_origin) = (shift.set_to(-origin), shift.set_to(origin));

        let p = self.basis.evaluate(shift[0], shift[1]);
        let row = |&p: &Expr<'g>| all_at(&self.taylor_coefficients(p, shift), &at_minus_origin);
        let T: Vec<Vec<Expr<'g>>> = p.iter().map(row).collect();
        let f = dot(&p, self.alpha(&fit.problem));
        let coefficients = all_at(&self.taylor_coefficients(f, shift), &at_origin);

        let entry = |i: usize, j: usize| fit.A[i.max(j)][i.min(j)];
        let product = |row: &Vec<Expr<'g>>, j: usize| dot(row, (0..size).map(|i| entry(i, j)));
        let T_A: Vec<Vec<Expr<'g>>> =
            T.iter().map(|row| (0..size).map(|j| product(row, j)).collect()).collect();
        let moment = |i: usize, j: usize| dot(&T_A[i], &T[j]).named(&format!("foot_moment_{i}_{j}"));
        let A: Vec<Vec<Expr<'g>>> = (0..size).map(|i| (0..=i).map(|j| moment(i, j)).collect()).collect();
        let order = self.basis.elimination_order();
        let system = self.sheet().system(SymmetricSystem::of("foot_l", &A, order));
        let unknowns = bind_all("foot_alpha", &coefficients);
        let problem = self.problem(&self.basis_about(origin), unknowns, system);
        Fit { problem, origin, A }
    }

    /// (1/(i! j!)) ∂ⁱ∂ʲ f for the exponents (i, j) of the basis functions: f = Σ coefficient · p at the origin.
    fn taylor_coefficients(&self, f: Expr<'g>, u: Vec2<'g>) -> Vec<Expr<'g>> {
        let factorial = |k: u8| (1..=k).map(f64::from).product::<f64>();
        let times = |f: Expr<'g>, count: u8, u: Expr<'g>| (0..count).fold(f, |f, _| f.by(u));
        let coefficient =
            |&(i, j): &(u8, u8)| times(times(f, i, u[0]), j, u[1]) / (factorial(i) * factorial(j));
        self.basis.monomials().iter().map(coefficient).collect()
    }

    fn basis_about(&self, origin: Vec2<'g>) -> Vec<Expr<'g>> {
        let a = (self.position[0] - origin[0]).named("a_shifted");
        let b = (self.position[1] - origin[1]).named("b_shifted");
        let p = self.basis.evaluate(a, b).into_iter().enumerate();
        p.map(|(k, p)| p.named(&format!("p_{k}"))).collect()
    }

    /// The coefficients among the unknowns.
    fn alpha<'a>(&self, problem: &'a NodeProblem<'g>) -> &'a [Expr<'g>] {
        &problem.unknowns()[..self.basis.size()]
    }

    /// (13) as residuals: Σ ρ = 0 with ρ = w e p, e = z − p·α; with an pole σ p there, and −(e − σ/w) for σ.
    fn problem(&self, p: &[Expr<'g>], unknowns: Vec<Expr<'g>>, system: System<'g>) -> NodeProblem<'g> {
        let fitted = dot(p, &unknowns[..p.len()]).named("fitted");
        let e = (self.position[2] - fitted).named("e");
        let mut w_e = (self.weight * e).named("w_e");
        let mut groups = vec![p.len()];
        let mut constraint = None;
        if let (Some(pole), Some(&sigma)) = (self.pole, unknowns.get(p.len())) {
            w_e += pole.indicator * sigma;
            constraint = Some(pole.compliance * sigma - pole.indicator * e);
            groups.push(1);
        }
        let residual = p.iter().map(|&p| w_e * p).chain(constraint).collect();
        let block = Block { unknowns, residual, groups, system: Elimination::Symmetric(system) };
        let outer = self.plane.as_ref().map(|plane| plane.block.clone());
        NodeProblem { block, outer, coordinates: self.coordinates.clone(), values: self.values() }
    }

    /// Values of what is a variable while differentiating only.
    fn values(&self) -> Values<'g> {
        self.plane.as_ref().map(|plane| plane.values.clone()).unwrap_or_default()
    }

    /// α about the slave in length units: z = α·(1, a, b, …) with z, a, b in length units.
    pub fn coefficients(&self, fit: &Fit<'g>) -> Vec<Expr<'g>> {
        let about_slave = self.coefficients_about_slave(fit).into_iter().enumerate();
        about_slave.map(|(k, alpha)| self.coefficient_unit(k) * alpha).collect()
    }

    /// The Taylor coefficients of f at the slave.
    fn coefficients_about_slave(&self, fit: &Fit<'g>) -> Vec<Expr<'g>> {
        if self.pole.is_none() {
            return self.alpha(&fit.problem).to_vec();
        }
        let u = self.sheet().variables(["slave_a", "slave_b"]);
        let f = dot(self.basis.evaluate(u[0], u[1]), self.alpha(&fit.problem));
        all_at(&self.taylor_coefficients(f, u), &u.set_to(-fit.origin))
    }

    /// Length to the power of one minus the degree of basis function k.
    fn coefficient_unit(&self, k: usize) -> Expr<'g> {
        let (i, j) = self.basis.monomials()[k];
        match i + j {
            0 => self.support_radius,
            degree => self.inverse_radius.powi(i32::from(degree) - 1),
        }
    }

    /// The functional α_k about the slave, in length units.
    pub fn coefficient_functional(&self, fit: &Fit<'g>, k: usize) -> Functional<'g> {
        let coefficient = self.coefficients_about_slave(fit)[k];
        linear_functional(&format!("alpha{k}"), &fit.problem, coefficient, self.coefficient_unit(k))
    }

    /// f = p(u)·α with its derivatives by u, at `point`, dimensionless.
    pub fn surface(&self, fit: &Fit<'g>, point: Vec2<'g>) -> SurfacePoint<'g> {
        let u = self.sheet().variables(["u_a", "u_b"]);
        let surface = self.surface_of(self.alpha(&fit.problem), u);
        surface.at(&u.set_to(point - fit.origin))
    }

    /// f = p(u)·α with its derivatives by the variables u.
    fn surface_of(&self, alpha: &[Expr<'g>], u: Vec2<'g>) -> SurfacePoint<'g> {
        let value = dot(self.basis.evaluate(u[0], u[1]), alpha).named("f");
        let slopes = value.gradient(u);
        let curvatures = Vector([slopes[0].by(u[0]), slopes[0].by(u[1]), slopes[1].by(u[1])]);
        SurfacePoint { value, slopes, curvatures }
    }

    /// The functionals f, f_1, f_2 of a surface point, in length units.
    pub fn surface_functionals(&self, fit: &Fit<'g>, surface: &SurfacePoint<'g>) -> [Functional<'g>; 3] {
        let one = self.sheet().one();
        let [f_1, f_2] = surface.slopes.0;
        [("f", surface.value, self.support_radius), ("f1", f_1, one), ("f2", f_2, one)]
            .map(|(name, quantity, unit)| linear_functional(name, &fit.problem, quantity, unit))
    }

    /// Length units for a surface point: f, slopes, curvatures.
    pub fn surface_in_units(&self, surface: &SurfacePoint<'g>) -> SurfacePoint<'g> {
        SurfacePoint {
            value: self.support_radius * surface.value,
            slopes: surface.slopes,
            curvatures: self.inverse_radius * surface.curvatures,
        }
    }

    /// An in-plane offset in length units, made dimensionless.
    pub fn dimensionless(&self, length: Expr<'g>) -> Expr<'g> {
        length * self.inverse_radius
    }

    /// The foot point, and the surface about it.
    pub fn at_foot(&self, fit: Fit<'g>) -> AtFoot<'g> {
        // Foot point: F_k = −u_k + h f_k = 0 with h = −f(u).
        let u = self.sheet().variables(["u_1", "u_2"]);
        // With the coefficients about the slave, also where the basis has its origin at the pole: close to u = 0 the
        // residual is then as small as the foot, not as the rounding of what cancels.
        let about_slave = self.coefficients_about_slave(&fit);
        let about_slave = match self.pole {
            Some(_) => bind_all("slave_alpha", &about_slave),
            None => about_slave,
        };
        let equations = foot_equations(&self.surface_of(&about_slave, u), u);
        let (root, foot) = self.sheet().root("foot", u, equations);
        let foot = foot.bind("foot");
        let fit = self.recentred(fit, foot);
        let delta = self.sheet().variables(["delta_1", "delta_2"]);
        let surface = self.surface_beside(&fit, delta, foot);
        let equations = foot_equations(&surface, foot + delta);
        AtFoot { fit, foot, delta, surface, equations, jacobian: equations.jacobian(delta), root }
    }

    /// Gap and unit normal, and the gap as a functional of the coefficients at the foot.
    #[expect(non_snake_case, reason = "the paper's symbols")]
    pub fn contact(&self, at: &AtFoot<'g>) -> Contact<'g> {
        let one = self.sheet().one();
        let &AtFoot { ref fit, foot, delta, surface, equations, jacobian: J, .. } = at;
        // Signed distance as a stationary value. Ψ(δ, q) = ν(q)·(x^c − x^d(o + δ)) with the unit normal
        // ν(q) = (−q_1, −q_2, 1)/√(1 + q²): ∂Ψ/∂δ = 0 says q_k = f_k, ∂Ψ/∂q = 0 says that x^c − x^d is along ν.
        let q = self.sheet().variables(["q_1", "q_2"]);
        let point = foot + delta;
        let along = dot([q[0], q[1], one], [point[0], point[1], -surface.value]);
        let ell = dot([one, q[0], q[1]], [one, q[0], q[1]]).sqrt().named("ell");
        let distance = along / ell;

        // How δ and q follow α: δ by the foot equations, q = f_k(δ, α) by chain rule.
        let follower = |&alpha: &Expr<'g>| {
            let mut follower = Follower::new(alpha);
            follower.follow(delta.set_to(J.solve(-equations.by(alpha))));
            for k in 0..2 {
                follower.follow([(q[k], follower.total_derivative(surface.slopes[k]))]);
            }
            follower
        };
        let followers: Vec<Follower<'g>> = fit.problem.unknowns().iter().map(follower).collect();

        // Ψ is stationary in δ and q, so ∂G/∂α is its partial derivative; ∂²G/∂α² is the total derivative of that.
        let mut at_foot = delta.set_to(Vector::zero(self.sheet()));
        let slopes = surface.slopes.at(&at_foot);
        at_foot.extend(q.set_to(slopes));
        let first: Vec<Expr<'g>> = followers.iter().map(|f| distance.by(f.parameter())).collect();
        let R = self.support_radius;
        let second = |first: Expr<'g>, by: &Follower<'g>| R * by.total_derivative(first).at(&at_foot);
        let second =
            first.iter().map(|&first| followers.iter().map(|by| second(first, by)).collect()).collect();
        let first = all_at(&first, &at_foot).into_iter().map(|entry| R * entry).collect();
        let functional = Functional { name: "gap".to_owned(), first, second, point: None };

        // (19) g, (22) ν, and x^d, in global axes.
        let gap = R * distance.at(&at_foot);
        let inverse_ell = (1.0 / ell.at(&at_foot).named("ell")).named("inverse_ell");
        let normal = self.to_global([-slopes[0], -slopes[1], one]) * inverse_ell;
        let from_slave = self.to_global([foot[0], foot[1], surface.value.at(&at_foot)]);
        Contact {
            functional,
            gap,
            foot: self.slave + R * from_slave,
            normal,
            determinant: J.determinant().at(&at_foot),
            trace: J.trace().at(&at_foot),
            distance: foot.dot(foot).sqrt(),
        }
    }

    /// The normal ν in global axes, and the height of the surface over the foot with the foot held, whose derivative along n̂ is φ [T15].
    #[expect(non_snake_case, reason = "the paper's symbol")]
    pub fn foot_quantities(&self, at: &AtFoot<'g>) -> Vec<FootQuantity<'g>> {
        let &AtFoot { ref fit, delta, surface, equations, jacobian: J, .. } = at;
        let outer = self.plane.as_ref().map_or(&[][..], |plane| &plane.block.unknowns);
        let at_foot = [delta.set_to(Vector::zero(self.sheet())), self.values()].concat();
        let follower = |&alpha: &Expr<'g>| {
            let mut follower = Follower::new(alpha);
            follower.follow(delta.set_to(J.solve(-equations.by(alpha))));
            follower
        };
        let followers: Vec<Follower<'g>> = fit.problem.unknowns().iter().map(follower).collect();

        let n = Vector([-surface.slopes[0], -surface.slopes[1], self.sheet().one()]);
        let normal = n * (1.0 / n.dot(n).sqrt());
        // The frame turns with the plane.
        let normal = match *outer {
            [theta_1, theta_2, ..] => turned_back(Vector([-theta_1, -theta_2]), normal),
            _ => normal,
        };
        let global = |local: Vec3<'g>| self.to_global(local.at(&at_foot).0);
        let by_alpha: Vec<Vec3<'g>> =
            followers.iter().map(|by| global(normal.map(|x| by.total_derivative(x)))).collect();
        let by_theta: Vec<Vec3<'g>> =
            outer.iter().map(|&theta| global(normal.map(|x| x.by(theta)))).collect();
        let component = |all: &[Vec3<'g>], axis: usize| all.iter().map(|x| x[axis]).collect();
        let normal = ["normal_x", "normal_y", "normal_z"].into_iter().enumerate().map(|(axis, name)| {
            let (by_alpha, by_theta) = (component(&by_alpha, axis), Some(component(&by_theta, axis)));
            FootQuantity { name, by_alpha, by_theta }
        });
        let height = self.support_radius * surface.value;
        let by_alpha = followers.iter().map(|by| height.by(by.parameter()).at(&at_foot)).collect();
        normal.chain([FootQuantity { name: "height", by_alpha, by_theta: None }]).collect()
    }

    /// The surface at u + δ as a function of the variables δ.
    fn surface_beside(&self, fit: &Fit<'g>, delta: Vec2<'g>, u: Vec2<'g>) -> SurfacePoint<'g> {
        let from_origin = u - fit.origin;
        if from_origin.iter().all(|x| x.is_zero()) {
            return self.surface_of(self.alpha(&fit.problem), delta);
        }
        let v = self.sheet().variables(["v_1", "v_2"]);
        let surface = self.surface_of(self.alpha(&fit.problem), v);
        surface.at(&v.set_to(from_origin + delta))
    }

    /// Qᵀ x: global components of a vector given along (t1, t2, n̂).
    fn to_global(&self, x: [Expr<'g>; 3]) -> Vec3<'g> {
        Vector::from_fn(|axis| dot(x, self.frame.column(axis).0))
    }

    /// How the iteration for the foot went.
    pub fn foot_figures(&self, root: RootId) -> [Expr<'g>; 2] {
        [(RootFigure::Residual, "foot_residual"), (RootFigure::Iterations, "foot_iterations")]
            .map(|(figure, name)| self.sheet().root_figure(root, figure).named(name))
    }
}

impl<'g> SurfacePoint<'g> {
    fn at(self, values: &[(Expr<'g>, Expr<'g>)]) -> Self {
        Self {
            value: self.value.at(values),
            slopes: self.slopes.at(values),
            curvatures: self.curvatures.at(values),
        }
    }
}

/// −u_k + h f_k with h = −f: zero where the line from the surface point over u to the slave is normal to the surface.
fn foot_equations<'g>(surface: &SurfacePoint<'g>, u: Vec2<'g>) -> Vec2<'g> {
    let h = -surface.value;
    h * surface.slopes - u
}

/// unit · quantity, which is linear in the unknowns.
fn linear_functional<'g>(
    name: &str,
    problem: &NodeProblem<'g>,
    quantity: Expr<'g>,
    unit: Expr<'g>,
) -> Functional<'g> {
    let first: Vec<Expr<'g>> = problem.unknowns().iter().map(|&alpha| unit * quantity.by(alpha)).collect();
    let zero = unit.sheet().zero();
    Functional {
        name: name.to_owned(),
        second: vec![vec![zero; first.len()]; first.len()],
        first,
        point: None,
    }
}
