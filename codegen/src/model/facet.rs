//! Contact on the facets themselves, as formulas: the distance of the slave from a triangle or a quadrilateral.
//!
//! The slave counts as a node with the shape function −1, so that with s = (−1, N_1, …, N_n) the facet's point relative
//! to the slave is y(u) = Σ s_k(u) x_k. Everything is made dimensionless with a size of the facet that is held while
//! differentiating; outputs carry their units again. All derivatives in here are asked from the derivative engine.

use super::diffuse::Equation;
use super::facet_shape::FacetShape;
use super::kernel::{Kernel, Mode, Results};
use crate::expr::{AXES, Expr, Mat2, Mat3, Matrix, Sheet, Vec2, Vec3, Vector, dot};
use crate::graph::{Iteration, RootFigure, Scope};
use crate::structure::{Follower, LinearImages, SecondDerivative};

/// Names of the vectors that y(u) is made of.
const VECTORS: [&str; 4] = ["position", "tangent_1", "tangent_2", "twist"];

/// What identifies a facet kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FacetSpec {
    /// The facet's shape.
    pub shape: FacetShape,
    /// With how many derivatives.
    pub mode: Mode,
}

impl FacetSpec {
    /// All facet kernels.
    #[must_use]
    pub fn all() -> Vec<Self> {
        FacetShape::ALL.into_iter().flat_map(|shape| Mode::ALL.map(|mode| Self { shape, mode })).collect()
    }
}

/// Inputs and what follows from them before the foot.
struct Facet<'g> {
    shape: FacetShape,
    slave: Vec3<'g>,
    /// Parametric coordinates, variables.
    u: Vec2<'g>,
    /// s_k(u): −1 and the shape functions.
    weights: Vec<Expr<'g>>,
    size: Expr<'g>,
    inverse_size: Expr<'g>,
    /// Coefficient vectors of y(u)/size about the centre, one per monomial.
    vectors: Vec<Vec3<'g>>,
}

/// The foot and how it was found.
struct Foot<'g> {
    u: Vec2<'g>,
    residual: Expr<'g>,
    iterations: Expr<'g>,
}

impl Kernel<FacetSpec> {
    /// Builds a facet kernel from its formulas. Its derivatives are among the values, as `gradient` and `hessian`: with
    /// the number of corners fixed, all quantities are of element scope.
    #[must_use]
    pub fn facet(spec: FacetSpec) -> Self {
        let equations = vec![
            Equation {
                formula: "y(u) = sum s_k(u) x_k, s = (-1, N_1, ..., N_n)",
                source: "the facet's point relative to the slave",
            },
            Equation { formula: "y d_k y = 0, k = 1, 2", source: "foot u" },
            Equation { formula: "nu = (d_1 y x d_2 y) / |d_1 y x d_2 y|", source: "unit normal at the foot" },
            Equation { formula: "g = -nu y", source: "signed distance, positive apart" },
            Equation { formula: "N = dg/dx, M = d2g/dx2", source: "by the derivative engine" },
        ];
        Self::of(spec, equations, |sheet, spec, results| {
            Facet::declare(sheet, spec.shape).contact(spec.mode, results);
        })
    }
}

