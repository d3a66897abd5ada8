//! The search for the places of slaves, for many of them side by side, one per lane of the machine's vectors.
//!
//! Lanes take the steps that nearly all slaves need. Where they do not end, [`Lanes::search_thoroughly`] begins again with one lane.

use std::marker::PhantomData;
use std::ops::Range;

use diffuse_contact_kernels::support::{KernelSet, Lane, Vector, WithLanes};

use super::broyden::Searched;
pub use super::equations::Function;
use super::equations::{Fitting, Lanes, OfKernels, VALUES};
use super::{MaterialDomain, MaterialPlace};
use crate::vector::Vector3;
use crate::weight::with_kernels;
use crate::{ElementError, Frame, Point, Weight};

/// What fills up lanes with fewer nodes: a node whose first position is out of every domain.
const NO_NODE: [f64; VALUES] = [0.0, 0.0, 0.0, 1e200, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// A slave whose place is sought.
#[derive(Clone, Debug)]
pub struct Sought {
    pub slave: Point,
    /// Towards its side.
    pub outward: Point,
    /// Its masters.
    pub range: Range<usize>,
}

/// Memory from one search to the next.
#[derive(Clone, Debug, Default)]
pub struct SearchScratch {
    /// Slaves by their number of masters.
    order: Vec<(usize, usize)>,
    numbers: Vec<f64>,
}

/// Masters and their domains.
type Nodes<'a> = (&'a [Point], &'a [MaterialDomain]);

/// The places of slaves over masters with these domains.
pub fn places(
    slaves: &[Sought],
    nodes: Nodes<'_>,
    weight: Weight,
    scratch: &mut SearchScratch,
    found: &mut Vec<Result<MaterialPlace, ElementError>>,
) {
    let SearchScratch { order, numbers } = scratch;
    order.clear();
    order.extend(slaves.iter().enumerate().map(|(k, slave)| (slave.range.len(), k)));
    order.sort_unstable();
    found.clear();
    found.resize(slaves.len(), Err(ElementError::TooFewNodes { found: 0, needed: 3 }));
    let without = order.partition_point(|&(count, _)| count == 0);
    let order = &order[without..];
    with_kernels!(weight, K => {
        let fitting = OfKernels::<K>(PhantomData);
        K::best_isa().run(Search { slaves, order, nodes, numbers, found, fitting: &fitting });
        for &(_, k) in order {
            if found[k].is_err() {
                found[k] = place(&slaves[k], nodes, &fitting, numbers);
            }
        }
    });
}

/// The place of one slave, sought thoroughly. `numbers`: memory.
pub fn place(
    sought: &Sought,
    nodes: Nodes<'_>,
    fitting: &impl Fitting,
    numbers: &mut Vec<f64>,
) -> Result<MaterialPlace, ElementError> {
    if sought.range.is_empty() {
        return Err(ElementError::TooFewNodes { found: 0, needed: 3 });
    }
    let (lanes, nearest) =
        gather::<f64>(std::slice::from_ref(sought), &[(sought.range.len(), 0)], nodes, numbers);
    lanes.search_thoroughly(fitting)?.place(0, sought, nodes, nearest[0])
}

/// How far the place at the origin of the first configuration is off its equations, with a given normal of the average plane.
pub fn deviation(sought: &Sought, nodes: Nodes<'_>, normal: Point, fitting: &impl Fitting) -> f64 {
    let mut numbers = Vec::new();
    let order = [(sought.range.len(), 0)];
    let (lanes, nearest) = gather::<f64>(std::slice::from_ref(sought), &order, nodes, &mut numbers);
    let [x, y, z] = nodes.1[nearest[0]].position;
    lanes.with_normal(&lanes.sums::<false>([-x, -y, -z], fitting), normal).deviation
}

struct Search<'a, F> {
    slaves: &'a [Sought],
    order: &'a [(usize, usize)],
    nodes: Nodes<'a>,
    numbers: &'a mut Vec<f64>,
    /// What is not found stays an error.
    found: &'a mut [Result<MaterialPlace, ElementError>],
    fitting: &'a F,
}

impl<F: Fitting> WithLanes for Search<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self { slaves, order, nodes, numbers, found, fitting } = self;
        for group in order.chunks(T::WIDTH) {
            let (lanes, nearest) = gather::<T>(slaves, group, nodes, numbers);
            let searched = lanes.search(fitting);
            for (lane, &(_, k)) in group.iter().enumerate() {
                if searched.is_found.lane(lane) > 0.5 {
                    found[k] = searched.place(lane, &slaves[k], nodes, nearest[lane]);
                }
            }
        }
    }
}

/// Numbers in the widest vector.
const MOST_LANES: usize = 8;

