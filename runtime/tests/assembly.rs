//! Assembly against a plain loop into dense arrays, on random lists of elements and on real ones.

use crate::assembly_cases::{Case, Dense, cylinder};
use diffuse_contact::assembly::{
    AssemblyError, ContactLaw, ContactView, CsrMap, CsrPattern, DofMap, ElementView, Tangent, Triangle,
    Triplets, add_forces,
};
use diffuse_contact::{Generated, Mode};
use proptest::prelude::*;

/// Entries of a pattern as a dense matrix.
fn dense(pattern: &CsrPattern, values: &[f64]) -> Vec<Vec<f64>> {
    let mut matrix = vec![vec![0.0; pattern.equations()]; pattern.equations()];
    for (row, entries) in matrix.iter_mut().enumerate() {
        for k in pattern.row_offsets()[row]..pattern.row_offsets()[row + 1] {
            entries[pattern.columns()[k] as usize] = values[k];
        }
    }
    matrix
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

/// Everything that holds for any list of elements, law and map.
fn compare_with_dense(case: &Case, law: &ContactLaw<'_>, dofs: &DofMap) {
    let views = case.views();
    let elements = views.as_slice();
    let expected = Dense::assemble(elements, law, dofs);

    let mut residual = vec![0.0; dofs.equations()];
    assert_eq!(add_forces(elements, law, dofs, &mut residual), Ok(expected.active));
    assert_eq!(residual, expected.residual);

    let pattern = CsrPattern::union(elements, dofs).unwrap();
    let mut values = vec![f64::NAN; pattern.entries()];
    assert_eq!(pattern.fill(elements, law, &mut values), Ok(expected.active));
    assert_eq!(dense(&pattern, &values), expected.tangent);

    // The pattern is the union over all elements that are paired: sorted, without repetition, nothing too much.
    let mut places = 0;
    for (row, pair) in pattern.row_offsets().windows(2).enumerate() {
        let columns = &pattern.columns()[pair[0]..pair[1]];
        assert!(columns.windows(2).all(|pair| pair[0] < pair[1]));
        for column in 0..dofs.equations() {
            let there = expected.coupled[row][column];
            assert_eq!(columns.binary_search(&(column as u32)).is_ok(), there);
            assert_eq!(pattern.position(row, column).is_some(), there);
            places += usize::from(there);
        }
    }
    assert_eq!(places, pattern.entries());

    // In the memory of a pattern with fewer elements, and of one with more.
    let some = &elements[..elements.len() / 2];
    let mut renewed = CsrPattern::union(some, dofs).unwrap();
    for own in [elements, some, elements] {
        renewed.renew(own, dofs).unwrap();
        let expected = CsrPattern::union(own, dofs).unwrap();
        assert_eq!(renewed.row_offsets(), expected.row_offsets());
        assert_eq!(renewed.columns(), expected.columns());
        assert!(renewed.map().fits(own));
    }
    let mut found = vec![f64::NAN; renewed.entries()];
    assert_eq!(renewed.fill(elements, law, &mut found), Ok(expected.active));
    assert_eq!(dense(&renewed, &found), expected.tangent);

    let mut again = values.clone();
    assert_eq!(pattern.add(elements, law, &mut again), Ok(expected.active));
    for (twice, once) in again.iter().zip(&values) {
        assert!((twice - 2.0 * once).abs() <= 1e-12 * expected.largest);
    }

    let mut triplets = Triplets::new();
    for triangle in [Triangle::Full, Triangle::Lower] {
        assert_eq!(triplets.fill(elements, law, dofs, triangle), Ok(expected.active));
        let mut sum = vec![0.0; pattern.entries()];
        for (row, column, value) in triplets.iter() {
            sum[pattern.position(row, column).unwrap()] += value;
        }
        let mut matrix = expected.tangent.clone();
        if triangle == Triangle::Lower {
            for (row, entries) in matrix.iter_mut().enumerate() {
                entries[row + 1..].fill(0.0);
            }
        }
        assert_eq!(dense(&pattern, &sum), matrix);
    }
}

fn any_case() -> impl Strategy<Value = Case> {
    (1_usize..12, 0_usize..9, 0_usize..6, any::<u64>())
        .prop_map(|(nodes, elements, most, seed)| Case::random(nodes, elements, most, seed))
}

proptest! {
    #[test]
    fn any_list_is_assembled_as_by_a_plain_loop(
        case in any_case(),
        penalty in 0.1..10.0,
        augmented: bool,
        gauss_newton: bool,
        numbering in 0..3,
        seed: u64,
    ) {
        let multipliers = case.multipliers(seed);
        let law = ContactLaw::penalty(penalty).with_multipliers(augmented.then_some(multipliers.as_slice())).with_tangent(if gauss_newton { Tangent::GaussNewton } else { Tangent::Exact });
        let dofs = match numbering {
            0 => DofMap::standard(case.nodes),
            1 => DofMap::numbering(case.nodes, |node, axis| (seed >> ((3 * node + axis) % 64)) & 1 == 0).unwrap(),
            _ => case.scattered_equations(seed),
        };
        compare_with_dense(&case, &law, &dofs);
    }

    #[test]
    fn without_repeated_nodes_the_matrix_is_symmetric_to_the_last_bit(seed: u64) {
        let case = Case::with_distinct_nodes(40, 30, 9, seed);
        let views = case.views();
        let pattern = CsrPattern::union(views.as_slice(), &DofMap::standard(case.nodes)).unwrap();
        let mut values = vec![0.0; pattern.entries()];
        pattern.fill(views.as_slice(), &ContactLaw::penalty(3.0), &mut values).unwrap();
        let matrix = dense(&pattern, &values);
        for i in 0..matrix.len() {
            for j in 0..i {
                prop_assert_eq!(matrix[i][j].to_bits(), matrix[j][i].to_bits());
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let case = Case::random(300, 400, 12, 5);
    let views = case.views();
    let dofs = case.scattered_equations(7);
    let law = ContactLaw::penalty(2.0);
    let results = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let pattern = CsrPattern::union(views.as_slice(), &dofs).unwrap();
            let mut values = vec![0.0; pattern.entries()];
            let active = pattern.fill(views.as_slice(), &law, &mut values).unwrap();
            assert!(active > 100 && values.len() > 100_000, "large enough to be split");
            (pattern.row_offsets().to_vec(), pattern.columns().to_vec(), bits(&values))
        })
    });
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
    let expected = Dense::assemble(views.as_slice(), &law, &dofs);
    let (offsets, columns, values) = &results[0];
    for row in 0..dofs.equations() {
        for k in offsets[row]..offsets[row + 1] {
            assert_eq!(values[k], expected.tangent[row][columns[k] as usize].to_bits());
        }
    }
}

