//! How elements and their nodes are laid out in vectors: kernels are written once for all layouts.

use std::marker::PhantomData;

use super::form::write;
use super::form::{FormRows, Packed, batch, single};
use super::simd::Vector;
use super::{Lane, Second, SecondKind, packed_row};

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

    /// An element value for all nodes.
    fn spread(value: Self::Element) -> Self::Node;

    /// Sum over the nodes of values that were added up with [`add`](Self::add) or [`add_product`](Self::add_product).
    fn total(value: Self::Node) -> Self::Element;

    /// The number of each node, from `first` on; beyond the last of `count` nodes, of which there are copies, its number.
    fn node_index(first: usize, count: usize) -> Self::Node;

    /// 1 for the nodes from `first` on below `count`, 0 for what only fills the last vector.
    fn presence(first: usize, count: usize) -> Self::Node;

    /// `sum` + `x` for the nodes that are present. The others are copies of the last node: they bring no infinity or NaN
    /// that it does not bring itself.
    fn add(presence: Self::Node, x: Self::Node, sum: Self::Node) -> Self::Node;

    /// `sum` + `x` · `y` for the nodes that are present.
    fn add_product(presence: Self::Node, x: Self::Node, y: Self::Node, sum: Self::Node) -> Self::Node;

    /// An element value as a result.
    fn element_output(value: Self::Element) -> Self::Output;

    /// Writes x, y and z of the nodes of a vector to their places among those of all.
    fn write_nodes(values: [Self::Node; 3], vector: usize, target: &mut [Self::Output]);

    /// Scratch as results.
    fn outputs(scratch: &mut [Self::Node]) -> &mut [Self::Output];

    /// Results that a form takes until it is multiplied: at most 3 for each row and [`FormRows::OWN`] for each node of the vectors of
    /// nodes, and of one vector more.
    fn form_length(rows: FormRows) -> usize;

    /// Keeps the nodes' part of a row of a form, by x, y and z.
    fn keep_row(
        form: &mut [Self::Output],
        rows: FormRows,
        row: usize,
        vector: usize,
        values: [Self::Node; 3],
    );

    /// Keeps the nodes' part of a row b that the form before has, too: with [`finish_pair`](Self::finish_pair) a shape may read it
    /// there.
    fn keep_common_row(
        form: &mut [Self::Output],
        rows: FormRows,
        row: usize,
        vector: usize,
        values: [Self::Node; 3],
    );

    /// Keeps the nodes' own blocks, lower triangles.
    fn keep_own(form: &mut [Self::Output], rows: FormRows, vector: usize, own: [Self::Node; 6]);

    /// Keeps two rows, from `row` on, of the last node of a form: a point that no loop over the nodes writes.
    fn keep_point_rows(
        form: &mut [Self::Output],
        rows: FormRows,
        row: usize,
        b: [Self::Element; 3],
        c: [Self::Element; 3],
    );

    /// Keeps the own block of the last node, lower triangle.
    fn keep_point_own(form: &mut [Self::Output], rows: FormRows, own: [Self::Element; 6]);

    /// Writes a number of each node of a vector to its place among those of all.
    fn write_values(value: Self::Node, vector: usize, target: &mut [Self::Output]);

    /// Writes what is asked for of a form: the packed Hessian, its rows of the slave, or the factors it is made of. Returns 0 if every
    /// entry written is finite, else NaN.
    ///
    /// # Panics
    /// If a slice is shorter than `rows` says.
    #[inline(always)]
    fn finish_form(
        form: &mut [Self::Output],
        rows: FormRows,
        second: &mut Second<'_, Self::Output>,
    ) -> Self::Element {
        match second.kind() {
            SecondKind::Hessians => Self::multiply_form(form, rows, second),
            SecondKind::Factors | SecondKind::FactorsAndFoot => {
                Self::write_factors(form, rows, second.next(rows.factors()))
            }
            SecondKind::SlaveRows => Self::write_slave_rows(form, rows, second.next(rows.slave_rows())),
        }
    }

    /// Writes the packed Hessians of two forms. The second has the rows b of the first and one node more, a point whose
    /// rows b are zero. Returns of each 0 if every entry written is finite, else NaN.
    ///
    /// # Panics
    /// If a slice is shorter than `rows` says, or factors are asked for.
    fn finish_pair(
        forms: [&mut [Self::Output]; 2],
        rows: [FormRows; 2],
        second: &mut Second<'_, Self::Output>,
    ) -> [Self::Element; 2];

    /// Writes the factors of a form; arguments and what is returned as for [`finish_form`](Self::finish_form).
    ///
    /// # Panics
    /// If a slice is shorter than `rows` says.
    fn write_factors(form: &[Self::Output], rows: FormRows, target: &mut [Self::Output]) -> Self::Element;

    /// Writes the slave's rows of the Hessian of a form; arguments and what is returned as for [`finish_form`](Self::finish_form).
    ///
    /// # Panics
    /// If a slice is shorter than `rows` says.
    fn write_slave_rows(
        form: &mut [Self::Output],
        rows: FormRows,
        target: &mut [Self::Output],
    ) -> Self::Element;

    /// Writes the packed Hessian of a form; arguments and what is returned as for [`finish_form`](Self::finish_form). The slave's rows
    /// are the negative sums of the nodes'.
    ///
    /// # Panics
    /// If a slice is shorter than `rows` says.
    fn multiply_form(
        form: &mut [Self::Output],
        rows: FormRows,
        second: &mut Second<'_, Self::Output>,
    ) -> Self::Element;
}

