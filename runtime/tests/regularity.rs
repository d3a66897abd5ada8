//! What the least regularity of a fit costs and gains, on irregular meshes whose heights are off. The default is what it is because of
//! `hertz_cylinder_as_master` in the solver's tests.
//!
//! `cargo test --release -p diffuse-contact --test regularity -- --nocapture` prints the table of docs/results/surface.md.

use std::collections::HashMap;

use crate::common::{Mesh, Scene, Uniform};
use diffuse_contact::interface::{ContactElement, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::{Fallback, SMALLEST_REGULARITY, SearchOptions};
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Heights of nodes are off by up to this, in short sides of a cell.
const BUMPS: f64 = 0.05;
/// Radius of the paraboloid that the nodes would lie on.
const RADIUS: f64 = 10.0;
/// Of each kind; unoptimised kernels take their time.
const MESHES: u64 = if cfg!(debug_assertions) { 1 } else { 8 };
const SLAVES: usize = 500;
/// Times that slaves slide on, each by so much.
const STEPS: usize = 2;
const STEP: f64 = 0.15;
const MARGIN: f64 = 0.05;

/// An irregular mesh over the rectangle [0, `size[0]`] × [0, `size[1]`], and which slaves are called interior: those a
/// cell away from the border.
struct Irregular {
    mesh: Mesh,
    size: [f64; 2],
    cell: [f64; 2],
}

impl Irregular {
    /// The surface without bumps.
    fn height(size: [f64; 2], [x, y]: [f64; 2]) -> f64 {
        let [a, b] = [x - 0.5 * size[0], y - 0.5 * size[1]];
        -(a * a + b * b) / (2.0 * RADIUS)
    }

    /// Rows and columns of nodes, moved by this fraction of a cell at most; on the border along it only.
    fn quadrilaterals(cells: [usize; 2], cell: [f64; 2], jitter: f64, random: &mut Uniform) -> Self {
        let size = [0, 1].map(|axis| cells[axis] as f64 * cell[axis]);
        let place = |k: usize, axis: usize, random: &mut Uniform| {
            let shift = if k == 0 || k == cells[axis] { 0.0 } else { jitter * random.signed() };
            (k as f64 + shift) * cell[axis]
        };
        let columns = cells[0] + 1;
        let mut positions: Vec<Point> = Vec::new();
        for k in 0..columns * (cells[1] + 1) {
            let at = [place(k % columns, 0, random), place(k / columns, 1, random)];
            positions.push([at[0], at[1], Self::height(size, at) + BUMPS * random.signed()]);
        }
        let first = |k: usize| k % cells[0] + columns * (k / cells[0]);
        let corners = (0..cells[0] * cells[1]).map(first).map(|k| [k, k + 1, k + columns + 1, k + columns]);
        let facets = corners.map(Facet::Quadrilateral).collect();
        Self { mesh: Mesh { positions, facets }, size, cell }
    }

    /// The same nodes in a Delaunay triangulation.
    fn triangles(cells: [usize; 2], jitter: f64, random: &mut Uniform) -> Self {
        let Self { mesh, size, cell } = Self::quadrilaterals(cells, [1.0; 2], jitter, random);
        let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
        let insert = |(k, x): (usize, &Point)| (triangulation.insert(Point2::new(x[0], x[1])).unwrap(), k);
        let nodes: HashMap<_, _> = mesh.positions.iter().enumerate().map(insert).collect();
        let corners =
            triangulation.inner_faces().map(|face| face.vertices().map(|vertex| nodes[&vertex.fix()]));
        let facets = corners.map(Facet::Triangle).collect();
        Self { mesh: Mesh { facets, ..mesh }, size, cell }
    }

    fn is_interior(&self, at: [f64; 2]) -> bool {
        (0..2).all(|axis| at[axis] > self.cell[axis] && self.size[axis] - at[axis] > self.cell[axis])
    }
}

/// What was found with one bound on meshes of one kind.
#[derive(Default)]
struct Found {
    /// Sums of |∂gap/∂height| over the masters: by how much errors of the heights are enlarged.
    enlarged: Vec<f64>,
    square_gaps: f64,
    masters: usize,
    /// Inside, and at the border.
    slaves: [usize; 2],
    linear: [usize; 2],
    without: usize,
    /// Of slaves that were paired with others.
    square_jumps: f64,
    largest_jump: f64,
    jumps: usize,
}

impl Found {
    fn add(&mut self, irregular: &Irregular, smallest_regularity: f64, random: &mut Uniform) {
        let search = SearchOptions::default().with_smallest_regularity(smallest_regularity);
        let element = ContactElement::diffuse(search);
        let options = InterfaceOptions::default().with_element(element);
        let size = irregular.size;
        let on_surface = |at: &[f64; 2]| [at[0], at[1], Irregular::height(size, *at)];
        // Not so close to the border that bumps take the foot over it.
        let mut inside = |axis: usize| MARGIN + (size[axis] - 2.0 * MARGIN) * random.next();
        let mut at: Vec<[f64; 2]> = (0..SLAVES).map(|_| [inside(0), inside(1)]).collect();
        let slaves: Vec<Point> = at.iter().map(on_surface).collect();
        let mut scene = irregular.mesh.paired(&slaves, options);
        for (contact, &at) in scene.interface.evaluate(Mode::Gradient).unwrap().iter().zip(&at) {
            let zone = usize::from(!irregular.is_interior(at));
            self.slaves[zone] += 1;
            let Outcome::Contact { fallback } = contact.outcome else {
                self.without += 1;
                continue;
            };
            self.linear[zone] += usize::from(matches!(fallback, Fallback::Linear { .. }));
            let normal = contact.point.normal;
            let by_height = |node: &[f64]| (0..3).map(|axis| node[axis] * normal[axis]).sum::<f64>().abs();
            self.enlarged.push(contact.gradient[3..].chunks(3).map(by_height).sum());
            self.square_gaps += contact.point.gap.powi(2);
            self.masters += contact.nodes.len();
        }
        // They slide on, each its own way and back from the border.
        let turns: Vec<f64> = (0..SLAVES).map(|_| std::f64::consts::TAU * random.next()).collect();
        for _ in 0..STEPS {
            for (at, turn) in at.iter_mut().zip(&turns) {
                let way = [turn.cos(), turn.sin()];
                for axis in 0..2 {
                    let x = (at[axis] + STEP * way[axis]).abs();
                    at[axis] = if x > size[axis] { 2.0 * size[axis] - x } else { x };
                }
            }
            let slaves: Vec<Point> = at.iter().map(on_surface).collect();
            scene.move_slaves(&slaves);
            scene.update();
            let gaps = |scene: &mut Scene| -> Vec<(bool, f64, Vec<u32>)> {
                let contacts = scene.interface.evaluate(Mode::Value).unwrap().iter();
                contacts.map(|one| (one.outcome.is_contact(), one.point.gap, one.nodes.to_vec())).collect()
            };
            let before = gaps(&mut scene);
            scene.refresh();
            for (old, new) in before.iter().zip(gaps(&mut scene)) {
                if old.0 && new.0 && old.2 != new.2 {
                    let jump = (new.1 - old.1).abs();
                    self.jumps += 1;
                    self.square_jumps += jump * jump;
                    self.largest_jump = self.largest_jump.max(jump);
                }
            }
        }
    }

    fn row(&mut self, name: &str, bound: f64) -> String {
        self.enlarged.sort_by(f64::total_cmp);
        let count = self.enlarged.len();
        let percent = |k: usize| 100.0 * self.linear[k] as f64 / self.slaves[k].max(1) as f64;
        format!(
            "| {name} | {bound} | {:.1}, {:.1} | {:.4} | {:.1} | {:.1}, {:.1} | {:.4}, {:.3} |",
            self.enlarged[count * 99 / 100],
            self.enlarged[count - 1],
            (self.square_gaps / count as f64).sqrt(),
            self.masters as f64 / count as f64,
            percent(0),
            percent(1),
            (self.square_jumps / self.jumps as f64).sqrt(),
            self.largest_jump,
        )
    }
}

#[test]
fn the_default_bounds_errors_and_gives_up_no_quadratic_fit() {
    type Make = fn(&mut Uniform) -> Irregular;
    let kinds: [(&str, Make); 5] = [
        ("quadrilaterals, moved by 8 %", |random| {
            Irregular::quadrilaterals([12, 12], [1.0; 2], 0.08, random)
        }),
        ("quadrilaterals, 20 %", |random| Irregular::quadrilaterals([12, 12], [1.0; 2], 0.2, random)),
        ("quadrilaterals 3:1, 8 %", |random| Irregular::quadrilaterals([12, 12], [3.0, 1.0], 0.08, random)),
        ("triangles, 35 %", |random| Irregular::triangles([12, 12], 0.35, random)),
        ("a strip of two rows, 30 %", |random| Irregular::quadrilaterals([24, 2], [1.0; 2], 0.3, random)),
    ];
    println!(
        "| mesh | bound | enlarged by: 99 %, all | rms error | masters | linear: inside, border, % | jump: rms, largest |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: |");
    let mut largest = [0.0_f64; 2];
    for (name, make) in kinds {
        let mut of = |bound: f64| {
            let mut found = Found::default();
            for mesh in 0..MESHES {
                let mut random = Uniform(977 * (mesh + 1));
                // The first numbers of neighbouring seeds are alike.
                (0..8).for_each(|_| {
                    random.next();
                });
                let irregular = make(&mut random);
                found.add(&irregular, bound, &mut random);
            }
            println!("{}", found.row(name, bound));
            assert_eq!(found.without, 0, "{name}");
            found
        };
        let [default, more, _, much_more] = [SMALLEST_REGULARITY, 0.02, 0.05, 0.1].map(&mut of);
        assert_eq!(default.linear, [0, 0], "{name}");
        let worst = |found: &Found| *found.enlarged.last().expect("contacts");
        assert!(worst(&default) < 7.0, "{name}: {}", worst(&default));
        // What a larger bound gains, and what it loses.
        largest = [largest[0].max(worst(&default)), largest[1].max(worst(&more))];
        assert!(much_more.linear[1] > 0, "{name}");
    }
    assert!(largest[0] > 1.2 * largest[1], "{largest:?}");
}