#[test]
fn real_elements_are_in_equilibrium_and_their_tangent_is_the_derivative() {
    let patch = cylinder();
    let law = ContactLaw::penalty(1e4);
    let dofs = DofMap::standard(patch.positions.len());
    let residual = |positions: &[[f64; 3]]| {
        let case = patch.evaluate(&Generated, positions, Mode::Gradient);
        let mut residual = vec![0.0; dofs.equations()];
        let active = add_forces(case.views().as_slice(), &law, &dofs, &mut residual).unwrap();
        (residual, active)
    };
    let (forces, active) = residual(&patch.positions);
    assert!(active > 10 && active < patch.pairings.len(), "{active} of {}", patch.pairings.len());
    let largest = forces.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    for axis in 0..3 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let nodes = || patch.positions.iter().zip(forces.chunks(3));
        let force: f64 = nodes().map(|(_, f)| f[axis]).sum();
        let moment: f64 = nodes().map(|(x, f)| x[i] * f[j] - x[j] * f[i]).sum();
        assert!(force.abs() < 1e-10 * largest, "{force} of {largest}");
        assert!(moment.abs() < 1e-10 * largest, "{moment} of {largest}");
    }

    let case = patch.evaluate(&Generated, &patch.positions, Mode::Hessian);
    compare_with_dense(&case, &law, &dofs);
    let views = case.views();
    let pattern = CsrPattern::union(views.as_slice(), &dofs).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    pattern.fill(views.as_slice(), &law, &mut values).unwrap();
    // K d = −dR/dx d, by a central difference along a direction in which no element becomes active or inactive.
    let direction: Vec<f64> = (0..dofs.equations()).map(|k| (1.7 * k as f64).sin()).collect();
    let step = 1e-6;
    let moved = |sign: f64| {
        let shift = |(node, x): (usize, &[f64; 3])| {
            std::array::from_fn(|axis| x[axis] + sign * step * direction[3 * node + axis])
        };
        residual(&patch.positions.iter().enumerate().map(shift).collect::<Vec<_>>())
    };
    let ((ahead, more), (behind, fewer)) = (moved(1.0), moved(-1.0));
    assert_eq!((more, fewer), (active, active));
    let stiffness = values.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    for row in 0..dofs.equations() {
        let entries = pattern.row_offsets()[row]..pattern.row_offsets()[row + 1];
        let product: f64 = entries.map(|k| values[k] * direction[pattern.columns()[k] as usize]).sum();
        let difference = -(ahead[row] - behind[row]) / (2.0 * step);
        assert!((product - difference).abs() < 1e-7 * stiffness, "{row}: {product} and {difference}");
    }
}

