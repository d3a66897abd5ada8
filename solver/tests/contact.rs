//! Contact forces and stiffnesses as the solver adds them up.

use std::collections::BTreeSet;
use std::sync::Arc;

use diffuse_contact::assembly::Tangent;
use diffuse_contact::faces::{FacePressures, FaceRule};
use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::surface::Facet;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};

use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::contact::*;
use diffuse_contact_solver::model::shape::{Axis, Block, Facets, RigidCylinder, Side};
use diffuse_contact_solver::system::{BlockMatrix, BlockPattern, Operator};

const PENALTY: f64 = 1e3;

/// A bumpy master of 5 × 5 cells below a coarser slave of 3 × 3, which dips into it. Nodes, master facets, slave facets.
fn bed() -> (Vec<Point>, Vec<Facet>, Vec<Facet>) {
    let mut nodes = Vec::new();
    let mut grid = |count: usize, turned: bool, place: &dyn Fn(f64, f64) -> Point| {
        let first = nodes.len();
        for j in 0..=count {
            for i in 0..=count {
                nodes.push(place(i as f64 / count as f64, j as f64 / count as f64));
            }
        }
        let node = |i: usize, j: usize| first + j * (count + 1) + i;
        let cells = (0..count).flat_map(|j| (0..count).map(move |i| (i, j)));
        let corners = cells.map(|(i, j)| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]);
        corners
            .map(|[a, b, c, d]| Facet::Quadrilateral(if turned { [a, d, c, b] } else { [a, b, c, d] }))
            .collect::<Vec<_>>()
    };
    let height = |x: f64, y: f64| 0.1 * (1.3 * x).sin() * (0.9 * y).cos();
    let master = grid(5, false, &|s, t| [5.0 * s, 5.0 * t, height(5.0 * s, 5.0 * t)]);
    let slave = grid(3, true, &|s, t| [1.2 + 2.5 * s, 1.1 + 2.4 * t, -0.05 + 0.1 * (s - t)]);
    (nodes, master, slave)
}

/// Pairings that a refresh changes.
fn hull_layers() -> InterfaceOptions {
    let (weight, frame) = (Weight::Cubic, FrameDerivative::CoMoving);
    let element = ContactElement::diffuse(SearchOptions::default()).with_weight(weight).with_frame(frame);
    InterfaceOptions::default().with_element(element)
}

fn options(two_pass: bool, augmented: bool) -> InteractionOptions {
    InteractionOptions::new("bed", PENALTY)
        .with_augmentation(augmented.then_some(Augmentation::new(1e-9).with_max_rounds(5)))
        .with_tangent(TangentRule::Exact)
        .with_two_pass(two_pass)
        .with_interface(hull_layers())
}

fn contacts(options: InteractionOptions) -> (ContactSet, Vec<Point>) {
    let (nodes, master, slave) = bed();
    let mut set = ContactSet::new(vec![Interaction::new(options, &master, &slave, &nodes).unwrap()]);
    set.refresh(RefreshRule::Increment, &nodes).unwrap();
    (set, nodes)
}

/// −Σ f N, and how many contacts carry force.
fn forces(set: &mut ContactSet, nodes: &[Point], mode: Mode) -> (Vec<f64>, usize) {
    let mut forces = vec![0.0; 3 * nodes.len()];
    set.evaluate(nodes, mode).unwrap();
    let active = set.add_internal_forces(&mut forces).unwrap();
    (forces, active)
}

fn variants() -> Vec<InteractionOptions> {
    let mut variants = vec![options(false, false), options(true, false), options(false, true)];
    let interface = InterfaceOptions::node_to_facet().with_areas(true);
    variants.push(options(false, false).with_interface(interface));
    for (two_pass, augmented) in [(false, false), (true, false), (false, true)] {
        let integration = Integration::FACES;
        let interface = InterfaceOptions::default();
        variants.push(options(two_pass, augmented).with_integration(integration).with_interface(interface));
    }
    variants
}

