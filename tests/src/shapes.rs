//! Generated kernels in both shapes, with guards around everything they write.

use diffuse_contact::{Basis, Gap, Mode, SymmetricMatrix};
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::cubic_interpolating::CubicInterpolating;
use diffuse_contact_kernels::support::{
    BatchElement, ElementInputs, FormRows, FrameRule, GapValues, Isa, KernelSet, SecondKind, Status,
    Workspace, packed_row,
};
use diffuse_contact_kernels::wendland_c2::WendlandC2;

use crate::Case;
use crate::weights::{matern::Matern, spline::Spline};

/// Which kernel of a set.
pub type Kernel = (Basis, FrameRule, Mode);

type Single = fn(Isa, Kernel, &ElementInputs<'_>, &mut [f64], &mut [f64]) -> GapValues<f64>;
type Batch = fn(Isa, Kernel, &mut [BatchElement<'_>], &mut Workspace);
/// Which kernel gives factors.
type Factored = (Basis, FrameRule);
type SingleFactors =
    fn(Isa, Factored, SecondKind, &ElementInputs<'_>, &mut [f64], &mut [f64]) -> GapValues<f64>;
type BatchFactors = fn(Isa, Factored, SecondKind, &mut [BatchElement<'_>], &mut Workspace);

/// The kernels for the gap of one weight, whatever their type.
#[derive(Clone, Copy, Debug)]
pub struct GapKernels {
    /// Name of the weight.
    pub weight: &'static str,
    single: Single,
    batch: Batch,
    form: fn(Factored, usize) -> FormRows,
    single_factors: SingleFactors,
    batch_factors: BatchFactors,
}

/// The built-in weights and two of one's own: an expansion with a formula beyond it, and two branches.
pub const GAP_KERNELS: [GapKernels; 5] = [
    GapKernels::of::<Cubic>("cubic"),
    GapKernels::of::<CubicInterpolating>("cubic_interpolating"),
    GapKernels::of::<WendlandC2>("wendland_c2"),
    GapKernels::of::<Matern>("matern"),
    GapKernels::of::<Spline>("spline"),
];

/// What a kernel made of one element.
#[derive(Clone, Debug)]
pub struct Found {
    /// Values.
    pub values: GapValues<f64>,
    /// N, as far as the mode has it.
    pub gradient: Vec<f64>,
    /// Packed lower triangle of M, as far as the mode has it.
    pub hessian: Vec<f64>,
}

impl GapKernels {
    const fn of<K: KernelSet>(weight: &'static str) -> Self {
        Self {
            weight,
            single: K::gap,
            batch: K::gap_batch,
            form: K::gap_form,
            single_factors: K::gap_factors,
            batch_factors: K::gap_factors_batch,
        }
    }

    /// The form of M of an element.
    #[must_use]
    pub fn form(&self, (basis, frame, _): Kernel, case: &Case) -> FormRows {
        (self.form)((basis, frame), case.masters.len())
    }

    /// One element by itself, with the factors of M or its rows of the slave in the place of M. Slices are longer than needed by `spare`
    /// numbers.
    ///
    /// # Panics
    /// If something is not written, or written that should not be.
    #[track_caller]
    #[must_use]
    pub fn single_second(
        &self,
        isa: Isa,
        kernel: Kernel,
        kind: SecondKind,
        case: &Case,
        spare: usize,
    ) -> Found {
        let [mut gradient, mut second] = self.room_of_second(kernel, kind, case, spare);
        let (basis, frame, _) = kernel;
        let (inputs, numbers) = (case.inputs(), second.numbers_mut());
        let values =
            (self.single_factors)(isa, (basis, frame), kind, &inputs, gradient.numbers_mut(), numbers);
        Found { values, gradient: gradient.written(), hessian: second.written() }
    }

    /// The same of elements side by side.
    ///
    /// # Panics
    /// If something is not written, or written that should not be.
    #[track_caller]
    #[must_use]
    pub fn batch_second(
        &self,
        isa: Isa,
        kernel: Kernel,
        kind: SecondKind,
        (cases, workspace): (&[&Case], &mut Workspace),
        spare: usize,
    ) -> Vec<Found> {
        let rooms = cases.iter().map(|case| self.room_of_second(kernel, kind, case, spare)).collect();
        let (basis, frame, _) = kernel;
        in_batch(cases, rooms, |elements| {
            (self.batch_factors)(isa, (basis, frame), kind, elements, workspace)
        })
    }

    fn room_of_second(&self, kernel: Kernel, kind: SecondKind, case: &Case, spare: usize) -> [Guarded; 2] {
        let rows = self.form(kernel, case);
        let second = match kind {
            SecondKind::Hessians => packed_row(freedoms(case)),
            SecondKind::Factors => rows.factors(),
            SecondKind::FactorsAndFoot => rows.foot_numbers(),
            SecondKind::SlaveRows => rows.slave_rows(),
        };
        [freedoms(case), second].map(|needed| Guarded::new(needed, spare))
    }

    /// One element by itself. Slices are longer than needed by `spare` numbers.
    ///
    /// # Panics
    /// If something is not written, or written that should not be.
    #[track_caller]
    #[must_use]
    pub fn single(&self, isa: Isa, kernel: Kernel, case: &Case, spare: usize) -> Found {
        let [mut gradient, mut hessian] = room(kernel.2, case, spare);
        let values =
            (self.single)(isa, kernel, &case.inputs(), gradient.numbers_mut(), hessian.numbers_mut());
        Found { values, gradient: gradient.written(), hessian: hessian.written() }
    }

    /// Elements side by side, in the order given. Slices are longer than needed by `spare` numbers.
    ///
    /// # Panics
    /// If something is not written, or written that should not be.
    #[track_caller]
    #[must_use]
    pub fn batch(
        &self,
        isa: Isa,
        kernel: Kernel,
        cases: &[&Case],
        workspace: &mut Workspace,
        spare: usize,
    ) -> Vec<Found> {
        let rooms = cases.iter().map(|case| room(kernel.2, case, spare)).collect();
        in_batch(cases, rooms, |elements| (self.batch)(isa, kernel, elements, workspace))
    }

    /// Elements side by side, with slices as they are.
    pub fn run_batch(
        &self,
        isa: Isa,
        kernel: Kernel,
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    ) {
        (self.batch)(isa, kernel, elements, workspace);
    }

    /// One element by itself, with slices as they are.
    pub fn run_single(
        &self,
        isa: Isa,
        kernel: Kernel,
        inputs: &ElementInputs<'_>,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> GapValues<f64> {
        (self.single)(isa, kernel, inputs, gradient, hessian)
    }
}

/// Elements that something evaluates side by side.
#[track_caller]
fn in_batch(
    cases: &[&Case],
    mut rooms: Vec<[Guarded; 2]>,
    evaluate: impl FnOnce(&mut [BatchElement<'_>]),
) -> Vec<Found> {
    let mut elements: Vec<BatchElement<'_>> = cases
        .iter()
        .zip(&mut rooms)
        .map(|(case, [gradient, hessian])| BatchElement {
            inputs: case.inputs(),
            values: GapValues::NONE,
            gradient: gradient.numbers_mut(),
            hessian: hessian.numbers_mut(),
            places: &[],
        })
        .collect();
    evaluate(&mut elements);
    let values: Vec<GapValues<f64>> = elements.iter().map(|element| element.values).collect();
    let found = values.into_iter().zip(rooms);
    found
        .map(|(values, [gradient, hessian])| Found {
            values,
            gradient: gradient.written(),
            hessian: hessian.written(),
        })
        .collect()
}

impl Found {
    /// Whether it is a result.
    #[must_use]
    pub fn status(&self) -> Status {
        self.values.status()
    }

    /// All of it as bits; NaNs are one whatever their sign and payload.
    #[must_use]
    pub fn bits(&self) -> Vec<u64> {
        let GapValues {
            gap,
            foot,
            normal,
            slip,
            coefficients,
            pivot_ratio,
            plane_pivot_ratio,
            foot_residual,
            foot_iterations,
            foot_distance,
            jacobian_determinant,
            jacobian_trace,
            checksum,
        } = self.values;
        let figures = [
            gap,
            slip,
            pivot_ratio,
            plane_pivot_ratio,
            foot_residual,
            foot_iterations,
            foot_distance,
            jacobian_determinant,
            jacobian_trace,
            checksum,
        ];
        let all = [&figures[..], &foot, &normal, &coefficients, &self.gradient, &self.hessian].concat();
        all.into_iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
    }

    /// As backends return it.
    #[must_use]
    pub fn gap(&self, case: &Case) -> Gap {
        let mut hessian = SymmetricMatrix::zeros(if self.hessian.is_empty() { 0 } else { freedoms(case) });
        hessian.packed_mut().copy_from_slice(&self.hessian);
        Gap {
            gap: self.values.gap,
            foot: self.values.foot,
            normal: self.values.normal,
            coefficients: self.values.coefficients[..case.basis.size()].to_vec(),
            gradient: self.gradient.clone(),
            hessian,
        }
    }
}

/// Entries of N and of the packed lower triangle of M that a mode computes.
#[must_use]
pub fn output_sizes(mode: Mode, case: &Case) -> [usize; 2] {
    let freedoms = freedoms(case);
    match mode {
        Mode::Value => [0, 0],
        Mode::Gradient => [freedoms, 0],
        Mode::Hessian => [freedoms, packed_row(freedoms)],
    }
}

fn freedoms(case: &Case) -> usize {
    case.element().degrees_of_freedom()
}

fn room(mode: Mode, case: &Case, spare: usize) -> [Guarded; 2] {
    output_sizes(mode, case).map(|needed| Guarded::new(needed, spare))
}

/// The instructions that the kernels are compiled for: without optimisation numbers only.
pub fn instructions() -> impl Iterator<Item = Isa> {
    Isa::available().filter(|isa| Cubic::OPTIMISED || *isa == Isa::SCALAR)
}

/// Numbers before and after a slice: the widest vectors have eight.
const GUARDS: usize = 16;
/// What nobody else writes: NaNs with a payload of their own.
const GUARD: u64 = 0x7ff8_0000_6172_6421;
const UNWRITTEN: u64 = 0x7ff8_0000_7761_6974;

/// A slice to write to, among numbers that are to stay what they are.
struct Guarded {
    numbers: Vec<f64>,
    needed: usize,
    spare: usize,
}

impl Guarded {
    fn new(needed: usize, spare: usize) -> Self {
        let guards = |count| std::iter::repeat_n(f64::from_bits(GUARD), count);
        let unwritten = std::iter::repeat_n(f64::from_bits(UNWRITTEN), needed);
        let numbers = guards(GUARDS).chain(unwritten).chain(guards(spare + GUARDS)).collect();
        Self { numbers, needed, spare }
    }

    fn numbers_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[GUARDS..][..self.needed + self.spare]
    }

    /// What has been written.
    #[track_caller]
    fn written(self) -> Vec<f64> {
        let (before, rest) = self.numbers.split_at(GUARDS);
        let (written, after) = rest.split_at(self.needed);
        let is_left = |number: &f64| number.to_bits() == GUARD;
        assert!(before.iter().all(is_left), "written before the slice");
        assert!(after.iter().all(is_left), "written after the {} numbers needed", self.needed);
        let missing = written.iter().position(|number| number.to_bits() == UNWRITTEN);
        assert_eq!(missing, None, "not written, of {}", self.needed);
        written.to_vec()
    }
}