#[test]
fn an_element_that_just_touches_carries_nothing() {
    let mut case = Case::random(6, 30, 4, 1);
    case.elements.retain(|element| !element.masters.is_empty());
    case.elements.truncate(3);
    for (k, element) in case.elements.iter_mut().enumerate() {
        element.gap = [-0.5, 0.0, 0.25][k];
        (element.in_contact, element.area) = (true, 2.0);
    }
    let views = case.views();
    let active = |law: &ContactLaw<'_>| {
        let dofs = DofMap::standard(6);
        let mut triplets = Triplets::new();
        let active = triplets.fill(views.as_slice(), law, &dofs, Triangle::Full).unwrap();
        assert_eq!(add_forces(views.as_slice(), law, &dofs, &mut [0.0; 18]), Ok(active));
        active
    };
    assert_eq!(active(&ContactLaw::penalty(1.0)), 1);
    // ε g = 3 × 2 × 0.25 = 1.5 for the open element.
    for (multiplier, expected) in [(1.5, 2), (1.5 + 1e-12, 3)] {
        let multipliers = [multiplier; 3];
        let law = ContactLaw::penalty(3.0).with_multipliers(Some(&multipliers));
        assert_eq!(active(&law), expected);
        assert_eq!(law.force(0, -0.5, 2.0), multiplier + 3.0);
        assert_eq!(law.force(1, 0.0, 2.0), multiplier);
        assert!(law.force(2, 0.25, 2.0) < 1e-11);
    }
}

#[test]
fn a_pattern_serves_as_long_as_the_nodes_stay() {
    let mut case = Case::random(20, 10, 5, 3);
    let dofs = DofMap::standard(20);
    let pattern = CsrPattern::union(case.views().as_slice(), &dofs).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    for gap in [-1.0, 1.0, -0.5] {
        case.elements.iter_mut().for_each(|element| element.gap = gap);
        let views = case.views();
        let expected = Dense::assemble(views.as_slice(), &ContactLaw::penalty(2.0), &dofs);
        let active = pattern.fill(views.as_slice(), &ContactLaw::penalty(2.0), &mut values);
        assert_eq!(active, Ok(expected.active));
        assert_eq!(dense(&pattern, &values), expected.tangent);
    }
    let paired = case.elements.iter().position(|element| !element.masters.is_empty()).unwrap();
    case.elements[paired].masters[0] = (case.elements[paired].masters[0] + 1) % 20;
    let before = bits(&values);
    assert_eq!(
        pattern.fill(case.views().as_slice(), &ContactLaw::penalty(2.0), &mut values),
        Err(AssemblyError::PatternMismatch { element: paired })
    );
    case.elements.pop();
    assert_eq!(
        pattern.fill(case.views().as_slice(), &ContactLaw::penalty(2.0), &mut values),
        Err(AssemblyError::PatternMismatch { element: 9 })
    );
    assert_eq!(before, bits(&values), "a refusal changes nothing");
}

/// The documented sum, for a pattern without constraints.
#[test]
fn a_pattern_takes_the_memory_that_is_documented() {
    let case = Case::with_distinct_nodes(600, 250, 9, 11);
    let dofs = DofMap::standard(600);
    let pattern = CsrPattern::union(case.views().as_slice(), &dofs).unwrap();
    let (e, r) = (pattern.entries(), pattern.equations());
    assert_eq!(pattern.memory(), 4 * e + 8 * (r + 1) + pattern.map().memory());
    let nodes_of = |masters: usize| if masters == 0 { 0 } else { masters + 1 };
    let nodes = || case.elements.iter().map(|element| nodes_of(element.masters.len()));
    let blocks: usize = nodes().map(|nodes| nodes * nodes).sum();
    let most = 4 * blocks + 28 * nodes().sum::<usize>() + 80 * 600 + 16 * 250;
    assert!(pattern.map().memory() <= most, "{} of at most {most}", pattern.map().memory());
}

