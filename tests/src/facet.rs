//! Random facets with a slave whose foot is known.

use diffuse_contact::{FacetElement, Point};
use proptest::prelude::*;

use crate::geometry::{Random, add, cross, length, scale, turn};

/// A facet that owns its corners.
#[derive(Clone, Debug)]
pub struct FacetCase {
    /// Slave node.
    pub slave: Point,
    /// Three or four corners.
    pub corners: Vec<Point>,
    /// Natural coordinates of the foot.
    pub natural: [f64; 2],
    /// Signed distance of the slave from the foot along the normal.
    pub distance: f64,
}

impl FacetCase {
    /// A facet of about unit size in general position, a quadrilateral of four corners up to `warp` off a plane, its slave
    /// within 0.4 above or below a point inside or up to as far outside as the facet is wide.
    #[must_use]
    pub fn random(corners: usize, warp: f64, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let plane: &[[f64; 2]] = match corners {
            3 => &[[-0.5, -0.4], [0.5, -0.4], [0.0, 0.5]],
            _ => &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        };
        let local: Vec<Point> = plane
            .iter()
            .map(|[x, y]| [x + 0.15 * random.signed(), y + 0.15 * random.signed(), warp * random.signed()])
            .collect();
        let natural = match corners {
            3 => [0.4 + 1.2 * random.signed(), 0.4 + 1.2 * random.signed()],
            _ => [1.5 * random.signed(), 1.5 * random.signed()],
        };
        let distance = 0.4 * random.signed();
        let (q, centre) = (random.rotation(), random.vector(2.0));
        let corners = local.into_iter().map(|x| add(turn(&q, x), centre)).collect();
        Self { slave: [0.0; 3], corners, natural, distance }.with_slave()
    }

    /// The slave put where its foot and distance say.
    #[must_use]
    fn with_slave(mut self) -> Self {
        let [_, tangents @ ..] = self.surface(self.natural);
        let area = cross(tangents[0], tangents[1]);
        let normal = scale(1.0 / length(area), area);
        let [foot, ..] = self.surface(self.natural);
        self.slave = add(foot, scale(self.distance, normal));
        self
    }

    /// x(ξ, η), ∂x/∂ξ, ∂x/∂η.
    #[must_use]
    pub fn surface(&self, [xi, eta]: [f64; 2]) -> [Point; 3] {
        let weights: Vec<[f64; 3]> = match self.corners.len() {
            3 => vec![[1.0 - xi - eta, -1.0, -1.0], [xi, 1.0, 0.0], [eta, 0.0, 1.0]],
            _ => [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .into_iter()
                .map(|[a, b]| {
                    let (x, y) = (1.0 + a * xi, 1.0 + b * eta);
                    [x * y / 4.0, a * y / 4.0, b * x / 4.0]
                })
                .collect(),
        };
        [0, 1, 2].map(|k| {
            self.corners.iter().zip(&weights).fold([0.0; 3], |sum, (x, w)| add(sum, scale(w[k], *x)))
        })
    }

    /// What the backends take.
    #[must_use]
    pub fn element(&self) -> FacetElement<'_> {
        FacetElement { slave: self.slave, corners: &self.corners }
    }

    /// Slave and corners.
    #[must_use]
    pub fn nodes(&self) -> Vec<Point> {
        std::iter::once(self.slave).chain(self.corners.iter().copied()).collect()
    }

    /// Every position replaced by `f` of it.
    #[must_use]
    pub fn mapped(&self, f: impl Fn(Point) -> Point) -> Self {
        Self { slave: f(self.slave), corners: self.corners.iter().map(|x| f(*x)).collect(), ..self.clone() }
    }

    /// In another unit of length.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { distance: factor * self.distance, ..self.mapped(|x| scale(factor, x)) }
    }
}

/// Triangles and quadrilaterals by [`FacetCase::random`], flat or warped by up to a fifth of their edges.
pub fn facet_cases() -> impl Strategy<Value = FacetCase> {
    let warped = (3usize..=4, any::<u64>()).prop_map(|(n, seed)| FacetCase::random(n, 0.2, seed));
    let flat = (3usize..=4, any::<u64>()).prop_map(|(n, seed)| FacetCase::random(n, 0.0, seed));
    prop_oneof![3 => warped, 1 => flat]
}
