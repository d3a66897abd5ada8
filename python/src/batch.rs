//! Many elements on arrays.

use diffuse_contact::{
    Basis, BatchScratch, ContactPoint, Element, ElementError, Frame, FrameDerivative, GapSlot, Generated,
    Mode, Point, Weight, pairing,
};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray, PyReadwriteArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{points, readable, slice_mut, writable};
use crate::errors::{self, Raise};
use crate::{options, threads};

/// Elements that one thread evaluates in a row: a multiple of what goes into the widest vectors at once, few enough for
/// their packed Hessians to stay in the cache until they are written out.
const PIECE: usize = 64;

/// What a number in `status` means. Numbers never change; new codes come behind the last.
pub const STATUS_CODES: [&str; 16] = [
    "ok",
    "too-few-nodes",
    "no-kernels",
    "anisotropic-basis",
    "non-finite-input",
    "invalid-support-radius",
    "invalid-frame",
    "ambiguous-outward",
    "no-average-plane",
    "not-average-plane",
    "singular-fit",
    "foot-diverged",
    "foot-outside",
    "centre-of-curvature",
    "beyond-centre-of-curvature",
    "overflow",
];
/// The status of an error without a code above.
const OTHER: u8 = u8::MAX;

fn status_of(error: &ElementError) -> u8 {
    let place = STATUS_CODES.iter().position(|&code| code == error.code());
    place.and_then(|place| u8::try_from(place).ok()).unwrap_or(OTHER)
}

/// What is common to the elements.
#[derive(Clone, Copy)]
struct Kind {
    basis: Basis,
    weight: Weight,
    derivative: FrameDerivative,
    mode: Mode,
    /// Whether M is written as its packed lower triangle.
    packed: bool,
    /// Masters of each element.
    masters: usize,
}

impl Kind {
    const fn freedoms(&self) -> usize {
        3 * (self.masters + 1)
    }

    const fn packed_size(&self) -> usize {
        self.freedoms() * (self.freedoms() + 1) / 2
    }

    /// Numbers of N of one element.
    fn gradient_size(&self) -> usize {
        if self.mode >= Mode::Gradient { self.freedoms() } else { 0 }
    }

    /// Numbers of M of one element as it is written.
    fn hessian_size(&self) -> usize {
        match (self.mode, self.packed) {
            (Mode::Hessian, true) => self.packed_size(),
            (Mode::Hessian, false) => self.freedoms() * self.freedoms(),
            _ => 0,
        }
    }
}

/// The elements. What has a single entry is the same for all.
#[derive(Clone, Copy)]
struct Inputs<'a> {
    kind: Kind,
    slaves: &'a [Point],
    masters: &'a [Point],
    outward: &'a [Point],
    /// t1, t2, n̂ of each; none for the average plane.
    frames: Option<&'a [Point]>,
    radii: Option<&'a [f64]>,
}

impl<'a> Inputs<'a> {
    fn element(&self, k: usize) -> Result<Element<'a>, ElementError> {
        let Kind { basis, weight, derivative, masters: count, .. } = self.kind;
        if count < basis.size() {
            return Err(ElementError::TooFewNodes { found: count, needed: basis.size() });
        }
        let masters = &self.masters[k * count..(k + 1) * count];
        let slave = self.slaves[k];
        let frame = match self.frames {
            Some(frames) => {
                let [t1, t2, normal] = of(frames.as_chunks::<3>().0, k);
                let outward = (!self.outward.is_empty()).then(|| of(self.outward, k));
                Frame::given([0.0; 3], t1, t2, normal, outward)?
            }
            None => Frame { derivative, ..Frame::average_plane(masters, of(self.outward, k))? },
        };
        let support_radius = match self.radii {
            Some(radii) => of(radii, k),
            None => pairing::support_radius(&frame, slave, masters),
        };
        Ok(Element::new(slave, masters, frame, support_radius).with_basis(basis).with_weight(weight))
    }
}

/// The `k`-th of many, or the only one.
fn of<T: Copy>(values: &[T], k: usize) -> T {
    if values.len() == 1 { values[0] } else { values[k] }
}

/// Where the results of consecutive elements go.
struct Outputs<'a> {
    first: usize,
    gap: &'a mut [f64],
    foot: &'a mut [Point],
    normal: &'a mut [Point],
    gradient: &'a mut [f64],
    hessian: &'a mut [f64],
    status: &'a mut [u8],
}

