//! Laws with friction for slaves that can have none: refused where they are handed in, whether or not anything touches.

use diffuse_contact::assembly::{
    AssemblyError, ContactLaw, CsrMap, CsrPattern, DofMap, TangentOperator, Triangle, Triplets, add_forces,
};
use diffuse_contact::friction::Coulomb;
use diffuse_contact::interface::{ContactInterface, InterfaceError, InterfaceOptions};
use diffuse_contact::{Mode, Point};

use crate::common::{Mesh, hull_layers};

const TOUCHES: Point = [2.2, 2.1, -0.1];
const IS_OPEN: Point = [2.2, 2.1, 0.1];

/// What forces, triplets, both ways to a sparse matrix and the operator say to the law.
fn answers(slave: Point, options: InterfaceOptions, coefficient: f64) -> [Result<(), AssemblyError>; 6] {
    let mut scene = Mesh::plane(4.0, 4.0, 1.0).paired(&[slave], options);
    let law = ContactLaw::penalty(400.0).with_friction(Some(Coulomb::new(coefficient, 300.0).unwrap()));
    let dofs = DofMap::standard(scene.positions.len());
    let mut forces = vec![0.0; dofs.equations()];
    let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
    let pattern = CsrPattern::union(contacts, &dofs).unwrap();
    let offsets: Vec<i64> = pattern.row_offsets().iter().map(|&offset| offset as i64).collect();
    let columns: Vec<i32> = pattern.columns().iter().map(|&column| column as i32).collect();
    let map = CsrMap::within(contacts, &dofs, &offsets, &columns).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    let answers = [
        add_forces(contacts, &law, &dofs, &mut forces).map(|_| ()),
        Triplets::new().fill(contacts, &law, &dofs, Triangle::Full).map(|_| ()),
        map.fill(contacts, &law, &mut values).map(|_| ()),
        law.validate_for(contacts),
        of_law(TangentOperator::new(&scene.interface, &law, &dofs)),
        fill_from(&map, &mut scene.interface, &law, &mut values),
    ];
    assert!(coefficient == 0.0 || forces.iter().all(|&force| force == 0.0));
    answers
}

/// Second derivatives that nobody holds.
fn fill_from(
    map: &CsrMap,
    interface: &mut ContactInterface,
    law: &ContactLaw<'_>,
    values: &mut [f64],
) -> Result<(), AssemblyError> {
    interface.evaluate(Mode::Gradient).unwrap();
    of_law(map.fill_from(interface, law, values))
}

fn of_law<T>(found: Result<T, InterfaceError>) -> Result<(), AssemblyError> {
    match found {
        Ok(_) => Ok(()),
        Err(InterfaceError::Law(error)) => Err(error),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn friction_without_kernels_or_domains_is_refused_where_it_is_handed_in() {
    for slave in [TOUCHES, IS_OPEN] {
        assert_eq!(answers(slave, hull_layers(), 0.2), [Err(AssemblyError::NoAnchors); 6]);
        assert_eq!(answers(slave, hull_layers(), 0.0), [Ok(()); 6]);
        assert_eq!(answers(slave, InterfaceOptions::default(), 0.0), [Ok(()); 6]);
        let smooth = answers(slave, InterfaceOptions::default(), 0.2);
        if cfg!(not(feature = "friction")) {
            assert_eq!(smooth, [Err(AssemblyError::NoFrictionKernels); 6]);
        } else if slave == IS_OPEN {
            assert_eq!(smooth, [Ok(()); 6]);
        } else {
            assert_eq!(smooth[0], Err(AssemblyError::NoSlip { element: 0 }));
        }
    }
    // Facets have friction in every build.
    assert_eq!(answers(IS_OPEN, InterfaceOptions::node_to_facet(), 0.2), [Ok(()); 6]);
}
