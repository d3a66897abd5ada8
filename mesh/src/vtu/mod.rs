//! Writes unstructured grids in VTK's XML format (`.vtu`), as ParaView reads it: numbers bit for bit, appended as raw binary.
//!
//! ```
//! use diffuse_contact_mesh::{ElementKind, VtuFile};
//!
//! let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mut bytes = Vec::new();
//! VtuFile::new()
//!     .points(&points)
//!     .cell(ElementKind::Triangle3, &[0, 1, 2])
//!     .point_scalars("gap", &[0.1, 0.2, -0.3])
//!     .cell_i32("status", &[1])
//!     .write_to(&mut bytes)?;
//! assert!(bytes.starts_with(b"<?xml"));
//! # Ok::<(), diffuse_contact_mesh::VtuError>(())
//! ```

mod array;
mod error;

use std::borrow::Cow;
use std::collections::HashSet;
use std::io::{self, Write};
use std::path::Path;

use crate::element::{Cell, ElementKind};
use array::{Values, escaped, is_xml_text};
pub use error::{Attached, VtuError};

/// An unstructured grid with data on its points and cells, put together call by call and then written.
///
/// Nothing is checked before it is written, so the calls may come in any order. Data is borrowed or owned,
/// whichever is given.
#[derive(Clone, Debug, Default)]
pub struct VtuFile<'a> {
    points: Cow<'a, [[f64; 3]]>,
    cells: Cells,
    point_data: Vec<Field<'a>>,
    cell_data: Vec<Field<'a>>,
}

/// Cells as VTK stores them.
#[derive(Clone, Debug, Default)]
struct Cells {
    kinds: Vec<ElementKind>,
    connectivity: Vec<usize>,
    /// For each cell, the end of its nodes in `connectivity`.
    ends: Vec<usize>,
}

impl Cells {
    fn push(&mut self, kind: ElementKind, nodes: &[usize]) {
        self.kinds.push(kind);
        self.connectivity.extend(nodes);
        self.ends.push(self.connectivity.len());
    }

    /// Every cell's kind and nodes.
    fn iter(&self) -> impl Iterator<Item = (ElementKind, &[usize])> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        let nodes = begins.zip(&self.ends).map(|(begin, &end)| &self.connectivity[begin..end]);
        self.kinds.iter().copied().zip(nodes)
    }

    /// All nodes, each cell's in the order that VTK has.
    fn in_order_of_vtk(&self) -> Vec<usize> {
        let mut connectivity = self.connectivity.clone();
        for (kind, end) in self.kinds.iter().zip(&self.ends) {
            // The right-hand rule makes the first triangle look away from the other one, which it faces here.
            if *kind == ElementKind::Wedge6 {
                connectivity.swap(end - 5, end - 4);
                connectivity.swap(end - 2, end - 1);
            }
        }
        connectivity
    }

    fn check(&self, points: usize) -> Result<(), VtuError> {
        for (cell, (kind, nodes)) in self.iter().enumerate() {
            if nodes.len() != kind.node_count() {
                return Err(VtuError::CellNodeCount {
                    cell,
                    kind: kind.name(),
                    expected: kind.node_count(),
                    found: nodes.len(),
                });
            }
            if let Some(&node) = nodes.iter().find(|&&node| node >= points) {
                return Err(VtuError::NodeOutOfRange { cell, node, points });
            }
        }
        Ok(())
    }
}

/// A named array on the points or on the cells.
#[derive(Clone, Debug)]
struct Field<'a> {
    name: String,
    values: Values<'a>,
}

impl<'a> VtuFile<'a> {
    /// An empty grid.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the points, in place of any given before.
    pub fn points(mut self, points: impl Into<Cow<'a, [[f64; 3]]>>) -> Self {
        self.points = points.into();
        self
    }