impl Outputs<'_> {
    /// The same in pieces.
    fn pieces(self, kind: Kind) -> Vec<Self> {
        let mut pieces = Vec::with_capacity(self.gap.len().div_ceil(PIECE));
        let mut rest = self;
        while rest.gap.len() > PIECE {
            let (gap, more_gap) = rest.gap.split_at_mut(PIECE);
            let (foot, more_foot) = rest.foot.split_at_mut(PIECE);
            let (normal, more_normal) = rest.normal.split_at_mut(PIECE);
            let (gradient, more_gradient) = rest.gradient.split_at_mut(PIECE * kind.gradient_size());
            let (hessian, more_hessian) = rest.hessian.split_at_mut(PIECE * kind.hessian_size());
            let (status, more_status) = rest.status.split_at_mut(PIECE);
            let first = rest.first;
            pieces.push(Outputs { first, gap, foot, normal, gradient, hessian, status });
            rest = Outputs {
                first: first + PIECE,
                gap: more_gap,
                foot: more_foot,
                normal: more_normal,
                gradient: more_gradient,
                hessian: more_hessian,
                status: more_status,
            };
        }
        pieces.push(rest);
        pieces
    }
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    batch: BatchScratch,
    /// Packed Hessians of a piece, where they are written in full.
    packed: Vec<f64>,
}

/// Evaluates a piece; the first element without a result, and why.
fn evaluate(
    inputs: &Inputs<'_>,
    outputs: Outputs<'_>,
    scratch: &mut Scratch,
) -> Option<(usize, ElementError)> {
    let kind = inputs.kind;
    let Outputs { first, gap, foot, normal, gradient, hessian, status } = outputs;
    let count = gap.len();
    let in_full = kind.mode == Mode::Hessian && !kind.packed;
    let Scratch { batch, packed } = scratch;
    packed.resize(if in_full { count * kind.packed_size() } else { 0 }, 0.0);
    let mut gradients = gradient.chunks_exact_mut(kind.gradient_size().max(1));
    let target = if in_full { packed.as_mut_slice() } else { &mut *hessian };
    let mut hessians = target.chunks_exact_mut(kind.packed_size());
    let (mut elements, mut slots) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut unsound = Vec::new();
    for k in 0..count {
        let (gradient, hessian) = (gradients.next().unwrap_or_default(), hessians.next().unwrap_or_default());
        match inputs.element(first + k) {
            Ok(element) => {
                elements.push(element);
                slots.push(GapSlot { gradient, hessian });
            }
            Err(error) => unsound.push((k, error)),
        }
    }
    let points = Generated.gap_batch(&elements, kind.mode, slots, batch);
    let (mut points, mut unsound) = (points.into_iter(), unsound.into_iter().peekable());
    let mut failed = None;
    for k in 0..count {
        // Sound elements have their point, in their order.
        let result = match unsound.next_if(|(unsound, _)| *unsound == k) {
            Some((_, error)) => Err(error),
            None => points.next().unwrap_or(Err(ElementError::Overflow { what: "result" })),
        };
        match result {
            Ok(ContactPoint { gap: g, foot: x, normal: n }) => {
                (gap[k], foot[k], normal[k], status[k]) = (g, x, n, 0);
                if in_full {
                    let size = kind.packed_size();
                    write_full(kind.freedoms(), &packed[k * size..(k + 1) * size], hessian, k);
                }
            }
            Err(error) => {
                (gap[k], foot[k], normal[k], status[k]) =
                    (f64::NAN, [f64::NAN; 3], [f64::NAN; 3], status_of(&error));
                let (n, m) = (kind.gradient_size(), kind.hessian_size());
                gradient[k * n..(k + 1) * n].fill(f64::NAN);
                hessian[k * m..(k + 1) * m].fill(f64::NAN);
                failed = failed.or(Some((first + k, error)));
            }
        }
    }
    failed
}

/// Writes the `k`-th symmetric matrix out.
fn write_full(size: usize, packed: &[f64], full: &mut [f64], k: usize) {
    let full = &mut full[k * size * size..(k + 1) * size * size];
    let mut start = 0;
    for i in 0..size {
        let row = &packed[start..start + i + 1];
        full[i * size..i * size + i + 1].copy_from_slice(row);
        for (j, &value) in row[..i].iter().enumerate() {
            full[j * size + i] = value;
        }
        start += i + 1;
    }
}

/// The arrays of elements, attributes of a Python object. `outward`, `frames` and `support_radius` have one entry for
/// each element, or one for all; `outward` may have none if there are frames.
#[derive(FromPyObject)]
pub struct InputArrays<'py> {
    slaves: Bound<'py, PyArray2<f64>>,
    masters: Bound<'py, PyArray3<f64>>,
    outward: Bound<'py, PyArray2<f64>>,
    frames: Option<Bound<'py, PyArray3<f64>>>,
    support_radius: Option<Bound<'py, PyArray1<f64>>>,
    basis: String,
    weight: String,
    frame_derivative: String,
}

/// The arrays of results, attributes of a Python object; those of derivatives that are not asked for are empty.
#[derive(FromPyObject)]
pub struct OutputArrays<'py> {
    gap: Bound<'py, PyArray1<f64>>,
    foot: Bound<'py, PyArray2<f64>>,
    normal: Bound<'py, PyArray2<f64>>,
    gradient: Bound<'py, PyArray1<f64>>,
    hessian: Bound<'py, PyArray1<f64>>,
    status: Bound<'py, PyArray1<u8>>,
}

