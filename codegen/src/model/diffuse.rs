//! The diffuse contact element, as formulas.
//!
//! "(n)" is equation n of Chamoret, Rassineux, Bergheau (2008). Everything is made dimensionless with the support
//! radius R, so that the moment matrix has entries of order one in any length unit; outputs carry their units
//! again. "[Tn]" are formulas of `docs/equations.md`. All derivatives in here are asked from the derivative engine.

use super::anchor::Anchor;
use super::average_plane::AveragePlane;
use super::basis::Basis;
use super::kernel::FrameRule;
use super::weight::{DOMAIN_RATIO, NodeWeight, PLANE_REACH, Weight};
use crate::graph::{ExprId, Graph, RootFigure, RootId, Scope, SymbolId, SymmetricSystem, SystemId};
use crate::structure::{Block, CoordinateMap, Follower, Functional, NodeProblem};

/// Names of the global axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// A declared symbol of the model, for the documentation of emitted kernels.
#[derive(Clone, Copy, Debug)]
pub struct Equation {
    /// The formula, in the paper's symbols.
    pub formula: &'static str,
    /// Where it stands.
    pub source: &'static str,
}

/// What all kernels share: inputs, local offsets and weights.
pub(super) struct Diffuse {
    basis: Basis,
    slave: [ExprId; 3],
    /// t1, t2, n̂ as rows.
    frame: [[ExprId; 3]; 3],
    support_radius: ExprId,
    inverse_radius: ExprId,
    /// (a, b, z): a node's offset from the slave over R, in the frame; where the frame moves, variables that move with
    /// it.
    position: [ExprId; 3],
    /// w; where the weight has a pole, without the anchor's.
    weight: ExprId,
    anchor: Option<Anchor>,
    coordinates: CoordinateMap,
    plane: Option<AveragePlane>,
}

/// A fit.
pub(super) struct Fit {
    pub problem: NodeProblem,
    /// Origin of its basis.
    origin: [ExprId; 2],
    /// Moment matrix A as assembled, lower triangle.
    matrix: Vec<Vec<ExprId>>,
}

/// Value and derivatives of the fitted surface at one point.
pub(super) struct SurfacePoint {
    pub value: ExprId,
    pub slopes: [ExprId; 2],
    /// f_11, f_12, f_22
    pub curvatures: [ExprId; 3],
}

/// The foot point and what is defined there.
pub(super) struct Contact {
    pub problem: NodeProblem,
    pub functional: Functional,
    pub gap: ExprId,
    pub foot: [ExprId; 3],
    pub normal: [ExprId; 3],
    pub distance: ExprId,
    pub determinant: ExprId,
    pub trace: ExprId,
    pub root: RootId,
}

