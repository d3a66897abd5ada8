//! The kernels of contact on facets, compared on random triangles and quadrilaterals.
//!
//! A facet is made like this, all numbers uniform: size 10^s, s in [−3, 3); corners moved by up to 0.15 sizes from those of
//! a square or of a triangle of that size, the corners of a quadrilateral off its plane too; then rotated and put
//! anywhere in a cube of half width 5 sizes. The slave is within 0.3 sizes of a point on the facet, along its normal
//! there. So it is far from a centre of curvature, and has one foot.

use diffuse_contact::ad::Ad;
use diffuse_contact::{ElementError, FacetElement, FacetPoint, Gap, Generated, Mode, Point};
use diffuse_contact_benches::Random;
use diffuse_contact_codegen::FacetShape;
use nalgebra::Vector3;
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::blocks::{Part, worse};
use super::plan::{Against, MODES, TOLERANCE};
use crate::interpreted_facets::InterpretedFacets;

/// Facets of each shape.
pub const FACETS: usize = 64;
/// Blocks of the results of a facet, in the order of the report.
pub const FACET_BLOCKS: [&str; 6] = ["g", "foot", "ν", "(ξ, η)", "N", "M"];

/// Largest move of a corner over the size.
const MOVE: f64 = 0.15;
/// Largest distance of the slave over the size.
const DISTANCE: f64 = 0.3;
/// Half width of the cube of the facets over the size.
const CUBE: f64 = 5.0;

/// The worst differences of one block; nothing where nothing was compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetRow {
    /// Shape of the facets.
    pub shape: FacetShape,
    /// The block's symbol.
    pub name: &'static str,
    /// In the order of [`Against::ALL`].
    pub worst: [Option<f64>; Against::ALL.len()],
}

impl FacetRow {
    /// Whether there are differences, and all are within [`TOLERANCE`].
    pub fn passes(&self) -> bool {
        let mut all = self.worst.iter().flatten();
        self.worst[Against::Ad as usize].is_some() && all.all(|&difference| difference <= TOLERANCE)
    }

    fn add(&mut self, against: Against, difference: f64) {
        let worst = &mut self.worst[against as usize];
        *worst = Some(worst.map_or(difference, |before| worse(before, difference)));
    }
}

/// Compares the kernels of all shapes; failures are backends without a result.
pub(super) fn compare_facets(seed: u64) -> (Vec<FacetRow>, Vec<String>) {
    let interpreted = InterpretedFacets::default();
    let (mut rows, mut failures) = (Vec::new(), Vec::new());
    for shape in FacetShape::ALL {
        let first = rows.len();
        let none = [None; Against::ALL.len()];
        rows.extend(FACET_BLOCKS.map(|name| FacetRow { shape, name, worst: none }));
        for index in 0..FACETS {
            let facet = RandomFacet::new(shape, seed, index);
            let mut comparison = Comparison { rows: &mut rows[first..], failures: &mut failures };
            comparison.compare(&facet, &interpreted);
        }
    }
    (rows, failures)
}

struct Comparison<'a> {
    /// Those of the shape.
    rows: &'a mut [FacetRow],
    failures: &'a mut Vec<String>,
}

impl Comparison<'_> {
    fn compare(&mut self, facet: &RandomFacet, interpreted: &InterpretedFacets) {
        let element = facet.element();
        let ad = Ad.facet_gap(&element, Mode::Hessian).and_then(|gap| Ok((gap, Ad.facet_point(&element)?)));
        let ad = self.blocks("AD", "hessian", facet, ad);
        let interpreted = MODES
            .map(|(mode, name)| self.blocks("interpreter", name, facet, interpreted.gap(&element, mode)));
        let generated =
            MODES.map(|(mode, name)| self.blocks("generated", name, facet, generated(&element, mode)));
        for mode in 0..MODES.len() {
            self.add(Against::Ad, generated[mode].as_ref(), ad.as_ref());
            self.add(Against::Interpreter, generated[mode].as_ref(), interpreted[mode].as_ref());
            if mode + 1 < MODES.len() {
                self.add(Against::HessianMode, generated[mode].as_ref(), generated[MODES.len() - 1].as_ref());
            }
        }
    }

    /// The result's blocks in the order of [`FACET_BLOCKS`], or nothing and a failure.
    fn blocks(
        &mut self,
        who: &str,
        mode: &str,
        facet: &RandomFacet,
        result: Result<(Gap, FacetPoint), ElementError>,
    ) -> Option<[Part; FACET_BLOCKS.len()]> {
        match result {
            Ok((gap, point)) => {
                let foot: Point = std::array::from_fn(|k| gap.foot[k] - facet.slave[k]);
                Some([
                    Part::scaled(&[gap.gap], facet.size),
                    Part::scaled(&foot, facet.size),
                    Part::unscaled(&gap.normal),
                    Part::scaled(&point.natural, 1.0),
                    Part::unscaled(&gap.gradient),
                    Part::unscaled(gap.hessian.packed()),
                ])
            }
            Err(reason) => {
                self.failures.push(format!("{who} {} {mode}: {reason}", facet.shape.name()));
                None
            }
        }
    }

    /// Derivatives are compared where both have them.
    fn add(
        &mut self,
        against: Against,
        found: Option<&[Part; FACET_BLOCKS.len()]>,
        expected: Option<&[Part; FACET_BLOCKS.len()]>,
    ) {
        let (Some(found), Some(expected)) = (found, expected) else { return };
        for (row, (found, expected)) in self.rows.iter_mut().zip(found.iter().zip(expected)) {
            if !found.entries.is_empty() {
                row.add(against, found.difference(expected));
            }
        }
    }
}