impl<'g> Facet<'g> {
    fn declare(sheet: &'g Sheet, shape: FacetShape) -> Self {
        let slave = sheet.vector("slave", Scope::Element);
        let corners: Vec<Vec3<'g>> =
            (1..=shape.corners()).map(|k| sheet.vector(&format!("corner_{k}"), Scope::Element)).collect();
        let u = sheet.variables(["u_1", "u_2"]);
        let shape_functions = shape.shape_functions(u);
        let weights = [&[sheet.number(-1.0)], &shape_functions[..]].concat();

        // y(u) = (x^1 − x^c) + Σ N_i (x^i − x^1), as Σ N_i = 1: differences of what is close together come first.
        let centre = Vector::zero(sheet);
        let coefficients = [0, 1, 2].map(|axis| {
            let mut y = (corners[0][axis] - slave[axis]).named(&format!("from_slave_{}", AXES[axis]));
            for (k, (corner, &weight)) in corners.iter().zip(&shape_functions).enumerate().skip(1) {
                let edge = corner[axis] - corners[0][axis];
                y += weight * edge.named(&format!("edge_{}_{}", k + 1, AXES[axis]));
            }
            shape.taylor_coefficients(y, u, centre)
        });
        let count = shape.monomials().len();
        let vectors: Vec<Vec3<'g>> =
            (0..count).map(|m| Vector::from_fn(|axis| coefficients[axis][m])).collect();
        check_coefficients(shape, &vectors, &weights, u, slave, &corners);

        let size = largest_entry(vectors[1], vectors[2]).bind("size");
        let inverse_size = size.reciprocal_or_zero().bind("inverse_size");
        let scaled = vectors.into_iter().zip(VECTORS);
        let vectors = scaled.map(|(v, name)| (inverse_size * v).bind(&format!("centre_{name}"))).collect();
        Self { shape, slave, u, weights, size, inverse_size, vectors }
    }

    fn contact(&self, mode: Mode, results: &mut Results) {
        let sheet = self.size.sheet();
        let foot = self.foot();
        let corner_area = self.corner_area();
        let vectors = self.vectors_at(foot.u);

        // The gap as a stationary value: Ψ(δ, ν) = −ν·y(δ) does not change to first order with the point δ where ν is
        // normal to the facet, nor with the direction ν where y is along it.
        let delta = sheet.variables(["delta_1", "delta_2"]);
        let nu = sheet.variables(["nu_x", "nu_y", "nu_z"]);
        let y = self.point(&vectors, delta);
        let distance = -nu.dot(y);
        let normal = vectors[1].cross(vectors[2]).unit().bind("normal");
        let at_foot = [delta.set_to(Vector::zero(sheet)), nu.set_to(normal)].concat();

        // How δ and ν follow the vectors: δ by the foot equations, ν as the unit vector normal to both tangents.
        let foot_equations = self.foot_equations(|m, l| vectors[m].dot(vectors[l]), delta);
        let jacobian = foot_equations.jacobian(delta).at(&at_foot);
        let [y_1, y_2] = delta.0.map(|delta| y.by(delta));
        let normal_equations = Vector([nu.dot(y_1), nu.dot(y_2), 0.5 * (nu.dot(nu) - 1.0)]);
        let normal_jacobian = normal_equations.jacobian(nu).at(&at_foot);

        let first: Vec<Vec3<'g>> = vectors.iter().map(|&v| distance.gradient(v)).collect();
        let images = LinearImages::new(self.coefficients_at(foot.u));
        let gradient = (mode >= Mode::Gradient).then(|| {
            let first: Vec<Vec3<'g>> = first.iter().map(|row| row.at(&at_foot)).collect();
            images.gradient(&first)
        });
        let hessian = (mode >= Mode::Hessian).then(|| {
            let inverse_jacobian = jacobian.inverse().named("inverse_jacobian");
            let dual_basis = normal_jacobian.inverse().named("dual_basis");
            let followers: Vec<[Follower<'g>; 3]> = vectors
                .iter()
                .map(|v| {
                    v.0.map(|x| {
                        let mut follower = Follower::new(x);
                        follower.follow_root(delta, foot_equations, inverse_jacobian, &at_foot);
                        follower.follow_root(nu, normal_equations, dual_basis, &at_foot);
                        follower
                    })
                })
                .collect();
            // Ψ is stationary in δ and ν, so ∂G/∂v is its partial derivative, and ∂²G/∂v² the total one of that.
            let by = |first: Vec3<'g>, v: &[Follower<'g>; 3]| {
                Mat3::from_fn(|i, j| v[j].total_derivative(first[i]).at(&at_foot) * self.inverse_size)
            };
            let second: SecondDerivative<'g> =
                first.iter().map(|&first| followers.iter().map(|v| by(first, v)).collect()).collect();
            images.hessian(&second)
        });

        let gap = self.size * distance.at(&at_foot);
        let foot_point = self.slave + self.size * vectors[0];
        let natural = self.shape.natural(foot.u);
        let curvature = curvature_figure(jacobian, &vectors);
        let foot_area = self.area_at(foot.u);

        results.scalar("gap", "Signed gap g, length, positive apart", gap);
        results.array("foot", "Foot point, global axes, length", &foot_point.0);
        results.array("normal", "Unit normal ν at the foot, global axes", &normal.0);
        results.array("natural", "Natural coordinates (ξ, η) of the foot", &natural.0);
        if let Some(gradient) = gradient {
            results.array("gradient", "N = ∂g/∂x, dimensionless", &gradient);
        }
        if let Some(hessian) = hessian {
            results.array("hessian", "M = ∂²g/∂x∂x, 1/length, packed lower triangle", &hessian);
        }
        results.scalar("corner_area", "Smallest area element of a corner, relative", corner_area);
        results.scalar("foot_area", "Area element at the foot, relative", foot_area);
        results.scalar("foot_residual", "Largest foot residual, relative", foot.residual);
        results.scalar("foot_iterations", "Evaluations of the foot equations", foot.iterations);
        results.scalar(
            "jacobian_determinant",
            "det of the foot equations' Jacobian over that of a flat facet",
            curvature,
        );
    }

