//! The one emitted text that is checked in, for review.

use diffuse_contact_codegen::contact::emit_single;
use diffuse_contact_codegen::{Basis, FrameRule, KernelSpec, Mode, Output, Weight};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../generated/golden/gap_gradient_linear.rs");

#[test]
fn the_golden_excerpt_is_what_the_generator_emits() {
    let spec = KernelSpec {
        output: Output::Gap,
        mode: Mode::Gradient,
        basis: Basis::Linear,
        weight: Weight::cubic(),
        frame: FrameRule::Held,
    };
    let support = syn::parse_str("diffuse_contact_kernels::support").unwrap();
    let (text, _) = emit_single(&spec, &support);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &text).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert!(
        text == golden,
        "the emitted text has changed; refresh the excerpt and review the difference:\n    \
         UPDATE_GOLDEN=1 cargo test -p diffuse-contact-codegen --test all -- golden"
    );
}