fn generated(element: &FacetElement<'_>, mode: Mode) -> Result<(Gap, FacetPoint), ElementError> {
    Ok((Generated.facet_gap(element, mode)?, Generated.facet_point(element)?))
}

/// A facet that owns its corners.
struct RandomFacet {
    shape: FacetShape,
    slave: Point,
    corners: Vec<Point>,
    size: f64,
}

impl RandomFacet {
    fn new(shape: FacetShape, seed: u64, index: usize) -> Self {
        let mut random = Random::new(&[seed, shape.corners() as u64, index as u64]);
        let size = 10_f64.powf(random.between(-3.0, 3.0));
        let rotation = random.rotation();
        let centre: Point = std::array::from_fn(|_| size * random.between(-CUBE, CUBE));
        let plane: &[[f64; 2]] = match shape {
            FacetShape::Triangle => &[[-0.5, -0.4], [0.5, -0.4], [0.0, 0.5]],
            FacetShape::Quadrilateral => &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]],
        };
        let local: Vec<Point> = plane
            .iter()
            .map(|[x, y]| {
                let moved: Point = std::array::from_fn(|_| random.between(-MOVE, MOVE));
                [x + moved[0], y + moved[1], moved[2]]
            })
            .collect();
        let on_facet = random_point(&local, &mut random);
        let distance = random.between(-DISTANCE, DISTANCE);
        let over = std::array::from_fn(|k| on_facet.0[k] + distance * on_facet.1[k]);
        let place = |x: Point| {
            let turned = rotation.map(|row| (0..3).map(|k| row[k] * x[k]).sum::<f64>());
            std::array::from_fn(|k| centre[k] + size * turned[k])
        };
        Self { shape, slave: place(over), corners: local.into_iter().map(place).collect(), size }
    }

    fn element(&self) -> FacetElement<'_> {
        FacetElement { slave: self.slave, corners: &self.corners }
    }
}

/// A point on a facet and the unit normal there.
fn random_point(corners: &[Point], random: &mut Random) -> (Point, Point) {
    let [s, t] = [random.between(0.0, 1.0), random.between(0.0, 1.0)];
    let along =
        |x: Point, y: Point, s: f64| -> Point { std::array::from_fn(|k| (1.0 - s) * x[k] + s * y[k]) };
    // A triangle is a quadrilateral whose last two corners coincide.
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    let (bottom, top) = (along(first, corners[1], s), along(last, corners[2], s));
    let (left, right) = (along(first, last, t), along(corners[1], corners[2], t));
    let between = |x: Point, y: Point| Vector3::from(y) - Vector3::from(x);
    let normal = between(left, right).cross(&between(bottom, top)).normalize();
    (along(bottom, top, t), normal.into())
}

impl Serialize for FacetRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("FacetRow", 4)?;
        row.serialize_field("shape", self.shape.name())?;
        row.serialize_field("block", self.name)?;
        row.serialize_field("passes", &self.passes())?;
        let worst: std::collections::BTreeMap<&str, f64> = Against::ALL
            .iter()
            .filter_map(|&against| Some((against.name(), self.worst[against as usize]?)))
            .collect();
        row.serialize_field("against", &worst)?;
        row.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_are_compared_in_every_block() {
        for seed in [1, 2, 3] {
            let (rows, failures) = compare_facets(seed);
            assert!(failures.is_empty(), "{failures:?}");
            assert_eq!(rows.len(), FacetShape::ALL.len() * FACET_BLOCKS.len());
            for row in &rows {
                assert!(row.passes(), "{row:?}");
                let [ad, interpreter, between] = row.worst.map(|worst| worst.is_some());
                // M is there in one mode only.
                assert!(ad && interpreter && between == (row.name != "M"), "{row:?}");
            }
        }
    }

    #[test]
    fn a_difference_fails() {
        let shape = FacetShape::Triangle;
        for difference in [2e-11, f64::INFINITY, f64::NAN] {
            let mut row = FacetRow { shape, name: "N", worst: [Some(0.0), None, None] };
            row.add(Against::Ad, difference);
            row.add(Against::Ad, 1e-15);
            assert!(!row.passes());
        }
    }
}
