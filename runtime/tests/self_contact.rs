//! A surface in contact with itself: what a node may touch and what not, balance, and both sides alike.

use diffuse_contact::assembly::{ContactLaw, DofMap, Tangent};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions, NoContact, Outcome};
use diffuse_contact::surface::window::boxes_around;
use diffuse_contact::surface::{Facet, MasterSurface, SymmetryPlane};
use diffuse_contact::{Mode, Point};

use super::common::{Mesh, Uniform};

/// The smooth surface, and facets.
pub fn elements() -> [InterfaceOptions; 2] {
    [InterfaceOptions::default(), InterfaceOptions::node_to_facet()]
}

fn paired(mesh: &Mesh, options: InterfaceOptions) -> ContactInterface {
    let mut interface = ContactInterface::self_contact(mesh.surface(), &mesh.positions, options).unwrap();
    interface.refresh_pairing(&mesh.positions).unwrap();
    interface
}

/// The gap of each slave that has one.
fn gaps(interface: &mut ContactInterface) -> Vec<Option<f64>> {
    let contacts = interface.evaluate(Mode::Value).unwrap();
    contacts.iter().map(|contact| contact.outcome.is_contact().then_some(contact.point.gap)).collect()
}

/// Two meshes as one.
pub fn both(one: &Mesh, other: &Mesh) -> Mesh {
    let first = one.positions.len();
    let moved = |facet: &Facet| match *facet {
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| k + first)),
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| k + first)),
    };
    Mesh {
        positions: [&one.positions[..], &other.positions].concat(),
        facets: one.facets.iter().copied().chain(other.facets.iter().map(moved)).collect(),
    }
}

/// A hairpin: two legs of length `leg` one above the other, `apart` from one another, joined by half a turn at x > 0. Seen from inside.
pub fn hairpin(leg: f64, apart: f64, cells: usize) -> Mesh {
    let radius = 0.5 * apart;
    let length = 2.0 * leg + std::f64::consts::PI * radius;
    Mesh::grid([cells + 1, 5], [false; 2], |s, t| {
        let way = s * length - leg;
        let [x, z] = if way < 0.0 {
            [way, -radius]
        } else if way < length - 2.0 * leg {
            let (sine, cosine) = (way / radius).sin_cos();
            [radius * sine, -radius * cosine]
        } else {
            [length - 2.0 * leg - way, radius]
        };
        [x, 4.0 * t, z]
    })
}

#[test]
fn legs_of_a_fold_touch_one_another_and_not_themselves() {
    for options in elements() {
        // Cells of 0.8, legs 1 apart: the nearest nodes are mostly those beside, not those across.
        let mesh = hairpin(8.0, 1.0, 22);
        let mut interface = paired(&mesh, options);
        let found = gaps(&mut interface);
        let contacts = interface.contacts();
        for (k, gap) in found.iter().enumerate() {
            let [x, _, z] = mesh.positions[k];
            let contact = contacts.get(k);
            assert!(!contact.nodes.contains(&(k as u32)), "{k} is its own master");
            if x < -2.0 && x > -7.9 {
                let gap = gap.unwrap();
                assert!((gap - 1.0).abs() < 0.05, "{x} {z} {gap}");
                let across = contact.nodes.iter().all(|&node| mesh.positions[node as usize][2] * z < 0.0);
                assert!(across || x > -3.5, "{x} {z}");
            }
        }
        // Pressed together until the legs penetrate by 0.05.
        let mut pressed = mesh.clone();
        for x in &mut pressed.positions {
            x[2] *= (-0.05 / 1.0) * f64::from(x[0] < 0.0) + f64::from(x[0] >= 0.0);
        }
        interface.follow(&pressed.positions).unwrap();
        if options == InterfaceOptions::node_to_facet() {
            interface.refresh_pairing(&pressed.positions).unwrap();
        }
        for (k, gap) in gaps(&mut interface).iter().enumerate() {
            let x = mesh.positions[k][0];
            if x < -2.5 && x > -7.9 {
                assert!((gap.unwrap() + 0.05).abs() < 1e-3, "{x} {gap:?}");
            }
        }
    }
}