#[test]
fn forces_and_moments_of_each_pair_sum_to_nothing() {
    for options in variants() {
        let name = format!("{options:?}");
        let (mut set, nodes) = contacts(options);
        let (forces, active) = forces(&mut set, &nodes, Mode::Gradient);
        assert!(active > 3, "{active} {name}");
        let size = forces.iter().map(|force| force.abs()).fold(0.0, f64::max);
        assert!(size > 1.0);
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let rows = forces.as_chunks::<3>().0;
            let sum: f64 = rows.iter().map(|force| force[axis]).sum();
            let turn = |(x, force): (&Point, &[f64; 3])| x[next] * force[last] - x[last] * force[next];
            let moment: f64 = nodes.iter().zip(rows).map(turn).sum();
            assert!(sum.abs() < 1e-11 * size && moment.abs() < 1e-11 * size, "{sum} {moment} {size} {name}");
        }
    }
}

#[test]
fn the_force_on_the_slave_is_that_of_its_nodes() {
    let (mut set, nodes) = contacts(options(false, false));
    let (forces, active) = forces(&mut set, &nodes, Mode::Gradient);
    let slaves: Vec<_> = set.interactions()[0].slaves().collect();
    assert_eq!(slaves.iter().filter(|slave| slave.force > 0.0).count(), active);
    for axis in 0..3 {
        let sum: f64 = slaves.iter().map(|slave| -forces[3 * slave.node + axis]).sum();
        let found = set.resultants(&nodes)[0].force[axis];
        assert!((found - sum).abs() < 1e-10, "{found} {sum}");
    }
    let deepest =
        slaves.iter().filter_map(|slave| slave.gap).fold(0.0, |deepest: f64, gap| deepest.max(-gap));
    assert_eq!(set.max_penetration(), deepest);
    assert!(set.resultants(&nodes)[0].force[2] > 0.0);
}

/// Force, moment and centre are those of the forces on one side, in one pass and in two; areas are those of the nodes that carry force.
#[test]
fn resultants_are_those_of_the_slaves_side() {
    let (_, master, slave) = bed();
    let on = |facets: &[Facet]| facets.iter().flat_map(Facet::corners).copied().collect::<BTreeSet<usize>>();
    for options in variants() {
        let name = format!("{options:?}");
        let (mut set, nodes) = contacts(options);
        let (forces, _) = forces(&mut set, &nodes, Mode::Gradient);
        let found = set.resultants(&nodes)[0];
        // In equilibrium of all contact the rest is on the other side.
        let force = |node: usize| [0, 1, 2].map(|axis| -forces[3 * node + axis]);
        let side = on(&slave);
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let sum: f64 = side.iter().map(|&node| force(node)[axis]).sum();
            let turn =
                |node: usize| nodes[node][next] * force(node)[last] - nodes[node][last] * force(node)[next];
            let moment: f64 = side.iter().map(|&node| turn(node)).sum();
            assert!((found.force[axis] - sum).abs() < 1e-10 * (1.0 + sum.abs()), "{found:?} {sum} {name}");
            assert!(
                (found.moment[axis] - moment).abs() < 1e-10 * (1.0 + moment.abs()),
                "{found:?} {moment} {name}"
            );
        }
        // Forces push upwards from within the slave's outline.
        assert!(
            found.centre[0] > 1.2 && found.centre[0] < 3.7 && found.centre[1] > 1.1 && found.centre[1] < 3.5
        );
        assert!(found.normal > found.force[2] * (1.0 - 1e-12), "{found:?}");
        assert!(found.area > 0.0 && found.area < 2.5 * 2.4 * 1.01, "{}", found.area);
        assert!(on(&master).is_disjoint(&side));
    }
}

#[test]
fn the_stiffness_is_the_derivative_of_the_forces_with_the_pairing_held() {
    for options in variants() {
        let name = format!("{options:?}");
        let (mut set, nodes) = contacts(options);
        let (at_start, _) = forces(&mut set, &nodes, Mode::Hessian);
        let pattern = Arc::new(BlockPattern::new(nodes.len(), set.cliques().collect::<Vec<_>>().iter()));
        if set.multipliers().iter().any(|pass| !pass.is_empty()) {
            // With multipliers that are not zero. Then they are held.
            assert_eq!(set.augment(0).unwrap(), Augmented::Due);
            forces(&mut set, &nodes, Mode::Hessian);
        }
        let mut matrix = BlockMatrix::new(pattern);
        set.add_tangent(&mut matrix, [0.0; 2], None).unwrap();
        assert!(at_start.iter().any(|&force| force != 0.0));
        let size = entries(&matrix, nodes.len()).iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
        let step = 1e-6;
        for column in 0..3 * nodes.len() {
            let mut at = |shift: f64| {
                let mut moved = nodes.clone();
                moved[column / 3][column % 3] += shift;
                forces(&mut set, &moved, Mode::Gradient).0
            };
            let (after, before) = (at(step), at(-step));
            for row in 0..3 * nodes.len() {
                let expected = (after[row] - before[row]) / (2.0 * step);
                let found = matrix.block(row / 3, column / 3).map_or(0.0, |block| block[row % 3][column % 3]);
                assert!((found - expected).abs() < 1e-6 * size, "{row} {column}: {found} {expected} {name}");
            }
        }
    }
}