/// Elements side by side, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Batch<T>(PhantomData<T>);

impl<T: Vector> Shape for Batch<T> {
    type Element = T;
    type Node = T;
    type Output = T;
    const NODES: usize = 1;

    #[inline]
    fn spread(value: T) -> T {
        value
    }

    #[inline]
    fn total(value: T) -> T {
        value
    }

    #[inline]
    fn node_index(first: usize, _: usize) -> T {
        T::splat(first as f64)
    }

    #[inline]
    fn presence(_: usize, _: usize) -> T {
        T::ONE
    }

    #[inline]
    fn add(_: T, x: T, sum: T) -> T {
        sum + x
    }

    #[inline]
    fn add_product(_: T, x: T, y: T, sum: T) -> T {
        x.mul_add(y, sum)
    }

    #[inline]
    fn element_output(value: T) -> T {
        value
    }

    #[inline(always)]
    fn write_nodes(values: [T; 3], vector: usize, target: &mut [T]) {
        write(values, target, 3 * vector);
    }

    #[inline(always)]
    fn outputs(scratch: &mut [T]) -> &mut [T] {
        scratch
    }

    #[inline(always)]
    fn form_length(rows: FormRows) -> usize {
        batch::length(rows)
    }

    #[inline(always)]
    fn keep_row(form: &mut [T], rows: FormRows, row: usize, vector: usize, values: [T; 3]) {
        batch::keep_row(form, rows, row, vector, values);
    }

    #[inline(always)]
    fn keep_common_row(_: &mut [T], _: FormRows, _: usize, _: usize, _: [T; 3]) {}

    #[inline(always)]
    fn keep_own(form: &mut [T], rows: FormRows, vector: usize, own: [T; 6]) {
        batch::keep_own(form, rows, vector, own);
    }

    #[inline(always)]
    fn keep_point_rows(form: &mut [T], rows: FormRows, row: usize, b: [T; 3], c: [T; 3]) {
        batch::keep_row(form, rows, row, rows.count - 1, b);
        batch::keep_row(form, rows, row + 1, rows.count - 1, c);
    }

    #[inline(always)]
    fn keep_point_own(form: &mut [T], rows: FormRows, own: [T; 6]) {
        batch::keep_own(form, rows, rows.count - 1, own);
    }

    #[inline(always)]
    fn write_values(value: T, vector: usize, target: &mut [T]) {
        target[vector] = value;
    }

    #[inline(always)]
    fn write_factors(form: &[T], rows: FormRows, target: &mut [T]) -> T {
        batch::write_factors(form, rows, target)
    }

    #[inline(always)]
    fn write_slave_rows(form: &mut [T], rows: FormRows, target: &mut [T]) -> T {
        batch::write_slave_rows(form, rows, target)
    }

    #[inline(always)]
    fn multiply_form(form: &mut [T], rows: FormRows, second: &mut Second<'_, T>) -> T {
        // Number by number there is one element, whose numbers are its Hessian.
        if const { T::WIDTH == 1 } {
            let target = second.next(packed_row(3 * (rows.count + 1)));
            batch::multiply(form, rows, &mut Packed { target, node: 0 })
        } else {
            batch::multiply(form, rows, &mut second.next_placed(rows.count))
        }
    }

