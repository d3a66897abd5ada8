//! Contact on the facets themselves, as formulas: the distance of the slave from a triangle or a quadrilateral.
//!
//! The facet's point relative to the slave is y(u) = Σ N_k(u) x_k − x^c. Equations are made dimensionless with a size of the facet,
//! which is held. The foot is found by an iteration and held too; about it y(u + δ) = Σ V_m φ_m(δ), with vectors V that are linear in the
//! nodes. The gap −ν·y(δ) is stationary in δ and ν at δ = 0 and the normal there.

use crate::expr::{Expr, Mat2, Matrix, Vec2, Vec3, Vector, dot};
use crate::kernel::ElementModel;

/// Names of the vectors that y is made of.
const VECTORS: [&str; 4] = ["position", "tangent_1", "tangent_2", "twist"];

/// Shape of a facet with corner nodes only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FacetShape {
    /// Three corners, linear.
    Triangle,
    /// Four corners, bilinear.
    Quadrilateral,
}

/// The foot and how it was found.
struct Foot<'g> {
    u: Vec2<'g>,
    residual: Expr<'g>,
    evaluations: Expr<'g>,
}

impl FacetShape {
    /// All shapes.
    pub const ALL: [Self; 2] = [Self::Triangle, Self::Quadrilateral];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Triangle => "triangle",
            Self::Quadrilateral => "quadrilateral",
        }
    }

    /// Name of the element that is the gap over it.
    pub const fn gap_name(self) -> &'static str {
        match self {
            Self::Triangle => "gap_over_triangle",
            Self::Quadrilateral => "gap_over_quadrilateral",
        }
    }

    /// Number of corners n.
    pub const fn corners(self) -> usize {
        match self {
            Self::Triangle => 3,
            Self::Quadrilateral => 4,
        }
    }

    /// The formulas of the gap over it, of the element [`gap_name`](Self::gap_name).
    pub fn gap(self, m: &ElementModel<'_>) {
        match self {
            Self::Triangle => self.gap_over::<3>(m),
            Self::Quadrilateral => self.gap_over::<4>(m),
        }
    }

    fn gap_over<'g, const CORNERS: usize>(self, m: &ElementModel<'g>) {
        m.title(&format!("Distance of the slave from a {} (docs/equations.md, section 16).", self.name()));
        let slave: Vec3<'g> = m.variable("slave");
        let corners: [Vec3<'g>; CORNERS] = m.variable("corners");
        m.describe("slave", "Slave node x^c.");
        m.describe("corners", "Corners x^1 … x^n, counter-clockwise seen from the outward side.");

        let about_centre = self.about_centre(slave, &corners);
        let size = m.held("size", largest_entry(about_centre[1], about_centre[2]));
        let inverse_size = m.held("inverse_size", size.reciprocal_or_zero());
        let scaled: Vec<Vec3<'g>> = about_centre.iter().map(|&v| inverse_size * v).collect();
        let foot = self.foot(m, &scaled);

        // y(u + δ) = Σ V_m φ_m(δ)
        let vectors: Vec<Vec3<'g>> = self
            .about(foot.u, &about_centre, m)
            .into_iter()
            .zip(VECTORS)
            .map(|(v, name)| m.define(name, v))
            .collect();
        let scaled_at_foot: Vec<Vec3<'g>> = vectors.iter().map(|&v| inverse_size * v).collect();
        let zero = Vector::zero(m.sheet());
        let delta = m.stationary_at("delta", zero, |delta| self.foot_equations(&scaled_at_foot, delta));
        let normal = scaled_at_foot[1].cross(scaled_at_foot[2]).unit();
        let nu = m.stationary_at("nu", normal, |nu| {
            let [y_1, y_2] = self.tangents(&scaled_at_foot, delta);
            Vector([nu.dot(y_1), nu.dot(y_2), 0.5 * (nu.dot(nu) - 1.0)])
        });
        m.function("gap", -nu.dot(self.point(&vectors, delta)));
        m.describe("gap", "Signed gap g = −ν·y, length, positive apart.");

        m.value("foot", slave + vectors[0]);
        m.value("normal", normal);
        m.value("natural", self.natural(foot.u));
        let areas = self.area_coefficients(m, &scaled);
        let area = |u: Vec2<'g>| dot(&areas, self.monomials(u));
        let corner_areas = self.parametric_corners().iter().map(|&u| area(Vector::numbers(m.sheet(), u)));
        m.value("corner_area", corner_areas.reduce(|smallest, area| area.min(smallest)).expect("corners"));
        m.value("foot_area", area(foot.u));
        m.value("foot_residual", foot.residual);
        m.value("foot_iterations", foot.evaluations);
        m.value("jacobian_determinant", self.curvature_figure(m, &scaled_at_foot));
        m.describe("foot", "Foot point, global axes, length.");
        m.describe("normal", "Unit normal ν at the foot, outward, global axes.");
        m.describe(
            "natural",
            "Natural coordinates (ξ, η) of the foot: area coordinates of the second and third corner of a triangle, −1 … 1 on a quadrilateral.",
        );
        m.describe(
            "corner_area",
            "Smallest area element at a corner, along the normal at the centre, over the mean square of the tangents there: 1 for a square, 0 or less for a facet that has no area, is folded or not convex.",
        );
        m.describe("foot_area", "The same at the foot.");
        m.describe(
            "foot_residual",
            "Largest foot residual, relative to the starting residual or the foot's distance from the centre; 0 where the equations are linear.",
        );
        m.describe("foot_iterations", "Evaluations of the foot equations.");
        m.describe(
            "jacobian_determinant",
            "Π (1 − g κ) over the principal curvatures κ at the foot: 1 on a flat facet, 0 on a centre of curvature.",
        );
    }

    /// Monomials φ = 1, u_1, u_2 and, for the quadrilateral, u_1 u_2: the shape functions' span, which contains their derivatives.
    fn monomials(self, u: Vec2<'_>) -> Vec<Expr<'_>> {
        let mut monomials = vec![u[0].sheet().one(), u[0], u[1], u[0] * u[1]];
        monomials.truncate(self.corners());
        monomials
    }

    /// Coefficients of a function in the span of the monomials when these have their origin at `at`: its derivatives there.
    fn taylor_coefficients<'g>(self, f: Expr<'g>, u: Vec2<'g>, at: Vec2<'g>) -> Vec<Expr<'g>> {
        let mut derivatives = vec![f, f.by(u[0]), f.by(u[1]), f.by(u[0]).by(u[1])];
        derivatives.truncate(self.corners());
        derivatives.into_iter().map(|f| f.at(&u.set_to(at))).collect()
    }

    /// Parametric coordinates of the corners, with the centre at 0 and edges of length 1.
    fn parametric_corners(self) -> &'static [[f64; 2]] {
        const THIRD: f64 = 1.0 / 3.0;
        match self {
            Self::Triangle => &[[-THIRD, -THIRD], [2.0 * THIRD, -THIRD], [-THIRD, 2.0 * THIRD]],
            Self::Quadrilateral => &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        }
    }

    /// N_i(u)
    fn shape_functions(self, u: Vec2<'_>) -> Vec<Expr<'_>> {
        match self {
            Self::Triangle => {
                let third = u[0].sheet().number(1.0 / 3.0);
                vec![third - u[0] - u[1], third + u[0], third + u[1]]
            }
            Self::Quadrilateral => {
                let corners = self.parametric_corners().iter();
                // Of the two factors, each is 1 at the side of the corner, 0 at the other.
                let factor = |corner: &[f64; 2], k: usize| 0.5 + if corner[k] < 0.0 { -u[k] } else { u[k] };
                corners.map(|corner| factor(corner, 0) * factor(corner, 1)).collect()
            }
        }
    }

    /// (ξ, η) as usual.
    fn natural(self, u: Vec2<'_>) -> Vec2<'_> {
        match self {
            Self::Triangle => u.map(|u| u + 1.0 / 3.0),
            Self::Quadrilateral => 2.0 * u,
        }
    }

    /// The vectors of y about the centre: y(u) = (x^1 − x^c) + Σ N_i (x^i − x^1), as Σ N_i = 1. Differences of positions that are close
    /// together come first.
    fn about_centre<'g>(self, slave: Vec3<'g>, corners: &[Vec3<'g>]) -> Vec<Vec3<'g>> {
        let sheet = slave[0].sheet();
        let u = sheet.variables(["u_1", "u_2"]);
        let mut y = (corners[0] - slave).named("from_slave");
        for (k, (&corner, weight)) in corners.iter().zip(self.shape_functions(u)).enumerate().skip(1) {
            y += weight * (corner - corners[0]).named(&format!("edge_{}", k + 1));
        }
        let by_axis = y.0.map(|y| self.taylor_coefficients(y, u, Vector::zero(sheet)));
        (0..self.corners()).map(|m| Vector::from_fn(|axis| by_axis[axis][m])).collect()
    }

    /// The vectors of y about another place.
    fn about<'g>(self, place: Vec2<'g>, vectors: &[Vec3<'g>], m: &ElementModel<'g>) -> Vec<Vec3<'g>> {
        let u = m.sheet().variables(["u_1", "u_2"]);
        let by_axis = self.point(vectors, u).0.map(|y| self.taylor_coefficients(y, u, place));
        (0..self.corners()).map(|m| Vector::from_fn(|axis| by_axis[axis][m])).collect()
    }

    /// Σ v_m φ_m(u)
    fn point<'g>(self, v: &[Vec3<'g>], u: Vec2<'g>) -> Vec3<'g> {
        let phi = self.monomials(u);
        Vector::from_fn(|axis| dot(v.iter().map(|v| v[axis]), &phi))
    }

    /// ∂_1 y, ∂_2 y
    fn tangents<'g>(self, v: &[Vec3<'g>], u: Vec2<'g>) -> [Vec3<'g>; 2] {
        let y = self.point(v, u);
        u.0.map(|u| y.by(u))
    }

    /// r_k = −y·∂_k y
    fn foot_equations<'g>(self, v: &[Vec3<'g>], u: Vec2<'g>) -> Vec2<'g> {
        let y = self.point(v, u);
        u.map(|u| -y.dot(y.by(u)))
    }

    /// Where ½ |y|² is least, from the centre of the facet. Products of the vectors are formed once, so that a slave straight over the
    /// centre has its foot there to the last digit.
    fn foot<'g>(self, m: &ElementModel<'g>, v: &[Vec3<'g>]) -> Foot<'g> {
        let gram = |i: usize, j: usize| v[i].dot(v[j]).named(&format!("gram_{i}_{j}"));
        // ½ |y|², sorted by powers of u.
        let half_square = |u: Vec2<'g>| {
            let [a, b] = u.0;
            let twist =
                gram(2, 1) + gram(3, 0) + gram(3, 1) * a + gram(3, 2) * b + 0.5 * gram(3, 3) * (a * b);
            let along = |k: usize, u: Expr<'g>| gram(k, 0) * u + 0.5 * gram(k, k) * u.powi(2);
            along(1, a) + along(2, b) + twist * (a * b)
        };
        let sheet = m.sheet();
        let (u, residual, evaluations) = match self {
            Self::Triangle => {
                let matrix = Mat2::symmetric(|i, j| gram(1 + i, 1 + j));
                (matrix.solve(-Vector([gram(1, 0), gram(2, 0)])), sheet.zero(), sheet.one())
            }
            Self::Quadrilateral => {
                let foot = m.minimum("descent", half_square);
                (foot.unknowns, foot.residual, foot.iterations)
            }
        };
        Foot { u: m.held("at", u), residual, evaluations }
    }

    /// The area element ∂_1 y × ∂_2 y along its direction at the centre, over the mean square of the tangents there: 1 for a square and
    /// less for any other facet, as coefficients of the monomials.
    fn area_coefficients<'g>(self, m: &ElementModel<'g>, v: &[Vec3<'g>]) -> Vec<Expr<'g>> {
        let u = m.sheet().variables(["u_1", "u_2"]);
        let [y_1, y_2] = self.tangents(v, u);
        let centre = Vector::zero(m.sheet());
        let by_axis = y_1.cross(y_2).0.map(|area| self.taylor_coefficients(area, u, centre));
        let coefficient = |m: usize| Vec3::from_fn(|axis| by_axis[axis][m]);
        let direction = coefficient(0).unit();
        let factor = m.sheet().number(2.0).div_or_zero(v[1].dot(v[1]) + v[2].dot(v[2]));
        let along = |m: usize| (factor * direction.dot(coefficient(m))).named(&format!("area_{m}"));
        (0..v.len()).map(along).collect()
    }

    /// det J of the foot equations at the foot over the determinant of the metric, which it is on a flat facet: Π (1 − g κ), 0 on a
    /// centre of curvature.
    fn curvature_figure<'g>(self, m: &ElementModel<'g>, v: &[Vec3<'g>]) -> Expr<'g> {
        let delta = m.sheet().variables(["delta_1", "delta_2"]);
        let at_foot = delta.set_to(Vector::zero(m.sheet()));
        let jacobian = self.foot_equations(v, delta).jacobian(delta).at(&at_foot);
        let metric: Mat2<'g> = Matrix::from_fn(|k, l| v[1 + k.max(l)].dot(v[1 + k.min(l)]));
        let (determinant, flat) = (jacobian.determinant(), metric.determinant());
        if determinant == flat { m.sheet().one() } else { determinant / flat }
    }
}

/// Largest absolute value: no square that could overflow.
fn largest_entry<'g>(v: Vec3<'g>, w: Vec3<'g>) -> Expr<'g> {
    let sizes: Vec<Expr<'g>> = v.iter().chain(w.iter()).map(|x| x.abs().named("absolute")).collect();
    sizes.into_iter().reduce(|largest, size| largest.max(size).named("largest")).expect("six entries")
}
