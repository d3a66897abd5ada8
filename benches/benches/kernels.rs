//! Times of the contenders for development: `cargo bench -p diffuse-contact-benches -- generated`.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use diffuse_contact_benches::{CONTENDERS, Elements};
use diffuse_contact_kernels::support::Isa;

/// Different elements for each number of nodes.
const ELEMENTS: usize = 256;

/// The contenders that count, by output and number of nodes; dual numbers are left to `diffuse-contact bench`.
fn kernels(criterion: &mut Criterion) {
    for nodes in [6, 8, 9, 12, 16, 20, 24] {
        let elements = Elements::new(nodes, ELEMENTS).expect("patches with these numbers of nodes have gaps");
        for contender in CONTENDERS.iter().filter(|contender| !contender.kernel.starts_with("num-dual")) {
            let Some(mut run) = (contender.prepare)(&elements, Isa::best()) else { continue };
            let mut group = criterion.benchmark_group(contender.output.name());
            group.bench_function(BenchmarkId::new(contender.kernel, nodes), |bencher| {
                bencher.iter_custom(|count| -> Duration {
                    let start = Instant::now();
                    black_box(run.run(count as usize)).expect("all elements have a gap");
                    start.elapsed()
                });
            });
            group.finish();
        }
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
