//! Contact at the integration points of interfaces over faces, as VTU files.

use diffuse_contact::faces::IntegrationPoint;
use diffuse_contact_mesh::{ElementKind, VtuFile};

use super::directory::Directory;
use super::{OutputError, names, picture};
use crate::statics::Problem;

/// Name of a file of points in the directory of results.
pub fn name(number: usize) -> String {
    format!("{}/{number:05}.vtu", names::POINTS)
}

/// Writes the points over their masters at the last evaluation, each a cell; whether any interface is over faces.
pub fn write(directory: &Directory, number: usize, problem: &Problem) -> Result<bool, OutputError> {
    let path = directory.path(&name(number));
    let (mut points, mut interfaces): (Vec<IntegrationPoint>, Vec<i32>) = Default::default();
    let mut has_faces = false;
    for (interaction, place) in problem.contacts().interactions().iter().zip(0..) {
        let own = interaction
            .integration_points()
            .map_err(|error| OutputError::write(&path)(std::io::Error::other(error.to_string())))?;
        let Some(own) = own else { continue };
        has_faces = true;
        interfaces.resize(interfaces.len() + own.len(), place);
        points.extend(own);
    }
    if !has_faces {
        return Ok(false);
    }
    directory.make(names::POINTS)?;
    let scalars = |of: fn(&IntegrationPoint) -> f64| points.iter().map(of).collect::<Vec<_>>();
    let vectors = |of: fn(&IntegrationPoint) -> [f64; 3]| points.iter().map(of).collect::<Vec<_>>();
    let file = VtuFile::new().points(vectors(|point| point.position));
    (0..points.len())
        .fold(file, |file, k| file.cell(ElementKind::Point1, &[k]))
        .point_scalars("contact_gap", scalars(|point| point.gap))
        .point_scalars("contact_pressure", scalars(|point| point.pressure))
        .point_scalars("area", scalars(|point| point.area))
        .point_vectors("normal", vectors(|point| point.normal))
        .point_vectors("contact_friction", vectors(|point| point.friction))
        .point_i32("interface", interfaces)
        .write(&path)
        .map_err(picture::not_written(&path))?;
    Ok(true)
}