#[test]
fn the_back_of_a_thin_wall_is_never_touched() {
    for options in elements() {
        // A closed plate 0.2 thick with cells of 1, alone: whatever is opposite is its own.
        let mesh = Mesh::block([8, 8, 1], [4.0, 4.0, 0.1]);
        let mut interface = paired(&mesh, options);
        assert!(gaps(&mut interface).iter().all(Option::is_none));
        assert!(interface.contacts().iter().all(|contact| matches!(
            contact.outcome,
            Outcome::None(NoContact::NothingOver { limit }) if limit > 0.0
        )));
        // Dented by a quarter of its thickness, as in a trial state, it still does not touch itself.
        let mut dented = mesh.positions.clone();
        dented.iter_mut().filter(|x| x[2] > 0.0).for_each(|x| x[2] -= 0.05);
        interface.follow(&dented).unwrap();
        assert!(gaps(&mut interface).iter().all(Option::is_none));
    }
}

#[test]
fn across_a_coarse_bend_a_wall_does_not_touch_its_own_other_side() {
    // Of a pipe of this thickness and length, facets farther along face a node through the wall.
    for (around, along, thickness, length) in
        [(12, 1, 1.0, 10.0), (16, 1, 1.0, 30.0), (16, 2, 0.5, 10.0), (36, 1, 1.0, 20.0), (12, 3, 2.0, 60.0)]
    {
        let skin = |radius: f64, outward: f64| {
            Mesh::grid([around, along + 1], [true, false], |s, t| {
                let (sine, cosine) = (s * std::f64::consts::TAU * outward).sin_cos();
                [radius * cosine, radius * sine, t * length]
            })
        };
        let mesh = both(&skin(10.0 + 0.5 * thickness, 1.0), &skin(10.0 - 0.5 * thickness, -1.0));
        for options in elements() {
            let mut interface = paired(&mesh, options);
            for (k, gap) in gaps(&mut interface).iter().enumerate() {
                let [x, y, _] = mesh.positions[k];
                let is_inside = x.hypot(y) < 10.0;
                // Across the hole there may be something, far away.
                assert!(gap.is_none_or(|gap| is_inside && gap > 5.0), "{around} {thickness} {x} {y} {gap:?}");
            }
        }
    }
}

#[test]
fn plates_on_one_another_touch_the_next_and_no_other() {
    for options in elements() {
        // Three plates 0.2 thick, each 0.02 into the one below, with cells of 1.
        let plate = |z: f64, cells: usize| {
            let mut plate = Mesh::block([cells, cells, 1], [4.0, 4.0, 0.1]);
            plate.positions.iter_mut().for_each(|x| x[2] += z);
            plate
        };
        let mesh = both(&both(&plate(0.0, 8), &plate(0.18, 7)), &plate(0.36, 9));
        let mut interface = paired(&mesh, options);
        let found = gaps(&mut interface);
        for (k, gap) in found.iter().enumerate() {
            let [x, y, z] = mesh.positions[k];
            if x.abs() > 3.0 || y.abs() > 3.0 {
                continue;
            }
            let is_outside = !(-0.05..=0.41).contains(&z);
            assert_eq!(gap.is_none(), is_outside, "{x} {y} {z} {gap:?}");
            assert!(gap.is_none_or(|gap| (gap + 0.02).abs() < 1e-9), "{z} {gap:?}");
        }
    }
}

/// Legs of a serpentine whose two skins do not hang together: behind a leg is its other skin, and not the same skin of the next leg.
#[test]
fn the_back_of_a_wall_may_be_another_part_of_the_surface() {
    let skin = |side: f64| {
        // Three legs 4 apart, 1 thick, of which the middle one runs back.
        Mesh::grid([61, 5], [false; 2], |s, t| {
            let way = 3.0 * s;
            let (leg, along) = (way.floor().min(2.0), way - way.floor().min(2.0));
            let is_back = leg == 1.0;
            let x = 12.0 * if is_back { 1.0 - along } else { along };
            [x, 4.0 * t, 4.0 * leg + if is_back { -side } else { side }]
        })
    };
    let mut right = skin(-0.5);
    right.facets.iter_mut().for_each(|facet| *facet = facet.flipped());
    let mesh = both(&skin(0.5), &right);
    for options in elements() {
        let found = gaps(&mut paired(&mesh, options.with_distance_limit(Some(3.2))));
        assert!(found.iter().flatten().count() > 100);
        assert!(found.iter().flatten().all(|gap| *gap > 0.0), "{found:?}");
    }
}

