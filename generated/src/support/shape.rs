//! How elements and their nodes are laid out in vectors: kernels are written once for all layouts.

use std::marker::PhantomData;

use super::Lane;
use super::simd::Vector;

/// A layout of elements and nodes.
///
/// A kernel has values of *element scope*, one per element, and of *node scope*, one per master node. In a
/// [`Batch`] each lane is an element of its own and a node value belongs to the same node of all of them; in a
/// [`Single`] there is one element and the lanes are its nodes.
pub trait Shape {
    /// A value of element scope.
    type Element: Lane;
    /// A value of node scope.
    type Node: Lane;
    /// What results are made of.
    type Output: Copy;
    /// Nodes side by side in one node value.
    const NODES: usize;

    /// Element values for all nodes.
    fn spread<const VALUES: usize>(values: [Self::Element; VALUES]) -> [Self::Node; VALUES];

    /// Sums over the nodes of values that were added up with [`keep`](Self::keep).
    fn total<const VALUES: usize>(values: [Self::Node; VALUES]) -> [Self::Element; VALUES];

    /// The number of each node, from `first` on.
    fn node_index(first: usize) -> Self::Node;

    /// `new` for the nodes below `count`, `old` for what only fills the last vector.
    fn keep(node_index: Self::Node, count: usize, new: Self::Node, old: Self::Node) -> Self::Node;

    /// Values of one of the nodes side by side, for all of them.
    fn pick<const VALUES: usize>(values: [&Self::Node; VALUES], node: usize) -> [Self::Node; VALUES];

    /// An element value as a result.
    fn element_output(value: Self::Element) -> Self::Output;

    /// Calls `write` for each node from `first` on, below `count`, with its number and results.
    fn for_each_node<const RESULTS: usize>(
        first: usize,
        count: usize,
        values: [Self::Node; RESULTS],
        write: impl FnMut(usize, [Self::Output; RESULTS]),
    );

    /// Writes the results of nodes side by side, x, y and z of each, as many as `target` takes.
    fn write_nodes(values: [Self::Node; 3], target: &mut [Self::Output]);
}

/// Elements side by side, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Batch<T>(PhantomData<T>);

impl<T: Lane> Shape for Batch<T> {
    type Element = T;
    type Node = T;
    type Output = T;
    const NODES: usize = 1;

    #[inline(always)]
    fn spread<const VALUES: usize>(values: [T; VALUES]) -> [T; VALUES] {
        values
    }

    #[inline(always)]
    fn total<const VALUES: usize>(values: [T; VALUES]) -> [T; VALUES] {
        values
    }

    #[inline(always)]
    fn node_index(first: usize) -> T {
        T::splat(first as f64)
    }

    #[inline(always)]
    fn keep(_: T, _: usize, new: T, _: T) -> T {
        new
    }

    #[inline(always)]
    fn pick<const VALUES: usize>(values: [&T; VALUES], _: usize) -> [T; VALUES] {
        // Not `map`, which is not always inlined.
        let mut picked = [T::ZERO; VALUES];
        for (picked, value) in picked.iter_mut().zip(values) {
            *picked = *value;
        }
        picked
    }

    #[inline(always)]
    fn element_output(value: T) -> T {
        value
    }

    #[inline(always)]
    fn for_each_node<const RESULTS: usize>(
        first: usize,
        _: usize,
        values: [T; RESULTS],
        mut write: impl FnMut(usize, [T; RESULTS]),
    ) {
        write(first, values);
    }

    #[inline(always)]
    fn write_nodes(values: [T; 3], target: &mut [T]) {
        target.copy_from_slice(&values);
    }
}

/// The nodes of one element side by side.
#[derive(Clone, Copy, Debug)]
pub struct Single<T>(PhantomData<T>);

impl<T: Vector> Shape for Single<T> {
    type Element = T::Scalar;
    type Node = T;
    type Output = f64;
    const NODES: usize = T::WIDTH;

    #[inline(always)]
    fn spread<const VALUES: usize>(values: [T::Scalar; VALUES]) -> [T; VALUES] {
        let mut spread = [T::ZERO; VALUES];
        for (spread, value) in spread.iter_mut().zip(&values) {
            *spread = T::splat(value.lane(0));
        }
        spread
    }

    #[inline(always)]
    fn total<const VALUES: usize>(values: [T; VALUES]) -> [T::Scalar; VALUES] {
        let mut totals = [T::Scalar::ZERO; VALUES];
        for (total, value) in totals.iter_mut().zip(&values) {
            *total = T::Scalar::splat(value.sum());
        }
        totals
    }

    #[inline(always)]
    fn node_index(first: usize) -> T {
        T::from_fn(|k| (first + k) as f64)
    }

    #[inline(always)]
    fn keep(node_index: T, count: usize, new: T, old: T) -> T {
        T::select_less(node_index, T::splat(count as f64), new, old)
    }

    #[inline(always)]
    fn pick<const VALUES: usize>(values: [&T; VALUES], node: usize) -> [T; VALUES] {
        let mut picked = [T::ZERO; VALUES];
        for (picked, value) in picked.iter_mut().zip(values) {
            *picked = T::splat(value.lane(node));
        }
        picked
    }

    #[inline(always)]
    fn element_output(value: T::Scalar) -> f64 {
        value.lane(0)
    }

    #[inline(always)]
    fn for_each_node<const RESULTS: usize>(
        first: usize,
        count: usize,
        values: [T; RESULTS],
        mut write: impl FnMut(usize, [f64; RESULTS]),
    ) {
        for k in 0..T::WIDTH.min(count - first) {
            let mut results = [0.0; RESULTS];
            for (result, value) in results.iter_mut().zip(&values) {
                *result = value.lane(k);
            }
            write(first + k, results);
        }
    }

    #[inline(always)]
    fn write_nodes(values: [T; 3], target: &mut [f64]) {
        T::store_interleaved(values, target);
    }
}
