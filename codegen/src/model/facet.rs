//! Contact on the facets themselves, as formulas: the distance of the slave from a triangle or a quadrilateral.
//!
//! The slave counts as a node with the shape function −1, so that with s = (−1, N_1, …, N_n) the facet's point relative
//! to the slave is y(u) = Σ s_k(u) x_k. Everything is made dimensionless with a size of the facet that is held while
//! differentiating; outputs carry their units again. All derivatives in here are asked from the derivative engine.

use super::average_plane::cross;
use super::diffuse::Equation;
use super::facet_shape::FacetShape;
use super::kernel::{Kernel, Mode};
use crate::graph::{ExprId, Graph, RootFigure, Scope, SymbolId};
use crate::structure::{Follower, LinearImages, SecondDerivative};

/// Names of the global axes.
const AXES: [&str; 3] = ["x", "y", "z"];
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
struct Facet {
    shape: FacetShape,
    slave: [ExprId; 3],
    /// Parametric coordinates, variables.
    u: [ExprId; 2],
    /// s_k(u): −1 and the shape functions.
    weights: Vec<ExprId>,
    size: ExprId,
    inverse_size: ExprId,
    /// Coefficient vectors of y(u)/size about the centre, one per monomial.
    vectors: Vec<[ExprId; 3]>,
}

/// The foot and how it was found.
struct Foot {
    u: [ExprId; 2],
    residual: ExprId,
    iterations: ExprId,
}

impl Kernel<FacetSpec> {
    /// Builds a facet kernel from its formulas. Its derivatives are among the values, as `gradient` and `hessian`: with
    /// the number of corners fixed, all quantities are of element scope.
    #[must_use]
    pub fn facet(spec: FacetSpec) -> Self {
        let mut graph = Graph::new();
        let facet = Facet::declare(&mut graph, spec.shape);
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
        let mut kernel =
            Self { spec, graph, values: Vec::new(), gradients: Vec::new(), hessians: Vec::new(), equations };
        kernel.add_contact(&facet);
        kernel.add_checksum();
        kernel
    }