/// A host's matrix: the entries of the pattern, an equation that no node has, and a full row and column beside them.
fn host_matrix(pattern: &CsrPattern) -> (Vec<i64>, Vec<i32>) {
    let equations = pattern.equations();
    let (mut offsets, mut columns) = (vec![0], Vec::new());
    for row in 0..equations {
        let own = pattern.row_offsets()[row]..pattern.row_offsets()[row + 1];
        let mut of_row: Vec<i32> = pattern.columns()[own].iter().map(|&column| column as i32).collect();
        if row % 5 == 0 {
            of_row.extend(0..equations as i32);
        }
        of_row.push((7 * row % equations) as i32);
        of_row.sort_unstable();
        of_row.dedup();
        columns.extend(of_row);
        offsets.push(columns.len() as i64);
    }
    (offsets, columns)
}

proptest! {
    #[test]
    fn a_matrix_of_the_host_gets_the_entries_of_the_pattern(case in any_case(), numbering in 0..3, seed: u64) {
        let dofs = match numbering {
            0 => DofMap::standard(case.nodes),
            1 => DofMap::numbering(case.nodes, |node, axis| (seed >> ((3 * node + axis) % 64)) & 1 == 0).unwrap(),
            _ => case.scattered_equations(seed),
        };
        let (views, law) = (case.views(), ContactLaw::penalty(2.0));
        let elements = views.as_slice();
        let pattern = CsrPattern::union(elements, &dofs).unwrap();
        let mut expected = vec![0.0; pattern.entries()];
        let active = pattern.fill(elements, &law, &mut expected).unwrap();
        let (offsets, columns) = host_matrix(&pattern);
        let map = CsrMap::within(elements, &dofs, &offsets, &columns).unwrap();
        prop_assert_eq!((map.equations(), map.entries()), (dofs.equations(), columns.len()));
        let mut values = vec![0.0; columns.len()];
        prop_assert_eq!(map.add(elements, &law, &mut values), Ok(active));
        for row in 0..dofs.equations() {
            for k in offsets[row] as usize..offsets[row + 1] as usize {
                let own = pattern.position(row, columns[k] as usize).map_or(0.0, |entry| expected[entry]);
                prop_assert_eq!(values[k], own);
            }
        }
        // Without one of the entries it is refused, with its place.
        if pattern.entries() > 0 {
            let lost = seed as usize % pattern.entries();
            let row = pattern.row_offsets().partition_point(|&offset| offset <= lost) - 1;
            let column = pattern.columns()[lost] as usize;
            let own = offsets[row] as usize..offsets[row + 1] as usize;
            let place = own.start + columns[own].binary_search(&(column as i32)).unwrap();
            let (mut columns, mut offsets) = (columns, offsets);
            columns.remove(place);
            offsets[row + 1..].iter_mut().for_each(|offset| *offset -= 1);
            let error = CsrMap::within(elements, &dofs, &offsets, &columns).unwrap_err();
            prop_assert_eq!(error, AssemblyError::MissingEntry { row, column });
        }
    }
}

#[test]
fn what_is_no_matrix_is_refused() {
    let views = [
        ElementView { slave: 0, masters: &[], contact: None },
        ElementView { slave: 0, masters: &[1], contact: None },
    ];
    let (elements, dofs) = (views.as_slice(), DofMap::from_first(3, [None, Some(0)]).unwrap());
    let sound = ([0, 3, 6, 9], [0, 1, 2, 0, 1, 2, 0, 1, 2]);
    assert!(CsrMap::within(elements, &dofs, &sound.0, &sound.1).is_ok());
    let refused =
        |offsets: &[i32], columns: &[i32]| CsrMap::within(elements, &dofs, offsets, columns).unwrap_err();
    let short = AssemblyError::OutputLength { what: "row offsets", found: 3, expected: 4 };
    assert_eq!(refused(&sound.0[..3], &sound.1), short);
    for (offsets, row) in
        [([1, 3, 6, 9], 0), ([0, 3, 2, 9], 1), ([0, 3, 6, 8], 2), ([0, 3, -6, 9], 1), ([0, 30, 6, 9], 0)]
    {
        assert_eq!(refused(&offsets, &sound.1), AssemblyError::InvalidRow { row });
    }
    for (place, column) in [(1, 0), (4, 2), (8, 3), (0, -1)] {
        let mut columns = sound.1;
        columns[place] = column;
        assert_eq!(refused(&sound.0, &columns), AssemblyError::InvalidRow { row: place / 3 });
    }
}

