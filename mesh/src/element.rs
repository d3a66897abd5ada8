//! Elements and facets: a kind and the nodes in the order that Gmsh, Abaqus and VTK share.

/// The kinds of element this crate knows; all are first order. Gmsh, Abaqus and VTK order their nodes alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ElementKind {
    /// A single node.
    Point1,
    /// Two nodes.
    Line2,
    /// Three nodes; the right-hand rule gives the normal.
    Triangle3,
    /// Four nodes in cyclic order; the right-hand rule gives the normal.
    Quadrilateral4,
    /// A base triangle, then the apex on the side of the base's normal.
    Tetrahedron4,
    /// A base quadrilateral, then the opposite one, on the side of the base's normal, in the same sense.
    Hexahedron8,
}

impl ElementKind {
    /// The number of nodes.
    pub const fn node_count(self) -> usize {
        match self {
            ElementKind::Point1 => 1,
            ElementKind::Line2 => 2,
            ElementKind::Triangle3 => 3,
            ElementKind::Quadrilateral4 | ElementKind::Tetrahedron4 => 4,
            ElementKind::Hexahedron8 => 8,
        }
    }

    /// The number of parametric dimensions, 0 to 3.
    pub const fn dimension(self) -> usize {
        match self {
            ElementKind::Point1 => 0,
            ElementKind::Line2 => 1,
            ElementKind::Triangle3 | ElementKind::Quadrilateral4 => 2,
            ElementKind::Tetrahedron4 | ElementKind::Hexahedron8 => 3,
        }
    }

    /// The usual word, in the singular.
    pub const fn name(self) -> &'static str {
        match self {
            ElementKind::Point1 => "point",
            ElementKind::Line2 => "line",
            ElementKind::Triangle3 => "triangle",
            ElementKind::Quadrilateral4 => "quadrilateral",
            ElementKind::Tetrahedron4 => "tetrahedron",
            ElementKind::Hexahedron8 => "hexahedron",
        }
    }

    pub(crate) const fn plural(self) -> &'static str {
        match self {
            ElementKind::Point1 => "points",
            ElementKind::Line2 => "lines",
            ElementKind::Triangle3 => "triangles",
            ElementKind::Quadrilateral4 => "quadrilaterals",
            ElementKind::Tetrahedron4 => "tetrahedra",
            ElementKind::Hexahedron8 => "hexahedra",
        }
    }

    /// The faces of a solid, oriented outward, in Abaqus' order `S1`, `S2`, ...; empty for other kinds.
    pub(crate) const fn faces(self) -> &'static [&'static [usize]] {
        match self {
            ElementKind::Tetrahedron4 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            ElementKind::Hexahedron8 => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
            _ => &[],
        }
    }
}

/// An element of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    kind: ElementKind,
    tag: u64,
    /// The first `kind.node_count()` count, the rest is zero.
    nodes: [usize; 8],
}

impl Element {
    /// `nodes` beyond the kind's count must be zero.
    pub(crate) fn new(kind: ElementKind, tag: u64, nodes: [usize; 8]) -> Self {
        Self { kind, tag, nodes }
    }

    /// The kind of element.
    pub fn kind(&self) -> ElementKind {
        self.kind
    }

    /// The number the file gives this element.
    pub fn tag(&self) -> u64 {
        self.tag
    }

    /// Indices of the nodes.
    pub fn nodes(&self) -> &[usize] {
        &self.nodes[..self.kind.node_count()]
    }

    /// The element as a facet, if it is a triangle or a quadrilateral.
    pub fn facet(&self) -> Option<Facet> {
        match self.kind {
            ElementKind::Triangle3 | ElementKind::Quadrilateral4 => Facet::from_nodes(self.nodes()),
            _ => None,
        }
    }

    /// The face of a solid element, outward, `number` counted from 0.
    pub(crate) fn face(&self, number: usize) -> Option<Facet> {
        let corners = self.kind.faces().get(number)?;
        let nodes: Vec<usize> = corners.iter().map(|&corner| self.nodes[corner]).collect();
        Facet::from_nodes(&nodes)
    }
}

/// A facet of a surface: node indices, ordered so that the right-hand rule gives the normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facet {
    /// A triangle.
    Triangle([usize; 3]),
    /// A quadrilateral, nodes in cyclic order.
    Quadrilateral([usize; 4]),
}

impl Facet {
    /// A facet of three or four nodes; `None` for another number.
    pub fn from_nodes(nodes: &[usize]) -> Option<Self> {
        match *nodes {
            [a, b, c] => Some(Facet::Triangle([a, b, c])),
            [a, b, c, d] => Some(Facet::Quadrilateral([a, b, c, d])),
            _ => None,
        }
    }