    fn add_contact(&mut self, facet: &Facet) {
        let g = &mut self.graph;
        let foot = facet.foot(g);
        let corner_area = facet.corner_area(g);
        let vectors = facet.vectors_at(g, foot.u);

        // The gap as a stationary value: Ψ(δ, ν) = −ν·y(δ) does not change to first order with the point δ where ν is
        // normal to the facet, nor with the direction ν where y is along it.
        let delta = [g.variable("delta_1"), g.variable("delta_2")];
        let nu = AXES.map(|axis| g.variable(&format!("nu_{axis}")));
        let y = facet.point(g, &vectors, delta);
        let [delta_symbols, nu_symbols] = [&delta[..], &nu[..]].map(|v| symbols(g, v));
        let tangents: Vec<[ExprId; 3]> =
            delta_symbols.iter().map(|&d| y.map(|y| g.derivative(y, d))).collect();
        let along = g.dot(&nu, &y);
        let distance = g.neg(along);

        let area_vector = cross(g, vectors[1], vectors[2]);
        let normal = unit(g, area_vector);
        let normal: [ExprId; 3] = std::array::from_fn(|k| g.bind(&format!("normal_{}", AXES[k]), normal[k]));
        let zero = g.zero();
        let mut at_foot: Vec<(SymbolId, ExprId)> = delta_symbols.iter().map(|&d| (d, zero)).collect();
        at_foot.extend(nu_symbols.iter().copied().zip(normal));

        // How δ and ν follow the vectors: δ by the foot equations, ν as the unit vector normal to both tangents.
        let gram = |g: &mut Graph, m: usize, l: usize| g.dot(&vectors[m], &vectors[l]);
        let foot_equations = facet.foot_equations(g, gram, delta);
        let jacobian = jacobian_at(g, &foot_equations, &delta_symbols, &at_foot);
        let normal_equations = normal_equations(g, nu, &tangents);
        let normal_jacobian = jacobian_at(g, &normal_equations, &nu_symbols, &at_foot);
        let vector_symbols: Vec<[SymbolId; 3]> = vectors.iter().map(|v| v.map(|x| g.symbol_of(x))).collect();

        let first: Vec<[ExprId; 3]> =
            vector_symbols.iter().map(|v| v.map(|x| g.derivative(distance, x))).collect();
        let images = LinearImages::new(facet.coefficients_at(g, foot.u));
        let gradient = (self.spec.mode >= Mode::Gradient).then(|| {
            let first: Vec<[ExprId; 3]> =
                first.iter().map(|row| row.map(|x| g.substitute(x, &at_foot))).collect();
            images.gradient(g, &first)
        });
        let hessian = (self.spec.mode >= Mode::Hessian).then(|| {
            let inverse_jacobian = named_inverse(g, &jacobian, "inverse_jacobian");
            let inverse_normal_jacobian = named_inverse(g, &normal_jacobian, "dual_basis");
            let followers: Vec<[Follower; 3]> = vector_symbols
                .iter()
                .map(|v| {
                    v.map(|parameter| {
                        let mut follower = Follower::new(parameter);
                        follower.follow_root(g, &delta_symbols, &foot_equations, &inverse_jacobian, &at_foot);
                        let inverse = &inverse_normal_jacobian;
                        follower.follow_root(g, &nu_symbols, &normal_equations, inverse, &at_foot);
                        follower
                    })
                })
                .collect();
            // Ψ is stationary in δ and ν, so ∂G/∂v is its partial derivative, and ∂²G/∂v² the total one of that.
            let second: SecondDerivative = first
                .iter()
                .map(|row| {
                    followers
                        .iter()
                        .map(|by| {
                            row.map(|first| {
                                [0, 1, 2].map(|k| {
                                    let entry = by[k].total_derivative(g, first);
                                    let entry = g.substitute(entry, &at_foot);
                                    g.mul(entry, facet.inverse_size)
                                })
                            })
                        })
                        .collect()
                })
                .collect();
            images.hessian(g, &second)
        });

        let scaled_gap = g.substitute(distance, &at_foot);
        let gap = g.mul(facet.size, scaled_gap);
        let foot_point: Vec<ExprId> = (0..3)
            .map(|axis| {
                let offset = g.mul(facet.size, vectors[0][axis]);
                g.add(facet.slave[axis], offset)
            })
            .collect();
        let natural = facet.shape.natural(g, foot.u);
        let curvature = curvature_figure(g, &jacobian, &vectors);
        let foot_area = facet.area_at(g, foot.u);

        self.add_scalar("gap", "Signed gap g, length, positive apart", gap);
        self.add_array("foot", "Foot point, global axes, length", foot_point);
        self.add_array("normal", "Unit normal ν at the foot, global axes", normal.to_vec());
        self.add_array("natural", "Natural coordinates (ξ, η) of the foot", natural.to_vec());
        if let Some(gradient) = gradient {
            self.add_array("gradient", "N = ∂g/∂x, dimensionless", gradient);
        }
        if let Some(hessian) = hessian {
            self.add_array("hessian", "M = ∂²g/∂x∂x, 1/length, packed lower triangle", hessian);
        }
        self.add_scalar("corner_area", "Smallest area element of a corner, relative", corner_area);
        self.add_scalar("foot_area", "Area element at the foot, relative", foot_area);
        self.add_scalar("foot_residual", "Largest foot residual, relative", foot.residual);
        self.add_scalar("foot_iterations", "Evaluations of the foot equations", foot.iterations);
        self.add_scalar(
            "jacobian_determinant",
            "det of the foot equations' Jacobian over that of a flat facet",
            curvature,
        );
    }
}