impl Diffuse {
    /// Inputs and what follows from them before any unknown: offsets (a, b, z) and weights w.
    pub fn declare(g: &mut Graph, basis: Basis, weight: &Weight, frame_rule: FrameRule) -> Self {
        let slave = AXES.map(|axis| g.input(&format!("slave_{axis}"), Scope::Element));
        let node = AXES.map(|axis| g.input(&format!("master_{axis}"), Scope::Node));
        let frame = ["t1", "t2", "normal"]
            .map(|row| AXES.map(|axis| g.input(&format!("{row}_{axis}"), Scope::Element)));
        let support_radius = g.input("support_radius", Scope::Element);
        // R/R_k: a node's domain of influence has a radius of its own [T14].
        let ratio = g.input(DOMAIN_RATIO, Scope::Node);

        let one = g.one();
        let reciprocal = g.div(one, support_radius);
        let inverse_radius = g.bind("inverse_radius", reciprocal);

        // (a, b, z)_i = Q (x^i − x^c) / R
        let from_slave: Vec<ExprId> = (0..3)
            .map(|axis| {
                let difference = g.sub(node[axis], slave[axis]);
                g.name(difference, &format!("from_slave_{}", AXES[axis]))
            })
            .collect();
        let mut offset = [one; 3];
        for (k, name) in ["a", "b", "z"].into_iter().enumerate() {
            let scaled: Vec<ExprId> = (0..3)
                .map(|axis| {
                    let entry = g.mul(frame[k][axis], inverse_radius);
                    g.name(entry, &format!("axis_{name}_{}", AXES[axis]))
                })
                .collect();
            let definition = g.dot(&from_slave, &scaled);
            offset[k] = g.bind(name, definition);
        }
        let coordinates = CoordinateMap::new(g, &offset, &node, &slave);
        let (position, plane) = match frame_rule {
            FrameRule::Frozen => (offset, None),
            FrameRule::CoMoving => {
                // ω_k = ω(ρ), ρ = |x^k − x^c|/R_k; a reach of 0 makes all of them equal.
                let reach = g.input(PLANE_REACH, Scope::Element);
                let scale = g.mul(ratio, reach);
                let scaled = offset.map(|x| g.mul(x, scale));
                let in_plane = g.hypot(scaled[0], scaled[1]);
                let distance = g.hypot(in_plane, scaled[2]);
                let omega = weight.fitting(g, distance);
                g.name(omega, "plane_weight");
                let plane = AveragePlane::declare(g, offset, omega);
                (plane.position, Some(plane))
            }
        };
        let coordinates = match &plane {
            None => coordinates,
            Some(plane) => coordinates.with_moving(g, &plane.moving, &plane.values),
        };

        // (14) w = w(r), r = √(a² + b²) R/R_k
        let [a, b] = [position[0], position[1]].map(|x| g.mul(x, ratio));
        let r = g.hypot(a, b);
        g.name(r, "r");
        let (weight, anchor) = match weight.evaluate(g, r) {
            NodeWeight::Fitting(weight) => (weight, None),
            NodeWeight::Interpolating { weight, compliance } => {
                let (weight, anchor) = Anchor::declare(g, weight, compliance, offset);
                (weight, Some(anchor))
            }
        };
        g.name(weight, "w");
        Self {
            basis,
            slave,
            frame,
            support_radius,
            inverse_radius,
            position,
            weight,
            anchor,
            coordinates,
            plane,
        }
    }

    /// (13) A α = β with A = Σ w p pᵀ, β = Σ w z p, p = p(a − o₁, b − o₂), o = `origin`, or the anchor where there is one.
    pub fn fit(&self, g: &mut Graph, origin: [ExprId; 2]) -> Fit {
        let origin = self.anchor.map_or(origin, |anchor| anchor.origin);
        let p = self.basis_about(g, origin);
        let height = self.position[2];
        let values = self.values();
        let weighted: Vec<ExprId> = p
            .iter()
            .enumerate()
            .map(|(k, &p)| {
                let product = g.mul(self.weight, p);
                g.name(product, &format!("w_p_{k}"))
            })
            .collect();
        let mut matrix: Vec<Vec<ExprId>> = (0..p.len())
            .map(|i| {
                (0..=i)
                    .map(|j| {
                        let product = g.mul(weighted[i], p[j]);
                        let product = g.substitute(product, &values);
                        let sum = g.sum(product);
                        g.name(sum, &format!("moment_{i}_{j}"))
                    })
                    .collect()
            })
            .collect();
        let mut vector: Vec<ExprId> = (0..p.len())
            .map(|i| {
                let product = g.mul(weighted[i], height);
                let product = g.substitute(product, &values);
                let sum = g.sum(product);
                g.name(sum, &format!("beta_{i}"))
            })
            .collect();
        let diagonal: Vec<ExprId> = matrix.iter().filter_map(|row| row.last().copied()).collect();
        let references = self.basis.pivot_references(g, &diagonal);
        let mut order = self.basis.elimination_order();
        let multiplier = p.len();
        if let Some(anchor) = self.anchor {
            let (row, right_hand_side) = anchor.equation(g, multiplier, height, &self.values());
            matrix.push(row);
            vector.push(right_hand_side);
            // α₀ and σ first: their 2 × 2 block is regular whatever the compliance, and what is left after it is
            // positive definite also for as many nodes as coefficients.
            order.retain(|&k| k != 0);
            order.splice(0..0, [0, multiplier]);
        }
        let multipliers = self.anchor.iter().map(|_| multiplier).collect();
        let system = SymmetricSystem::new("l", matrix.clone(), order).with_multipliers(multipliers);
        let system = g.add_system(system.with_references(references));
        let mut solution = g.solve_symmetric(system, vector);
        let sigma = self.anchor.and_then(|_| solution.pop());
        let mut unknowns = bind_all(g, "alpha", solution);
        unknowns.extend(sigma.map(|sigma| g.bind("sigma", sigma)));
        let problem = self.problem(g, &p, unknowns, system);
        problem.check_system(g);
        Fit { problem, origin, matrix }
    }

