//! What the derivatives of a moving frame cost beside those of a held one.

use diffuse_contact_codegen::contact::emit_kernel;
use diffuse_contact_codegen::emit::KernelCounts;
use diffuse_contact_codegen::{Basis, FrameRule, KernelSpec, Mode, Output, Weight};

fn gap_hessian(basis: Basis, weight: &Weight, frame: FrameRule) -> KernelCounts {
    let (output, mode, weight) = (Output::Gap, Mode::Hessian, weight.clone());
    emit_kernel(&KernelSpec { output, mode, basis, weight, frame }).counts
}

/// Its plane weights the nodes by their distance in space: weights of their own, and a height whose rows differ from node to node. A
/// plane of equal weights took 1.55.
#[test]
fn a_moving_frame_costs_less_than_the_held_one_again() {
    for weight in [Weight::cubic(), Weight::cubic_interpolating(), Weight::wendland_c2()] {
        let held = gap_hessian(Basis::Quadratic, &weight, FrameRule::Held);
        let moving = gap_hessian(Basis::Quadratic, &weight, FrameRule::CoMoving);
        for nodes in 6..=24 {
            let [held, moving] = [held, moving].map(|counts| counts.total(nodes).total() as f64);
            assert!(moving <= 1.8 * held, "{}, {nodes} nodes: {held}, {moving}", weight.name());
        }
    }
}

/// Two for each of the plane's turns and for its height: with weighted nodes the rows of the height differ from node to node.
#[test]
fn a_moving_frame_adds_a_rank_of_six_to_the_pairs() {
    for basis in Basis::ALL {
        let [held, moving] = [FrameRule::Held, FrameRule::CoMoving]
            .map(|frame| gap_hessian(basis, &Weight::cubic(), frame).pair.total());
        assert_eq!(moving - held, 6 * 9, "{}", basis.name());
    }
}

/// The slip's Hessian has the rows b of the gap's, of which the kernel keeps one copy.
#[test]
fn the_hessians_of_gap_and_slip_have_rows_in_common() {
    for basis in Basis::ALL {
        for weight in [Weight::cubic(), Weight::cubic_interpolating()] {
            for frame in [FrameRule::Held, FrameRule::CoMoving, FrameRule::Material] {
                let (output, mode, weight) = (Output::Slip, Mode::Hessian, weight.clone());
                let text = emit_kernel(&KernelSpec { output, mode, basis, weight, frame }).tokens.to_string();
                let calls = ["finish_pair", "finish_form"].map(|name| text.matches(name).count());
                assert_eq!(calls, [1, 0], "{}, {frame:?}", basis.name());
            }
        }
    }
}
