//! The products of rows are the Hessians, for all widths of vectors.

use super::super::simd::{Block, Spread};
use super::super::{Isa, WithLanes};
use super::*;

/// Rows and own blocks of nodes, by any rule, and the Hessian.
struct Case {
    rows: FormRows,
    /// An entry of a node's own block that is infinite: node, row, column.
    infinite: Option<(usize, usize, usize)>,
    /// Whether it is the second of a pair: the last node is a point, and the rows c are others.
    has_point: bool,
}

/// A lower triangle.
const LOWER: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

impl Case {
    fn entry(&self, row: usize, node: usize, axis: usize) -> f64 {
        if node == 0 {
            return -(1..=self.rows.count).map(|node| self.entry(row, node, axis)).sum::<f64>();
        }
        let is_c = row % 2 == 1;
        if self.has_point && node == self.rows.count && !is_c {
            return 0.0;
        }
        let shift = if self.has_point && is_c { 3 } else { 0 };
        ((7 * row + 13 * node + 5 * axis + shift) % 17) as f64 - 8.0
    }

    fn own(&self, node: usize, row: usize, column: usize) -> f64 {
        if self.infinite == Some((node, row.max(column), row.min(column))) {
            return f64::INFINITY;
        }
        ((11 * node + 3 * row.max(column) + row.min(column)) % 19) as f64 - 9.0
    }

    fn expected(&self, row: usize, column: usize) -> f64 {
        let [(i, a), (j, b)] = [row, column].map(|k| (k / 3, k % 3));
        let products: f64 = (0..self.rows.rows)
            .step_by(2)
            .map(|k| {
                self.entry(k + 1, i, a) * self.entry(k, j, b) + self.entry(k, i, a) * self.entry(k + 1, j, b)
            })
            .sum();
        match j {
            _ if i == 0 => products + (1..=self.rows.count).map(|node| self.own(node, a, b)).sum::<f64>(),
            _ if i == j => products + self.own(i, a, b),
            0 => products - self.own(i, a, b),
            _ => products,
        }
    }

    /// Whole numbers: any order of additions gives the same. `sum`: what `multiply` returned.
    fn check(&self, hessian: &[f64], sum: f64, what: &str) {
        assert_eq!(sum.is_nan(), self.infinite.is_some(), "{what}, {:?}: {:?}", self.rows, self.infinite);
        assert!(sum == 0.0 || sum.is_nan());
        for row in 0..3 * (self.rows.count + 1) {
            for column in 0..=row {
                let found = hessian[packed_row(row) + column];
                assert_eq!(found, self.expected(row, column), "{what}, {:?}: ({row}, {column})", self.rows);
            }
        }
    }

    /// Of each node the rows by axes and its own block.
    fn check_factors(&self, factors: &[f64], sum: f64) {
        assert_eq!(sum.is_nan(), self.infinite.is_some(), "{:?}: {:?}", self.rows, self.infinite);
        let FormRows { rows, count } = self.rows;
        let of_node =
            |node: usize| (0..3).flat_map(move |axis| (0..rows).map(move |row| self.entry(row, node, axis)));
        let nodes =
            (1..=count).flat_map(|node| of_node(node).chain(LOWER.map(|(i, j)| self.own(node, i, j))));
        let expected: Vec<f64> = nodes.collect();
        assert_eq!(factors, expected, "{:?}", self.rows);
    }

    /// The slave's rows, over all coordinates.
    fn check_slave_rows(&self, found: &[f64], sum: f64) {
        let freedoms = 3 * (self.rows.count + 1);
        assert_eq!(sum.is_nan(), self.infinite.is_some(), "{:?}: {:?}", self.rows, self.infinite);
        for (place, &entry) in found[..3 * freedoms].iter().enumerate() {
            let (row, column) = (place / freedoms, place % freedoms);
            let expected = self.expected(row.max(column), row.min(column));
            assert_eq!(entry, expected, "{:?}: ({row}, {column})", self.rows);
        }
        assert!(found[3 * freedoms..].iter().all(|x| x.is_nan()), "beyond the end");
    }