impl Facet {
    fn declare(g: &mut Graph, shape: FacetShape) -> Self {
        let slave = AXES.map(|axis| g.input(&format!("slave_{axis}"), Scope::Element));
        let corners: Vec<[ExprId; 3]> = (1..=shape.corners())
            .map(|k| AXES.map(|axis| g.input(&format!("corner_{k}_{axis}"), Scope::Element)))
            .collect();
        let u = [g.variable("u_1"), g.variable("u_2")];
        let shape_functions = shape.shape_functions(g, u);
        let slave_weight = g.constant(-1.0);
        let mut weights = vec![slave_weight];
        weights.extend(&shape_functions);

        // y(u) = (x^1 − x^c) + Σ N_i (x^i − x^1), as Σ N_i = 1: differences of what is close together come first.
        let mut vectors = vec![[slave_weight; 3]; shape.monomials().len()];
        let u_symbols = u.map(|u| g.symbol_of(u));
        let zero = g.zero();
        for axis in 0..3 {
            let mut y = g.sub(corners[0][axis], slave[axis]);
            g.name(y, &format!("from_slave_{}", AXES[axis]));
            for (k, (corner, &weight)) in corners.iter().zip(&shape_functions).enumerate().skip(1) {
                let edge = g.sub(corner[axis], corners[0][axis]);
                g.name(edge, &format!("edge_{}_{}", k + 1, AXES[axis]));
                let term = g.mul(weight, edge);
                y = g.add(y, term);
            }
            let coefficients = shape.taylor_coefficients(g, y, u_symbols, [zero; 2]);
            for (vector, coefficient) in vectors.iter_mut().zip(coefficients) {
                vector[axis] = coefficient;
            }
        }
        check_coefficients(g, shape, &vectors, &weights, u_symbols, &slave, &corners);

        let size = largest_entry(g, &[vectors[1], vectors[2]].concat());
        let size = g.bind("size", size);
        let one = g.one();
        let reciprocal = g.div_or_zero(one, size);
        let inverse_size = g.bind("inverse_size", reciprocal);
        let vectors = vectors
            .into_iter()
            .zip(VECTORS)
            .map(|(vector, name)| {
                std::array::from_fn(|axis| {
                    let scaled = g.mul(inverse_size, vector[axis]);
                    g.bind(&format!("centre_{name}_{}", AXES[axis]), scaled)
                })
            })
            .collect();
        Self { shape, slave, u, weights, size, inverse_size, vectors }
    }

    /// r_k = −y·∂_k y with y(u) = Σ v_m φ_m(u), from the products v_m·v_l.
    fn foot_equations(
        &self,
        g: &mut Graph,
        mut gram: impl FnMut(&mut Graph, usize, usize) -> ExprId,
        u: [ExprId; 2],
    ) -> Vec<ExprId> {
        let monomials = self.shape.evaluate_monomials(g, u);
        // v_m·y
        let products: Vec<ExprId> = (0..monomials.len())
            .map(|m| {
                let row: Vec<ExprId> = (0..monomials.len()).map(|l| gram(g, m.max(l), m.min(l))).collect();
                g.dot(&row, &monomials)
            })
            .collect();
        u.into_iter()
            .map(|u| {
                let u = g.symbol_of(u);
                let slopes: Vec<ExprId> = monomials.iter().map(|&phi| g.derivative(phi, u)).collect();
                let product = g.dot(&slopes, &products);
                g.neg(product)
            })
            .collect()
    }

    /// The root of the foot equations about the centre of the facet. Products of the vectors are formed once, so that a
    /// slave straight over the centre is a root to the last digit.
    fn foot(&self, g: &mut Graph) -> Foot {
        let count = self.vectors.len();
        let gram: Vec<Vec<ExprId>> = (0..count)
            .map(|m| {
                (0..=m)
                    .map(|l| {
                        let product = g.dot(&self.vectors[m], &self.vectors[l]);
                        g.bind(&format!("gram_{m}_{l}"), product)
                    })
                    .collect()
            })
            .collect();
        let equations = self.foot_equations(g, |_, m, l| gram[m][l], self.u);
        let symbols = symbols(g, &self.u);
        let (zero, one) = (g.zero(), g.one());
        let at_centre: Vec<(SymbolId, ExprId)> = symbols.iter().map(|&u| (u, zero)).collect();
        let jacobian = jacobian_at(g, &equations, &symbols, &[]);
        let is_linear = jacobian.iter().flatten().all(|&x| g.substitute(x, &at_centre) == x);
        let (u, residual, iterations) = if is_linear {
            let minus_residual: Vec<ExprId> = equations
                .iter()
                .map(|&r| {
                    let residual = g.substitute(r, &at_centre);
                    g.neg(residual)
                })
                .collect();
            (g.solve_small(&jacobian, &minus_residual), zero, one)
        } else {
            let (root, u) = g.add_root("foot", &self.u, equations);
            let figures = [RootFigure::Residual, RootFigure::Iterations].map(|f| g.root_figure(root, f));
            (u, figures[0], figures[1])
        };
        let u = [g.bind("foot_1", u[0]), g.bind("foot_2", u[1])];
        Foot { u, residual, iterations }
    }

