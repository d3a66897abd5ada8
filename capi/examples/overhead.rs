//! What a call from Rust costs: the counterpart of `overhead.c`, on the same elements.
//!
//! ```sh
//! cargo run --release -p diffuse-contact-capi --example overhead
//! ```

use std::hint::black_box;
use std::time::Instant;

use diffuse_contact_kernels::support::Isa;
use runtime::{Element, ElementError, Frame, Generated, Mode, Point};

const RUNS: usize = 200;
const CALLS: usize = 200;
const MOST: usize = 20;

fn main() -> Result<(), ElementError> {
    let node = |k: usize| {
        [(k % 5) as f64 - 2.0 + 0.03 * (k % 3) as f64, (k / 5) as f64 - 1.5 + 0.02 * (k % 4) as f64]
    };
    let masters: Vec<Point> = (0..MOST).map(|k| [node(k)[0], node(k)[1], 0.01 * (k % 7) as f64]).collect();
    let freedoms = 3 * (MOST + 1);
    let (mut gradient, mut hessian) = (vec![0.0; freedoms], vec![0.0; freedoms * (freedoms + 1) / 2]);
    println!("ns of a call from Rust, {}\n   n    gap      N      M", Isa::best());
    for count in (8..=MOST).step_by(4) {
        print!("{count:4}");
        for mode in [Mode::Value, Mode::Gradient, Mode::Hessian] {
            let mut best = f64::INFINITY;
            for _ in 0..RUNS {
                let start = Instant::now();
                for _ in 0..CALLS {
                    let slave = black_box([0.1, 0.2, 0.25]);
                    let (t1, t2, normal) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
                    let element = Element::new(
                        slave,
                        &masters[..count],
                        Frame::given(slave, t1, t2, normal, None)?,
                        black_box(4.0),
                    );
                    black_box(Generated.gap_into(&element, mode, &mut gradient, &mut hessian)?);
                }
                best = best.min(start.elapsed().as_nanos() as f64 / CALLS as f64);
            }
            print!(" {best:6.0}");
        }
        println!();
    }
    Ok(())
}