    /// r_k = −y·∂_k y with y(u) = Σ v_m φ_m(u), from the products v_m·v_l.
    fn foot_equations(&self, gram: impl Fn(usize, usize) -> Expr<'g>, u: Vec2<'g>) -> Vec2<'g> {
        let phi = self.shape.evaluate_monomials(u);
        let count = phi.len();
        // v_m·y
        let products: Vec<Expr<'g>> =
            (0..count).map(|m| dot((0..count).map(|l| gram(m.max(l), m.min(l))), &phi)).collect();
        u.map(|u| -dot(phi.iter().map(|phi| phi.by(u)), &products))
    }

    /// The root of the foot equations about the centre of the facet. Products of the vectors are formed once, so that a
    /// slave straight over the centre is a root to the last digit.
    fn foot(&self) -> Foot<'g> {
        let sheet = self.size.sheet();
        let v = &self.vectors;
        let product = |m: usize, l: usize| v[m].dot(v[l]).bind(&format!("gram_{m}_{l}"));
        let gram: Vec<Vec<Expr<'g>>> =
            (0..v.len()).map(|m| (0..=m).map(|l| product(m, l)).collect()).collect();
        let equations = self.foot_equations(|m, l| gram[m][l], self.u);
        let at_centre = self.u.set_to(Vector::zero(sheet));
        let jacobian = equations.jacobian(self.u);
        let is_linear = jacobian.at(&at_centre) == jacobian;
        let (u, residual, iterations) = if is_linear {
            (jacobian.solve(-equations.at(&at_centre)), sheet.zero(), sheet.one())
        } else {
            // The negative derivatives of half the squared distance.
            let (root, u) = sheet.root_by(Iteration::Descent, "foot", self.u, equations);
            let [residual, iterations] =
                [RootFigure::Residual, RootFigure::Iterations].map(|f| sheet.root_figure(root, f));
            (u, residual, iterations)
        };
        Foot { u: u.bind("foot"), residual, iterations }
    }

    /// Σ v_m φ_m(u)
    fn point(&self, v: &[Vec3<'g>], u: Vec2<'g>) -> Vec3<'g> {
        let phi = self.shape.evaluate_monomials(u);
        Vector::from_fn(|axis| dot(v.iter().map(|v| v[axis]), &phi))
    }

    /// Coefficient vectors of y/size about the foot: position, tangents, twist.
    fn vectors_at(&self, foot: Vec2<'g>) -> Vec<Vec3<'g>> {
        let y = self.point(&self.vectors, self.u);
        let by_axis = y.0.map(|y| self.shape.taylor_coefficients(y, self.u, foot));
        let vector = |m: usize| Vector::from_fn(|axis| by_axis[axis][m]).bind(VECTORS[m]);
        (0..self.vectors.len()).map(vector).collect()
    }

    /// How the vectors at the foot, times size, depend on the nodes: v_m = Σ c_km x_k, `[node][vector]`.
    fn coefficients_at(&self, foot: Vec2<'g>) -> Vec<Vec<Expr<'g>>> {
        self.weights.iter().map(|&s| self.shape.taylor_coefficients(s, self.u, foot)).collect()
    }

    /// The area element ∂_1 y × ∂_2 y along its direction at the centre, over the mean square of the tangents there: 1
    /// for a square and less for any other facet, as coefficients of the monomials.
    fn area_coefficients(&self) -> Vec<Expr<'g>> {
        let y = self.point(&self.vectors, self.u);
        let area = y.by(self.u[0]).cross(y.by(self.u[1]));
        let centre = Vector::zero(self.size.sheet());
        let by_axis = area.0.map(|area| self.shape.taylor_coefficients(area, self.u, centre));
        let coefficient = |m: usize| Vec3::from_fn(|axis| by_axis[axis][m]);
        let direction = coefficient(0).unit();
        let v = &self.vectors;
        let factor = self.size.sheet().number(2.0).div_or_zero(v[1].dot(v[1]) + v[2].dot(v[2]));
        let along = |m: usize| (factor * direction.dot(coefficient(m))).named(&format!("area_{m}"));
        (0..v.len()).map(along).collect()
    }

    fn area_at(&self, u: Vec2<'g>) -> Expr<'g> {
        dot(self.area_coefficients(), self.shape.evaluate_monomials(u))
    }

    /// Smallest relative area element at a corner: 0 or less if the facet has no area, is folded or not convex.
    fn corner_area(&self) -> Expr<'g> {
        let corners = self.shape.parametric_corners().iter();
        let areas = corners.map(|&u| self.area_at(Vector::numbers(self.size.sheet(), u)));
        areas.reduce(|smallest, area| area.min(smallest)).expect("a facet has corners")
    }
}

