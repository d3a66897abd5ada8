//! Times of M v without M, and of the tangent of an interface as an operator:
//!
//! ```text
//! cargo run --release -p diffuse-contact-benches --example products [slaves along a side]
//! ```

use std::hint::black_box;
use std::time::Instant;

use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap, TangentOperator};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{BatchScratch, Element, Frame, GapSlot, Generated, HessianForm, Mode, Point};
use diffuse_contact_benches::Random;

type Failure = Box<dyn std::error::Error>;

/// Elements evaluated one after another, and those side by side in a batch.
const ELEMENTS: usize = 256;
const BATCH: usize = 16;
const ROUNDS: usize = 60;

fn main() -> Result<(), Failure> {
    println!("one element, ns: g, N and M; g, N and the factors of M; M v from these; ratios to the first");
    for moving in [false, true] {
        for nodes in [9, 12, 16, 20] {
            elements(nodes, moving)?;
        }
    }
    let side = std::env::args().nth(1).map_or(Ok(320), |side| side.parse())?;
    interface(side)
}

/// The masters of an element about the origin, in rings, and where the slave is.
fn patch(nodes: usize, noise: &mut Random) -> (Point, Vec<Point>) {
    let slave = [0.05 * noise.signed(), 0.05 * noise.signed(), 0.1 * noise.signed()];
    let masters = (0..nodes).map(|k| {
        let radius = ((k as f64 + 0.5) / nodes as f64).sqrt();
        let angle = 2.399_963 * k as f64 + 0.1 * noise.signed();
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        [x, y, 0.1 * x * x - 0.07 * x * y + 0.01 * noise.signed()]
    });
    (slave, masters.collect())
}

fn element((slave, masters): &(Point, Vec<Point>), moving: bool) -> Result<Element<'_>, Failure> {
    let frame = Frame::average_plane(masters, [0.0, 0.0, 1.0])?;
    Ok(Element::new(*slave, masters, if moving { frame } else { frame.held() }, 1.3))
}

fn elements(nodes: usize, moving: bool) -> Result<(), Failure> {
    let mut noise = Random::seeded(7);
    let patches: Vec<(Point, Vec<Point>)> = (0..ELEMENTS).map(|_| patch(nodes, &mut noise)).collect();
    let all: Vec<Element<'_>> =
        patches.iter().map(|patch| element(patch, moving)).collect::<Result<_, _>>()?;
    let form: HessianForm = Generated.hessian_form(&all[0])?;
    let freedoms = form.degrees_of_freedom();
    let packed = freedoms * (freedoms + 1) / 2;
    let mut scratch = BatchScratch::default();
    let mut gradients = vec![0.0; ELEMENTS * freedoms];
    let mut seconds = vec![0.0; ELEMENTS * packed.max(form.numbers())];
    let v: Vec<f64> = (0..freedoms).map(|k| (k as f64).sin()).collect();
    let mut product = vec![0.0; freedoms];
    let mut best = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        for (kind, size) in [packed, form.numbers()].into_iter().enumerate() {
            let start = Instant::now();
            let slots = gradients.chunks_exact_mut(freedoms).zip(seconds.chunks_exact_mut(size));
            let mut slots = slots.map(|(gradient, hessian)| GapSlot { gradient, hessian });
            for batch in all.chunks(BATCH) {
                let own = slots.by_ref().take(batch.len());
                let points = match kind {
                    0 => Generated.gap_batch(batch, Mode::Hessian, own, &mut scratch),
                    _ => Generated.gap_factors_batch(batch, own, &mut scratch),
                };
                for point in black_box(points) {
                    point?;
                }
            }
            best[kind] = best[kind].min(start.elapsed().as_secs_f64());
        }
        let start = Instant::now();
        for factors in seconds.chunks_exact(form.numbers()).take(ELEMENTS) {
            form.multiply(factors, black_box(&v), &mut product);
            black_box(&product);
        }
        best[2] = best[2].min(start.elapsed().as_secs_f64());
    }
    let [matrix, factors, products] = best.map(|time| 1e9 * time / ELEMENTS as f64);
    println!(
        "n = {nodes:2}, frame {}: {matrix:6.0} {factors:6.0} {products:6.0}; {:.3} from positions, {:.3} from factors",
        if moving { "moving" } else { "held  " },
        (factors + products) / matrix,
        products / matrix,
    );
    Ok(())
}

fn height(x: f64, y: f64) -> f64 {
    (0.04 * x).sin() * (0.03 * y).cos()
}