/// Pairings follow from positions: whatever there was before, multipliers are all there is to put back.
#[test]
fn multipliers_taken_out_and_put_back_change_nothing() {
    let (mut set, mut nodes) = contacts(options(true, true));
    forces(&mut set, &nodes, Mode::Gradient);
    set.augment(0).unwrap();
    let slide = |nodes: &mut [Point]| nodes[36..].iter_mut().for_each(|x| x[0] += 0.15);
    slide(&mut nodes);
    set.refresh(RefreshRule::Increment, &nodes).unwrap();
    let multipliers = set.multipliers();

    let (mut other, _) = contacts(options(true, true));
    other.set_multipliers(&multipliers).unwrap();
    slide(&mut nodes);
    for set in [&mut set, &mut other] {
        set.refresh(RefreshRule::Increment, &nodes).unwrap();
    }
    assert_eq!(forces(&mut set, &nodes, Mode::Hessian), forces(&mut other, &nodes, Mode::Hessian));
    assert_eq!(set.cliques().collect::<Vec<_>>(), other.cliques().collect::<Vec<_>>());
}

#[test]
fn multipliers_of_other_surfaces_are_refused() {
    let (mut set, _) = contacts(options(false, true));
    let wrong = |found, expected| Err(ContactError::OtherPasses { what: "multipliers", found, expected });
    assert_eq!(set.set_multipliers(&[vec![], vec![]]), wrong(2, 1));
    assert_eq!(set.set_multipliers(&[vec![0.0; 3]]), wrong(3, 16));
}

#[test]
fn augmenting_ends_when_penetrations_are_small_or_rounds_are_over() {
    let (mut set, nodes) = contacts(options(false, true));
    let (_, active) = forces(&mut set, &nodes, Mode::Gradient);
    let before: Vec<f64> = set.interactions()[0].slaves().map(|slave| slave.force).collect();
    assert_eq!(set.augment(0).unwrap(), Augmented::Due);
    assert_eq!(set.multipliers()[0], before);
    assert_eq!(before.iter().filter(|&&force| force > 0.0).count(), active);
    assert_eq!(set.augment(5).unwrap(), Augmented::Short, "rounds are over");
    assert_eq!(set.multipliers()[0], before);
    let mut apart = nodes.clone();
    apart[36..].iter_mut().for_each(|x| x[2] += 1.0);
    forces(&mut set, &apart, Mode::Gradient);
    assert!(set.interactions()[0].slaves().all(|slave| slave.force == 0.0));
    assert_eq!(set.augment(1).unwrap(), Augmented::Met, "nothing penetrates");
}

/// Force across an open gap is as wrong as a penetration.
#[test]
fn augmenting_goes_on_while_a_contact_pulled_open_carries_force() {
    let (mut set, mut nodes) = contacts(options(false, true));
    forces(&mut set, &nodes, Mode::Gradient);
    set.augment(0).unwrap();
    let lambda: f64 = set.multipliers()[0].iter().fold(0.0, |most, &force| most.max(force));
    // To half of the gap at which the largest multiplier's force is gone.
    let gaps: Vec<_> = set.interactions()[0].slaves().map(|slave| (slave.node, slave.gap)).collect();
    for (node, gap) in gaps {
        nodes[node][2] += 0.5 * lambda / PENALTY + (-gap.unwrap_or(0.0)).max(0.0);
    }
    forces(&mut set, &nodes, Mode::Gradient);
    let interaction = &set.interactions()[0];
    assert_eq!(interaction.max_penetration(), 0.0);
    let open: Vec<_> = interaction.slaves().filter(|slave| slave.force > 0.0).collect();
    assert!(!open.is_empty() && open.iter().all(|slave| slave.gap.unwrap() > 1e-3));
    let worst = open.iter().filter_map(|slave| slave.gap).fold(0.0, f64::max);
    assert_eq!(interaction.gap_error(), worst);
    let mut rounds = 0;
    while set.augment(rounds).unwrap() == Augmented::Due {
        rounds += 1;
        forces(&mut set, &nodes, Mode::Gradient);
    }
    assert!(rounds > 0 && rounds < 5, "{rounds}");
    assert!(set.interactions()[0].slaves().all(|slave| slave.force == 0.0));
}