/// Evaluates all elements. Returns index, code and message of the first one without a result, if there is one.
#[pyfunction]
pub fn gap_batch(
    py: Python<'_>,
    inputs: InputArrays<'_>,
    outputs: OutputArrays<'_>,
    mode: &str,
    packed: bool,
) -> PyResult<Option<(usize, &'static str, String)>> {
    let kind = Kind {
        basis: options::basis(py, &inputs.basis)?,
        weight: options::weight(py, &inputs.weight)?,
        derivative: options::frame_derivative(py, &inputs.frame_derivative)?,
        mode: options::mode(py, mode)?,
        packed,
        masters: inputs.masters.shape()[1],
    };
    let slaves = readable(&inputs.slaves)?;
    let masters = readable(&inputs.masters)?;
    let outward = readable(&inputs.outward)?;
    let frames = inputs.frames.as_ref().map(readable).transpose()?;
    let radii = inputs.support_radius.as_ref().map(readable).transpose()?;
    let elements = Inputs {
        kind,
        slaves: points(py, &slaves)?,
        masters: points(py, &masters)?,
        outward: points(py, &outward)?,
        frames: frames.as_ref().map(|frames| points(py, frames)).transpose()?,
        radii: radii
            .as_ref()
            .map(|radii: &PyReadonlyArray<'_, f64, _>| crate::arrays::slice(py, radii))
            .transpose()?,
    };
    let mut gap = writable(&outputs.gap)?;
    let mut foot = writable(&outputs.foot)?;
    let mut normal = writable(&outputs.normal)?;
    let mut gradient = writable(&outputs.gradient)?;
    let mut hessian = writable(&outputs.hessian)?;
    let mut status = writable(&outputs.status)?;
    let results = Outputs {
        first: 0,
        gap: slice_mut(py, &mut gap)?,
        foot: points_mut(py, &mut foot)?,
        normal: points_mut(py, &mut normal)?,
        gradient: slice_mut(py, &mut gradient)?,
        hessian: slice_mut(py, &mut hessian)?,
        status: slice_mut(py, &mut status)?,
    };
    check(py, &elements, &results)?;
    let failed = evaluate_all(py, &elements, results.pieces(kind));
    Ok(failed.map(|(index, error)| (index, error.stable_code(), error.to_string())))
}

/// Evaluates all pieces, on threads. The first element that fails, with the reason.
fn evaluate_all(
    py: Python<'_>,
    elements: &Inputs<'_>,
    pieces: Vec<Outputs<'_>>,
) -> Option<(usize, ElementError)> {
    if threads::thread_count() == 1 {
        // Handing a batch over to another thread and waiting for it takes as long as several elements.
        py.detach(|| {
            let mut scratch = Scratch::default();
            let failed = pieces.into_iter().filter_map(|piece| evaluate(elements, piece, &mut scratch));
            failed.min_by_key(|(index, _)| *index)
        })
    } else {
        threads::run(py, || {
            let failed = pieces
                .into_par_iter()
                .map_init(Scratch::default, |scratch, piece| evaluate(elements, piece, scratch));
            failed.flatten_iter().min_by_key(|(index, _)| *index)
        })
    }
}

fn points_mut<'a>(
    py: Python<'_>,
    array: &'a mut PyReadwriteArray<'_, f64, numpy::Ix2>,
) -> PyResult<&'a mut [Point]> {
    match slice_mut(py, array)?.as_chunks_mut::<3>() {
        (points, []) => Ok(points),
        _ => Err(errors::input(py, "wrong-shape", "the last axis has to be 3 coordinates")),
    }
}

/// Checks that all arrays have the sizes that follow from the number of slaves.
fn check(py: Python<'_>, inputs: &Inputs<'_>, outputs: &Outputs<'_>) -> PyResult<()> {
    let (count, kind) = (inputs.slaves.len(), inputs.kind);
    let one_or_each =
        |found: usize, size: usize| if found == size { size } else { count.saturating_mul(size) };
    let outward = inputs.outward.len();
    let without = inputs.frames.is_some() && outward == 0;
    let sizes = [
        ("masters", inputs.masters.len(), count.saturating_mul(kind.masters)),
        ("outward", outward, if without { 0 } else { one_or_each(outward, 1) }),
        (
            "frames",
            inputs.frames.map_or(0, <[_]>::len),
            inputs.frames.map_or(0, |frames| one_or_each(frames.len(), 3)),
        ),
        (
            "support_radius",
            inputs.radii.map_or(0, <[_]>::len),
            inputs.radii.map_or(0, |radii| one_or_each(radii.len(), 1)),
        ),
        ("gap", outputs.gap.len(), count),
        ("foot", outputs.foot.len(), count),
        ("normal", outputs.normal.len(), count),
        ("status", outputs.status.len(), count),
        ("gradient", outputs.gradient.len(), count.saturating_mul(kind.gradient_size())),
        ("hessian", outputs.hessian.len(), count.saturating_mul(kind.hessian_size())),
    ];
    for (name, found, expected) in sizes {
        if found != expected {
            let message = format!("{name} has {found} entries, but {count} slaves need {expected}");
            return Err(errors::input(py, "wrong-shape", &message));
        }
    }
    Ok(())
}