/// Compares the coefficient vectors' dependence on the nodes with the shape functions' coefficients: what the vectors
/// were assembled from says that they are Σ s_k x_k.
fn check_coefficients<'g>(
    shape: FacetShape,
    vectors: &[Vec3<'g>],
    weights: &[Expr<'g>],
    u: Vec2<'g>,
    slave: Vec3<'g>,
    corners: &[Vec3<'g>],
) {
    let centre = Vector::zero(u[0].sheet());
    for (node, &weight) in std::iter::once(&slave).chain(corners).zip(weights) {
        for (vector, expected) in vectors.iter().zip(shape.taylor_coefficients(weight, u, centre)) {
            for axis in 0..3 {
                let [found, expected] = [vector[axis].by(node[axis]), expected].map(Expr::value);
                let difference = found.zip(expected).map(|(found, expected)| (found - expected).abs());
                assert!(
                    difference.is_some_and(|difference| difference < 1e-15),
                    "a vector's derivative by a node is {found:?}, not {expected:?}"
                );
            }
        }
    }
}

/// det J over the determinant of the metric, which it is on a flat facet: Π (1 − g κ), 0 on a centre of curvature.
fn curvature_figure<'g>(jacobian: Mat2<'g>, v: &[Vec3<'g>]) -> Expr<'g> {
    let metric: Mat2<'g> = Matrix::from_fn(|k, l| v[1 + k.max(l)].dot(v[1 + k.min(l)]));
    let (determinant, flat) = (jacobian.determinant(), metric.determinant());
    if determinant == flat { flat.sheet().one() } else { determinant / flat }
}

/// Largest absolute value: no square that could overflow.
fn largest_entry<'g>(v: Vec3<'g>, w: Vec3<'g>) -> Expr<'g> {
    let sizes: Vec<Expr<'g>> = v.iter().chain(w.iter()).map(|x| x.abs().named("absolute")).collect();
    sizes.into_iter().reduce(|largest, size| largest.max(size).named("largest")).expect("six entries")
}