    /// Indices of the nodes.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Facet::Triangle(nodes) => nodes,
            Facet::Quadrilateral(nodes) => nodes,
        }
    }

    /// The same facet seen from the other side: the first node stays first, the normal turns round.
    pub fn reversed(self) -> Self {
        match self {
            Facet::Triangle([a, b, c]) => Facet::Triangle([a, c, b]),
            Facet::Quadrilateral([a, b, c, d]) => Facet::Quadrilateral([a, d, c, b]),
        }
    }
}

/// Anything that can be written as a cell: it has a kind and nodes.
pub trait Cell {
    /// The kind of cell.
    fn kind(&self) -> ElementKind;
    /// Indices of its nodes.
    fn nodes(&self) -> &[usize];
}

impl Cell for Element {
    fn kind(&self) -> ElementKind {
        self.kind
    }

    fn nodes(&self) -> &[usize] {
        Element::nodes(self)
    }
}

impl Cell for Facet {
    fn kind(&self) -> ElementKind {
        match self {
            Facet::Triangle(_) => ElementKind::Triangle3,
            Facet::Quadrilateral(_) => ElementKind::Quadrilateral4,
        }
    }

    fn nodes(&self) -> &[usize] {
        Facet::nodes(self)
    }
}

impl Cell for (ElementKind, &[usize]) {
    fn kind(&self) -> ElementKind {
        self.0
    }

    fn nodes(&self) -> &[usize] {
        self.1
    }
}

impl<C: Cell + ?Sized> Cell for &C {
    fn kind(&self) -> ElementKind {
        (**self).kind()
    }

    fn nodes(&self) -> &[usize] {
        (**self).nodes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the area vector of a facet, by the diagonals or edges.
    fn area_vector(facet: Facet, points: &[[f64; 3]]) -> [f64; 3] {
        let p = |i: usize| points[i];
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let (u, v) = match facet {
            Facet::Triangle([a, b, c]) => (minus(p(b), p(a)), minus(p(c), p(a))),
            Facet::Quadrilateral([a, b, c, d]) => (minus(p(c), p(a)), minus(p(d), p(b))),
        };
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    }

    /// The faces of a solid point outward if each area vector points away from the centre, and they close the
    /// solid if the area vectors add up to zero.
    fn assert_outward_and_closed(kind: ElementKind, points: &[[f64; 3]]) {
        let nodes = std::array::from_fn(|i| if i < kind.node_count() { i } else { 0 });
        let element = Element::new(kind, 1, nodes);
        let mean = |indices: &[usize]| -> [f64; 3] {
            std::array::from_fn(|k| indices.iter().map(|&i| points[i][k]).sum::<f64>() / indices.len() as f64)
        };
        let centre = mean(element.nodes());
        let mut sum = [0.0; 3];
        for number in 0..kind.faces().len() {
            let face = element.face(number).unwrap();
            let area = area_vector(face, points);
            let away = mean(face.nodes());
            let outward: f64 = (0..3).map(|k| area[k] * (away[k] - centre[k])).sum();
            assert!(outward > 0.0, "face {number} of {kind:?} points inward");
            (0..3).for_each(|k| sum[k] += area[k]);
        }
        assert_eq!(sum, [0.0; 3]);
    }

    #[test]
    fn faces_of_solids_point_outward() {
        let cube = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i % 4];
            [corner[0], corner[1], (i / 4) as f64]
        });
        assert_outward_and_closed(ElementKind::Hexahedron8, &cube);
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_outward_and_closed(ElementKind::Tetrahedron4, &corner);
    }

    #[test]
    fn faces_follow_the_numbers_of_abaqus() {
        // Node numbers of S1 to S6 as in the manual (any order, from 1).
        let manual: [[usize; 4]; 6] =
            [[1, 2, 3, 4], [5, 6, 7, 8], [1, 2, 5, 6], [2, 3, 6, 7], [3, 4, 7, 8], [1, 4, 5, 8]];
        for (face, expected) in ElementKind::Hexahedron8.faces().iter().zip(manual) {
            let mut corners: Vec<usize> = face.iter().map(|corner| corner + 1).collect();
            corners.sort_unstable();
            assert_eq!(corners, expected);
        }
        let manual: [[usize; 3]; 4] = [[1, 2, 3], [1, 2, 4], [2, 3, 4], [1, 3, 4]];
        for (face, expected) in ElementKind::Tetrahedron4.faces().iter().zip(manual) {
            let mut corners: Vec<usize> = face.iter().map(|corner| corner + 1).collect();
            corners.sort_unstable();
            assert_eq!(corners, expected);
        }
    }

    #[test]
    fn reversing_turns_the_normal_and_undoes_itself() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        for facet in [Facet::Triangle([0, 1, 2]), Facet::Quadrilateral([0, 1, 2, 3])] {
            let (area, turned) = (area_vector(facet, &points), area_vector(facet.reversed(), &points));
            assert!(area[2] > 0.0);
            assert_eq!(turned[2], -area[2]);
            assert_eq!(facet.reversed().reversed(), facet);
        }
        assert_eq!(Facet::from_nodes(&[1, 2]), None);
    }
}