    /// The same for elements side by side, of which another case says which block is infinite. NaN where nothing is kept: rows b of
    /// the second of a pair, which are the first's.
    fn form<'b, T: Vector>(
        &self,
        blocks: &'b mut Vec<Block>,
        case_of: impl Fn(usize) -> &'b Self,
    ) -> &'b mut [T] {
        let length = batch::length(self.rows);
        blocks.resize(Block::count::<T>(length), Block::ZERO);
        let form = &mut Block::vectors::<T>(blocks)[..length];
        form.fill(T::splat(f64::NAN));
        for node in 0..self.rows.count {
            for row in (0..self.rows.rows).filter(|row| !self.has_point || row % 2 == 1) {
                let values = [0, 1, 2].map(|axis| T::splat(self.entry(row, node + 1, axis)));
                batch::keep_row(form, self.rows, row, node, values);
            }
            let own = LOWER.map(|(i, j)| T::from_fn(|lane| case_of(lane).own(node + 1, i, j)));
            batch::keep_own(form, self.rows, node, own);
        }
        form
    }

    /// The lower triangle of own blocks.
    fn own_of<T: Lane>(&self, node: impl Fn(usize) -> usize) -> [T; 6] {
        LOWER.map(|(row, column)| T::from_fn(|lane| self.own(node(lane), row, column)))
    }
}

/// The nodes of one element side by side.
struct Nodes<'a>(&'a Case);

impl WithLanes for Nodes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self(case) = self;
        let rows = case.rows;
        let size = packed_row(3 * (rows.count + 1));
        // What is read must have been written: NaN shows.
        let mut form = vec![f64::NAN; single::length::<T>(rows)];
        for vector in 0..rows.count.div_ceil(T::WIDTH) {
            let node = |lane: usize| 1 + (T::WIDTH * vector + lane).min(rows.count - 1);
            for row in 0..rows.rows {
                let values = [0, 1, 2].map(|axis| T::from_fn(|lane| case.entry(row, node(lane), axis)));
                single::keep_row(&mut form, rows, row, vector, values);
            }
            single::keep_own(&mut form, rows, vector, case.own_of::<T>(node));
        }
        let mut factors = vec![f64::NAN; rows.factors()];
        let sum = single::write_factors::<T>(&form, rows, &mut factors);
        case.check_factors(&factors, sum);
        let mut slave_rows = vec![f64::NAN; rows.slave_rows() + 1];
        let sum = single::write_slave_rows::<T>(&mut form, rows, &mut slave_rows);
        case.check_slave_rows(&slave_rows, sum);
        let mut hessian = vec![f64::NAN; size + 1];
        let sum = single::multiply::<T>(&mut form, rows, &mut hessian[..size]);
        case.check(&hessian, sum, &format!("nodes side by side, {}", T::WIDTH));
        assert!(hessian[size].is_nan(), "beyond the end");
    }
}

/// Elements side by side, the case in one lane after the other; the others have no infinite entry.
struct Elements<'a>(&'a Case);

impl WithLanes for Elements<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self(case) = self;
        let rows = case.rows;
        let size = packed_row(3 * (rows.count + 1));
        let finite = Case { infinite: None, ..*case };
        for place in 0..T::WIDTH {
            let case_of = |lane: usize| if lane == place { case } else { &finite };
            let mut blocks = Vec::new();
            let form = case.form::<T>(&mut blocks, case_of);
            let mut factors = vec![T::ZERO; rows.factors()];
            let sum = batch::write_factors(form, rows, &mut factors);
            for lane in 0..T::WIDTH {
                let factors: Vec<f64> = factors.iter().map(|x| x.lane(lane)).collect();
                case_of(lane).check_factors(&factors, sum.lane(lane));
            }
            let mut slave_rows = vec![T::splat(f64::NAN); rows.slave_rows() + 1];
            let sum = batch::write_slave_rows(form, rows, &mut slave_rows);
            for lane in 0..T::WIDTH {
                let found: Vec<f64> = slave_rows.iter().map(|x| x.lane(lane)).collect();
                case_of(lane).check_slave_rows(&found, sum.lane(lane));
            }
            let mut packed = vec![T::splat(f64::NAN); size];
            let target = &mut Packed { target: &mut packed, node: 0 };
            let sum = batch::multiply(form, rows, target);
            for lane in 0..T::WIDTH {
                let hessian: Vec<f64> = packed.iter().map(|x| x.lane(lane)).collect();
                case_of(lane).check(&hessian, sum.lane(lane), "elements side by side, packed");
            }
            let mut hessians = vec![vec![f64::NAN; size + 1]; T::WIDTH];
            let mut spread = Spread::default();
            spread.set(rows.count, (0..T::WIDTH).map(|_| (rows.count, &[][..])));
            let mut placed = spread.hessians(&mut hessians, |hessian| &mut hessian[..size]).next(rows.count);
            let sum = batch::multiply(form, rows, &mut placed);
            for (lane, hessian) in hessians.iter().enumerate() {
                let what = format!("elements side by side, {lane} of {}", T::WIDTH);
                case_of(lane).check(hessian, sum.lane(lane), &what);
                assert!(hessian[size].is_nan(), "beyond the end");
            }
        }
    }
}

