//! The formulas of elements of a fixed size: laws, and forces on facets.

use diffuse_contact_codegen::expr::{Expr, Mat3, Vec2, Vec3, Vector, dot, total};
use diffuse_contact_codegen::{Config, ConfigError, ElementModel};

/// The configuration with all of them.
pub fn all(config: Config) -> Result<Config, ConfigError> {
    config
        .element("coulomb", coulomb)?
        .element("traction", traction)?
        .element("coulomb_sliding", coulomb_sliding)?
        .element("traction_sliding", traction_sliding)?
        .element("decaying_coefficient", decaying_coefficient)?
        .element("interpolated", interpolated)?
        .element("isochoric_neo_hooke", isochoric_neo_hooke)?
        .element("volumetric_neo_hooke", volumetric_neo_hooke)?
        .element("volumetric_hencky", volumetric_hencky)?
        .element("direction", direction)?
        .element("load_of_point", load_of_point)?
        .element("friction_over_pressure", friction_over_pressure)?
        .element("foot_of_gap", foot_of_gap)?
        .element("slip_over_triangle", slip_over_triangle)?
        .element("slip_over_quadrilateral", slip_over_quadrilateral)?
        .element("carried_by_triangle", carried_by_triangle)?
        .element("carried_by_quadrilateral", carried_by_quadrilateral)?
        .element("carried_by_triangle6", carried_by_triangle6)?
        .element("carried_by_quadrilateral8", carried_by_quadrilateral8)?
        .element("carried_by_quadrilateral9", carried_by_quadrilateral9)
}

/// The factor c of a contact that slides at a coefficient of pressure and slip rate.
pub fn coulomb_sliding(m: &ElementModel<'_>) {
    m.title(
        "Coulomb's friction that slides at a coefficient of its own: the factor c of R = −c ∇q (docs/equations.md, section 17).",
    );
    let [q, pressure]: [Expr<'_>; 2] = ["half_square", "pressure"].map(|name| m.variable(name));
    let factor = sliding_factor(m, q, pressure);
    m.residual("factor", factor);
}

/// The traction of a node of the faces that slides at such a coefficient.
pub fn traction_sliding(m: &ElementModel<'_>) {
    m.title("Traction −c P_n d over faces that slides at a coefficient of its own (docs/equations.md, section 18).");
    let [way, normal]: [Vec3<'_>; 2] = ["way", "normal"].map(|name| m.variable(name));
    let pressure = m.variable("pressure");
    let slip = m.define("slip", way - (way.dot(normal) / normal.dot(normal)) * normal);
    let factor = sliding_factor(m, 0.5 * slip.dot(slip), pressure);
    m.value("factor", factor);
    m.residual("traction", -(factor * slip));
}

/// The factor c at a coefficient that is known with its derivatives at the pressure and the slip rate of the contact. The rate
/// depends on the traction, which is the root of a linear equation.
fn sliding_factor<'g>(m: &ElementModel<'g>, q: Expr<'g>, pressure: Expr<'g>) -> Expr<'g> {
    let [mu, by_pressure, by_rate] =
        m.parameters(["coefficient", "coefficient_by_pressure", "coefficient_by_rate"]);
    let [at_pressure, at_rate] = m.parameters(["at_pressure", "at_rate"]);
    let [stiffness, opening, duration] = m.parameters(["stiffness", "opening", "duration"]);
    let slip = (2.0 * q).sqrt();
    let share = share_in_touch(m, pressure, opening);
    // t = μ p with the rate (w s − t/ε_T)/(w Δt): the contact has been in touch for w Δt.
    let rate_if_free = slip / duration;
    let held = mu + by_pressure * (pressure - at_pressure) + by_rate * (rate_if_free - at_rate);
    let strength = pressure * held / (1.0 + pressure * by_rate / (stiffness * (share * duration)));
    strength / slip
}

/// The part w of the slip since the place of touch: all of it, to the last bit, of a contact that was closed.
fn share_in_touch<'g>(m: &ElementModel<'g>, pressure: Expr<'g>, opening: Expr<'g>) -> Expr<'g> {
    let (zero, one) = (m.sheet().zero(), m.sheet().one());
    zero.less(opening).select(pressure / (pressure + opening), one)
}