    /// The same fit with the origin of its basis moved to `origin`: p(a − o) = T p(a), so A becomes T A Tᵀ, and α
    /// the Taylor coefficients of f at the new origin. The surface stays what it is, so `origin` is held while
    /// differentiating. With an anchor the basis stays there.
    fn recentred(&self, g: &mut Graph, fit: Fit, origin: [ExprId; 2]) -> Fit {
        if self.anchor.is_some() {
            return fit;
        }
        let (a, b) = (g.variable("shift_a"), g.variable("shift_b"));
        let size = self.basis.size();
        let at_minus_origin = [(a, origin[0]), (b, origin[1])].map(|(v, o)| (g.symbol_of(v), g.neg(o)));
        let at_origin = [(g.symbol_of(a), origin[0]), (g.symbol_of(b), origin[1])];

        let p = self.basis.evaluate(g, a, b);
        let shift: Vec<Vec<ExprId>> = p
            .iter()
            .map(|&p_k| {
                let coefficients = self.taylor_coefficients(g, p_k, [a, b]);
                g.substitute_all(&coefficients, &at_minus_origin)
            })
            .collect();
        let f = g.dot(&p, self.alpha(&fit.problem));
        let coefficients = self.taylor_coefficients(g, f, [a, b]);
        let coefficients = g.substitute_all(&coefficients, &at_origin);

        let half: Vec<Vec<ExprId>> = shift
            .iter()
            .map(|row| {
                (0..size)
                    .map(|j| {
                        let column: Vec<ExprId> = (0..size).map(|i| fit.matrix[i.max(j)][i.min(j)]).collect();
                        g.dot(row, &column)
                    })
                    .collect()
            })
            .collect();
        let matrix: Vec<Vec<ExprId>> = (0..size)
            .map(|i| {
                (0..=i)
                    .map(|j| {
                        let entry = g.dot(&half[i], &shift[j]);
                        g.name(entry, &format!("foot_moment_{i}_{j}"))
                    })
                    .collect()
            })
            .collect();
        let system =
            g.add_system(SymmetricSystem::new("foot_l", matrix.clone(), self.basis.elimination_order()));
        let unknowns = bind_all(g, "foot_alpha", coefficients);
        let p = self.basis_about(g, origin);
        Fit { problem: self.problem(g, &p, unknowns, system), origin, matrix }
    }

    /// (1/(i! j!)) ∂ⁱ∂ʲ f for the exponents (i, j) of the basis functions: f = Σ coefficient · p at the origin.
    fn taylor_coefficients(&self, g: &mut Graph, f: ExprId, variables: [ExprId; 2]) -> Vec<ExprId> {
        let symbols = variables.map(|v| g.symbol_of(v));
        let factorial = |k: u8| (1..=k).map(f64::from).product::<f64>();
        self.basis
            .monomials()
            .iter()
            .map(|&(i, j)| {
                let by_a = (0..i).fold(f, |f, _| g.derivative(f, symbols[0]));
                let derivative = (0..j).fold(by_a, |f, _| g.derivative(f, symbols[1]));
                let divisor = g.constant(factorial(i) * factorial(j));
                g.div(derivative, divisor)
            })
            .collect()
    }