/// Slaves by their places in `group`, ascending by their numbers of masters, side by side; and which master is nearest to each.
#[inline(always)]
fn gather<'n, T: Vector>(
    slaves: &[Sought],
    group: &[(usize, usize)],
    nodes: Nodes<'_>,
    numbers: &'n mut Vec<f64>,
) -> (Lanes<'n, T>, [usize; MOST_LANES]) {
    let most = group[group.len() - 1].0;
    let size = VALUES * T::WIDTH;
    if numbers.len() < most * size {
        numbers.resize(most * size, 0.0);
    }
    let mut nearest = [0; MOST_LANES];
    let numbers = &mut numbers[..most * size];
    // The last slave also fills the lanes beyond.
    let slave = |lane: usize| &slaves[group[lane.min(group.len() - 1)].1];
    for lane in 0..T::WIDTH {
        nearest[lane] = fill_lane(slave(lane), nodes, numbers, (lane, T::WIDTH));
    }
    let lanes = Lanes::<T> {
        numbers,
        near: splits(|lane| nodes.1[nearest[lane]].metric),
        slave: splits(|lane| difference(slave(lane).slave, nodes.0[nearest[lane]])),
    };
    (lanes, nearest)
}

/// Writes the nodes of a slave into its lane, and returns which of all is the nearest.
fn fill_lane(
    Sought { slave, range, .. }: &Sought,
    (masters, domains): (&[Point], &[MaterialDomain]),
    numbers: &mut [f64],
    (lane, width): (usize, usize),
) -> usize {
    let (mut nearest, mut least) = (range.start, f64::INFINITY);
    for k in range.clone() {
        let [x, y, z] = difference(masters[k], *slave);
        let square = x * x + y * y + z * z;
        if square < least {
            (nearest, least) = (k, square);
        }
    }
    let (master, first) = (masters[nearest], domains[nearest].position);
    for (place, node) in numbers.chunks_exact_mut(VALUES * width).enumerate() {
        let mut values = NO_NODE;
        if place < range.len() {
            let k = range.start + place;
            let ([x, y, z], [a, b, c]) =
                (difference(masters[k], master), difference(domains[k].position, first));
            let [xx, xy, xz, yy, yz, zz] = domains[k].metric;
            values = [x, y, z, a, b, c, xx, xy, xz, yy, yz, zz];
        }
        for (value, number) in values.into_iter().enumerate() {
            node[width * value + lane] = number;
        }
    }
    nearest
}

#[inline(always)]
fn difference(x: Point, y: Point) -> Point {
    [x[0] - y[0], x[1] - y[1], x[2] - y[2]]
}

/// Numbers of each lane as vectors.
#[inline(always)]
fn splits<T: Lane, const N: usize>(of_lane: impl Fn(usize) -> [f64; N]) -> [T; N] {
    let mut vectors = [T::ZERO; N];
    for k in 0..N {
        vectors[k] = T::from_fn(|lane| of_lane(lane)[k]);
    }
    vectors
}