    /// Adds cells: elements, facets, or pairs of kind and nodes.
    pub fn cells<C: Cell>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        for cell in cells {
            self.cells.push(cell.kind(), cell.nodes());
        }
        self
    }

    /// Adds one cell.
    pub fn cell(mut self, kind: ElementKind, nodes: &[usize]) -> Self {
        self.cells.push(kind, nodes);
        self
    }

    /// Adds a number for each point.
    pub fn point_scalars(self, name: impl Into<String>, values: impl Into<Cow<'a, [f64]>>) -> Self {
        self.point_field(name, Values::Scalars(values.into()))
    }

    /// Adds a vector for each point.
    pub fn point_vectors(self, name: impl Into<String>, values: impl Into<Cow<'a, [[f64; 3]]>>) -> Self {
        self.point_field(name, Values::Vectors(values.into()))
    }

    /// Adds a symmetric tensor, xx, yy, zz, xy, yz, xz, for each point.
    pub fn point_tensors(self, name: impl Into<String>, values: impl Into<Cow<'a, [[f64; 6]]>>) -> Self {
        self.point_field(name, Values::Tensors(values.into()))
    }

    /// Adds an integer for each point.
    pub fn point_i32(self, name: impl Into<String>, values: impl Into<Cow<'a, [i32]>>) -> Self {
        self.point_field(name, Values::I32(values.into()))
    }

    /// Adds an integer for each cell.
    pub fn cell_i32(mut self, name: impl Into<String>, values: impl Into<Cow<'a, [i32]>>) -> Self {
        self.cell_data.push(Field { name: name.into(), values: Values::I32(values.into()) });
        self
    }

    /// Checks the grid and writes it to a file, which appears whole or not at all: it is written under another
    /// name in the same directory and then renamed. A file of this name is replaced.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), VtuError> {
        let path = path.as_ref();
        self.check()?;
        crate::file::replace(path, |writer| self.write_grid(writer))
            .map_err(|cause| VtuError::Write { path: path.to_path_buf(), cause })
    }

    /// Checks the grid and writes it to `writer`.
    pub fn write_to(&self, writer: &mut impl Write) -> Result<(), VtuError> {
        self.check()?;
        self.write_grid(writer).map_err(|cause| VtuError::Output { cause })
    }

    fn point_field(mut self, name: impl Into<String>, values: Values<'a>) -> Self {
        self.point_data.push(Field { name: name.into(), values });
        self
    }

    fn check(&self) -> Result<(), VtuError> {
        if let Some(point) = self.points.iter().position(|point| point.iter().any(|x| !x.is_finite())) {
            return Err(VtuError::NonFinitePoint { point });
        }
        self.cells.check(self.points.len())?;
        Self::check_fields(&self.point_data, Attached::Points, self.points.len())?;
        Self::check_fields(&self.cell_data, Attached::Cells, self.cells.kinds.len())
    }

    fn check_fields(fields: &[Field], attached: Attached, expected: usize) -> Result<(), VtuError> {
        let mut names = HashSet::new();
        for Field { name, values } in fields {
            if name.is_empty() || !is_xml_text(name) {
                return Err(VtuError::InvalidName { name: name.clone() });
            }
            if !names.insert(name) {
                return Err(VtuError::DuplicateName { name: name.clone(), attached });
            }
            let found = values.layout().count;
            if found != expected {
                return Err(VtuError::LengthMismatch { name: name.clone(), attached, expected, found });
            }
        }
        Ok(())
    }

    /// Writes the XML and, after it, the binary numbers to which the XML's offsets refer.
    fn write_grid(&self, writer: &mut impl Write) -> io::Result<()> {
        let (points, cells) = (self.points.len(), self.cells.kinds.len());
        let places = Values::Vectors(Cow::from(&*self.points));
        let connectivity = Values::Indices(Cow::from(self.cells.in_order_of_vtk()));
        let offsets = Values::Indices(Cow::from(&self.cells.ends));
        let types = Values::U8(self.cells.kinds.iter().map(|&kind| vtk_type(kind)).collect());
        let mut xml = Xml { writer, appended: Vec::new(), offset: 0 };
        writeln!(
            xml.writer,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n\
             <UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
        )?;
        xml.section("PointData", self.point_data.iter().map(Field::named))?;
        xml.section("CellData", self.cell_data.iter().map(Field::named))?;
        xml.section("Points", [("Points", &places)])?;
        xml.section("Cells", [("connectivity", &connectivity), ("offsets", &offsets), ("types", &types)])?;
        writeln!(xml.writer, "</Piece>\n</UnstructuredGrid>")?;
        xml.finish()
    }
}

impl<'a> Field<'a> {
    fn named(&self) -> (&str, &Values<'a>) {
        (&self.name, &self.values)
    }
}

/// VTK's number of a cell type. VTK orders the nodes of these as [`ElementKind`] does, but those of the wedge of six nodes.
fn vtk_type(kind: ElementKind) -> u8 {
    match kind {
        ElementKind::Point1 => 1,
        ElementKind::Line2 => 3,
        ElementKind::Line3 => 21,
        ElementKind::Triangle3 => 5,
        ElementKind::Triangle6 => 22,
        ElementKind::Quadrilateral4 => 9,
        ElementKind::Quadrilateral8 => 23,
        ElementKind::Quadrilateral9 => 28,
        ElementKind::Tetrahedron4 => 10,
        ElementKind::Tetrahedron10 => 24,
        ElementKind::Wedge6 => 13,
        ElementKind::Wedge15 => 26,
        ElementKind::Hexahedron8 => 12,
        ElementKind::Hexahedron20 => 25,
        ElementKind::Hexahedron27 => 29,
    }
}

/// The file under way.
struct Xml<'w, 'd, W> {
    writer: &'w mut W,
    /// Arrays announced in the XML, to follow it.
    appended: Vec<&'d Values<'d>>,
    /// Bytes of `appended`.
    offset: usize,
}

impl<'d, W: Write> Xml<'_, 'd, W> {
    fn section<'n>(
        &mut self,
        name: &str,
        arrays: impl IntoIterator<Item = (&'n str, &'d Values<'d>)>,
    ) -> io::Result<()> {
        writeln!(self.writer, "<{name}>")?;
        for (name, array) in arrays {
            let (layout, name, offset) = (array.layout(), escaped(name), self.offset);
            write!(self.writer, "<DataArray type=\"{}\" Name=\"{name}\"", layout.kind)?;
            // Readers such as meshio give an array of n × 1 numbers where one component is named.
            if layout.components > 1 {
                write!(self.writer, " NumberOfComponents=\"{}\"", layout.components)?;
            }
            writeln!(self.writer, " format=\"appended\" offset=\"{offset}\"/>")?;
            self.offset += layout.appended_bytes();
            self.appended.push(array);
        }
        writeln!(self.writer, "</{name}>")
    }

    fn finish(self) -> io::Result<()> {
        write!(self.writer, "<AppendedData encoding=\"raw\">\n_")?;
        self.appended.iter().try_for_each(|array| array.write(self.writer))?;
        writeln!(self.writer, "\n</AppendedData>\n</VTKFile>")
    }
}