    /// Σ v_m φ_m(u)
    fn point(&self, g: &mut Graph, vectors: &[[ExprId; 3]], u: [ExprId; 2]) -> [ExprId; 3] {
        let monomials = self.shape.evaluate_monomials(g, u);
        std::array::from_fn(|axis| {
            let column: Vec<ExprId> = vectors.iter().map(|v| v[axis]).collect();
            g.dot(&column, &monomials)
        })
    }

    /// Coefficient vectors of y/size about the foot: position, tangents, twist.
    fn vectors_at(&self, g: &mut Graph, foot: [ExprId; 2]) -> Vec<[ExprId; 3]> {
        let y = self.point(g, &self.vectors, self.u);
        let u = self.u.map(|u| g.symbol_of(u));
        let by_axis = y.map(|y| self.shape.taylor_coefficients(g, y, u, foot));
        (0..self.vectors.len())
            .map(|m| {
                std::array::from_fn(|axis| {
                    g.bind(&format!("{}_{}", VECTORS[m], AXES[axis]), by_axis[axis][m])
                })
            })
            .collect()
    }

    /// How the vectors at the foot, times size, depend on the nodes: v_m = Σ c_km x_k, `[node][vector]`.
    fn coefficients_at(&self, g: &mut Graph, foot: [ExprId; 2]) -> Vec<Vec<ExprId>> {
        let u = self.u.map(|u| g.symbol_of(u));
        self.weights.iter().map(|&weight| self.shape.taylor_coefficients(g, weight, u, foot)).collect()
    }

    /// The area element ∂_1 y × ∂_2 y along its direction at the centre, over the mean square of the tangents there: 1
    /// for a square and less for any other facet, as coefficients of the monomials.
    fn area_coefficients(&self, g: &mut Graph) -> Vec<ExprId> {
        let u = self.u.map(|u| g.symbol_of(u));
        let y = self.point(g, &self.vectors, self.u);
        let [left, right] = u.map(|u| y.map(|y| g.derivative(y, u)));
        let area = cross(g, left, right);
        let zero = g.zero();
        let by_axis = area.map(|area| self.shape.taylor_coefficients(g, area, u, [zero; 2]));
        let direction = unit(g, std::array::from_fn(|axis| by_axis[axis][0]));
        let squares: Vec<ExprId> = (1..3).map(|m| g.dot(&self.vectors[m], &self.vectors[m])).collect();
        let (sum, two) = (g.total(&squares), g.constant(2.0));
        let factor = g.div_or_zero(two, sum);
        (0..self.vectors.len())
            .map(|m| {
                let along: Vec<ExprId> = by_axis.iter().map(|coefficients| coefficients[m]).collect();
                let along = g.dot(&direction, &along);
                let coefficient = g.mul(factor, along);
                g.name(coefficient, &format!("area_{m}"))
            })
            .collect()
    }

    fn area_at(&self, g: &mut Graph, u: [ExprId; 2]) -> ExprId {
        let coefficients = self.area_coefficients(g);
        let monomials = self.shape.evaluate_monomials(g, u);
        g.dot(&coefficients, &monomials)
    }

    /// Smallest relative area element at a corner: 0 or less if the facet has no area, is folded or not convex.
    fn corner_area(&self, g: &mut Graph) -> ExprId {
        let corners: Vec<ExprId> = self
            .shape
            .parametric_corners()
            .iter()
            .map(|corner| {
                let u = corner.map(|u| g.constant(u));
                self.area_at(g, u)
            })
            .collect();
        corners[1..].iter().fold(corners[0], |smallest, &area| g.select_less(area, smallest, area, smallest))
    }
}

