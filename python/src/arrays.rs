//! Slices of arrays. The Python part passes contiguous arrays of the right type, which is checked here once more.

use diffuse_contact::Point;
use diffuse_contact::assembly::Triplets;
use diffuse_contact::faces::QuadraticFace;
use diffuse_contact::surface::Facet;
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray, PyReadwriteArray};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyString};

use crate::errors;

pub type Numbers<'py> = Bound<'py, PyArray1<f64>>;
pub type Indices<'py> = Bound<'py, PyArray1<i64>>;

/// A list of words, of which there are few different ones: each is one object, however often it stands there.
pub fn words<'py>(
    py: Python<'py>,
    words: impl ExactSizeIterator<Item = &'static str>,
) -> PyResult<Bound<'py, PyList>> {
    let mut known: Vec<(&'static str, Bound<'py, PyString>)> = Vec::new();
    let texts = words.map(|word| match known.iter().find(|(other, _)| *other == word) {
        Some((_, text)) => text.clone(),
        None => {
            let text = PyString::new(py, word);
            known.push((word, text.clone()));
            text
        }
    });
    PyList::new(py, texts)
}

/// Read access to an array.
pub fn readable<'py, T: Element, D: numpy::ndarray::Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    array.try_readonly().map_err(|_| errors::busy(array.py(), "an array"))
}

/// Write access to an array.
pub fn writable<'py, T: Element, D: numpy::ndarray::Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    array.try_readwrite().map_err(|_| errors::busy(array.py(), "an array (or it is read-only)"))
}

/// The numbers of an array.
pub fn slice<'a, T: Element, D: numpy::ndarray::Dimension>(
    py: Python<'_>,
    array: &'a PyReadonlyArray<'_, T, D>,
) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| not_contiguous(py))
}

/// The numbers of an array, to be written.
pub fn slice_mut<'a, T: Element, D: numpy::ndarray::Dimension>(
    py: Python<'_>,
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [T]> {
    array.as_slice_mut().map_err(|_| not_contiguous(py))
}

fn not_contiguous(py: Python<'_>) -> PyErr {
    errors::input(py, "wrong-array", "the array is not contiguous")
}

/// An array of shape (…, 3) as points.
pub fn points<'a, D: numpy::ndarray::Dimension>(
    py: Python<'_>,
    array: &'a PyReadonlyArray<'_, f64, D>,
) -> PyResult<&'a [Point]> {
    match slice(py, array)?.as_chunks::<3>() {
        (points, []) => Ok(points),
        _ => Err(errors::input(py, "wrong-shape", "the last axis has to be 3 coordinates")),
    }
}

/// Node indices.
pub fn indices<D: numpy::ndarray::Dimension>(
    py: Python<'_>,
    what: &str,
    array: &PyReadonlyArray<'_, i64, D>,
) -> PyResult<Vec<usize>> {
    let index = |&index: &i64| {
        usize::try_from(index).map_err(|_| {
            errors::input(py, "negative-index", &format!("{what}: the index {index} is negative"))
        })
    };
    slice(py, array)?.iter().map(index).collect()
}

/// Rows of 6, 8 or 9 nodes, of all arrays.
pub fn quadratic_faces(py: Python<'_>, arrays: &[Bound<'_, PyArray2<i64>>]) -> PyResult<Vec<QuadraticFace>> {
    let mut faces = Vec::new();
    for array in arrays {
        let array = readable(array)?;
        let width = array.as_array().ncols();
        for row in indices(py, "quadratic", &array)?.chunks(width.max(1)) {
            let message = format!("quadratic: faces have 6, 8 or 9 nodes, not {width}");
            faces.push(QuadraticFace::new(row).ok_or_else(|| errors::input(py, "wrong-shape", &message))?);
        }
    }
    Ok(faces)
}

/// Rows, columns and values.
pub fn of_triplets<'py>(py: Python<'py>, triplets: &Triplets) -> (Indices<'py>, Indices<'py>, Numbers<'py>) {
    let indices = |all: &[usize]| PyArray1::from_iter(py, all.iter().map(|&index| index as i64));
    let values = PyArray1::from_slice(py, triplets.values());
    (indices(triplets.rows()), indices(triplets.columns()), values)
}

/// Rows of four corners, the last one −1 for a triangle.
pub fn facets<D: numpy::ndarray::Dimension>(
    py: Python<'_>,
    array: &PyReadonlyArray<'_, i64, D>,
) -> PyResult<Vec<Facet>> {
    let (rows, rest) = slice(py, array)?.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(errors::input(py, "wrong-shape", "facets have rows of 4 corners"));
    }
    let facet = |(number, row): (usize, &[i64; 4])| match row.map(usize::try_from) {
        [Ok(a), Ok(b), Ok(c), Ok(d)] => Ok(Facet::Quadrilateral([a, b, c, d])),
        [Ok(a), Ok(b), Ok(c), Err(_)] if row[3] == -1 => Ok(Facet::Triangle([a, b, c])),
        _ => {
            let message = format!(
                "facet {number} has a negative corner, which only the fourth may be: −1 for a triangle"
            );
            Err(errors::input(py, "negative-index", &message))
        }
    };
    rows.iter().enumerate().map(facet).collect()
}
