//! The state at the end of an increment as a VTU file, and the list of them.

use std::path::Path;

use diffuse_contact_mesh::{ElementKind, VtuError, VtuFile};

use super::directory::Directory;
use super::{Fields, OutputError, names};
use crate::model::Model;

/// Name of a picture in the directory of results.
pub fn name(number: usize) -> String {
    format!("{}/{number:05}.vtu", names::PICTURES)
}

/// Writes a picture: the mesh at the start, `fields` at its nodes. Cells carry `part`, the place of their body among
/// all of them; rigid surfaces have the number of bodies.
pub fn write(
    directory: &Directory,
    number: usize,
    model: &Model,
    start: &[[f64; 3]],
    fields: &Fields,
) -> Result<(), OutputError> {
    let mut parts = Vec::new();
    let mut picture = VtuFile::new().points(start);
    for (k, body) in model.bodies.iter().enumerate() {
        for cell in body.elements.iter() {
            picture = picture.cell(cell.kind, cell.nodes);
            parts.push(k as i32);
        }
    }
    for facet in model.rigid_parts().flat_map(|(_, facets)| facets) {
        let kind = match facet.corners().len() {
            3 => ElementKind::Triangle3,
            _ => ElementKind::Quadrilateral4,
        };
        picture = picture.cell(kind, facet.corners());
        parts.push(model.bodies.len() as i32);
    }
    picture = picture.point_vectors("displacement", &fields.displacement[..]);
    if let Some(stresses) = &fields.stresses {
        picture = picture
            .point_tensors("stress", &stresses.stress[..])
            .point_scalars("von_mises", &stresses.von_mises[..])
            .point_scalars("plastic_strain", &stresses.plastic_strain[..]);
    }
    if let Some(friction) = &fields.friction {
        picture = picture
            .point_scalars("contact_slip", &friction.slip[..])
            .point_vectors("contact_friction", &friction.traction[..])
            .point_i32("friction_status", &friction.status[..]);
    }
    let path = directory.path(&name(number));
    picture
        .point_scalars("contact_gap", &fields.contact_gap[..])
        .point_scalars("contact_pressure", &fields.contact_pressure[..])
        .point_i32("contact_status", &fields.contact_status[..])
        .point_i32("contact_basis", &fields.contact_basis[..])
        .cell_i32("part", &parts[..])
        .write(&path)
        .map_err(not_written(&path))
}

/// The error of a file that was not written.
pub fn not_written(path: &Path) -> impl Fn(VtuError) -> OutputError + '_ {
    |error| {
        OutputError::write(path)(match error {
            VtuError::Write { cause, .. } | VtuError::Output { cause } => cause,
            other => std::io::Error::other(other.to_string()),
        })
    }
}

/// Writes the list of pictures, each a number and a time.
pub fn write_series(directory: &Directory, series: &[(usize, f64)]) -> Result<(), OutputError> {
    write_list(directory, names::SERIES, series, name)
}

/// Writes a list of numbered files.
pub fn write_list(
    directory: &Directory,
    list: &str,
    series: &[(usize, f64)],
    name: impl Fn(usize) -> String,
) -> Result<(), OutputError> {
    directory.write(list, |writer| {
        writeln!(writer, "<?xml version=\"1.0\"?>")?;
        writeln!(writer, "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">")?;
        writeln!(writer, "  <Collection>")?;
        for &(number, time) in series {
            let file = name(number);
            writeln!(writer, "    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>")?;
        }
        writeln!(writer, "  </Collection>\n</VTKFile>")
    })
}