/// Compares the coefficient vectors' dependence on the nodes with the shape functions' coefficients: what the vectors
/// were assembled from says that they are Σ s_k x_k.
fn check_coefficients(
    g: &mut Graph,
    shape: FacetShape,
    vectors: &[[ExprId; 3]],
    weights: &[ExprId],
    u: [SymbolId; 2],
    slave: &[ExprId; 3],
    corners: &[[ExprId; 3]],
) {
    let zero = g.zero();
    for (node, &weight) in std::iter::once(slave).chain(corners).zip(weights) {
        let expected = shape.taylor_coefficients(g, weight, u, [zero; 2]);
        for axis in 0..3 {
            let by = g.symbol_of(node[axis]);
            for (vector, &expected) in vectors.iter().zip(&expected) {
                let found = g.derivative(vector[axis], by);
                let [found, expected] = [found, expected].map(|x| g.constant_value(x));
                let difference = found.zip(expected).map(|(found, expected)| (found - expected).abs());
                assert!(
                    difference.is_some_and(|difference| difference < 1e-15),
                    "a vector's derivative by a node is {found:?}, not {expected:?}"
                );
            }
        }
    }
}

/// ν·∂_1 y, ν·∂_2 y, ½ (ν·ν − 1)
fn normal_equations(g: &mut Graph, nu: [ExprId; 3], tangents: &[[ExprId; 3]]) -> Vec<ExprId> {
    let mut equations: Vec<ExprId> = tangents.iter().map(|tangent| g.dot(&nu, tangent)).collect();
    let (square, one, half) = (g.dot(&nu, &nu), g.one(), g.constant(0.5));
    let excess = g.sub(square, one);
    equations.push(g.mul(half, excess));
    equations
}

/// det J over the determinant of the metric, which it is on a flat facet: Π (1 − g κ), 0 on a centre of curvature.
fn curvature_figure(g: &mut Graph, jacobian: &[Vec<ExprId>], vectors: &[[ExprId; 3]]) -> ExprId {
    let metric: Vec<Vec<ExprId>> =
        (1..3).map(|k| (1..3).map(|l| g.dot(&vectors[k.max(l)], &vectors[k.min(l)])).collect()).collect();
    let (determinant, flat) = (g.determinant(jacobian), g.determinant(&metric));
    if determinant == flat { g.one() } else { g.div(determinant, flat) }
}

fn jacobian_at(
    g: &mut Graph,
    equations: &[ExprId],
    unknowns: &[SymbolId],
    at: &[(SymbolId, ExprId)],
) -> Vec<Vec<ExprId>> {
    equations
        .iter()
        .map(|&equation| {
            unknowns
                .iter()
                .map(|&unknown| {
                    let derivative = g.derivative(equation, unknown);
                    g.substitute(derivative, at)
                })
                .collect()
        })
        .collect()
}

fn named_inverse(g: &mut Graph, matrix: &[Vec<ExprId>], name: &str) -> Vec<Vec<ExprId>> {
    let inverse = g.inverse_small(matrix);
    for (i, row) in inverse.iter().enumerate() {
        for (j, &entry) in row.iter().enumerate() {
            g.name(entry, &format!("{name}_{}_{}", i + 1, j + 1));
        }
    }
    inverse
}

/// x/‖x‖, and 0 for x = 0.
fn unit(g: &mut Graph, x: [ExprId; 3]) -> [ExprId; 3] {
    let square = g.dot(&x, &x);
    let (length, one) = (g.sqrt(square), g.one());
    let reciprocal = g.div_or_zero(one, length);
    x.map(|x| g.mul(x, reciprocal))
}

/// Largest absolute value: no square that could overflow.
fn largest_entry(g: &mut Graph, entries: &[ExprId]) -> ExprId {
    let zero = g.zero();
    let sizes: Vec<ExprId> = entries
        .iter()
        .map(|&x| {
            let minus = g.neg(x);
            let size = g.select_less(x, zero, minus, x);
            g.name(size, "absolute")
        })
        .collect();
    sizes[1..].iter().fold(sizes[0], |largest, &size| {
        let larger = g.select_less(largest, size, size, largest);
        g.name(larger, "largest")
    })
}

fn symbols(g: &Graph, exprs: &[ExprId]) -> Vec<SymbolId> {
    exprs.iter().map(|&x| g.symbol_of(x)).collect()
}