/// As many slaves as a square of this side has, all 0.01 deep, over a grid of as many masters.
fn interface(side: usize) -> Result<(), Failure> {
    let (positions, mut interface) = scene(side)?;
    interface.refresh_pairing(&positions)?;
    let (law, dofs) = (ContactLaw::penalty(1e3), DofMap::standard(positions.len()));
    println!("interface of {} slaves, {} threads, µs per slave", side * side, rayon::current_num_threads());
    let v: Vec<f64> = (0..dofs.equations()).map(|k| (k as f64).sin()).collect();
    let per_slave = |time: f64| 1e6 * time / (side * side) as f64;
    let found = operator(&interface, (&law, &dofs), &v, per_slave)?;
    let expected = assembled(&mut interface, (&law, &dofs), &v, per_slave)?;
    let (mut difference, mut largest) = (0.0_f64, 0.0_f64);
    for (x, y) in found.iter().zip(&expected) {
        (difference, largest) = (difference.max((x - y).abs()), largest.max(y.abs()));
    }
    println!("largest difference over the largest entry: {:.1e}", difference / largest);
    Ok(())
}

/// A surface of so many nodes each way, and as many slaves a little below it.
fn scene(side: usize) -> Result<(Vec<Point>, ContactInterface), Failure> {
    let mut noise = Random::seeded(3);
    let mut positions: Vec<Point> = Vec::new();
    for k in 0..side * side {
        let (x, y) = ((k % side) as f64 + 0.1 * noise.signed(), (k / side) as f64 + 0.1 * noise.signed());
        positions.push([x, y, height(x, y)]);
    }
    let cells = (side - 1) * (side - 1);
    let corner = |cell: usize| cell % (side - 1) + side * (cell / (side - 1));
    let facets = (0..cells).map(corner).map(|k| Facet::Quadrilateral([k, k + 1, k + side + 1, k + side]));
    let master = MasterSurface::new(&positions, facets.collect())?;
    let slaves: Vec<usize> = (positions.len()..positions.len() + side * side).collect();
    for k in 0..side * side {
        let inner = |k: usize| 1.0 + (side - 3) as f64 * (k as f64 + 0.3) / side as f64;
        let (x, y) = (inner(k % side), inner(k / side));
        positions.push([x, y, height(x, y) - 0.01]);
    }
    let interface = ContactInterface::new(master, slaves, &[], &positions, InterfaceOptions::default())?;
    Ok((positions, interface))
}

/// The least time of some calls, s.
fn least<T>(calls: usize, mut call: impl FnMut() -> Result<T, Failure>) -> Result<f64, Failure> {
    let mut best = f64::INFINITY;
    for _ in 0..calls {
        let start = Instant::now();
        black_box(call()?);
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// The product by the operator.
fn operator(
    interface: &ContactInterface,
    (law, dofs): (&ContactLaw<'_>, &DofMap),
    v: &[f64],
    per_slave: impl Fn(f64) -> f64,
) -> Result<Vec<f64>, Failure> {
    let start = Instant::now();
    let mut operator = TangentOperator::new(interface, law, dofs)?;
    let made = start.elapsed().as_secs_f64();
    let bytes = operator.bytes() as f64 / operator.contacts() as f64;
    println!("operator: made {:.3}, {bytes:.0} bytes per contact", per_slave(made));
    let mut found = vec![0.0; v.len()];
    let best = least(12, || {
        found.fill(0.0);
        Ok(operator.add_product(v, &mut found)?)
    })?;
    println!("operator: product {:.3}", per_slave(best));
    Ok(found)
}

/// The product by the assembled matrix.
fn assembled(
    interface: &mut ContactInterface,
    (law, dofs): (&ContactLaw<'_>, &DofMap),
    v: &[f64],
    per_slave: impl Fn(f64) -> f64,
) -> Result<Vec<f64>, Failure> {
    let slaves = interface.slaves().len();
    let start = Instant::now();
    let contacts = interface.evaluate(Mode::Hessian)?;
    let evaluated = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut pattern = CsrPattern::union(contacts, dofs)?;
    let patterned = start.elapsed().as_secs_f64();
    let renewed = least(5, || Ok(pattern.renew(contacts, dofs)?))?;
    let anew = least(5, || Ok(CsrPattern::union(contacts, dofs)?))?;
    println!("pattern: least of five {:.3}, in the same memory {:.3}", per_slave(anew), per_slave(renewed));
    let mut values = vec![0.0; pattern.entries()];
    let filled = least(1, || Ok(pattern.fill(contacts, law, &mut values)?))?;
    let refilled = least(5, || Ok(pattern.fill(contacts, law, &mut values)?))?;
    println!("fill: into new memory {:.3}, again {:.3}", per_slave(filled), per_slave(refilled));
    let mut product = vec![0.0; v.len()];
    let best = least(4, || {
        for (row, entry) in product.iter_mut().enumerate() {
            let range = pattern.row_offsets()[row]..pattern.row_offsets()[row + 1];
            let entries = values[range.clone()].iter().zip(&pattern.columns()[range]);
            *entry = entries.map(|(value, &column)| value * v[column as usize]).sum();
        }
        Ok(())
    })?;
    println!(
        "assembled: g, N, M {:.3}, pattern {:.3}, fill {:.3}, product by one thread {:.3}, {:.0} bytes per slave",
        per_slave(evaluated),
        per_slave(patterned),
        per_slave(filled),
        per_slave(best),
        16.0 * pattern.entries() as f64 / slaves as f64,
    );
    Ok(product)
}
