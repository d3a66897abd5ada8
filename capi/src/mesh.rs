//! What interfaces and contact over faces are made of, from arrays of the caller: nodes, facets, planes of symmetry, equations.

use runtime::Point;
use runtime::assembly::DofMap;
use runtime::surface::{Facet, SymmetryPlane};

use crate::border::{disjoint, input, reserve, target, wanted};
use crate::status::{DC_BAD_POINTER, DC_BAD_SIZE, DC_OUT_OF_RANGE, DC_TOO_LARGE, Failure};

/// Slave nodes.
pub fn slaves_of(slaves: &[i32]) -> Result<Vec<usize>, Failure> {
    let index = |(k, &node): (usize, &i32)| {
        usize::try_from(node).map_err(|_| {
            Failure::new(DC_OUT_OF_RANGE, format!("slave-out-of-range: slave {k} is node {node}"))
        })
    };
    let mut nodes = reserve("slaves", slaves.len())?;
    for slave in slaves.iter().enumerate() {
        nodes.push(index(slave)?);
    }
    Ok(nodes)
}

/// Refuses an array that has not an entry for each slave.
pub fn expect_slaves(slaves: &[usize], found: usize) -> Result<(), Failure> {
    let expected = slaves.len();
    if found == expected {
        return Ok(());
    }
    Err(Failure::new(DC_BAD_SIZE, format!("bad-size: {found} entries for {expected} slaves")))
}

/// Writes the nodes of slaves.
///
/// # Safety
/// `into` has `count` entries.
pub unsafe fn write_slaves(slaves: &[usize], into: *mut i32, count: usize) -> Result<(), Failure> {
    expect_slaves(slaves, count)?;
    let into = target("slaves", into, count)?;
    unsafe { into.write(slaves.iter().map(|&node| node as i32)) };
    Ok(())
}

/// Writes numbers of nodes and of slaves.
///
/// # Safety
/// Each is NULL or may be written.
pub unsafe fn write_counts(
    nodes: usize,
    slaves: &[usize],
    node_count: *mut usize,
    slave_count: *mut usize,
) -> Result<(), Failure> {
    let node_count = wanted("node_count", node_count, 1, 1)?;
    let slave_count = wanted("slave_count", slave_count, 1, 1)?;
    disjoint([node_count.span(), slave_count.span()])?;
    unsafe {
        node_count.write([nodes]);
        slave_count.write([slaves.len()]);
    }
    Ok(())
}

/// Counts in an array of the caller, 3 numbers for each node.
///
/// # Safety
/// As [`input`].
pub unsafe fn points<'a>(positions: *const f64, nodes: usize) -> Result<&'a [Point], Failure> {
    let too_many = || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {nodes} nodes"));
    let count = nodes.checked_mul(3).ok_or_else(too_many)?;
    let (points, _) = unsafe { input("positions", positions, count)? }.as_chunks::<3>();
    Ok(points)
}

/// Facets from rows of four nodes.
pub fn facets_of(rows: &[i32]) -> Result<Vec<Facet>, Failure> {
    let (rows, _) = rows.as_chunks::<4>();
    let node = |facet: usize, node: i32| {
        usize::try_from(node).map_err(|_| {
            let message = format!("node-out-of-range: facet {facet} has node {node} for a corner");
            Failure::new(DC_OUT_OF_RANGE, message)
        })
    };
    let facet = |(k, &[a, b, c, d]): (usize, &[i32; 4])| -> Result<Facet, Failure> {
        let [a, b, c] = [node(k, a)?, node(k, b)?, node(k, c)?];
        Ok(if d == -1 { Facet::Triangle([a, b, c]) } else { Facet::Quadrilateral([a, b, c, node(k, d)?]) })
    };
    let mut facets = reserve("facets", rows.len())?;
    for row in rows.iter().enumerate() {
        facets.push(facet(row)?);
    }
    Ok(facets)
}

/// An array of facets.
///
/// # Safety
/// As [`input`].
pub unsafe fn facet_rows<'a>(name: &str, rows: *const i32, count: usize) -> Result<&'a [i32], Failure> {
    let too_many = || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {count} {name}"));
    unsafe { input(name, rows, count.checked_mul(4).ok_or_else(too_many)?) }
}

/// Planes of symmetry, 6 numbers each.
///
/// # Safety
/// As [`input`].
pub unsafe fn symmetry_planes(planes: *const f64, plane_count: usize) -> Result<Vec<SymmetryPlane>, Failure> {
    let too_many = || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {plane_count} planes"));
    let count = plane_count.checked_mul(6).ok_or_else(too_many)?;
    let (rows, _) = unsafe { input("planes", planes, count)? }.as_chunks::<6>();
    let plane = |&[x, y, z, a, b, c]: &[f64; 6]| SymmetryPlane { point: [x, y, z], normal: [a, b, c] };
    let mut planes = reserve("planes", rows.len())?;
    planes.extend(rows.iter().map(plane));
    Ok(planes)
}

/// The equations of so many nodes.
///
/// # Safety
/// As [`input`].
pub unsafe fn equations_of(
    equations: *const i32,
    (node_count, equation_count): (usize, usize),
    nodes: usize,
) -> Result<DofMap, Failure> {
    if equations.is_null() {
        if (node_count, equation_count) != (0, 0) {
            let message = format!(
                "bad-pointer: equations is NULL, which goes with no counts, not with {node_count} nodes and \
                 {equation_count} equations"
            );
            return Err(Failure::new(DC_BAD_POINTER, message));
        }
        return Ok(DofMap::standard(nodes));
    }
    if node_count != nodes {
        let message = format!("bad-size: equations of {node_count} nodes, but there are {nodes}");
        return Err(Failure::new(DC_BAD_SIZE, message));
    }
    let numbers = unsafe { input("equations", equations, 3 * node_count)? };
    if let Some((place, number)) = numbers.iter().enumerate().find(|(_, number)| **number < -1) {
        let message =
            format!("unknown-equation: axis {} of node {} has equation {number}", place % 3, place / 3);
        return Err(Failure::new(DC_OUT_OF_RANGE, message));
    }
    let (rows, _) = numbers.as_chunks::<3>();
    let rows = rows.iter().map(|row| row.map(|number| usize::try_from(number).ok()));
    Ok(DofMap::new(equation_count, rows)?)
}

/// Whether nodes can be named by the indices of C.
pub fn check_nodes(count: usize) -> Result<(), Failure> {
    if i32::try_from(count).is_err() {
        let message = format!("too-many: {count} nodes are more than 32-bit indices can name");
        return Err(Failure::new(DC_TOO_LARGE, message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_facets() {
        let read = facets_of(&[0, 1, 2, -1, 4, 5, 6, 7]).unwrap();
        assert_eq!(read, [Facet::Triangle([0, 1, 2]), Facet::Quadrilateral([4, 5, 6, 7])]);
        assert_eq!(facets_of(&[0, -1, 2, 3]).unwrap_err().status, DC_OUT_OF_RANGE);
        assert_eq!(facets_of(&[0, 1, 2, -2]).unwrap_err().status, DC_OUT_OF_RANGE);
    }
}
