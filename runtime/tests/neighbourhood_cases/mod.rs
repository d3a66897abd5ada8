//! Clouds of nodes and searches in them, for the tests of neighbourhoods.
#![allow(dead_code, reason = "every test uses its part")]

use std::f64::consts::PI;

use diffuse_contact::Point;
use diffuse_contact::neighbourhood::{
    NeighbourRule, NeighbourSearch, Neighbourhood, NeighbourhoodError, SearchOptions,
};
use diffuse_contact::pairing::NearestNodes;
use nalgebra::{Rotation3, Vector3};

pub const UP: Point = [0.0, 0.0, 1.0];

/// A small deterministic generator of numbers in [0, 1).
pub struct Uniform(pub u64);

impl Uniform {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn point(&mut self) -> Point {
        [self.next(), self.next(), self.next()]
    }

    pub fn rotation(&mut self) -> Rotation3<f64> {
        let axis = Vector3::from(self.point().map(|x| x - 0.5));
        Rotation3::new(axis.normalize() * (2.0 * PI * self.next()))
    }
}

pub fn find(
    points: &[Point],
    slave: Point,
    options: SearchOptions,
) -> Result<Neighbourhood, NeighbourhoodError> {
    let nodes = NearestNodes::new(points.to_vec()).unwrap();
    NeighbourSearch::new(options)?.find(&nodes, slave, UP)
}

pub fn hull(layers: Option<usize>) -> SearchOptions {
    SearchOptions::default().with_rule(NeighbourRule::hull_layers(layers))
}

/// A flat cloud with a third of the nodes crowded in one quarter.
pub fn flat_cloud(random: &mut Uniform, size: usize) -> Vec<Point> {
    let node = |k: usize| {
        let crowd = if k.is_multiple_of(3) { 0.25 } else { 1.0 };
        [random.next() * crowd, random.next() * crowd, 0.0]
    };
    (0..size).map(node).collect()
}

/// The nodes of a plane lattice spanned by `u` and `v` around the origin, and their integer coordinates.
pub fn lattice(u: [f64; 2], v: [f64; 2], half: i32) -> (Vec<Point>, Vec<[i32; 2]>) {
    let row = |j: i32| (-half..=half).map(move |i| [i, j]);
    let integers: Vec<[i32; 2]> = (-half..=half).flat_map(row).collect();
    let point = |&[i, j]: &[i32; 2]| {
        let (i, j) = (f64::from(i), f64::from(j));
        [i * u[0] + j * v[0], i * u[1] + j * v[1], 0.0]
    };
    (integers.iter().map(point).collect(), integers)
}

pub fn lattices() -> [(&'static str, [f64; 2], [f64; 2]); 3] {
    [
        ("squares", [1.0, 0.0], [0.0, 1.0]),
        ("equilateral triangles", [1.0, 0.0], [0.5, 0.75_f64.sqrt()]),
        ("quads 3:1", [3.0, 0.0], [0.0, 1.0]),
    ]
}

/// On a node, in the middle of an edge, in the middle of a cell (of a quad, of a triangle), and in between.
pub const PLACES: [[f64; 2]; 6] =
    [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5], [1.0 / 3.0, 1.0 / 3.0], [0.21, 0.34]];
