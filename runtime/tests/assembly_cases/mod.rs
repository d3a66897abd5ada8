//! Lists of elements to assemble, and the plain loop to compare with.
#![allow(dead_code, reason = "each test file uses its part")]

use diffuse_contact::assembly::{ContactLaw, ContactView, DofMap, ElementView, Elements, Tangent};
use diffuse_contact::neighbourhood::{NeighbourSearch, SearchOptions};
use diffuse_contact::pairing::{NearestNodes, Pairing};
use diffuse_contact::{Backend, Frame, Mode, Point, Weight};

use crate::common::Uniform;

/// Numbers of a case.
fn numbers(seed: u64) -> Uniform {
    let mut random = Uniform(seed);
    random.next();
    random
}

/// An element that owns its numbers.
#[derive(Clone, Debug)]
pub struct OwnedElement {
    pub slave: usize,
    pub masters: Vec<u32>,
    pub in_contact: bool,
    pub gap: f64,
    pub area: f64,
    pub gradient: Vec<f64>,
    pub hessian: Vec<f64>,
}

/// Elements over `nodes` nodes.
#[derive(Clone, Debug)]
pub struct Case {
    pub nodes: usize,
    pub elements: Vec<OwnedElement>,
}

impl Case {
    /// Random nodes, also twice in an element, and random numbers; up to `most` masters, one in six elements not paired.
    pub fn random(nodes: usize, elements: usize, most: usize, seed: u64) -> Self {
        let mut random = numbers(seed);
        let elements = (0..elements)
            .map(|_| {
                let count = if random.below(6) == 0 { 0 } else { random.below(most + 1) };
                let masters = (0..count).map(|_| random.below(nodes) as u32).collect();
                OwnedElement::random(random.below(nodes), masters, &mut random)
            })
            .collect();
        Self { nodes, elements }
    }

    /// The same with all nodes of an element different.
    pub fn with_distinct_nodes(nodes: usize, elements: usize, most: usize, seed: u64) -> Self {
        let mut random = numbers(seed);
        let elements = (0..elements)
            .map(|_| {
                let mut shuffled: Vec<u32> = (0..nodes as u32).collect();
                for k in (1..nodes).rev() {
                    shuffled.swap(k, random.below(k + 1));
                }
                let count = random.below(most.min(nodes - 1) + 1);
                OwnedElement::random(shuffled[0] as usize, shuffled[1..=count].to_vec(), &mut random)
            })
            .collect();
        Self { nodes, elements }
    }

    pub fn views(&self) -> Vec<ElementView<'_>> {
        self.elements.iter().map(OwnedElement::view).collect()
    }

    /// Multipliers of which a third are zero.
    pub fn multipliers(&self, seed: u64) -> Vec<f64> {
        let mut random = numbers(seed);
        self.elements.iter().map(|_| (3.0 * random.signed()).max(-1.0) + 1.0).collect()
    }

    /// Equations in random order with gaps between them; one degree of freedom in eight is constrained.
    pub fn scattered_equations(&self, seed: u64) -> DofMap {
        let mut random = numbers(seed);
        let count = 4 * self.nodes;
        let mut equations: Vec<usize> = (0..count).collect();
        for k in (1..count).rev() {
            equations.swap(k, random.below(k + 1));
        }
        let mut number = |equation| (random.below(8) != 0).then_some(equation);
        let numbers: Vec<[Option<usize>; 3]> =
            equations.chunks(4).map(|e| [number(e[0]), number(e[1]), number(e[2])]).collect();
        DofMap::new(count, numbers).unwrap()
    }
}

impl OwnedElement {
    fn random(slave: usize, masters: Vec<u32>, random: &mut Uniform) -> Self {
        let freedoms = 3 * (masters.len() + 1);
        let in_contact = !masters.is_empty() && random.below(5) != 0;
        let mut numbers = |count: usize| (0..count).map(|_| random.signed()).collect::<Vec<_>>();
        let (gradient, hessian) = (numbers(freedoms), numbers(freedoms * (freedoms + 1) / 2));
        Self {
            slave,
            masters,
            in_contact,
            gap: random.signed() - 0.3,
            area: random.signed() + 1.0,
            gradient,
            hessian,
        }
    }

    fn view(&self) -> ElementView<'_> {
        let Self { gap, area, gradient, hessian, .. } = self;
        let contact = ContactView { gap: *gap, area: *area, gradient, hessian, slip: None };
        ElementView { slave: self.slave, masters: &self.masters, contact: self.in_contact.then_some(contact) }
    }
}

/// Residual and tangent by a plain loop over elements, rows and columns.
pub struct Dense {
    pub residual: Vec<f64>,
    pub tangent: Vec<Vec<f64>>,
    /// Where paired elements have entries.
    pub coupled: Vec<Vec<bool>>,
    pub active: usize,
    pub largest: f64,
}

