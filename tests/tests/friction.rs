//! Contact with friction: the slip q with its derivatives against automatic differentiation, what rigid motions and
//! the theory say of it, batches, and the tangent of Coulomb's law.

use diffuse_contact::ad::Ad;
use diffuse_contact::friction::{Coulomb, FrictionState, NormalForce};
use diffuse_contact::{
    Backend, Basis, FrameDerivative, Generated, Mode, Point, Slip, SymmetricMatrix, Weight,
};
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::cubic_interpolating::CubicInterpolating;
use diffuse_contact_kernels::support::{
    BatchElement, ElementInputs, FrameRule, GapValues, Isa, KernelSet, Workspace, packed_row,
};
use diffuse_contact_kernels::wendland_c2::WendlandC2;
use diffuse_contact_tests::{
    Case, Random, add, cross, difference, instructions, largest, length, scale, turn,
};

/// Relative to the largest entry, against another implementation.
const TOLERANCE: f64 = 1e-12;
/// Sums that vanish, relative to the largest entry.
const ROUNDING: f64 = 1e-13;

const FRAMES: [FrameRule; 3] = [FrameRule::Held, FrameRule::CoMoving, FrameRule::Material];
const WEIGHTS: [Weight; 3] = [Weight::Cubic, Weight::CubicInterpolating, Weight::WendlandC2];

/// An element with an anchor half a radius away at most.
struct Slipped {
    case: Case,
    anchor: Point,
}

impl Slipped {
    fn random(n: usize, basis: Basis, weight: Weight, frame: FrameRule, seed: u64) -> Self {
        let case = Case::random(n, basis, seed).with_weight(weight);
        let case = match frame {
            FrameRule::Held => case,
            FrameRule::CoMoving => case.co_moving(),
            FrameRule::Material => case.material(),
        };
        let mut random = Random::new(seed ^ 0xA5A5);
        let anchor = add(case.slave, random.vector(0.5 * case.support_radius));
        Self { case, anchor }
    }

    fn by(&self, backend: &dyn Backend, mode: Mode) -> Slip {
        backend.slip(&self.case.element(), self.anchor, mode).expect("a well-conditioned element")
    }

    /// With a coordinate of slave, master or anchor changed.
    fn moved(&self, point: usize, axis: usize, step: f64) -> Self {
        let mut moved = Self { case: self.case.clone(), anchor: self.anchor };
        match point {
            0 => moved.case.slave[axis] += step,
            k if k <= self.case.masters.len() => moved.case.masters[k - 1][axis] += step,
            _ => moved.anchor[axis] += step,
        }
        moved
    }

    fn points(&self) -> Vec<Point> {
        std::iter::once(self.case.slave)
            .chain(self.case.masters.iter().copied())
            .chain([self.anchor])
            .collect()
    }
}

/// All weights, bases and frame rules.
fn all(nodes: &[usize]) -> impl Iterator<Item = Slipped> + '_ {
    let bases = [Basis::Quadratic, Basis::Linear];
    let kinds = WEIGHTS.into_iter().flat_map(move |weight| {
        bases.into_iter().flat_map(move |basis| FRAMES.map(|frame| (weight, basis, frame)))
    });
    kinds.enumerate().flat_map(move |(k, (weight, basis, frame))| {
        let of_size = |&n: &usize| Slipped::random(n, basis, weight, frame, 100 * k as u64 + n as u64);
        nodes.iter().map(of_size).collect::<Vec<_>>()
    })
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let worst = difference(found, expected);
    assert!(worst <= tolerance, "{what}: {worst:e}");
}

#[test]
fn the_slip_is_that_of_automatic_differentiation() {
    for slipped in all(&[9, 16]) {
        let (found, expected) = (slipped.by(&Generated, Mode::Hessian), slipped.by(&Ad, Mode::Hessian));
        assert_close(&[found.half_square], &[expected.half_square], TOLERANCE, "q");
        assert_close(&found.gradient, &expected.gradient, TOLERANCE, "∇q");
        assert_close(found.hessian.packed(), expected.hessian.packed(), TOLERANCE, "∇²q");
        assert_close(&found.foot_weights, &expected.foot_weights, TOLERANCE, "φ");
        assert_close(&found.contact.gradient, &expected.contact.gradient, TOLERANCE, "N");
        assert_close(found.contact.hessian.packed(), expected.contact.hessian.packed(), TOLERANCE, "M");
    }
}