#[test]
fn faces_of_a_corner_do_not_touch_one_another() {
    // A trough with walls at right angles, seen from inside, and one with walls 40° apart, whose walls do face one another.
    for (angle, touch) in [(90.0_f64, false), (40.0, true)] {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let mesh = Mesh::grid([17, 5], [false; 2], |s, t| {
            let way = 16.0 * s - 8.0;
            let [x, z] = if way < 0.0 { [-way, 0.0] } else { [way * cosine, way * sine] };
            [-x, 4.0 * t, z]
        });
        for options in elements() {
            let mut interface = paired(&mesh, options);
            let found = gaps(&mut interface);
            assert_eq!(found.iter().any(Option::is_some), touch, "{angle}");
            assert!(found.iter().flatten().all(|gap| *gap > 0.3), "{angle} {found:?}");
        }
    }
}

/// A tube squeezed to less than nothing: forces, moments, the two sides, and the derivatives.
#[test]
fn forces_of_a_surface_on_itself_are_in_balance_and_derive_from_an_energy() {
    let mut random = Uniform(7);
    for options in elements() {
        let options = options.with_areas(true);
        let mut mesh = Mesh::grid([24, 6], [true, false], |s, t| {
            let (sine, cosine) = (std::f64::consts::TAU * s).sin_cos();
            // Seen from inside.
            [-3.0 * sine, 4.0 * t, 3.0 * cosine]
        });
        let first = mesh.positions.clone();
        let mut interface = ContactInterface::self_contact(mesh.surface(), &first, options).unwrap();
        for x in &mut mesh.positions {
            x[2] *= -0.02;
            (0..3).for_each(|axis| x[axis] += 1e-2 * random.signed());
        }
        interface.refresh_pairing(&mesh.positions).unwrap();
        let law = ContactLaw::penalty(0.5 * 100.0).with_tangent(Tangent::Exact);
        let dofs = DofMap::standard(mesh.positions.len());
        let forces = |interface: &mut ContactInterface, positions: &[Point]| {
            interface.update(positions).unwrap();
            let contacts = interface.evaluate(Mode::Gradient).unwrap();
            let mut forces = vec![0.0; dofs.equations()];
            diffuse_contact::add_forces(contacts, &law, &dofs, &mut forces).unwrap();
            let energy = |contact: diffuse_contact::interface::ContactRef<'_>| {
                let depth = (-contact.point.gap).max(0.0);
                if contact.outcome.is_contact() { 25.0 * contact.area * depth * depth } else { 0.0 }
            };
            (forces, contacts.iter().map(energy).sum::<f64>())
        };
        let (found, _) = forces(&mut interface, &mesh.positions);
        let size = found.iter().fold(0.0_f64, |size, force| size.max(force.abs()));
        assert!(size > 1.0);
        let rows = found.as_chunks::<3>().0;
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let sum: f64 = rows.iter().map(|force| force[axis]).sum();
            let moment = |(x, force): (&Point, &[f64; 3])| x[next] * force[last] - x[last] * force[next];
            let moment: f64 = mesh.positions.iter().zip(rows).map(moment).sum();
            assert!(sum.abs() < 1e-11 * size && moment.abs() < 1e-10 * size, "{sum} {moment} {size}");
        }
        // −f is the derivative of the energy.
        let direction: Vec<f64> = found.iter().map(|_| random.signed()).collect();
        let moved = |step: f64| -> Vec<Point> {
            let moves = direction.as_chunks::<3>().0;
            let move_by = |(x, by): (&Point, &[f64; 3])| [0, 1, 2].map(|axis| x[axis] + step * by[axis]);
            mesh.positions.iter().zip(moves).map(move_by).collect()
        };
        let step = 1e-6;
        let [more, less] = [step, -step].map(|step| forces(&mut interface, &moved(step)).1);
        let work: f64 = found.iter().zip(&direction).map(|(force, by)| force * by).sum();
        assert!(((less - more) / (2.0 * step) - work).abs() < 1e-6 * work.abs().max(size), "{work}");
    }
}

