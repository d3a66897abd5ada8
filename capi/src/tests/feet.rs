//! The feet are those of the runtime, bit for bit.

use std::ptr::null_mut;

use runtime::interface::{ContactFeet, ContactInterface, InterfaceOptions};
use runtime::surface::{Facet, MasterSurface};

use super::{Mesh, message};
use crate::feet::dc_feet;
use crate::interface::{dc_destroy, dc_refresh, dc_update};
use crate::outcome::dc_outcome::{DC_BEYOND_BORDER, DC_BEYOND_CENTRE_OF_CURVATURE, DC_CONTACT};
use crate::status::{DC_BAD_POINTER, DC_BAD_SIZE, DC_OK};

/// Outcomes, weights, and derivatives of foot and normal.
struct Arrays {
    outcomes: Vec<i32>,
    numbers: [Vec<f64>; 3],
}

/// Those of the runtime, with zeros where there is no contact.
fn expected(mesh: &Mesh, moved: &[f64]) -> Arrays {
    let points = |numbers: &[f64]| numbers.as_chunks::<3>().0.to_vec();
    let quadrilateral = |row: &[i32; 4]| Facet::Quadrilateral(row.map(|node| node as usize));
    let facets = mesh.facets.as_chunks::<4>().0.iter().map(quadrilateral).collect();
    let positions = points(&mesh.positions);
    let master = MasterSurface::new(&positions, facets).unwrap();
    let slaves = mesh.slaves.iter().map(|&node| node as usize).collect();
    let options = InterfaceOptions::default();
    let mut interface = ContactInterface::new(master, slaves, &[], &positions, options).unwrap();
    interface.refresh_pairing(&positions).unwrap();
    interface.update(&points(moved)).unwrap();
    let feet = interface.foot_derivatives().unwrap();
    assert!(!feet.get(1).nodes.is_empty() && feet.get(3).nodes.is_empty());
    arrays(&feet)
}

fn arrays(feet: &ContactFeet) -> Arrays {
    let mut arrays = Arrays { outcomes: Vec::new(), numbers: [const { Vec::new() }; 3] };
    for foot in feet.iter() {
        arrays.outcomes.push(crate::outcome::of(&foot.outcome) as i32);
        let (n, rows) = (foot.nodes.len(), 9 * (foot.nodes.len() + 1));
        for (all, (found, count)) in
            arrays.numbers.iter_mut().zip([(foot.weights, n), (foot.foot, rows), (foot.normal, rows)])
        {
            let end = all.len() + count;
            all.extend_from_slice(found);
            all.resize(end, 0.0);
        }
    }
    arrays
}

#[test]
fn feet_are_those_of_the_runtime() {
    let mut mesh = Mesh::new();
    // Two without contact: a slave beyond the border, and one that has moved through the ridge, deeper than its centre of curvature.
    mesh.positions[3 * 39] = -3.0;
    let mut moved = mesh.positions.clone();
    moved[3 * 37 + 2] -= 15.0;
    let Arrays { outcomes: kinds, numbers: [weights, foot, normal] } = expected(&mesh, &moved);
    assert_eq!(
        kinds,
        [DC_CONTACT, DC_BEYOND_CENTRE_OF_CURVATURE, DC_CONTACT, DC_BEYOND_BORDER].map(|kind| kind as i32)
    );

    let (status, handle) = mesh.make(&super::options());
    assert_eq!(status, DC_OK);
    let mut outcomes = vec![-1; 4];
    let [mut phi, mut by_foot, mut by_normal] =
        [&weights, &foot, &normal].map(|numbers| vec![f64::NAN; numbers.len()]);
    let (n, rows) = (phi.len(), by_foot.len());
    let at = by_foot.as_mut_ptr();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_refresh(handle, mesh.positions.as_ptr(), 40, null_mut()), DC_OK);
        assert_eq!(dc_update(handle, moved.as_ptr(), 40), DC_OK);
        let short = dc_feet(handle, null_mut(), 4, phi.as_mut_ptr(), n - 1, null_mut(), 0, null_mut(), 0);
        assert_eq!(short, DC_BAD_SIZE);
        assert!(message().contains(&format!("needs {n}")), "{}", message());
        assert_eq!(dc_feet(handle, null_mut(), 4, null_mut(), 0, at, rows, at, rows), DC_BAD_POINTER);
        assert!(by_foot.iter().all(|x| x.is_nan()), "a refused call changes nothing");
        let status = dc_feet(
            handle,
            outcomes.as_mut_ptr(),
            4,
            phi.as_mut_ptr(),
            n,
            by_foot.as_mut_ptr(),
            rows,
            by_normal.as_mut_ptr(),
            rows,
        );
        assert_eq!(status, DC_OK, "{}", message());
        dc_destroy(handle);
    }
    assert_eq!(outcomes, kinds);
    assert_eq!([phi, by_foot, by_normal], [weights, foot, normal]);
}