/// Between nodes that are all prescribed a penetration is the deck's: no multiplier can take it away.
#[test]
fn contacts_that_move_nothing_are_not_augmented() {
    let (mut set, nodes) = contacts(options(false, true));
    forces(&mut set, &nodes, Mode::Gradient);
    let deepest = set.max_penetration();
    let mut held = vec![true; nodes.len()];
    set.hold(&held);
    assert!(set.interactions()[0].slaves().any(|slave| slave.force > 0.0 && slave.is_held));
    assert_eq!((set.max_penetration(), set.augment(0).unwrap()), (0.0, Augmented::Met));
    assert!(set.loaded()[0].is_empty(), "there is nothing to lose");
    // One master that can give way is enough for the slaves around it.
    held[14] = false;
    set.hold(&held);
    let active = set.interactions()[0].slaves().filter(|slave| slave.force > 0.0).count();
    assert_eq!(set.loaded()[0].len(), active, "they may come over it");
    assert!(set.max_penetration() > 0.0 && set.max_penetration() <= deepest);
    assert_eq!(set.augment(0).unwrap(), Augmented::Due);
    let slaves: Vec<_> = set.interactions()[0].slaves().collect();
    for (slave, &multiplier) in slaves.iter().zip(&set.multipliers()[0]) {
        assert_eq!(multiplier > 0.0, slave.force > 0.0 && !slave.is_held);
    }
    assert!(slaves.iter().any(|slave| slave.is_held));
}

#[test]
fn a_contact_that_vanishes_under_load_is_lost_and_one_that_opens_is_not() {
    let (mut set, nodes) = contacts(options(false, false));
    forces(&mut set, &nodes, Mode::Gradient);
    let loaded = set.loaded();
    assert!(loaded[0].len() > 3);
    let lost = |set: &ContactSet, to: &[Point]| {
        let way = Way { from: &nodes, to };
        set.lost(way).map(|(_, lost)| lost).collect::<Vec<_>>()
    };
    let moved = |by: Point| {
        let mut moved = nodes.clone();
        moved[36..].iter_mut().for_each(|x| (0..3).for_each(|axis| x[axis] += by[axis]));
        moved
    };
    // Far along the master its slaves leave the support of their fits.
    let slid = moved([2.2, 2.2, 0.0]);
    set.begin(&[Vec::new()]).unwrap();
    forces(&mut set, &slid, Mode::Gradient);
    assert!(lost(&set, &slid).is_empty(), "nobody carried force");
    set.begin(&loaded).unwrap();
    let found = lost(&set, &slid);
    assert!(!found.is_empty());
    let nodes_loaded: Vec<usize> = loaded[0].iter().map(|&k| 36 + k as usize).collect();
    assert!(found.iter().all(|lost| nodes_loaded.contains(&lost.node) && !lost.from_start), "{found:?}");
    let failed: Vec<usize> =
        set.interactions()[0].slaves().filter(|slave| slave.has_failed).map(|slave| slave.node).collect();
    assert!(found.iter().all(|lost| failed.contains(&lost.node)));
    set.excuse();
    assert!(lost(&set, &slid).iter().all(|lost| lost.from_start));
    // Who carried force on the way counts, too.
    set.begin(&[Vec::new()]).unwrap();
    forces(&mut set, &nodes, Mode::Gradient);
    set.note();
    forces(&mut set, &slid, Mode::Gradient);
    assert_eq!(lost(&set, &slid).len(), found.len());
    // Opened, and beyond the border.
    let opened = moved([0.0, 0.0, 0.3]);
    forces(&mut set, &opened, Mode::Gradient);
    assert!(lost(&set, &opened).is_empty());
    let beyond = moved([9.0, 0.0, 0.0]);
    set.refresh(RefreshRule::Increment, &beyond).unwrap();
    forces(&mut set, &beyond, Mode::Gradient);
    assert!(
        lost(&set, &beyond).is_empty() && set.interactions()[0].slaves().all(|slave| slave.gap.is_none())
    );
    assert_eq!(
        set.begin(&[vec![16]]),
        Err(ContactError::OtherPasses { what: "loaded slaves", found: 17, expected: 16 })
    );
}

