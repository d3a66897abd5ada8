//! Prints inputs and results of the Rust library, every number as the hexadecimal digits of its bits, for
//! `test_reference.py` to compare with: one line `name number number …` per array. Run with
//! `cargo run --release --bin reference` in `python/`, so that kernels are compiled as those of the Python module are.
#![forbid(unsafe_code)]

use std::error::Error;

use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap, Tangent, add_forces};
use diffuse_contact::friction::Coulomb;
use diffuse_contact::interface::{ContactElement, ContactInterface, Contacts, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::surface::{Facet, MasterSurface, SymmetryPlane};
use diffuse_contact::{
    Basis, BatchScratch, Element, Frame, FrameDerivative, GapSlot, Generated, Mode, Point, Weight, pairing,
};

fn main() -> Result<(), Box<dyn Error>> {
    for weight in Weight::ALL {
        for (derivative, name) in [(FrameDerivative::CoMoving, "co-moving"), (FrameDerivative::Held, "held")]
        {
            batch(
                &format!("batch/{}/quadratic/{name}/13", weight.name()),
                weight,
                Basis::Quadratic,
                derivative,
                13,
            )?;
            batch(&format!("batch/{}/linear/{name}/5", weight.name()), weight, Basis::Linear, derivative, 5)?;
        }
    }
    interface("interface/diffuse", InterfaceOptions::default().with_areas(true), &[])?;
    // Two of its borders.
    let planes = [SymmetryPlane::across(1, [0.0; 3]), SymmetryPlane::across(0, [0.0; 3])];
    interface("interface/symmetric", InterfaceOptions::default().with_areas(true), &planes)?;
    let layers = ContactElement::diffuse(SearchOptions::default());
    interface("interface/layers", InterfaceOptions::default().with_element(layers).with_areas(true), &[])?;
    let held = ContactElement::diffuse(SearchOptions::nearest())
        .with_weight(Weight::CubicInterpolating)
        .with_frame(FrameDerivative::Held);
    interface("interface/held", InterfaceOptions::default().with_element(held).with_areas(true), &[])?;
    let facets = InterfaceOptions::node_to_facet().with_areas(true);
    interface("interface/node-to-facet", facets, &[])?;
    friction("friction/node-to-facet", facets)?;
    if cfg!(feature = "friction") {
        friction("friction/diffuse", InterfaceOptions::default().with_areas(true))?;
    }
    adaptive_tangents();
    Ok(())
}

/// The decision on both sides of its border, and where there is nothing to divide.
fn adaptive_tangents() {
    let ratio = Tangent::ADAPTIVE_RATIO;
    let residuals = [0.0, 1e-300, ratio.next_down(), ratio, ratio.next_up(), 1.0, f64::INFINITY, f64::NAN];
    let forces = [0.0, 1e-300, 1.0, f64::INFINITY, f64::NAN];
    let pairs: Vec<[f64; 2]> =
        residuals.iter().flat_map(|&residual| forces.map(|force| [residual, force])).collect();
    print("adaptive/norms", pairs.iter().flatten().copied());
    let is_exact = |&[residual, force]: &[f64; 2]| Tangent::adaptive(residual, force) == Tangent::Exact;
    print("adaptive/exact", pairs.iter().map(|pair| f64::from(u8::from(is_exact(pair)))));
}

fn print(name: &str, numbers: impl IntoIterator<Item = f64>) {
    let digits: Vec<String> = numbers.into_iter().map(|x| format!("{:016x}", x.to_bits())).collect();
    println!("{name} {}", digits.join(" "));
}

/// Numbers from 0 to 1 that are the same everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Elements in no particular order of the plane: 203 of them, so that the last vector and the last piece are not full.
fn batch(
    name: &str,
    weight: Weight,
    basis: Basis,
    derivative: FrameDerivative,
    count: usize,
) -> Result<(), Box<dyn Error>> {
    let mut random = Random(count as u64);
    let (mut slaves, mut masters, mut radii) = (Vec::<Point>::new(), Vec::<Point>::new(), Vec::new());
    for _ in 0..203 {
        slaves.push([0.2 * random.next(), 0.2 * random.next(), 0.3 * random.next() - 0.1]);
        let start = masters.len();
        for k in 0..count {
            let angle = 2.4 * k as f64;
            let r = ((k as f64 + 0.5) / count as f64).sqrt() + 0.1 * random.next();
            let [x, y] = [r * angle.cos(), r * angle.sin()];
            masters.push([x, y, 0.1 * x - 0.1 * x * x + 0.05 * x * y + 0.02 * random.next()]);
        }
        let frame = Frame::average_plane(&masters[start..], [0.0, 0.0, 1.0])?;
        radii.push(pairing::support_radius(&frame, slaves[slaves.len() - 1], &masters[start..]));
    }
    let elements: Vec<Element<'_>> = slaves
        .iter()
        .zip(masters.chunks(count))
        .zip(&radii)
        .map(|((&slave, masters), &support_radius)| {
            let frame = Frame { derivative, ..Frame::average_plane(masters, [0.0, 0.0, 1.0])? };
            Ok(Element::new(slave, masters, frame, support_radius).with_basis(basis).with_weight(weight))
        })
        .collect::<Result<_, diffuse_contact::ElementError>>()?;
    let freedoms = 3 * (count + 1);
    let packed = freedoms * (freedoms + 1) / 2;
    let mut gradients = vec![0.0; elements.len() * freedoms];
    let mut hessians = vec![0.0; elements.len() * packed];
    let slots = gradients.chunks_mut(freedoms).zip(hessians.chunks_mut(packed));
    let slots = slots.map(|(gradient, hessian)| GapSlot { gradient, hessian });
    let results = Generated.gap_batch(&elements, Mode::Hessian, slots, &mut BatchScratch::default());
    let results = results.into_iter().collect::<Result<Vec<_>, _>>()?;
    print(&format!("{name}/slaves"), slaves.into_iter().flatten());
    print(&format!("{name}/masters"), masters.iter().flatten().copied());
    print(&format!("{name}/radii"), radii.iter().copied());
    print(&format!("{name}/gap"), results.iter().map(|point| point.gap));
    print(&format!("{name}/foot"), results.iter().flat_map(|point| point.foot));
    print(&format!("{name}/normal"), results.iter().flat_map(|point| point.normal));
    print(&format!("{name}/gradient"), gradients);
    print(&format!("{name}/hessian"), hessians);
    Ok(())
}

/// A grid of slaves in a trough of quadrilaterals and triangles, and where its nodes are.
fn scene(name: &str, options: InterfaceOptions) -> Result<(ContactInterface, Vec<Point>), Box<dyn Error>> {
    const CELLS: usize = 8;
    let place = |k: usize| [(k % (CELLS + 1)) as f64, (k / (CELLS + 1)) as f64];
    let height = |x: f64, y: f64| 0.05 * (x - 4.0) * (x - 4.0) + 0.1 * (0.8 * y).sin();
    let mut positions: Vec<Point> =
        (0..(CELLS + 1) * (CELLS + 1)).map(place).map(|[x, y]| [x, y, height(x, y)]).collect();
    let mut facets = Vec::new();
    for k in (0..CELLS * CELLS).map(|k| k % CELLS + (CELLS + 1) * (k / CELLS)) {
        let [a, b, c, d] = [k, k + 1, k + CELLS + 2, k + CELLS + 1];
        if k % 3 == 0 {
            facets.extend([Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]);
        } else {
            facets.push(Facet::Quadrilateral([a, b, c, d]));
        }
    }
    let first = positions.len();
    // Slaves above, some of them beyond the border.
    positions.extend(
        (0..49)
            .map(|k| [1.3 * (k % 7) as f64, 1.3 * (k / 7) as f64])
            .map(|[x, y]| [x, y, height(x, y) + 0.1 * (2.1 * x + y).cos() - 0.02]),
    );
    let slaves: Vec<usize> = (first..positions.len()).collect();
    let slave_facets: Vec<Facet> = (0..36)
        .map(|k| first + k % 6 + 7 * (k / 6))
        .map(|k| Facet::Quadrilateral([k, k + 7, k + 8, k + 1]))
        .collect();
    let corners = |facet: &Facet| {
        let corners = facet.corners();
        (0..4).map(|k| corners.get(k).map_or(-1.0, |&node| node as f64)).collect::<Vec<_>>()
    };
    print(&format!("{name}/positions"), positions.iter().flatten().copied());
    print(&format!("{name}/facets"), facets.iter().flat_map(corners));
    print(&format!("{name}/slave_facets"), slave_facets.iter().flat_map(corners));
    print(&format!("{name}/slaves"), slaves.iter().map(|&node| node as f64));

    let master = MasterSurface::new(&positions, facets)?;
    let interface = ContactInterface::new(master, slaves, &slave_facets, &positions, options)?;
    Ok((interface, positions))
}

/// The scene moved: gaps and derivatives, forces and tangents.
fn interface(name: &str, options: InterfaceOptions, planes: &[SymmetryPlane]) -> Result<(), Box<dyn Error>> {
    let (mut interface, mut positions) = scene(name, options)?;
    interface.set_symmetry(planes)?;
    let report = interface.refresh_pairing(&positions)?;
    print(&format!("{name}/paired"), [report.paired as f64, report.fallbacks.extended as f64]);
    for (k, position) in positions.iter_mut().enumerate() {
        position[2] += 0.01 * (k as f64).sin();
    }
    print(&format!("{name}/moved"), positions.iter().flatten().copied());
    interface.update(&positions)?;
    let contacts = interface.evaluate(Mode::Hessian)?;
    print(&format!("{name}/gap"), contacts.iter().map(|contact| contact.point.gap));
    print(&format!("{name}/foot"), contacts.iter().flat_map(|contact| contact.point.foot));
    print(&format!("{name}/normal"), contacts.iter().flat_map(|contact| contact.point.normal));
    print(&format!("{name}/area"), contacts.iter().map(|contact| contact.area));
    print(&format!("{name}/gradients"), contacts.iter().flat_map(|contact| contact.gradient.iter().copied()));
    print(&format!("{name}/hessians"), contacts.iter().flat_map(|contact| contact.hessian.iter().copied()));
    let codes: Vec<&str> = contacts.iter().map(|contact| contact.outcome.code()).collect();
    println!("{name}/outcomes {}", codes.join(" "));

    let multipliers: Vec<f64> = (0..contacts.len()).map(|k| 0.5 * (k % 5) as f64).collect();
    let dofs = DofMap::standard(positions.len());
    for (tangent, word) in [(Tangent::Exact, "exact"), (Tangent::GaussNewton, "gauss-newton")] {
        let law = ContactLaw::penalty(1e3).with_multipliers(Some(&multipliers)).with_tangent(tangent);
        system(&format!("{name}/{word}"), contacts, &law, &dofs)?;
    }
    Ok(())
}

/// Forces and tangent of contacts by a law.
fn system(
    name: &str,
    contacts: &Contacts,
    law: &ContactLaw<'_>,
    dofs: &DofMap,
) -> Result<(), Box<dyn Error>> {
    let mut residual = vec![0.0; dofs.equations()];
    add_forces(contacts, law, dofs, &mut residual)?;
    let pattern = CsrPattern::union(contacts, dofs)?;
    let mut values = vec![0.0; pattern.entries()];
    pattern.fill(contacts, law, &mut values)?;
    print(&format!("{name}/residual"), residual);
    print(&format!("{name}/offsets"), pattern.row_offsets().iter().map(|&x| x as f64));
    print(&format!("{name}/columns"), pattern.columns().iter().map(|&x| x as f64));
    print(&format!("{name}/values"), values);
    Ok(())
}

/// The slaves have touched, then slid by less and by more than what sticks: forces, tangents and histories.
fn friction(name: &str, options: InterfaceOptions) -> Result<(), Box<dyn Error>> {
    let (mut interface, mut positions) = scene(name, options)?;
    let law = ContactLaw::penalty(1e3).with_friction(Some(Coulomb::new(0.2, 500.0)?));
    let dofs = DofMap::standard(positions.len());
    interface.refresh_pairing(&positions)?;
    interface.accept(&law)?;
    for (step, by) in [("short", 2e-3), ("long", 0.05)] {
        let name = format!("{name}/{step}");
        for &slave in interface.slaves() {
            positions[slave][0] += by;
            positions[slave][1] += 0.5 * by;
        }
        print(&format!("{name}/moved"), positions.iter().flatten().copied());
        interface.refresh_pairing(&positions)?;
        let contacts = interface.evaluate(Mode::Hessian)?;
        for (tangent, word) in [(Tangent::Exact, "exact"), (Tangent::GaussNewton, "gauss-newton")] {
            system(&format!("{name}/{word}"), contacts, &law.with_tangent(tangent), &dofs)?;
        }
        let report = interface.accept(&law)?;
        let counts = [report.stuck, report.sliding, report.unanchored].map(|count| count as f64);
        print(&format!("{name}/report"), counts.into_iter().chain([report.dissipated]));
        print(&format!("{name}/history"), interface.history());
    }
    Ok(())
}