    fn basis_about(&self, g: &mut Graph, origin: [ExprId; 2]) -> Vec<ExprId> {
        let a = g.sub(self.position[0], origin[0]);
        let b = g.sub(self.position[1], origin[1]);
        g.name(a, "a_shifted");
        g.name(b, "b_shifted");
        let p = self.basis.evaluate(g, a, b);
        for (k, &p) in p.iter().enumerate() {
            g.name(p, &format!("p_{k}"));
        }
        p
    }

    /// The coefficients among the unknowns.
    fn alpha<'a>(&self, problem: &'a NodeProblem) -> &'a [ExprId] {
        &problem.unknowns()[..self.basis.size()]
    }

    /// (13) as residuals: Σ ρ = 0 with ρ = w e p, e = z − p·α; with an anchor σ p there, and −(e − σ/w) for σ.
    fn problem(&self, g: &mut Graph, p: &[ExprId], unknowns: Vec<ExprId>, system: SystemId) -> NodeProblem {
        let fitted = g.dot(p, &unknowns[..p.len()]);
        g.name(fitted, "fitted");
        let error = g.sub(self.position[2], fitted);
        g.name(error, "e");
        let mut weighted_error = g.mul(self.weight, error);
        g.name(weighted_error, "w_e");
        let mut groups = vec![p.len()];
        let mut constraint = None;
        if let (Some(anchor), Some(&sigma)) = (self.anchor, unknowns.get(p.len())) {
            let own = g.mul(anchor.indicator, sigma);
            weighted_error = g.add(weighted_error, own);
            let (left, right) = (g.mul(anchor.compliance, sigma), g.mul(anchor.indicator, error));
            constraint = Some(g.sub(left, right));
            groups.push(1);
        }
        let mut residual: Vec<ExprId> = p.iter().map(|&p| g.mul(weighted_error, p)).collect();
        residual.extend(constraint);
        let block = Block { unknowns, residual, groups, system };
        let outer = self.plane.as_ref().map(|plane| plane.block.clone());
        NodeProblem { block, outer, coordinates: self.coordinates.clone(), values: self.values() }
    }

    /// Values of what is a variable while differentiating only.
    fn values(&self) -> Vec<(SymbolId, ExprId)> {
        self.plane.as_ref().map(|plane| plane.values.clone()).unwrap_or_default()
    }

    /// The system of the average plane, where the frame moves with it.
    pub fn plane_system(&self) -> Option<SystemId> {
        self.plane.as_ref().map(|plane| plane.block.system)
    }

    /// α about the slave in length units: z = α·(1, a, b, …) with z, a, b in length units.
    pub fn coefficients(&self, g: &mut Graph, fit: &Fit) -> Vec<ExprId> {
        let about_slave = self.coefficients_about_slave(g, fit);
        (0..self.basis.size())
            .map(|k| {
                let unit = self.coefficient_unit(g, k);
                g.mul(unit, about_slave[k])
            })
            .collect()
    }

    /// The Taylor coefficients of f at the slave.
    fn coefficients_about_slave(&self, g: &mut Graph, fit: &Fit) -> Vec<ExprId> {
        if self.anchor.is_none() {
            return self.alpha(&fit.problem).to_vec();
        }
        let u = [g.variable("slave_a"), g.variable("slave_b")];
        let p = self.basis.evaluate(g, u[0], u[1]);
        let f = g.dot(&p, self.alpha(&fit.problem));
        let coefficients = self.taylor_coefficients(g, f, u);
        let at_slave = [0, 1].map(|k| (g.symbol_of(u[k]), g.neg(fit.origin[k])));
        g.substitute_all(&coefficients, &at_slave)
    }

    /// Length to the power of one minus the degree of basis function k.
    fn coefficient_unit(&self, g: &mut Graph, k: usize) -> ExprId {
        let (i, j) = self.basis.monomials()[k];
        match i + j {
            0 => self.support_radius,
            degree => g.power(self.inverse_radius, i32::from(degree) - 1),
        }
    }

    /// The functional α_k about the slave, in length units.
    pub fn coefficient_functional(&self, g: &mut Graph, fit: &Fit, k: usize) -> Functional {
        let coefficient = self.coefficients_about_slave(g, fit)[k];
        let unit = self.coefficient_unit(g, k);
        let first = self.partial_derivatives(g, &fit.problem, coefficient, unit);
        self.linear_functional(g, &format!("alpha{k}"), first)
    }

    /// unit · ∂quantity/∂(unknowns)
    fn partial_derivatives(
        &self,
        g: &mut Graph,
        problem: &NodeProblem,
        quantity: ExprId,
        unit: ExprId,
    ) -> Vec<ExprId> {
        problem
            .unknowns()
            .iter()
            .map(|&unknown| {
                let unknown = g.symbol_of(unknown);
                let derivative = g.derivative(quantity, unknown);
                g.mul(unit, derivative)
            })
            .collect()
    }

    fn linear_functional(&self, g: &mut Graph, name: &str, first: Vec<ExprId>) -> Functional {
        let size = first.len();
        Functional { name: name.to_owned(), first, second: vec![vec![g.zero(); size]; size] }
    }

    /// f = p(u)·α with its derivatives by u, at `point`, dimensionless.
    pub fn surface(&self, g: &mut Graph, fit: &Fit, point: [ExprId; 2]) -> SurfacePoint {
        let u = [g.variable("u_a"), g.variable("u_b")];
        let surface = self.surface_at(g, &fit.problem, u);
        let at_point = [0, 1].map(|k| (g.symbol_of(u[k]), g.sub(point[k], fit.origin[k])));
        SurfacePoint {
            value: g.substitute(surface.value, &at_point),
            slopes: surface.slopes.map(|x| g.substitute(x, &at_point)),
            curvatures: surface.curvatures.map(|x| g.substitute(x, &at_point)),
        }
    }

    fn surface_at(&self, g: &mut Graph, problem: &NodeProblem, u: [ExprId; 2]) -> SurfacePoint {
        self.surface_of(g, self.alpha(problem), u)
    }

    /// f = p(u)·α with its derivatives by the variables u.
    fn surface_of(&self, g: &mut Graph, alpha: &[ExprId], u: [ExprId; 2]) -> SurfacePoint {
        let p = self.basis.evaluate(g, u[0], u[1]);
        let value = g.dot(&p, alpha);
        g.name(value, "f");
        let [u1, u2] = u.map(|u| g.symbol_of(u));
        let slopes = [g.derivative(value, u1), g.derivative(value, u2)];
        let curvatures =
            [g.derivative(slopes[0], u1), g.derivative(slopes[0], u2), g.derivative(slopes[1], u2)];
        SurfacePoint { value, slopes, curvatures }
    }

    /// The functionals f, f_1, f_2 of a surface point, in length units.
    pub fn surface_functionals(&self, g: &mut Graph, fit: &Fit, surface: &SurfacePoint) -> [Functional; 3] {
        let one = g.one();
        let quantities = [
            ("f", surface.value, self.support_radius),
            ("f1", surface.slopes[0], one),
            ("f2", surface.slopes[1], one),
        ];
        quantities.map(|(name, quantity, unit)| {
            let first = self.partial_derivatives(g, &fit.problem, quantity, unit);
            self.linear_functional(g, name, first)
        })
    }

    /// Length units for a surface point: f, slopes, curvatures.
    pub fn surface_in_units(&self, g: &mut Graph, surface: &SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            value: g.mul(self.support_radius, surface.value),
            slopes: surface.slopes,
            curvatures: surface.curvatures.map(|x| g.mul(self.inverse_radius, x)),
        }
    }

    /// An in-plane offset in length units, made dimensionless.
    pub fn dimensionless(&self, g: &mut Graph, length: ExprId) -> ExprId {
        g.mul(length, self.inverse_radius)
    }

    /// Foot point, gap and unit normal, and the gap as a functional of the coefficients at the foot.
    pub fn contact(&self, g: &mut Graph, fit: Fit) -> Contact {
        // Foot point: F_k = −u_k + h f_k = 0 with h = −f(u).
        let u = [g.variable("u_1"), g.variable("u_2")];
        let zero = g.zero();
        // With the coefficients about the slave, also where the basis has its origin at the anchor: close to u = 0 the
        // residual is then as small as the foot, not as the rounding of what cancels.
        let about_slave = self.coefficients_about_slave(g, &fit);
        let about_slave = match self.anchor {
            Some(_) => bind_all(g, "slave_alpha", about_slave),
            None => about_slave,
        };
        let surface = self.surface_of(g, &about_slave, u);
        let equations = foot_equations(g, &surface, u);
        let (root, foot) = g.add_root("foot", &u, equations.to_vec());
        let foot = [g.bind("foot_1", foot[0]), g.bind("foot_2", foot[1])];
        let fit = self.recentred(g, fit, foot);

        // Signed distance as a stationary value. Ψ(δ, q) = ν(q)·(x^c − x^d(o + δ)) with the unit normal
        // ν(q) = (−q_1, −q_2, 1)/√(1 + q²): ∂Ψ/∂δ = 0 says q_k = f_k, ∂Ψ/∂q = 0 says that x^c − x^d is along ν.
        let delta = [g.variable("delta_1"), g.variable("delta_2")];
        let q = [g.variable("q_1"), g.variable("q_2")];
        let surface = self.surface_beside(g, &fit, delta, foot);
        let point = [g.add(foot[0], delta[0]), g.add(foot[1], delta[1])];
        let (one, height) = (g.one(), g.neg(surface.value));
        let along = g.dot(&[q[0], q[1], one], &[point[0], point[1], height]);
        let square = g.dot(&[one, q[0], q[1]], &[one, q[0], q[1]]);
        let length = g.sqrt(square);
        g.name(length, "ell");
        let distance = g.div(along, length);

        // How δ and q follow α: δ by the foot equations, q = f_k(δ, α) by chain rule.
        let equations = foot_equations(g, &surface, point);
        let delta_symbols = delta.map(|d| g.symbol_of(d));
        let jacobian: Vec<Vec<ExprId>> = equations
            .iter()
            .map(|&equation| delta_symbols.iter().map(|&d| g.derivative(equation, d)).collect())
            .collect();
        let unknowns = fit.problem.unknowns().to_vec();
        let followers: Vec<Follower> = unknowns
            .iter()
            .map(|&alpha| {
                let alpha = g.symbol_of(alpha);
                let minus_partial: Vec<ExprId> = equations
                    .iter()
                    .map(|&equation| {
                        let partial = g.derivative(equation, alpha);
                        g.neg(partial)
                    })
                    .collect();
                let by_alpha = g.solve_small(&jacobian, &minus_partial);
                let mut follower = Follower::new(alpha);
                follower.follow(delta_symbols.iter().copied().zip(by_alpha));
                for k in 0..2 {
                    let change = follower.total_derivative(g, surface.slopes[k]);
                    follower.follow([(g.symbol_of(q[k]), change)]);
                }
                follower
            })
            .collect();

        // Ψ is stationary in δ and q, so ∂G/∂α is its partial derivative; ∂²G/∂α² is the total derivative of that.
        let mut at_foot: Vec<_> = delta_symbols.iter().map(|&d| (d, zero)).collect();
        let slopes = surface.slopes.map(|slope| g.substitute(slope, &at_foot));
        at_foot.extend([(g.symbol_of(q[0]), slopes[0]), (g.symbol_of(q[1]), slopes[1])]);
        let first: Vec<ExprId> = followers.iter().map(|f| g.derivative(distance, f.parameter())).collect();
        let second = first
            .iter()
            .map(|&first| {
                followers
                    .iter()
                    .map(|follower| {
                        let entry = follower.total_derivative(g, first);
                        let entry = g.substitute(entry, &at_foot);
                        g.mul(self.support_radius, entry)
                    })
                    .collect()
            })
            .collect();
        let first: Vec<ExprId> = g
            .substitute_all(&first, &at_foot)
            .into_iter()
            .map(|entry| g.mul(self.support_radius, entry))
            .collect();
        let functional = Functional { name: "gap".to_owned(), first, second };

        // (19) g, (22) ν, and x^d, in global axes.
        let scaled_gap = g.substitute(distance, &at_foot);
        let gap = g.mul(self.support_radius, scaled_gap);
        let length = g.substitute(length, &at_foot);
        g.name(length, "ell");
        let reciprocal = g.div(one, length);
        g.name(reciprocal, "inverse_ell");
        let (minus_f1, minus_f2) = (g.neg(slopes[0]), g.neg(slopes[1]));
        let unnormalised = self.to_global(g, [minus_f1, minus_f2, one]);
        let normal = unnormalised.map(|x| g.mul(x, reciprocal));
        let height = g.substitute(surface.value, &at_foot);
        let from_slave = self.to_global(g, [foot[0], foot[1], height]);
        let foot_point = std::array::from_fn(|axis| {
            let offset = g.mul(self.support_radius, from_slave[axis]);
            g.add(self.slave[axis], offset)
        });

        let determinant = g.determinant(&jacobian);
        let determinant = g.substitute(determinant, &at_foot);
        let trace = g.add(jacobian[0][0], jacobian[1][1]);
        let trace = g.substitute(trace, &at_foot);
        let square = g.dot(&foot, &foot);
        let distance = g.sqrt(square);
        let problem = fit.problem;
        Contact { problem, functional, gap, foot: foot_point, normal, distance, determinant, trace, root }
    }

    /// The surface at u + δ as a function of the variables δ.
    fn surface_beside(&self, g: &mut Graph, fit: &Fit, delta: [ExprId; 2], u: [ExprId; 2]) -> SurfacePoint {
        let from_origin = [0, 1].map(|k| g.sub(u[k], fit.origin[k]));
        if from_origin.iter().all(|&x| g.is_zero(x)) {
            return self.surface_at(g, &fit.problem, delta);
        }
        let v = [g.variable("v_1"), g.variable("v_2")];
        let surface = self.surface_at(g, &fit.problem, v);
        let at_point = [0, 1].map(|k| (g.symbol_of(v[k]), g.add(from_origin[k], delta[k])));
        SurfacePoint {
            value: g.substitute(surface.value, &at_point),
            slopes: surface.slopes.map(|x| g.substitute(x, &at_point)),
            curvatures: surface.curvatures.map(|x| g.substitute(x, &at_point)),
        }
    }

    /// Global components of a vector given along (t1, t2, n̂).
    fn to_global(&self, g: &mut Graph, local: [ExprId; 3]) -> [ExprId; 3] {
        std::array::from_fn(|axis| {
            let column = self.frame.map(|row| row[axis]);
            g.dot(&local, &column)
        })
    }

    /// How the iteration for the foot went.
    pub fn foot_figures(&self, g: &mut Graph, root: RootId) -> [ExprId; 2] {
        [(RootFigure::Residual, "foot_residual"), (RootFigure::Iterations, "foot_iterations")].map(
            |(figure, name)| {
                let figure = g.root_figure(root, figure);
                g.name(figure, name)
            },
        )
    }
}

/// −u_k + h f_k with h = −f: zero where the line from the surface point over u to the slave is normal to the surface.
fn foot_equations(g: &mut Graph, surface: &SurfacePoint, u: [ExprId; 2]) -> [ExprId; 2] {
    let height = g.neg(surface.value);
    std::array::from_fn(|k| {
        let product = g.mul(height, surface.slopes[k]);
        g.sub(product, u[k])
    })
}

fn bind_all(g: &mut Graph, name: &str, exprs: Vec<ExprId>) -> Vec<ExprId> {
    exprs.into_iter().enumerate().map(|(k, x)| g.bind(&format!("{name}_{k}"), x)).collect()
}