/// Elements side by side with two Hessians, one case in one lane after the other.
struct Pairs<'a>([&'a Case; 2]);

impl WithLanes for Pairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self(cases) = self;
        let rows = cases.map(|case| case.rows);
        let size = rows.map(|rows| packed_row(3 * (rows.count + 1)));
        let finite = cases.map(|case| Case { infinite: None, ..*case });
        for place in 0..T::WIDTH {
            let case_of = |k: usize, lane: usize| if lane == place { cases[k] } else { &finite[k] };
            let check = |hessians: [&[f64]; 2], sums: [T; 2], lane: usize, what: &str| {
                for k in 0..2 {
                    let what = format!("{what}, Hessian {k}, lane {lane} of {}", T::WIDTH);
                    case_of(k, lane).check(hessians[k], sums[k].lane(lane), &what);
                }
            };
            let mut blocks = [Vec::new(), Vec::new()];
            let [first, other] = &mut blocks;
            let first = cases[0].form::<T>(first, |lane| case_of(0, lane));
            let other = cases[1].form::<T>(other, |lane| case_of(1, lane));
            let mut packed = size.map(|size| vec![T::splat(f64::NAN); size]);
            let [mut target, mut other_target] =
                packed.each_mut().map(|target| Packed { target: &mut target[..], node: 0 });
            let targets = [&mut target, &mut other_target];
            let sums = batch::multiply_pair([&mut *first, &mut *other], rows, targets);
            for lane in 0..T::WIDTH {
                let [first, other] = packed
                    .each_ref()
                    .map(|packed| -> Vec<f64> { packed.iter().map(|x| x.lane(lane)).collect() });
                check([&first, &other], sums, lane, "packed");
            }
            let mut hessians = vec![vec![f64::NAN; size[0] + size[1] + 1]; T::WIDTH];
            let mut spread = Spread::default();
            spread.set(rows[1].count, (0..T::WIDTH).map(|_| (rows[1].count, &[][..])));
            let mut placed = spread.hessians(&mut hessians, |hessian| &mut hessian[..size[0] + size[1]]);
            let (mut target, mut other_target) = (placed.next(rows[0].count), placed.next(rows[1].count));
            let sums = batch::multiply_pair([first, other], rows, [&mut target, &mut other_target]);
            for (lane, hessians) in hessians.iter().enumerate() {
                let (first, other) = hessians.split_at(size[0]);
                check([first, other], sums, lane, "in places");
                assert!(other[size[1]].is_nan(), "beyond the end");
            }
        }
    }
}

/// In vectors of every width that there is code for.
fn check_all_widths(isa: Isa, case: &Case) {
    isa.run(Elements(case));
    match isa {
        Isa::SCALAR => Nodes(case).run::<f64>(),
        _ => assert!(isa.run_four(Nodes(case)).is_ok(), "{isa}"),
    }
}

#[test]
fn the_products_of_rows_are_the_hessian() {
    for isa in Isa::available() {
        for rows in [12, 16, 2, 0] {
            // All remainders of all widths, and many vectors.
            for count in (1..=17).chain([32, 33]) {
                let rows = FormRows { rows, count };
                check_all_widths(isa, &Case { rows, infinite: None, has_point: false });
            }
        }
    }
}

#[test]
fn no_entry_that_is_not_finite_goes_unnoticed() {
    for isa in Isa::available() {
        for count in 1..=9 {
            for node in 1..=count {
                for (row, column) in LOWER {
                    let rows = FormRows { rows: 6, count };
                    let infinite = Some((node, row, column));
                    check_all_widths(isa, &Case { rows, infinite, has_point: false });
                }
            }
        }
    }
}

#[test]
fn two_hessians_with_the_same_rows_b_are_those_of_their_rows() {
    let case = |count: usize, infinite: Option<(usize, usize, usize)>, has_point: bool| {
        let rows = FormRows { rows: 12, count };
        Case { rows, infinite, has_point }
    };
    for isa in Isa::available() {
        for count in 1..=17 {
            isa.run(Pairs([&case(count, None, false), &case(count + 1, None, true)]));
        }
        for node in 1..=6 {
            for (row, column) in LOWER {
                let infinite = Some((node, row, column));
                isa.run(Pairs([&case(5, infinite.filter(|_| node < 6), false), &case(6, None, true)]));
                isa.run(Pairs([&case(5, None, false), &case(6, infinite, true)]));
            }
        }
    }
}