/// A step that is no number is told, not a fault of the program: a shorter increment may be without it.
#[test]
fn a_product_of_the_operator_with_what_is_no_number_is_an_error() {
    let (mut set, nodes) = contacts(options(false, false));
    set.operate().unwrap();
    forces(&mut set, &nodes, Mode::Hessian);
    let operator = set.operator([0.0, 1.0], None).unwrap().unwrap();
    let (mut x, mut y) = (vec![[0.0; 3]; nodes.len()], vec![[0.0; 3]; nodes.len()]);
    assert_eq!(operator.add_product(&x, &mut y), Ok(()));
    x[4][1] = f64::NAN;
    let (entry, value) = operator.add_product(&x, &mut y).unwrap_err();
    assert!(entry == 13 && value.is_nan(), "{entry} {value}");
}

/// Who has nothing over it went through the master, beyond its border, or opened: only the first is a loss, and an opening is no warning.
#[test]
fn a_slave_that_went_through_is_lost_and_a_force_that_vanishes_is_named() {
    let limited = || InterfaceOptions::node_to_facet().with_areas(true).with_distance_limit(Some(0.5));
    let faces = Integration::FACES;
    for (integration, interface) in
        [(Integration::Nodes, limited()), (faces, limited()), (faces, InterfaceOptions::default())]
    {
        let (mut set, nodes) =
            contacts(options(false, false).with_integration(integration).with_interface(interface));
        assert!(forces(&mut set, &nodes, Mode::Gradient).1 > 3);
        let loaded = set.loaded();
        let mut after = |by: Point| {
            let mut to = nodes.clone();
            to[36..].iter_mut().for_each(|x| (0..3).for_each(|axis| x[axis] += by[axis]));
            set.begin(&loaded).unwrap();
            set.refresh(RefreshRule::Increment, &nodes).unwrap();
            forces(&mut set, &nodes, Mode::Gradient);
            set.excuse();
            set.refresh(RefreshRule::Increment, &to).unwrap();
            assert_eq!(forces(&mut set, &to, Mode::Gradient).1, 0, "{by:?}");
            let way = Way { from: &nodes, to: &to };
            let vanished: Vec<_> = set.vanished(way).collect();
            (set.lost(way).map(|(_, lost)| lost).collect::<Vec<_>>(), vanished)
        };
        let named = vec![("bed".to_owned(), loaded[0].len())];
        let (lost, vanished) = after([0.1, 0.2, -4.0]);
        // Who was over it without force went through it, too.
        assert_eq!((lost.len(), &vanished), (nodes.len() - 36, &named));
        for LostContact { loss, from_start, .. } in lost {
            assert!(matches!(loss, Loss::Through { depth } if (3.8..4.4).contains(&depth)) && !from_start);
        }
        assert_eq!(after([0.1, 0.2, 4.0]), (Vec::new(), Vec::new()));
        // Down by a little and off the border.
        let (lost, vanished) = after([9.0, 0.0, -0.6]);
        assert!(lost.is_empty() && vanished[0].1 > 0, "{lost:?} {vanished:?}");
    }
}