/// A coefficient of friction that decays with the slip rate.
pub fn decaying_coefficient(m: &ElementModel<'_>) {
    m.title("A coefficient of friction that decays exponentially from rest to fast sliding.");
    let rate: Expr<'_> = m.variable("rate");
    let [at_rest, in_motion, decay] = m.parameters(["at_rest", "in_motion", "decay"]);
    m.residual("coefficient", in_motion + (at_rest - in_motion) * (-(decay * rate)).exp());
}

/// A cell of a table of two numbers.
pub fn interpolated(m: &ElementModel<'_>) {
    m.title("Bilinear interpolation in a cell of a table.");
    let [x, y]: [Expr<'_>; 2] = ["x", "y"].map(|name| m.variable(name));
    let [x_0, x_1, y_0, y_1] = m.parameters(["first_x", "last_x", "first_y", "last_y"]);
    let corners: [Expr<'_>; 4] = m.parameters(["value_00", "value_10", "value_11", "value_01"]);
    let place = Vector([(x - x_0) / (x_1 - x_0), (y - y_0) / (y_1 - y_0)]);
    m.residual("value", dot(corners, bilinear(place)));
}

/// The factor c of Coulomb's friction, R = −c ∇q.
pub fn coulomb(m: &ElementModel<'_>) {
    m.title("Coulomb's friction with a penalty for stick: the factor c of R = −c ∇q (docs/equations.md, section 17).");
    let [q, pressure]: [Expr<'_>; 2] = ["half_square", "pressure"].map(|name| m.variable(name));
    let factor = friction_factor(m, q, pressure);
    m.residual("factor", factor);
}

/// The traction −c P_n d of Coulomb's friction, for a way d and a normal n of any length.
pub fn traction(m: &ElementModel<'_>) {
    m.title("Traction −c P_n d of Coulomb's friction over faces (docs/equations.md, section 18).");
    let [way, normal]: [Vec3<'_>; 2] = ["way", "normal"].map(|name| m.variable(name));
    let pressure = m.variable("pressure");
    let slip = m.define("slip", way - (way.dot(normal) / normal.dot(normal)) * normal);
    let factor = friction_factor(m, 0.5 * slip.dot(slip), pressure);
    m.value("slip", slip);
    m.value("factor", factor);
    m.residual("traction", -(factor * slip));
    m.describe("way", "From the anchor to the slave's point, length");
    m.describe("normal", "Normal of the master, of any length");
    m.describe("slip", "P_n d, length");
    m.describe("traction", "Friction on the slave, force per area");
}

/// The factor c of a half square of the slip and a pressure, with the parameters of the law.
fn friction_factor<'g>(m: &ElementModel<'g>, q: Expr<'g>, pressure: Expr<'g>) -> Expr<'g> {
    let [mu, stiffness, opening, largest] =
        m.parameters(["coefficient", "stiffness", "opening", "shear_limit"]);
    let slip = (2.0 * q).sqrt();
    let (zero, one) = (m.sheet().zero(), m.sheet().one());
    let share = share_in_touch(m, pressure, opening);
    let (strength, stuck) = (mu * pressure, share * stiffness);
    let limit = strength.less(largest).select(strength, largest);
    let slides = limit.less(stuck * slip);
    m.value("share", share);
    m.value("slides", slides.select(one, zero));
    slides.select(limit / slip, stuck)
}

/// Isochoric neo-Hooke elasticity in the principal axes of a stretch. A strain E on top of it makes C = Fᵀ (1 + 2 E) F: Kirchhoff's stress
/// and the spatial tangent are the energy's derivatives by E at E = 0.
pub fn isochoric_neo_hooke(m: &ElementModel<'_>) {
    m.title("Isochoric neo-Hooke elasticity, W = μ/2 (tr C / (det C)^(1/3) − 3), in the principal axes of a stretch.");
    let squares: Vec3<'_> = m.parameter("squares");
    let shear_modulus: Expr<'_> = m.parameter("shear_modulus");
    let along: Vec3<'_> = m.sheet().variables(["e_11", "e_22", "e_33"]);
    let across: Vec3<'_> = m.sheet().variables(["g_23", "g_31", "g_12"]);
    let added = Mat3::from_fn(|i, j| if i == j { 1.0 + 2.0 * along[i] } else { across[3 - i - j] });
    let trace = total((0..3).map(|k| squares[k] * added[k][k]));
    // Of each factor by itself: their product may overflow.
    let volume = (0..3).fold(added.determinant().cbrt(), |volume, k| volume * squares[k].cbrt());
    let energy = 0.5 * shear_modulus * (trace / volume - 3.0);
    let at_rest: Vec<_> =
        along.0.into_iter().chain(across.0).map(|strain| (strain, m.sheet().zero())).collect();
    let stress = energy.gradient(along);
    m.value("energy", energy.at(&at_rest));
    m.value("stress", stress.at(&at_rest));
    m.value("normal", stress.jacobian(along).map(|x| x.at(&at_rest)));
    m.value("shear", across.map(|strain| energy.by(strain).by(strain).at(&at_rest)));
    m.describe("squares", "λ², squares of the principal stretches");
    m.describe("shear_modulus", "μ, force per area");
    m.describe("stress", "Principal values of Kirchhoff's stress");
    m.describe("normal", "Components AABB of the spatial tangent");
    m.describe("shear", "Components ABAB, of the axes A, B ≠ k");
}

/// The volumetric energy of a neo-Hooke material.
pub fn volumetric_neo_hooke(m: &ElementModel<'_>) {
    m.title("Volumetric energy U = κ/2 (θ − 1)² of a neo-Hooke material.");
    let ratio: Expr<'_> = m.variable("volume_ratio");
    let bulk_modulus: Expr<'_> = m.parameter("bulk_modulus");
    m.energy(0.5 * bulk_modulus * (ratio - 1.0).powi(2));
}

/// The volumetric energy of Hencky's material.
pub fn volumetric_hencky(m: &ElementModel<'_>) {
    m.title("Volumetric energy U = κ/2 (ln θ)² of Hencky's material.");
    let ratio: Expr<'_> = m.variable("volume_ratio");
    let bulk_modulus: Expr<'_> = m.parameter("bulk_modulus");
    m.energy(0.5 * bulk_modulus * ratio.ln().powi(2));
}

/// The unit vector along another one.
pub fn direction(m: &ElementModel<'_>) {
    m.title("The unit vector along another one.");
    let along: Vec3<'_> = m.variable("along");
    m.residual("direction", along.unit());
}

/// The force of a point of the faces that has a pressure of its own.
pub fn load_of_point(m: &ElementModel<'_>) {
    m.title("Force d + P_d τ of a point at unit pressure, with friction (docs/equations.md, section 18).");
    let [along, ratio]: [Vec3<'_>; 2] = ["along", "ratio"].map(|name| m.variable(name));
    let direction = m.define("direction", along.unit());
    m.residual("load", direction + ratio - direction.dot(ratio) * direction);
    m.describe("along", "∂g/∂x of the point, of any length");
    m.describe("ratio", "τ, friction over the pressure");
}

/// What a point of the faces has of a node's friction at unit pressure.
pub fn friction_over_pressure(m: &ElementModel<'_>) {
    m.title("Friction over the pressure, τ = t/p (docs/equations.md, section 18).");
    let traction: Vec3<'_> = m.variable("traction");
    let pressure: Expr<'_> = m.variable("pressure");
    m.residual("ratio", traction / pressure);
}

/// The foot of a gap.
pub fn foot_of_gap(m: &ElementModel<'_>) {
    m.title("The foot x^d = x^c − g ν of a gap (Chamoret et al. 2008, eq. 19).");
    let slave: Vec3<'_> = m.variable("slave");
    let gap: Expr<'_> = m.variable("gap");
    let normal: Vec3<'_> = m.variable("normal");
    m.residual("foot", slave - gap * normal);
}

/// Half the square of the slip over a triangle.
pub fn slip_over_triangle(m: &ElementModel<'_>) {
    slip(m, |_, _, [a, b, c]: [Vec3<'_>; 3]| (b - a).cross(c - a));
}

/// The same over a bilinear quadrilateral, at the foot that its gap has: the same minimum by the same way.
pub fn slip_over_quadrilateral<'g>(m: &ElementModel<'g>) {
    slip(m, |m, slave, corners: [Vec3<'g>; 4]| {
        let [a, b, c, d] = corners.map(|corner| corner - slave);
        // y(u) = v_0 + s v_1 + t v_2 + s t v_3 about the centre, with edges of length 1. Callers divide lengths by the facet's size.
        let [position, first, second, twist] =
            [0.25 * (a + b + c + d), 0.5 * (b + c - a - d), 0.5 * (c + d - a - b), (a + c) - (b + d)];
        let position = m.define("position", position);
        let [first, second] = [m.define("first", first), m.define("second", second)];
        let twist = m.define("twist", twist);
        let foot = m.minimum("foot", |Vector([s, t])| {
            let y = position + s * first + t * second + (s * t) * twist;
            0.5 * y.dot(y)
        });
        m.value("residual", foot.residual);
        m.describe("residual", "Of the foot's equations");
        m.value("iterations", foot.iterations);
        m.describe("iterations", "Evaluations of the foot's equations");
        let Vector([s, t]) = foot.unknowns;
        (first + t * twist).cross(second + s * twist)
    });
}

/// q = ½ |ν × d|² for the unit normal of a facet at the foot of the slave, and the way d from the anchor (docs/equations.md, section 17).
fn slip<'g, const N: usize>(
    m: &ElementModel<'g>,
    normal: impl FnOnce(&ElementModel<'g>, Vec3<'g>, [Vec3<'g>; N]) -> Vec3<'g>,
) {
    m.title("Half the square of the slip from an anchor over a facet (docs/equations.md, section 17).");
    let slave: Vec3<'_> = m.variable("slave");
    let corners = m.variable("corners");
    let anchor: Vec3<'_> = m.variable("anchor");
    let way = m.define("way", slave - anchor);
    let normal = m.define("normal", normal(m, slave, corners).unit());
    let across = normal.cross(way);
    m.energy(0.5 * across.dot(across));
    m.describe("slave", "Slave node, length");
    m.describe("corners", "Corners of the facet, length");
    m.describe("anchor", "Where the slave stuck, length");
    m.describe("energy", "q, half the square of the slip, length²");
}

/// A force carried by a triangle.
pub fn carried_by_triangle(m: &ElementModel<'_>) {
    carried(m, |m, [a, b, c]: [Vec3<'_>; 3], point, force| {
        let [first, second] = across(b - a, c - a, force);
        let [xi, eta] = [first, second].map(|across| across.dot(point - a));
        m.value("natural", Vector([xi, eta]));
        [1.0 - xi - eta, xi, eta]
    });
}

/// A force carried by a bilinear quadrilateral.
pub fn carried_by_quadrilateral<'g>(m: &ElementModel<'g>) {
    carried(m, |m, corners: [Vec3<'g>; 4], point, force| {
        let [a, b, c, d] = corners;
        let [first, second] = across(0.5 * (b + c - a - d), 0.5 * (c + d - a - b), force);
        // From 0 at the first corner to 1: a place in the middle is no root to begin with, but for rounding.
        let u = m.sheet().variables(["s", "t"]);
        let beside = |u: Vec2<'g>| {
            let x = point - combined(&corners, &bilinear(u));
            Vector([first.dot(x), second.dot(x)])
        };
        let (_, place) = m.sheet().root("place", u, beside(u));
        m.value("natural", place.map(|s| 2.0 * s - 1.0));
        m.value("beside", beside(place));
        m.describe(
            "beside",
            "How far the place is from the line, in natural coordinates: rounding, if there is one",
        );
        bilinear(place)
    });
}

/// A force carried by a quadratic triangle: corners, then the middles of its edges.
pub fn carried_by_triangle6(m: &ElementModel<'_>) {
    carried(m, |m, nodes: [Vec3<'_>; 6], point, force| {
        let [a, b, c, ..] = nodes;
        on_curved(m, nodes, [b - a, c - a], triangle6, point, force)
    });
}

/// A force carried by a quadrilateral with the middles of its edges.
pub fn carried_by_quadrilateral8(m: &ElementModel<'_>) {
    carried(m, |m, nodes: [Vec3<'_>; 8], point, force| {
        let [a, b, c, d, ..] = nodes;
        on_curved(m, nodes, [0.25 * (b + c - a - d), 0.25 * (c + d - a - b)], quadrilateral8, point, force)
    });
}

/// The same with its centre.
pub fn carried_by_quadrilateral9(m: &ElementModel<'_>) {
    carried(m, |m, nodes: [Vec3<'_>; 9], point, force| {
        let [a, b, c, d, ..] = nodes;
        on_curved(m, nodes, [0.25 * (b + c - a - d), 0.25 * (c + d - a - b)], quadrilateral9, point, force)
    });
}

/// The shape functions where a line meets a curved facet; `edges`: about its tangents by the natural coordinates.
fn on_curved<'g, const N: usize>(
    m: &ElementModel<'g>,
    nodes: [Vec3<'g>; N],
    edges: [Vec3<'g>; 2],
    functions: impl Fn(Vec2<'g>) -> [Expr<'g>; N],
    point: Vec3<'g>,
    direction: Vec3<'g>,
) -> [Expr<'g>; N] {
    let start = Vector(m.parameters(["start_xi", "start_eta"]));
    let [first, second] = across(edges[0], edges[1], direction);
    let step = m.sheet().variables(["s", "t"]);
    let beside = |step: Vec2<'g>| {
        let x = point - combined(&nodes, &functions(start + step));
        Vector([first.dot(x), second.dot(x)])
    };
    let (_, step) = m.sheet().root("place", step, beside(step));
    m.value("natural", start + step);
    m.value("beside", beside(step));
    m.describe(
        "beside",
        "How far the place is from the line, in natural coordinates: rounding, if there is one",
    );
    functions(start + step)
}

/// A force through `point`: the parts of it that a facet's nodes carry are its shape functions where the line of the force meets it
/// (docs/equations.md, section 18).
fn carried<'g, const N: usize>(
    m: &ElementModel<'g>,
    shape_functions: impl FnOnce(&ElementModel<'g>, [Vec3<'g>; N], Vec3<'g>, Vec3<'g>) -> [Expr<'g>; N],
) {
    m.title("A force along its line, carried by the nodes of a facet that the line meets (docs/equations.md, section 18).");
    let [point, force]: [Vec3<'_>; 2] = ["point", "force"].map(|name| m.variable(name));
    let corners = m.variable("corners");
    let parts = shape_functions(m, corners, point, force);
    m.residual("parts", parts.map(|part| part * force));
    m.describe("point", "A point of the line, length");
    m.describe("force", "The force: the line's direction");
    m.describe("parts", "What each node of the facet carries of it");
}

/// The shape functions of a quadrilateral, of coordinates from 0 at the first corner to 1.
fn bilinear(u: Vec2<'_>) -> [Expr<'_>; 4] {
    let Vector([s, t]) = u;
    [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t]
}

/// The shape functions of a quadratic triangle, of two area coordinates.
fn triangle6<'g>(u: Vec2<'g>) -> [Expr<'g>; 6] {
    let Vector([s, t]) = u;
    let r = 1.0 - s - t;
    let corner = |x: Expr<'g>| x * (2.0 * x - 1.0);
    [corner(r), corner(s), corner(t), 4.0 * r * s, 4.0 * s * t, 4.0 * t * r]
}

/// Those of a quadrilateral with the middles of its edges, of coordinates from −1 to 1.
fn quadrilateral8(u: Vec2<'_>) -> [Expr<'_>; 8] {
    let Vector([s, t]) = u;
    let corner = |a: f64, b: f64| 0.25 * (1.0 + a * s) * (1.0 + b * t) * (a * s + b * t - 1.0);
    let along_s = |b: f64| 0.5 * (1.0 - s * s) * (1.0 + b * t);
    let along_t = |a: f64| 0.5 * (1.0 - t * t) * (1.0 + a * s);
    [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
        along_s(-1.0),
        along_t(1.0),
        along_s(1.0),
        along_t(-1.0),
    ]
}

/// Those of a quadrilateral with its centre, too.
fn quadrilateral9<'g>(u: Vec2<'g>) -> [Expr<'g>; 9] {
    let of = |x: Expr<'g>| [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)];
    let [s, t] = u.0.map(of);
    let places = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]];
    places.map(|[i, j]| s[i] * t[j])
}

/// Two vectors across a direction of any length that are dual to two edges.
fn across<'g>(first: Vec3<'g>, second: Vec3<'g>, direction: Vec3<'g>) -> [Vec3<'g>; 2] {
    let volume = direction.dot(first.cross(second));
    [(1.0 / volume) * second.cross(direction), (1.0 / volume) * direction.cross(first)]
}

/// Σ N_k x_k
fn combined<'g>(points: &[Vec3<'g>], weights: &[Expr<'g>]) -> Vec3<'g> {
    Vector::from_fn(|axis| dot(points.iter().map(|x| x[axis]), weights))
}