#[test]
fn lower_modes_have_the_values_of_the_hessian_mode() {
    for slipped in all(&[8]) {
        let [value, gradient, hessian] =
            [Mode::Value, Mode::Gradient, Mode::Hessian].map(|mode| slipped.by(&Generated, mode));
        for lower in [&value, &gradient] {
            assert_close(&[lower.half_square], &[hessian.half_square], TOLERANCE, "q");
            assert_close(&[lower.contact.gap], &[hessian.contact.gap], TOLERANCE, "g");
            assert_eq!(lower.hessian, SymmetricMatrix::default());
        }
        assert!(value.gradient.is_empty() && value.foot_weights.is_empty());
        assert_close(&gradient.gradient, &hessian.gradient, TOLERANCE, "∇q");
        assert_close(&gradient.foot_weights, &hessian.foot_weights, TOLERANCE, "φ");
    }
}

#[test]
fn forces_and_moments_balance_where_the_frame_moves() {
    for slipped in all(&[10, 15]) {
        let slip = slipped.by(&Generated, Mode::Hessian);
        let size = largest(&slip.gradient);
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for (part, x) in slip.gradient.chunks_exact(3).zip(slipped.points()) {
            let part = [part[0], part[1], part[2]];
            force = add(force, part);
            moment = add(moment, cross(add(x, scale(-1.0, slipped.case.slave)), part));
        }
        assert!(length(force) <= ROUNDING * size, "{:e}", length(force) / size);
        if slipped.case.element().frame.derivative == FrameDerivative::CoMoving {
            assert!(length(moment) <= ROUNDING * size, "{:e}", length(moment) / size);
        }
        for row in slip.hessian.to_rows() {
            for axis in 0..3 {
                let sum: f64 = row.iter().skip(axis).step_by(3).sum();
                assert!(sum.abs() <= ROUNDING * largest(slip.hessian.packed()), "{sum:e}");
            }
        }
    }
}

#[test]
fn the_foot_is_its_weights_combination_of_the_nodes() {
    for slipped in all(&[8, 13]) {
        let slip = slipped.by(&Generated, Mode::Gradient);
        let sum: f64 = slip.foot_weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-13, "{sum}");
        let slave = slipped.case.slave;
        let mut foot = [0.0; 3];
        for (weight, master) in slip.foot_weights.iter().zip(&slipped.case.masters) {
            foot = add(foot, scale(*weight, add(*master, scale(-1.0, slave))));
        }
        let expected = add(slip.contact.foot, scale(-1.0, slave));
        // Along the normal the fit does not pass through the nodes, but f at the foot is Σ φ z.
        assert!(length(add(foot, scale(-1.0, expected))) < 1e-12, "{foot:?} {expected:?}");
    }
}

#[test]
fn a_slip_from_the_foot_itself_is_none() {
    for mut slipped in all(&[9]) {
        let slip = slipped.by(&Generated, Mode::Hessian);
        let gap = slip.contact.gap;
        slipped.anchor = slip.contact.foot;
        let stuck = slipped.by(&Generated, Mode::Hessian);
        // No root of q is drawn: all of it is finite, and the force is nothing.
        assert!(stuck.half_square.abs() <= 1e-26, "{:e}", stuck.half_square);
        assert!(largest(&stuck.gradient) <= 1e-13 * (1.0 + gap.abs()));
        assert!(stuck.hessian.packed().iter().all(|x| x.is_finite()));
    }
}