/// Whether a state was reached by following or by pairing anew makes no difference.
#[test]
fn lists_that_follow_are_those_of_the_place() {
    let mesh = hairpin(8.0, 3.0, 40);
    let mut follows = paired(&mesh, InterfaceOptions::default());
    let mut positions = mesh.positions.clone();
    for round in 1..=12 {
        for (x, from) in positions.iter_mut().zip(&mesh.positions) {
            if from[0] < 0.0 && from[2] > 0.0 {
                // The upper leg comes down, and slides.
                x[2] = from[2] - 0.255 * f64::from(round);
                x[0] = from[0] + 0.1 * f64::from(round);
            }
        }
        follows.follow(&positions).unwrap();
        let mut anew =
            ContactInterface::self_contact(mesh.surface(), &mesh.positions, *follows.options()).unwrap();
        anew.renew_pairing(&positions).unwrap();
        let [one, other] = [gaps(&mut follows), gaps(&mut anew)];
        // The bend does not follow its legs, and is torn.
        let in_legs = |&(k, _): &(usize, _)| mesh.positions[k][0] < 0.0;
        for (k, (one, other)) in one.iter().zip(&other).enumerate().filter(in_legs) {
            let loaded = |gap: &Option<f64>| gap.filter(|gap| *gap < 0.0);
            let [one, other] = [one, other].map(|gap| loaded(gap).unwrap_or(0.0));
            assert!((one - other).abs() < 1e-12, "{round} {:?}: {one} {other}", mesh.positions[k]);
        }
        if round == 12 {
            assert!(one.iter().flatten().filter(|gap| **gap < 0.0).count() > 40);
        }
    }
}

/// Half of a tube goes on behind its plane of symmetry: no border there, and contact up to it.
#[test]
fn contact_goes_on_to_planes_of_symmetry() {
    let half = Mesh::grid([25, 6], [false; 2], |s, t| {
        let (sine, cosine) = (std::f64::consts::PI * s).sin_cos();
        [3.0 * sine, 4.0 * t, -3.0 * cosine]
    });
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    let mut interface =
        ContactInterface::self_contact(half.surface(), &half.positions, InterfaceOptions::default()).unwrap();
    interface.set_symmetry(&planes).unwrap();
    let flat: Vec<Point> = half.positions.iter().map(|&[x, y, z]| [x, y, -0.01 * z]).collect();
    interface.refresh_pairing(&flat).unwrap();
    let found = gaps(&mut interface);
    for (x, gap) in half.positions.iter().zip(&found).filter(|(x, _)| x[0] < 1e-9) {
        let gap = gap.unwrap();
        assert!((gap + 0.06).abs() < 2e-3, "{x:?} {gap}");
    }
}

#[test]
fn what_is_no_surface_is_refused_and_no_slaves_are_named() {
    let mesh = Mesh::plane(4.0, 4.0, 1.0);
    let bad = InterfaceOptions::default().with_distance_limit(Some(-1.0));
    assert!(ContactInterface::self_contact(mesh.surface(), &mesh.positions, bad).is_err());
    let short = &mesh.positions[..5];
    assert!(ContactInterface::self_contact(mesh.surface(), short, InterfaceOptions::default()).is_err());
    let surface = MasterSurface::new(&mesh.positions, mesh.facets.clone()).unwrap();
    let interface =
        ContactInterface::self_contact(surface, &mesh.positions, InterfaceOptions::default()).unwrap();
    assert_eq!(interface.slaves().len(), mesh.positions.len());
}

/// A window has neither what is near along the skin nor what is a node's back. An interface in one would pair a node with itself.
#[test]
fn there_is_no_window_of_a_surface_in_contact_with_itself() {
    let mesh = hairpin(8.0, 1.0, 22);
    let interface = paired(&mesh, InterfaceOptions::default());
    let boxes = boxes_around(&mesh.positions, 1.0, 4);
    assert_eq!(interface.window(&boxes, 0.1).unwrap_err().code(), "self-contact");
    let lone = vec![[50.0; 3]];
    let positions = [&mesh.positions[..], &lone].concat();
    let other = ContactInterface::new(
        mesh.surface(),
        vec![mesh.positions.len()],
        &[],
        &positions,
        InterfaceOptions::default(),
    );
    assert!(other.unwrap().window(&boxes, 0.1).is_ok());
}