/// Two faces eight times as long as the radius of the rollers under them: no node of theirs goes through anything. One of them does, while
/// the other stays over its roller. So does one face over both rollers, of which one goes through.
#[test]
fn a_wide_face_that_went_through_a_roller_is_lost() {
    let roller = |x: f64| {
        let (axis, facets) = (Axis::Y, Facets::Quadrilaterals);
        let (angles, side) = ([0.0, 360.0], Side::Outside);
        let shape =
            RigidCylinder { axis, radius: 1.0, length: 4.0, angles, divisions: [16, 1], facets, side };
        let mut part = shape.part().unwrap();
        part.nodes.iter_mut().for_each(|node| (node[0], node[2]) = (node[0] + x, node[2] - 1.0));
        part
    };
    let (left, right) = (roller(4.0), roller(12.0));
    let right_from = left.nodes.len();
    let slave_from = right_from + right.nodes.len();
    let master: Vec<Facet> = left.outside().into_iter().chain(moved(&right.outside(), right_from)).collect();
    let face = |corners: [usize; 4]| Facet::Quadrilateral(corners.map(|node| slave_from + node));
    let strip = [0.0, 4.0].into_iter().flat_map(|y| [0.0, 8.0, 16.0].map(|x| [x, y, -1e-3]));
    let nodes: Vec<Point> = left.nodes.into_iter().chain(right.nodes).chain(strip).collect();
    let points = Integration::Faces { rule: FaceRule::Second, pressures: FacePressures::Points };
    for integration in [Integration::FACES, points] {
        let options = InteractionOptions::new("rollers", PENALTY).with_integration(integration);
        let set = |slave: &[Facet]| {
            ContactSet::new(vec![Interaction::new(options.clone(), &master, slave, &nodes).unwrap()])
        };
        let mut wide = set(&[face([0, 3, 5, 2])]);
        for (by, count) in [(6.0, 4), (-6.0, 0), (0.0, 0)] {
            let mut to = nodes.clone();
            to[right_from..slave_from].iter_mut().for_each(|x| x[2] += by);
            let (_, lost) = lost_between(&mut wide, &nodes, &to);
            assert_eq!(lost.len(), count, "{by}: {lost:?}");
        }
        let mut set = set(&[face([0, 3, 4, 1]), face([1, 4, 5, 2])]);
        let mut lost = |by: [Point; 3]| {
            let mut to = nodes.clone();
            for (k, x) in to[slave_from..].iter_mut().enumerate() {
                (0..3).for_each(|axis| x[axis] += by[k % 3][axis]);
            }
            let (_, lost) = lost_between(&mut set, &nodes, &to);
            lost.into_iter().map(|lost| lost.node - slave_from).collect::<Vec<_>>()
        };
        let [stays, down] = [[0.0; 3], [0.0, 0.0, -6.0]];
        assert_eq!(lost([down; 3]), [0, 1, 2, 3, 4, 5]);
        assert_eq!(
            lost([stays, stays, down]),
            [1, 2, 4, 5],
            "the middle nodes are over the left roller still"
        );
        // Aside over the rollers' flanks, and off them.
        for kept in [stays, [0.0, 0.0, 6.0], [1.0, 0.0, 0.0], [30.0, 0.0, 0.0], [-30.0, 0.0, 0.1]] {
            assert!(lost([kept; 3]).is_empty(), "{kept:?}");
        }
    }
}

/// Plates of a fifth of a facet's size that go through one another: what lies deeper than half of the thickness, or all of it between two
/// surfaces, has nothing over it. Beside one another, or apart, nothing is lost.
#[test]
fn thin_walls_that_went_through_one_another_are_lost() {
    const THICKNESS: f64 = 0.2;
    let faces = Integration::FACES;
    for (gap, self_contact) in [(0.02, false), (0.02, true), (0.5, false), (0.5, true)] {
        let plate = |origin: Point, cells: usize| {
            let size = [cells as f64, cells as f64, THICKNESS];
            let block = Block { origin, size, divisions: [cells, cells, 1], grading: [1.0; 3] };
            block.part(ElementKind::Hexahedron8).unwrap()
        };
        let (lower, upper) = (plate([0.0; 3], 6), plate([1.3, 1.2, THICKNESS + gap], 3));
        let first = lower.nodes.len();
        let below: Vec<usize> = upper.node_sets["z-"].iter().map(|node| first + node).collect();
        let (master, slave) = if self_contact {
            let all: Vec<Facet> = lower.outside().into_iter().chain(moved(&upper.outside(), first)).collect();
            (all.clone(), all)
        } else {
            (lower.outside(), moved(&upper.surfaces["z-"], first).collect())
        };
        let nodes = [lower.nodes, upper.nodes].concat();
        let options = InteractionOptions::new("plates", PENALTY)
            .with_integration(faces)
            .with_self_contact(self_contact);
        let mut set = ContactSet::new(vec![Interaction::new(options, &master, &slave, &nodes).unwrap()]);
        let mut lost = |by: Point| {
            let mut to = nodes.clone();
            to[first..].iter_mut().for_each(|x| (0..3).for_each(|axis| x[axis] += by[axis]));
            let (active, lost) = lost_between(&mut set, &nodes, &to);
            assert_eq!(active, 0);
            lost
        };
        let through = lost([0.0, 0.0, -gap - 0.25]);
        for node in below {
            let found = through.iter().find(|lost| lost.node == node).unwrap_or_else(|| panic!("{node}"));
            assert!(
                matches!(found.loss, Loss::Through { depth } if (depth - 0.25).abs() < 1e-9),
                "{found:?}"
            );
        }
        assert!(lost([9.0, 0.0, -gap - 0.25]).is_empty() && lost([0.0, 0.0, 5.0]).is_empty());
    }
}

