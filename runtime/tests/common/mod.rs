//! Surfaces and interfaces for the tests.
#![allow(dead_code, reason = "every test uses its part")]

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceOptions, RefreshReport};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::surface::{Facet, MasterSurface};
use nalgebra::{Rotation3, Vector3};

/// A small deterministic generator of numbers in [0, 1).
pub struct Uniform(pub u64);

impl Uniform {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From −1 to 1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.next() - 1.0
    }

    /// A whole number below `bound`.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.next() * bound as f64) as usize
    }

    /// From −1 to 1 along each axis.
    pub fn point(&mut self) -> Point {
        std::array::from_fn(|_| self.signed())
    }

    pub fn rotation(&mut self) -> Rotation3<f64> {
        let axis = Vector3::from_fn(|_, _| self.signed());
        Rotation3::new(axis.normalize() * (std::f64::consts::PI * self.next()))
    }
}

/// The default options with the masters of hull layers, which only a refresh changes.
pub fn hull_layers() -> InterfaceOptions {
    let element = ContactElement::diffuse(SearchOptions::default());
    InterfaceOptions::default().with_element(element)
}

/// Nodes and facets of a surface.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub positions: Vec<Point>,
    pub facets: Vec<Facet>,
}

impl Mesh {
    /// A grid of m × n nodes at `place(s, t)`, s and t from 0 to 1, outward where s × t points. Every third
    /// cell is cut in two triangles. In a closed direction the last nodes are the first: s (or t) stays below
    /// 1.
    pub fn grid([m, n]: [usize; 2], closed: [bool; 2], place: impl Fn(f64, f64) -> Point) -> Self {
        let cells = [m - usize::from(!closed[0]), n - usize::from(!closed[1])];
        let at = |k: usize, cells: usize| k as f64 / cells as f64;
        let positions = (0..m * n).map(|k| place(at(k % m, cells[0]), at(k / m, cells[1]))).collect();
        let node = |i: usize, j: usize| i % m + m * (j % n);
        let facets = (0..cells[0] * cells[1]).flat_map(|cell| {
            let (i, j) = (cell % cells[0], cell / cells[0]);
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            if cell % 3 == 0 {
                vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
            } else {
                vec![Facet::Quadrilateral([a, b, c, d])]
            }
        });
        Self { positions, facets: facets.collect() }
    }

    /// The rectangle from (0, 0, 0) to (width, depth, 0) with cells of about `size`, outside above.
    pub fn plane(width: f64, depth: f64, size: f64) -> Self {
        let count = |length: f64| (length / size).round() as usize + 1;
        Self::grid([count(width), count(depth)], [false; 2], |s, t| [width * s, depth * t, 0.0])
    }

    /// A closed box of n × n squares on each face, from −1 to 1 in every direction, outside around it.
    pub fn cube(n: usize) -> Self {
        Self::block([n, n, n], [1.0, 1.0, 1.0])
    }

    /// A closed block of these half widths around the origin with so many cells along each edge.
    pub fn block(cells: [usize; 3], half: [f64; 3]) -> Self {
        let mut mesh = Self { positions: Vec::new(), facets: Vec::new() };
        let mut numbers = std::collections::BTreeMap::new();
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for side in [0, cells[axis]] {
                for i in 0..cells[u] {
                    for j in 0..cells[v] {
                        let mut corner = |[a, b]: [usize; 2]| {
                            let mut at = [0; 3];
                            (at[axis], at[u], at[v]) = (side, i + a, j + b);
                            *numbers.entry(at).or_insert_with(|| {
                                let along = |k: usize| half[k] * (2.0 * at[k] as f64 / cells[k] as f64 - 1.0);
                                mesh.positions.push([along(0), along(1), along(2)]);
                                mesh.positions.len() - 1
                            })
                        };
                        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(&mut corner);
                        let facet = Facet::Quadrilateral(corners);
                        mesh.facets.push(if side == 0 { facet.flipped() } else { facet });
                    }
                }
            }
        }
        mesh
    }

    pub fn surface(&self) -> MasterSurface {
        MasterSurface::new(&self.positions, self.facets.clone()).expect("a surface")
    }

    /// The mesh as master and these slaves behind its nodes, not yet paired.
    pub fn scene(&self, slaves: &[Point], options: InterfaceOptions) -> Scene {
        let first = self.positions.len();
        let positions = [&self.positions, slaves].concat();
        let numbers = (first..positions.len()).collect();
        let interface =
            ContactInterface::new(self.surface(), numbers, &[], &positions, options).expect("an interface");
        Scene { positions, first, interface }
    }

    /// The same, paired.
    pub fn paired(&self, slaves: &[Point], options: InterfaceOptions) -> Scene {
        let mut scene = self.scene(slaves, options);
        scene.refresh();
        scene
    }
}

/// An interface and the positions of its nodes.
#[derive(Debug)]
pub struct Scene {
    pub positions: Vec<Point>,
    /// The first slave.
    pub first: usize,
    pub interface: ContactInterface,
}

impl Scene {
    pub fn refresh(&mut self) -> RefreshReport {
        self.interface.refresh_pairing(&self.positions).expect("good positions")
    }

    pub fn update(&mut self) {
        self.interface.update(&self.positions).expect("good positions");
    }

    /// Moves all slaves to these positions.
    pub fn move_slaves(&mut self, slaves: &[Point]) {
        self.positions.truncate(self.first);
        self.positions.extend_from_slice(slaves);
    }
}

pub fn dot(x: Point, y: Point) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

pub fn cross(x: Point, y: Point) -> Point {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// Rotation about `axis` by `angle` (Rodrigues).
pub fn rotate(x: Point, axis: Point, angle: f64) -> Point {
    let k = axis.map(|c| c / dot(axis, axis).sqrt());
    let (s, c) = angle.sin_cos();
    let kx = cross(k, x);
    let along = dot(k, x) * (1.0 - c);
    std::array::from_fn(|i| x[i] * c + kx[i] * s + k[i] * along)
}

/// Distance between two points.
pub fn distance(a: Point, b: Point) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

/// The larger of two errors; NaN if one is.
pub fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}