impl Dense {
    pub fn assemble<E: Elements + ?Sized>(elements: &E, law: &ContactLaw<'_>, dofs: &DofMap) -> Self {
        let size = dofs.equations();
        let mut dense = Self {
            residual: vec![0.0; size],
            tangent: vec![vec![0.0; size]; size],
            coupled: vec![vec![false; size]; size],
            active: 0,
            largest: 0.0,
        };
        for k in 0..elements.len() {
            dense.add(k, &elements.element(k), law, dofs);
        }
        let entries = dense.tangent.iter().flatten();
        dense.largest = entries.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        dense
    }

    fn add(&mut self, k: usize, element: &ElementView<'_>, law: &ContactLaw<'_>, dofs: &DofMap) {
        if element.masters.is_empty() {
            return;
        }
        let mut equations = Vec::new();
        for node in [element.slave].into_iter().chain(element.masters.iter().map(|&node| node as usize)) {
            equations.extend((0..3).map(|axis| dofs.equation(node, axis)));
        }
        let places: Vec<usize> = equations.iter().flatten().copied().collect();
        for &row in &places {
            places.iter().for_each(|&column| self.coupled[row][column] = true);
        }
        let Some(contact) = &element.contact else { return };
        let stiffness = law.penalty * contact.area;
        let force = law.multipliers.map_or(0.0, |multipliers| multipliers[k]) - stiffness * contact.gap;
        if force <= 0.0 {
            return;
        }
        self.active += 1;
        for (p, row) in equations.iter().enumerate() {
            let Some(row) = *row else { continue };
            self.residual[row] += force * contact.gradient[p];
            for (q, column) in equations.iter().enumerate() {
                let Some(column) = *column else { continue };
                let mut value = stiffness * (contact.gradient[p] * contact.gradient[q]);
                if law.tangent == Tangent::Exact {
                    let (i, j) = (p.max(q), p.min(q));
                    value -= force * contact.hessian[i * (i + 1) / 2 + j];
                }
                self.tangent[row][column] += value;
            }
        }
    }
}

/// Slave nodes over a part of a cylinder.
pub struct Patch {
    /// Master nodes, then slave nodes.
    pub positions: Vec<Point>,
    masters: usize,
    pub pairings: Vec<Pairing>,
    outward: Vec<Point>,
}

/// 9 × 7 master nodes on a third of a cylinder of radius 2, and a plane of 5 × 5 slave nodes of which the middle ones
/// penetrate it.
pub fn cylinder() -> Patch {
    let node = |k: usize| {
        let angle = (k % 9) as f64 * 0.25 - 1.0;
        [2.0 * angle.sin(), 0.4 * (k / 9) as f64, 2.0 * angle.cos()]
    };
    let masters: Vec<Point> = (0..63).map(node).collect();
    let slaves = (0..25).map(|k| [0.31 * (k % 5) as f64 - 0.6, 0.43 * (k / 5) as f64 + 0.29, 1.93]);
    let positions: Vec<Point> = masters.iter().copied().chain(slaves).collect();
    let nodes = NearestNodes::new(masters).unwrap();
    let mut search = NeighbourSearch::new(SearchOptions::nearest()).unwrap();
    let mut pairing =
        |&slave: &Point| search.find(&nodes, slave, [0.0, 0.0, 1.0]).unwrap().pairing(&nodes, Weight::Cubic);
    let pairings: Vec<Pairing> = positions[63..].iter().map(&mut pairing).collect();
    let outward = pairings.iter().map(|pairing| pairing.frame.normal).collect();
    Patch { positions, masters: 63, pairings, outward }
}

impl Patch {
    /// The elements of the pairings with their nodes at these positions.
    pub fn evaluate(&self, backend: &dyn Backend, positions: &[Point], mode: Mode) -> Case {
        let elements = self.pairings.iter().enumerate().map(|(k, pairing)| {
            let slave = self.masters + k;
            let masters: Vec<Point> = pairing.masters.iter().map(|&node| positions[node]).collect();
            let mut element = pairing
                .element(positions[slave])
                .with_frame(Frame::average_plane(&masters, self.outward[k]).unwrap());
            element.masters = &masters;
            let gap = backend.gap(&element, mode).unwrap();
            OwnedElement {
                slave,
                masters: pairing.masters.iter().map(|&node| node as u32).collect(),
                in_contact: true,
                gap: gap.gap,
                area: 1.0,
                hessian: gap.hessian.packed().to_vec(),
                gradient: gap.gradient,
            }
        });
        Case { nodes: positions.len(), elements: elements.collect() }
    }
}
