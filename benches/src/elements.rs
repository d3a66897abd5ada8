//! The elements all contenders evaluate: patches of a curved surface with noise, turned and moved anywhere.

use std::f64::consts::PI;

use diffuse_contact::{Backend, Basis, Element, ElementError, Frame, Generated, Mode, Point, Weight};

use crate::Random;

/// Support radius over the largest in-plane distance of a master from the slave, as the pairing has it.
const RADIUS_FACTOR: f64 = 1.25;
/// Slopes and curvatures of the surface in its own axes, with the patch's radius as unit of length.
const SIZES: [f64; 5] = [0.2, 0.2, 0.15, 0.1, 0.15];
/// Noise in the masters' heights.
const NOISE: f64 = 0.01;
/// Farthest that slaves are above or below the surface.
const DISTANCE: f64 = 0.1;
/// Farthest that slaves are from the middle of the patch, in each direction.
const INSET: f64 = 0.2;
/// Patches drawn for each element asked for before giving up.
const DRAWS: usize = 20;

/// Why there are no elements.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ElementsError {
    #[error("{nodes} master nodes: the quadratic basis needs at least {}", Basis::Quadratic.size())]
    TooFewNodes { nodes: usize },
    #[error("of {drawn} patches with {nodes} master nodes only {found} have a gap, {wanted} are wanted")]
    TooFewSound { nodes: usize, drawn: usize, found: usize, wanted: usize },
}

/// Elements with the same number of master nodes, all of which have a gap.
#[derive(Clone, Debug)]
pub struct Elements {
    nodes: usize,
    slaves: Vec<Point>,
    masters: Vec<Point>,
    frames: Vec<Frame>,
    radii: Vec<f64>,
}

impl Elements {
    /// `count` elements with `nodes` master nodes each, the same in every run.
    pub fn new(nodes: usize, count: usize) -> Result<Self, ElementsError> {
        if nodes < Basis::Quadratic.size() {
            return Err(ElementsError::TooFewNodes { nodes });
        }
        let mut random = Random::seeded(nodes as u64);
        let mut elements = Self { nodes, slaves: vec![], masters: vec![], frames: vec![], radii: vec![] };
        let drawn = DRAWS * count;
        for _ in 0..drawn {
            if elements.len() == count {
                break;
            }
            let _ = elements.try_push(&mut random);
        }
        if elements.len() < count {
            return Err(ElementsError::TooFewSound { nodes, drawn, found: elements.len(), wanted: count });
        }
        Ok(elements)
    }

    /// Number of elements.
    pub const fn len(&self) -> usize {
        self.slaves.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.slaves.is_empty()
    }

    /// Master nodes of each.
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// Coordinates the gap of one depends on, 3(n+1).
    pub const fn degrees_of_freedom(&self) -> usize {
        3 * (self.nodes + 1)
    }

    /// Element `index` with its frame held.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn held(&self, index: usize) -> Element<'_> {
        let element = self.co_moving(index);
        element.with_frame(element.frame.held())
    }

    /// Element `index` with its frame, the average plane, moving with the masters.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn co_moving(&self, index: usize) -> Element<'_> {
        Element::new(
            self.slaves[index],
            &self.masters[index * self.nodes..][..self.nodes],
            self.frames[index],
            self.radii[index],
        )
    }

    /// Draws a patch and keeps it if it has a gap with either frame.
    fn try_push(&mut self, random: &mut Random) -> Result<(), ElementError> {
        let surface = SIZES.map(|size| size * random.signed());
        let height = |a: f64, b: f64| {
            surface[0] * a + surface[1] * b + surface[2] * a * a + surface[3] * a * b + surface[4] * b * b
        };
        let axes = random.rotation();
        let origin: Point = std::array::from_fn(|_| 10.0 * random.signed());
        let globally = |local: Point| -> Point {
            std::array::from_fn(|k| origin[k] + (0..3).map(|j| axes[j][k] * local[j]).sum::<f64>())
        };
        let masters: Vec<Point> = spread(self.nodes, random)
            .into_iter()
            .map(|[a, b]| globally([a, b, height(a, b) + NOISE * random.signed()]))
            .collect();
        let [a, b] = [INSET * random.signed(), INSET * random.signed()];
        let slave = globally([a, b, height(a, b) + DISTANCE * random.signed()]);
        let frame = Frame::average_plane(&masters, axes[2])?;
        let square = |x: &Point| {
            let along = |t: Point| (0..3).map(|k| t[k] * (x[k] - slave[k])).sum::<f64>();
            along(frame.t1).powi(2) + along(frame.t2).powi(2)
        };
        let support_radius = RADIUS_FACTOR * masters.iter().map(square).fold(0.0, f64::max).sqrt();
        let (basis, weight) = (Basis::Quadratic, Weight::Cubic);
        let element =
            Element::new(slave, &masters, frame, support_radius).with_basis(basis).with_weight(weight);
        // By the backend that uses no vectors, so that the elements are the same on every machine.
        Generated.gap(&element, Mode::Value)?;
        Generated.gap(&element.with_frame(frame.held()), Mode::Value)?;
        self.slaves.push(slave);
        self.masters.extend_from_slice(&masters);
        self.frames.push(frame);
        self.radii.push(support_radius);
        Ok(())
    }
}

/// `n` points of the unit disc along a spiral by golden angles, each moved by up to a quarter of their distance.
fn spread(n: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let golden = PI * (3.0 - 5.0f64.sqrt());
    let start = PI * random.signed();
    let step = 0.25 / (n as f64).sqrt();
    (0..n)
        .map(|i| {
            let r = ((i as f64 + 0.5) / n as f64).sqrt();
            let (s, c) = (golden * i as f64 + start).sin_cos();
            [r * c + step * random.signed(), r * s + step * random.signed()]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_different_and_the_same_in_every_run() {
        let elements = Elements::new(9, 20).unwrap();
        assert_eq!((elements.len(), elements.nodes(), elements.degrees_of_freedom()), (20, 9, 30));
        let again = Elements::new(9, 20).unwrap();
        for i in 0..20 {
            assert_eq!(elements.held(i).masters, again.held(i).masters);
            for j in 0..i {
                assert_ne!(elements.held(i).slave, elements.held(j).slave);
            }
        }
    }

    #[test]
    fn too_few_nodes_are_refused() {
        assert_eq!(Elements::new(5, 1).unwrap_err(), ElementsError::TooFewNodes { nodes: 5 });
    }
}