/// One entry of the batch functions of each weight.
type BatchFunction = fn(Isa, (Basis, FrameRule, Mode), &mut [BatchElement<'_>], &mut Workspace);

#[test]
fn batches_give_what_elements_give_one_by_one() {
    let sets: [(Weight, BatchFunction); 3] = [
        (Weight::Cubic, Cubic::slip_batch),
        (Weight::CubicInterpolating, CubicInterpolating::slip_batch),
        (Weight::WendlandC2, WendlandC2::slip_batch),
    ];
    for (weight, batch) in sets {
        for (frame, n) in FRAMES.into_iter().flat_map(|frame| [8, 9, 16].map(|n| (frame, n))) {
            let slipped: Vec<Slipped> =
                (0..7).map(|k| Slipped::random(n, Basis::Quadratic, weight, frame, 900 + k)).collect();
            let freedoms = 3 * (n + 1);
            let sizes = [2 * freedoms + 3 + n, packed_row(freedoms) + packed_row(freedoms + 3)];
            let mut rooms: Vec<[Vec<f64>; 2]> =
                slipped.iter().map(|_| sizes.map(|size| vec![f64::NAN; size])).collect();
            for isa in instructions() {
                let mut elements: Vec<BatchElement<'_>> = slipped
                    .iter()
                    .zip(&mut rooms)
                    .map(|(slipped, [gradient, hessian])| BatchElement {
                        inputs: ElementInputs { anchor: slipped.anchor, ..slipped.case.inputs() },
                        values: GapValues::NONE,
                        gradient,
                        hessian,
                        places: &[],
                    })
                    .collect();
                batch(
                    isa,
                    (Basis::Quadratic, frame, Mode::Hessian),
                    &mut elements,
                    &mut Workspace::default(),
                );
                for (element, slipped) in elements.iter().zip(&slipped) {
                    let one = slipped.by(&Generated, Mode::Hessian);
                    assert_close(&[element.values.slip], &[one.half_square], TOLERANCE, "q");
                    let expected = [&one.contact.gradient[..], &one.gradient, &one.foot_weights].concat();
                    assert_close(element.gradient, &expected, TOLERANCE, "N, ∇q, φ");
                    let (gap, slip) = element.hessian.split_at(packed_row(freedoms));
                    assert_close(gap, one.contact.hessian.packed(), TOLERANCE, "M");
                    assert_close(slip, one.hessian.packed(), TOLERANCE, "∇²q");
                }
            }
        }
    }
}

#[test]
fn a_rigid_motion_changes_no_slip_and_turns_its_force() {
    for slipped in all(&[11]) {
        let q = Random::new(5).rotation();
        let turned = Slipped { case: slipped.case.turned(&q), anchor: turn(&q, slipped.anchor) };
        let [here, there] = [&slipped, &turned].map(|x| x.by(&Generated, Mode::Gradient));
        assert_close(&[there.half_square], &[here.half_square], TOLERANCE, "q");
        let expected: Vec<f64> =
            here.gradient.chunks_exact(3).flat_map(|part| turn(&q, [part[0], part[1], part[2]])).collect();
        assert_close(&there.gradient, &expected, TOLERANCE, "∇q");
    }
}

/// −∂R/∂x by central differences of R = −c ∇q under the penalty's force.
#[test]
fn the_tangent_of_friction_is_its_force_differentiated() {
    const PENALTY: f64 = 100.0;
    for (state, coefficient, stiffness) in
        [(FrictionState::Stick, 50.0, 30.0), (FrictionState::Slip, 0.2, 3000.0)]
    {
        for slipped in all(&[8]) {
            let law = Coulomb::new(coefficient, stiffness).unwrap();
            let force = |slip: &Slip| {
                // Pressed whatever the side: the force is linear in the gap.
                let normal = NormalForce { force: 60.0 - PENALTY * slip.contact.gap, stiffness: PENALTY };
                law.force(normal, slip.half_square)
            };
            let slip = slipped.by(&Generated, Mode::Hessian);
            let friction = force(&slip);
            assert_eq!(friction.state, state);
            let tangent = friction.tangent(&slip);
            let h = 1e-5;
            let size = tangent.iter().map(|row| largest(row)).fold(0.0, f64::max);
            let count = slipped.points().len();
            // A frame that moves is the plane of where the nodes are, but the anchor does not turn it.
            let held = slipped.case.element().frame.derivative == FrameDerivative::Held;
            for point in if held { 0 } else { count - 1 }..count {
                for axis in 0..3 {
                    let moved = |step: f64| {
                        let slip = slipped.moved(point, axis, step).by(&Generated, Mode::Gradient);
                        force(&slip).contact_force(&slip)
                    };
                    let (plus, minus) = (moved(h), moved(-h));
                    for (p, row) in tangent.iter().enumerate() {
                        let (found, expected) = (row[3 * point + axis], -(plus[p] - minus[p]) / (2.0 * h));
                        assert!((found - expected).abs() <= 1e-6 * size, "{p}: {found} {expected}");
                    }
                }
            }
        }
    }
}