/// A plate of facets that are a fifth of the face above it, which meets it two of them aside.
#[test]
fn a_wide_face_that_went_obliquely_through_fine_facets_is_lost() {
    let plate = Block {
        origin: [-1.0, -1.0, -0.3],
        size: [3.0, 3.0, 0.3],
        divisions: [15, 15, 1],
        grading: [1.0; 3],
    };
    let plate = plate.part(ElementKind::Hexahedron8).unwrap();
    let (first, master) = (plate.nodes.len(), plate.outside());
    let slave = [Facet::Quadrilateral([first, first + 2, first + 3, first + 1])];
    let corners = [0.0, 1.0].into_iter().flat_map(|y| [0.0, 1.0].map(|x| [x, y, 0.5]));
    let nodes: Vec<Point> = plate.nodes.into_iter().chain(corners).collect();
    let options = InteractionOptions::new("plate", PENALTY).with_integration(Integration::FACES);
    let mut set = ContactSet::new(vec![Interaction::new(options, &master, &slave, &nodes).unwrap()]);
    let mut lost = |by: Point| {
        let mut to = nodes.clone();
        to[first..].iter_mut().for_each(|x| (0..3).for_each(|axis| x[axis] += by[axis]));
        let (active, lost) = lost_between(&mut set, &nodes, &to);
        assert_eq!(active, 0);
        lost.len()
    };
    assert_eq!(lost([0.5, 0.0, -1.2]), 4);
    assert_eq!(lost([0.5, 0.0, 1.2]), 0);
    assert_eq!(lost([5.0, 0.0, -1.2]), 0, "off the plate");
}

/// Contacts that carry force at the end of an increment before which none did, and those that were lost in it.
fn lost_between(set: &mut ContactSet, from: &[Point], to: &[Point]) -> (usize, Vec<LostContact>) {
    set.begin(&vec![Vec::new(); set.pass_count()]).unwrap();
    set.refresh(RefreshRule::Increment, from).unwrap();
    forces(set, from, Mode::Gradient);
    set.excuse();
    let (_, active) = forces(set, to, Mode::Gradient);
    (active, set.lost(Way { from, to }).map(|(_, lost)| lost).collect())
}

/// Facets of nodes with other numbers.
fn moved(facets: &[Facet], first: usize) -> impl Iterator<Item = Facet> {
    facets.iter().map(move |facet| match *facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|node| first + node)),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|node| first + node)),
    })
}

/// All entries of a matrix over so many nodes, block by block.
fn entries(matrix: &BlockMatrix, nodes: usize) -> Vec<f64> {
    let pairs = (0..nodes).flat_map(|row| (0..nodes).map(move |column| (row, column)));
    let blocks = pairs.filter_map(|(row, column)| matrix.block(row, column));
    blocks.flat_map(|block| block.as_flattened()).copied().collect()
}

/// The tangent at a state with this residual and forces of norm 2.
fn tangent_at(tangent: TangentRule, residual: f64) -> Vec<f64> {
    let (mut set, nodes) = contacts(options(false, false).with_tangent(tangent));
    forces(&mut set, &nodes, Mode::Hessian);
    let pattern = Arc::new(BlockPattern::new(nodes.len(), set.cliques().collect::<Vec<_>>().iter()));
    let mut matrix = BlockMatrix::new(pattern);
    set.add_tangent(&mut matrix, [residual, 2.0], None).unwrap();
    entries(&matrix, nodes.len())
}

#[test]
fn far_from_equilibrium_the_adaptive_tangent_has_no_second_derivatives() {
    let exact = tangent_at(TangentRule::Exact, 2.0);
    let without = tangent_at(TangentRule::GaussNewton, 0.0);
    assert!(exact.iter().any(|&entry| entry != 0.0) && exact != without);
    let adaptive = |residual| tangent_at(TangentRule::Adaptive, residual);
    assert_eq!(adaptive(2.0 * Tangent::ADAPTIVE_RATIO), exact);
    assert_eq!(adaptive(2.002 * Tangent::ADAPTIVE_RATIO), without);
    assert_eq!(adaptive(f64::INFINITY), without);
    assert_eq!(adaptive(f64::NAN), without);
}