    #[inline(always)]
    fn finish_pair(forms: [&mut [T]; 2], rows: [FormRows; 2], second: &mut Second<'_, T>) -> [T; 2] {
        assert!(second.kind() == SecondKind::Hessians, "factors are those of one form");
        if const { T::WIDTH == 1 } {
            let [first, other] = second.next_two(rows.map(|rows| packed_row(3 * (rows.count + 1))));
            let (mut first, mut other) =
                (Packed { target: first, node: 0 }, Packed { target: other, node: 0 });
            batch::multiply_pair(forms, rows, [&mut first, &mut other])
        } else {
            let (mut first, mut other) =
                (second.next_placed(rows[0].count), second.next_placed(rows[1].count));
            batch::multiply_pair(forms, rows, [&mut first, &mut other])
        }
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

    #[inline]
    fn spread(value: T::Scalar) -> T {
        T::splat(value.lane(0))
    }

    #[inline]
    fn total(value: T) -> T::Scalar {
        T::Scalar::splat(value.sum())
    }

    #[inline]
    fn node_index(first: usize, count: usize) -> T {
        T::from_fn(|k| (first + k).min(count - 1) as f64)
    }

    #[inline]
    fn presence(first: usize, count: usize) -> T {
        T::from_fn(|k| if first + k < count { 1.0 } else { 0.0 })
    }

    #[inline]
    fn add(presence: T, x: T, sum: T) -> T {
        x.mul_add(presence, sum)
    }

    #[inline]
    fn add_product(presence: T, x: T, y: T, sum: T) -> T {
        (x * y).mul_add(presence, sum)
    }

    #[inline]
    fn element_output(value: T::Scalar) -> f64 {
        value.lane(0)
    }

    #[inline(always)]
    fn write_nodes(values: [T; 3], vector: usize, target: &mut [f64]) {
        let place = 3 * T::WIDTH * vector;
        let end = target.len().min(place + 3 * T::WIDTH);
        T::store_interleaved(values, &mut target[place..end]);
    }

    #[inline(always)]
    fn outputs(scratch: &mut [T]) -> &mut [f64] {
        T::numbers(scratch)
    }

    #[inline(always)]
    fn form_length(rows: FormRows) -> usize {
        single::length::<T>(rows)
    }

    #[inline(always)]
    fn keep_row(form: &mut [f64], rows: FormRows, row: usize, vector: usize, values: [T; 3]) {
        single::keep_row(form, rows, row, vector, values);
    }

    #[inline(always)]
    fn keep_common_row(form: &mut [f64], rows: FormRows, row: usize, vector: usize, values: [T; 3]) {
        single::keep_row(form, rows, row, vector, values);
    }

    #[inline(always)]
    fn keep_own(form: &mut [f64], rows: FormRows, vector: usize, own: [T; 6]) {
        single::keep_own(form, rows, vector, own);
    }

    #[inline(always)]
    fn keep_point_rows(form: &mut [f64], rows: FormRows, row: usize, b: [T::Scalar; 3], c: [T::Scalar; 3]) {
        single::keep_last_row::<T>(form, rows, row, b);
        single::keep_last_row::<T>(form, rows, row + 1, c);
    }

    #[inline(always)]
    fn keep_point_own(form: &mut [f64], rows: FormRows, own: [T::Scalar; 6]) {
        single::keep_last_own::<T>(form, rows, own);
    }

    #[inline(always)]
    fn write_values(value: T, vector: usize, target: &mut [f64]) {
        let place = T::WIDTH * vector;
        for k in 0..T::WIDTH.min(target.len() - place) {
            target[place + k] = value.lane(k);
        }
    }

    #[inline(always)]
    fn write_factors(form: &[f64], rows: FormRows, target: &mut [f64]) -> T::Scalar {
        T::Scalar::splat(single::write_factors::<T>(form, rows, target))
    }

    #[inline(always)]
    fn write_slave_rows(form: &mut [f64], rows: FormRows, target: &mut [f64]) -> T::Scalar {
        T::Scalar::splat(single::write_slave_rows::<T>(form, rows, target))
    }

    #[inline(always)]
    fn multiply_form(form: &mut [f64], rows: FormRows, second: &mut Second<'_, f64>) -> T::Scalar {
        let target = second.next(packed_row(3 * (rows.count + 1)));
        T::Scalar::splat(single::multiply::<T>(form, rows, target))
    }

    #[inline(always)]
    fn finish_pair(
        forms: [&mut [f64]; 2],
        rows: [FormRows; 2],
        second: &mut Second<'_, f64>,
    ) -> [T::Scalar; 2] {
        assert!(second.kind() == SecondKind::Hessians, "factors are those of one form");
        let [form, other] = forms;
        [Self::multiply_form(form, rows[0], second), Self::multiply_form(other, rows[1], second)]
    }
}