impl<T: Vector> Searched<T> {
    /// Where a lane's slave is.
    fn place(
        &self,
        lane: usize,
        sought: &Sought,
        nodes: Nodes<'_>,
        nearest: usize,
    ) -> Result<MaterialPlace, ElementError> {
        let of = |vector: &[T; 3]| {
            Vector3::from([vector[0].lane(lane), vector[1].lane(lane), vector[2].lane(lane)])
        };
        let (position, first) = (nodes.0[nearest], nodes.1[nearest].position);
        let origin = Vector3::from(position) + of(&self.mean);
        let place = (Vector3::from(first) + of(&self.place)).into();
        let frame = Frame::of_average_plane(origin, of(&self.normal), sought.outward)?;
        Ok(MaterialPlace { place, frame, steps: self.evaluations })
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact_kernels::cubic::Cubic;
    use diffuse_contact_kernels::support::Isa;

    use super::*;

    /// Sheets of nodes, each with a slave over it.
    #[derive(Default)]
    struct Scene {
        slaves: Vec<Sought>,
        masters: Vec<Point>,
        domains: Vec<MaterialDomain>,
    }

    impl Scene {
        /// A sheet with the slave's height and `rings` of nodes around those within reach.
        fn add(&mut self, number: usize, height: f64, rings: i32) {
            let (phase, start) = (0.7 * number as f64, self.masters.len());
            let side = -3 - rings..4 + rings;
            for (i, j) in side.clone().flat_map(|i| side.clone().map(move |j| (f64::from(i), f64::from(j)))) {
                let noise = |k: f64| 0.1 * (3.1 * i + 1.7 * j + k + phase).sin();
                let position = [i + noise(0.0), j + noise(1.0), 0.5 * noise(2.0)];
                let radius = 1.9 + 2.0 * noise(3.0);
                let metric = [1.0 / radius, 0.05, 0.0, 0.9 / radius, 0.02, 1.0 / radius];
                self.domains.push(MaterialDomain { position, metric });
                let [x, y, z] = position;
                self.masters.push([1.1 * x + 40.0, 0.2 * x + 0.9 * y - 3.0, z + 0.06 * x * x - 0.04 * x * y]);
            }
            let slave = [40.0 + 0.4 * phase.sin(), 0.4 * phase.cos() - 3.0, height];
            let (outward, range) = ([0.0, 0.1, 1.0], start..self.masters.len());
            self.slaves.push(Sought { slave, outward, range });
        }

        fn found(&self, isa: Isa, slaves: &[Sought]) -> Vec<Result<MaterialPlace, ElementError>> {
            let mut found = vec![Err(ElementError::TooFewNodes { found: 0, needed: 3 }); slaves.len()];
            let mut order: Vec<_> =
                slaves.iter().enumerate().map(|(k, slave)| (slave.range.len(), k)).collect();
            order.sort_unstable();
            isa.run(Search {
                slaves,
                order: &order,
                nodes: (&self.masters, &self.domains),
                numbers: &mut Vec::new(),
                found: &mut found,
                fitting: &OfKernels::<Cubic>(PhantomData),
            });
            found
        }
    }

    #[test]
    fn a_few_steps_find_what_a_thorough_search_finds() {
        let mut scene = Scene::default();
        for k in 0..13 {
            scene.add(k, [-0.2, 0.0, 0.3][k % 3], (k % 2) as i32);
        }
        for isa in Isa::available() {
            for (slave, found) in scene.slaves.iter().zip(scene.found(isa, &scene.slaves)) {
                let (masters, domains) =
                    (&scene.masters[slave.range.clone()], &scene.domains[slave.range.clone()]);
                let fitting = |r| Weight::Cubic.fitting(r);
                let (found, expected) = (
                    found.unwrap(),
                    MaterialPlace::find(slave.slave, masters, domains, fitting, slave.outward).unwrap(),
                );
                for axis in 0..3 {
                    assert!((found.place[axis] - expected.place[axis]).abs() < 1e-12, "{isa}");
                    assert!((found.frame.normal[axis] - expected.frame.normal[axis]).abs() < 1e-12, "{isa}");
                }
                assert!(found.steps <= 9, "{isa}: {} evaluations", found.steps);
            }
        }
    }

    /// High over a curved sheet places are far from where their search begins: lanes begin once more nearby.
    #[test]
    fn lanes_find_far_places() {
        let mut scene = Scene::default();
        for k in 0..13 {
            scene.add(k, 0.4 + 0.1 * k as f64, 1);
        }
        for isa in Isa::available() {
            let found = scene.found(isa, &scene.slaves);
            let count = found.iter().flatten().count();
            assert!(count > 10, "{isa}: {count}");
            for (slave, found) in scene.slaves.iter().zip(found) {
                let Ok(found) = found else { continue };
                let nodes = (&scene.masters[..], &scene.domains[..]);
                let fitting = OfKernels::<Cubic>(PhantomData);
                let expected = place(slave, nodes, &fitting, &mut Vec::new()).unwrap();
                for axis in 0..3 {
                    assert!((found.place[axis] - expected.place[axis]).abs() < 1e-11, "{isa}");
                }
            }
        }
    }

    #[test]
    fn neither_other_lanes_nor_nodes_out_of_reach_change_a_bit() {
        let (mut few, mut many) = (Scene::default(), Scene::default());
        // Some are far from where their search begins.
        for k in 0..9 {
            let height = [0.1, 0.9][k % 2];
            few.add(k, height, 0);
            many.add(k, height, 1 + (k % 3) as i32);
        }
        let bits = |found: &Result<MaterialPlace, ElementError>| {
            let MaterialPlace { place, frame, .. } = (*found).unwrap();
            [place, frame.t1, frame.t2, frame.normal].map(|vector| vector.map(f64::to_bits))
        };
        for isa in Isa::available() {
            let [few_found, many_found] = [&few, &many].map(|scene| scene.found(isa, &scene.slaves));
            for (k, found) in few_found.iter().enumerate() {
                assert_eq!(bits(found), bits(&many_found[k]), "{isa}");
                let alone = few.found(isa, &few.slaves[k..=k]);
                assert_eq!(bits(found), bits(&alone[0]), "{isa}");
            }
        }
    }

    /// Nodes on a line have no plane.
    #[test]
    fn what_lanes_do_not_find_has_the_error_of_the_thorough_search() {
        let mut scene = Scene::default();
        scene.add(0, 0.1, 0);
        scene.add(1, 0.1, 0);
        for k in scene.slaves[0].range.clone() {
            scene.masters[k] = [k as f64, 0.0, 0.0];
        }
        let mut found = Vec::new();
        let nodes = (&scene.masters[..], &scene.domains[..]);
        places(&scene.slaves, nodes, Weight::Cubic, &mut SearchScratch::default(), &mut found);
        assert!(matches!(found[0], Err(ElementError::NoAveragePlane { .. })), "{:?}", found[0]);
        assert!(found[1].is_ok());
    }
}