#[test]
fn no_elements_have_an_empty_pattern() {
    let none: &[ElementView<'_>] = &[];
    for nodes in [0, 4] {
        let dofs = DofMap::standard(nodes);
        let pattern = CsrPattern::union(none, &dofs).unwrap();
        assert_eq!((pattern.equations(), pattern.entries()), (3 * nodes, 0));
        assert_eq!(pattern.row_offsets(), vec![0; 3 * nodes + 1]);
        assert_eq!(pattern.fill(none, &ContactLaw::penalty(1.0), &mut []), Ok(0));
        assert_eq!(add_forces(none, &ContactLaw::penalty(1.0), &dofs, &mut vec![0.0; 3 * nodes]), Ok(0));
    }
}

/// What every kind of assembly answers to one element.
#[track_caller]
fn assert_refused(element: ElementView<'_>, law: &ContactLaw<'_>, expected: &AssemblyError) {
    let elements: &[ElementView<'_>] = &[element];
    let dofs = DofMap::standard(2);
    let mut residual = [0.5; 6];
    let error = add_forces(elements, law, &dofs, &mut residual).unwrap_err();
    if matches!(expected, AssemblyError::DerivativeLength { what: "Hessian", .. }) {
        panic!("no Hessian is needed for the residual, but: {error}");
    }
    assert_eq!(format!("{error:?}"), format!("{expected:?}"));
    assert_eq!(residual, [0.5; 6]);
    assert_tangent_refused(element, law, expected);
}

#[track_caller]
fn assert_tangent_refused(element: ElementView<'_>, law: &ContactLaw<'_>, expected: &AssemblyError) {
    let elements: &[ElementView<'_>] = &[element];
    let dofs = DofMap::standard(2);
    let mut triplets = Triplets::new();
    let error = triplets.fill(elements, law, &dofs, Triangle::Lower).unwrap_err();
    // As text: a NaN is not equal to itself.
    assert_eq!(format!("{error:?}"), format!("{expected:?}"));
    assert!(triplets.is_empty());
    if let Ok(pattern) = CsrPattern::union(elements, &dofs) {
        let mut values = vec![0.5; pattern.entries()];
        let error = pattern.fill(elements, law, &mut values).unwrap_err();
        assert_eq!(format!("{error:?}"), format!("{expected:?}"));
        assert!(values.iter().all(|&value| value == 0.5));
    }
}

#[test]
fn bad_input_is_refused_with_its_figures() {
    let (gradient, hessian) = ([0.1; 6], [0.2; 21]);
    let contact = ContactView { gap: -0.1, area: 1.0, gradient: &gradient, hessian: &hessian, slip: None };
    let element = |contact| ElementView { slave: 0, masters: &[1], contact: Some(contact) };
    let good = ContactLaw::penalty(1.0);
    for value in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        let law = ContactLaw::penalty(value);
        assert_refused(element(contact), &law, &AssemblyError::InvalidPenalty { value });
    }
    for value in [f64::NAN, -1e-300, f64::INFINITY] {
        let multipliers = [value];
        let law = good.with_multipliers(Some(&multipliers));
        assert_refused(element(contact), &law, &AssemblyError::InvalidMultiplier { element: 0, value });
        let area = ContactView { area: value, ..contact };
        assert_refused(element(area), &good, &AssemblyError::InvalidArea { element: 0, value });
    }
    let law = good.with_multipliers(Some(&[1.0, 1.0]));
    assert_refused(element(contact), &law, &AssemblyError::MultiplierCount { found: 2, elements: 1 });
    for value in [f64::NAN, f64::NEG_INFINITY] {
        let gap = ContactView { gap: value, ..contact };
        assert_refused(element(gap), &good, &AssemblyError::InvalidGap { element: 0, value });
    }
    for (penalty, area, gap) in [(1e200, 1.0, -1e200), (1e200, 1e200, 0.0), (1e200, 1e200, 1.0)] {
        let large = ContactView { gap, area, ..contact };
        let expected = AssemblyError::ForceOverflow { element: 0, penalty, area, gap };
        assert_refused(element(large), &ContactLaw::penalty(penalty), &expected);
    }
    let short = ContactView { gradient: &gradient[..5], ..contact };
    let expected = AssemblyError::DerivativeLength { what: "gradient", element: 0, found: 5, expected: 6 };
    assert_refused(element(short), &good, &expected);
    let alone = ElementView { masters: &[], ..element(contact) };
    assert_refused(alone, &good, &AssemblyError::NoMasters { element: 0 });
    for (slave, masters, node) in
        [(2, &[1], 2), (usize::MAX, &[0], usize::MAX), (0, &[u32::MAX], u32::MAX as usize)]
    {
        let unknown = ElementView { slave, masters, contact: None };
        let expected = AssemblyError::UnknownNode { element: 0, node, nodes: 2 };
        assert_refused(unknown, &good, &expected);
        let elements: &[ElementView<'_>] = &[unknown];
        assert_eq!(CsrPattern::union(elements, &DofMap::standard(2)).unwrap_err(), expected);
    }

    // The Hessian: not needed by Gauss–Newton, nor by an element that carries no force.
    let without = ContactView { hessian: &[], ..contact };
    let expected = AssemblyError::DerivativeLength { what: "Hessian", element: 0, found: 0, expected: 21 };
    assert_tangent_refused(element(without), &good, &expected);
    let elements: &[ElementView<'_>] = &[element(without)];
    let gauss_newton = good.with_tangent(Tangent::GaussNewton);
    let mut triplets = Triplets::new();
    assert_eq!(triplets.fill(elements, &gauss_newton, &DofMap::standard(2), Triangle::Full), Ok(1));
    assert_eq!(triplets.len(), 36);
    let open: &[ElementView<'_>] = &[element(ContactView { gap: 0.1, ..without })];
    assert_eq!(triplets.fill(open, &good, &DofMap::standard(2), Triangle::Full), Ok(0));
}

#[test]
fn wrong_lengths_of_the_output_are_refused() {
    let case = Case::with_distinct_nodes(5, 3, 3, 2);
    let views = case.views();
    let dofs = DofMap::standard(5);
    let law = ContactLaw::penalty(1.0);
    assert_eq!(
        add_forces(views.as_slice(), &law, &dofs, &mut [0.0; 14]),
        Err(AssemblyError::OutputLength { what: "forces", found: 14, expected: 15 })
    );
    let pattern = CsrPattern::union(views.as_slice(), &dofs).unwrap();
    let expected = pattern.entries();
    assert_eq!(
        pattern.fill(views.as_slice(), &law, &mut vec![0.0; expected + 1]),
        Err(AssemblyError::OutputLength { what: "values", found: expected + 1, expected })
    );
}

#[test]
fn sums_that_leave_the_range_of_numbers_are_refused() {
    let (gradient, hessian) = ([1.0, 0.0, 0.0, 0.0, 1e200, 0.0], [0.0; 21]);
    let contact = ContactView { gap: -1e150, area: 1.0, gradient: &gradient, hessian: &hessian, slip: None };
    let elements: &[ElementView<'_>] = &[ElementView { slave: 0, masters: &[1], contact: Some(contact) }];
    let dofs = DofMap::standard(2);
    let law = ContactLaw::penalty(1.0);
    let overflow = |what| AssemblyError::Overflow { what, equation: 4 };
    assert_eq!(add_forces(elements, &law, &dofs, &mut [0.0; 6]), Err(overflow("forces")));
    let mut triplets = Triplets::new();
    assert_eq!(triplets.fill(elements, &law, &dofs, Triangle::Lower), Err(overflow("values")));
    assert!(triplets.is_empty());
    let pattern = CsrPattern::union(elements, &dofs).unwrap();
    assert_eq!(pattern.fill(elements, &law, &mut [0.0; 36]), Err(overflow("values")));
    // A NaN that was there before is not passed on with an ok either.
    let fine: &[ElementView<'_>] = &[ElementView { contact: None, ..elements[0] }];
    let mut values = [0.0; 36];
    values[10] = f64::NAN;
    assert_eq!(
        pattern.add(fine, &law, &mut values),
        Err(AssemblyError::Overflow { what: "values", equation: 1 })
    );
    assert_eq!(pattern.fill(fine, &law, &mut values), Ok(0));
    assert_eq!(values, [0.0; 36]);
}

#[test]
fn what_does_not_fit_into_memory_is_refused() {
    let none: &[ElementView<'_>] = &[];
    let error = CsrPattern::union(none, &DofMap::standard(usize::MAX)).unwrap_err();
    assert_eq!(error, AssemblyError::TooLarge { what: "nodes", count: usize::MAX / 3 });
    let endless = DofMap::new(usize::MAX, [[Some(0), None, Some(usize::MAX - 1)]]).unwrap();
    let error = CsrPattern::union(none, &endless).unwrap_err();
    assert_eq!(error.code(), "too-large");
}
