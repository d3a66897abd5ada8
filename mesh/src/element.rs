//! Elements and facets: a kind and the nodes in one order, that of Abaqus and VTK, as far as these agree.

/// The most nodes of any kind.
pub(crate) const MOST_NODES: usize = 27;

/// The kinds of element this crate knows. Corners come first. Of second-order kinds a node in the middle of each edge follows, as each
/// kind says; `a–b` is the edge between the corners a and b, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ElementKind {
    /// A single node.
    Point1,
    /// Two nodes.
    Line2,
    /// Two nodes and the middle.
    Line3,
    /// Three nodes; the right-hand rule gives the normal.
    Triangle3,
    /// A triangle and the middles of 0–1, 1–2, 2–0.
    Triangle6,
    /// Four nodes in cyclic order; the right-hand rule gives the normal.
    Quadrilateral4,
    /// A quadrilateral and the middles of 0–1, 1–2, 2–3, 3–0.
    Quadrilateral8,
    /// The same, then the centre.
    Quadrilateral9,
    /// A base triangle, then the apex on the side of the base's normal.
    Tetrahedron4,
    /// A tetrahedron and the middles of 0–1, 1–2, 2–0, 0–3, 1–3, 2–3.
    Tetrahedron10,
    /// A base triangle, then the opposite one, on the side of the base's normal, in the same sense.
    Wedge6,
    /// A wedge and the middles of 0–1, 1–2, 2–0, 3–4, 4–5, 5–3, 0–3, 1–4, 2–5.
    Wedge15,
    /// A base quadrilateral, then the opposite one, on the side of the base's normal, in the same sense.
    Hexahedron8,
    /// A hexahedron and the middles of 0–1, 1–2, 2–3, 3–0, 4–5, 5–6, 6–7, 7–4, 0–4, 1–5, 2–6, 3–7.
    Hexahedron20,
    /// The same, then the centres of the faces 0473, 1265, 0154, 3267, 0123, 4567, and the element's.
    Hexahedron27,
}

/// The description of a kind.
struct Table {
    nodes: usize,
    dimension: usize,
    name: &'static str,
    plural: &'static str,
    /// Corners of the faces of a solid, oriented outward, in Abaqus' order `S1`, `S2`, ...
    faces: &'static [&'static [usize]],
    /// Ends of the edges that have a middle, in the order of these.
    edges: &'static [[usize; 2]],
    /// Corners around the nodes at the centres of faces, or of a quadrilateral, in the order of these after the edges' middles.
    centres: &'static [[usize; 4]],
}

const TRIANGLE: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0]];
const QUADRILATERAL: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3], [3, 0]];
const TETRAHEDRON: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
const WEDGE: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
const HEXAHEDRON: &[[usize; 2]] =
    &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
const HEXAHEDRON_CENTRES: &[[usize; 4]] =
    &[[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]];

impl ElementKind {
    /// The solids.
    pub const SOLIDS: [Self; 7] = [
        Self::Tetrahedron4,
        Self::Tetrahedron10,
        Self::Wedge6,
        Self::Wedge15,
        Self::Hexahedron8,
        Self::Hexahedron20,
        Self::Hexahedron27,
    ];

    const fn table(self) -> Table {
        const fn flat(nodes: usize, dimension: usize, name: &'static str, plural: &'static str) -> Table {
            Table { nodes, dimension, name, plural, faces: &[], edges: &[], centres: &[] }
        }
        const fn solid(nodes: usize, name: &'static str, plural: &'static str) -> Table {
            flat(nodes, 3, name, plural)
        }
        const TETRAHEDRON_FACES: &[&[usize]] = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
        const WEDGE_FACES: &[&[usize]] =
            &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];
        const HEXAHEDRON_FACES: &[&[usize]] =
            &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
        match self {
            ElementKind::Point1 => flat(1, 0, "point", "points"),
            ElementKind::Line2 => flat(2, 1, "line", "lines"),
            ElementKind::Line3 => Table { edges: &[[0, 1]], ..flat(3, 1, "3-node line", "3-node lines") },
            ElementKind::Triangle3 => flat(3, 2, "triangle", "triangles"),
            ElementKind::Triangle6 => {
                Table { edges: TRIANGLE, ..flat(6, 2, "6-node triangle", "6-node triangles") }
            }
            ElementKind::Quadrilateral4 => flat(4, 2, "quadrilateral", "quadrilaterals"),
            ElementKind::Quadrilateral8 => {
                Table { edges: QUADRILATERAL, ..flat(8, 2, "8-node quadrilateral", "8-node quadrilaterals") }
            }
            ElementKind::Quadrilateral9 => Table {
                edges: QUADRILATERAL,
                centres: &[[0, 1, 2, 3]],
                ..flat(9, 2, "9-node quadrilateral", "9-node quadrilaterals")
            },
            ElementKind::Tetrahedron4 => {
                Table { faces: TETRAHEDRON_FACES, ..solid(4, "tetrahedron", "tetrahedra") }
            }
            ElementKind::Tetrahedron10 => Table {
                faces: TETRAHEDRON_FACES,
                edges: TETRAHEDRON,
                ..solid(10, "10-node tetrahedron", "10-node tetrahedra")
            },
            ElementKind::Wedge6 => Table { faces: WEDGE_FACES, ..solid(6, "wedge", "wedges") },
            ElementKind::Wedge15 => {
                Table { faces: WEDGE_FACES, edges: WEDGE, ..solid(15, "15-node wedge", "15-node wedges") }
            }
            ElementKind::Hexahedron8 => {
                Table { faces: HEXAHEDRON_FACES, ..solid(8, "hexahedron", "hexahedra") }
            }
            ElementKind::Hexahedron20 => Table {
                faces: HEXAHEDRON_FACES,
                edges: HEXAHEDRON,
                ..solid(20, "20-node hexahedron", "20-node hexahedra")
            },
            ElementKind::Hexahedron27 => Table {
                faces: HEXAHEDRON_FACES,
                edges: HEXAHEDRON,
                centres: HEXAHEDRON_CENTRES,
                ..solid(27, "27-node hexahedron", "27-node hexahedra")
            },
        }
    }

    /// The number of nodes.
    pub const fn node_count(self) -> usize {
        self.table().nodes
    }

    /// The number of corners.
    pub const fn corner_count(self) -> usize {
        let Table { nodes, edges, centres, .. } = self.table();
        // The last node of 27 belongs to no face.
        if nodes == 27 { 8 } else { nodes - edges.len() - centres.len() }
    }

    /// Whether there are nodes in the middle of edges: elements of second order.
    pub const fn has_middles(self) -> bool {
        !self.table().edges.is_empty()
    }

    /// The number of parametric dimensions, 0 to 3.
    pub const fn dimension(self) -> usize {
        self.table().dimension
    }

    /// The usual word, in the singular.
    pub const fn name(self) -> &'static str {
        self.table().name
    }

    pub(crate) const fn plural(self) -> &'static str {
        self.table().plural
    }

    /// Ends of the edges that have a node in their middle, in the order of these nodes.
    pub const fn edges(self) -> &'static [[usize; 2]] {
        self.table().edges
    }

    /// Corners around the nodes in the centres of faces, in the order of these nodes, which follow those of the edges.
    pub const fn centres(self) -> &'static [[usize; 4]] {
        self.table().centres
    }

    /// Corners of the faces of a solid, oriented outward, in Abaqus' order `S1`, `S2`, ...; empty for other kinds.
    pub const fn faces(self) -> &'static [&'static [usize]] {
        self.table().faces
    }

    /// The nodes of the face with these corners: the corners, the middles of its edges from the first corner on, its centre, as far as the
    /// kind has them.
    pub fn nodes_of(self, corners: &[usize]) -> Vec<usize> {
        let Table { edges, centres, .. } = self.table();
        let (count, own) = (corners.len(), self.corner_count());
        let middles = (0..count).filter_map(|k| {
            let ends = [corners[k], corners[(k + 1) % count]];
            let place = edges.iter().position(|edge| *edge == ends || *edge == [ends[1], ends[0]])?;
            Some(own + place)
        });
        let on_face = |centre: &[usize; 4]| corners.iter().all(|corner| centre.contains(corner));
        let centre = if count == 4 { centres.iter().position(on_face) } else { None };
        corners.iter().copied().chain(middles).chain(centre.map(|place| own + edges.len() + place)).collect()
    }

    /// The flat facets that a face with these corners, or a triangle or quadrilateral itself, is made of, by local nodes. A face with
    /// middle nodes has several: each node of it is a corner of some.
    pub fn facets_of(self, corners: &[usize]) -> Vec<Facet> {
        let (nodes, count) = (self.nodes_of(corners), corners.len());
        if nodes.len() < 2 * count {
            return Facet::from_nodes(corners).into_iter().collect();
        }
        let (middles, centre) = (&nodes[count..2 * count], nodes.get(2 * count));
        let around = |k: usize| [middles[(k + count - 1) % count], corners[k], middles[k]];
        match centre {
            Some(&centre) => (0..count)
                .map(|k| {
                    let [before, corner, after] = around(k);
                    Facet::Quadrilateral([corner, after, centre, before])
                })
                .collect(),
            None => {
                let at_corners = (0..count).map(|k| Facet::Triangle(around(k)));
                at_corners.chain(Facet::from_nodes(middles)).collect()
            }
        }
    }
}

/// An element of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    kind: ElementKind,
    tag: u64,
    /// The first `kind.node_count()` count, the rest is zero.
    nodes: [usize; MOST_NODES],
    incompatible_modes: bool,
}

impl Element {
    /// `nodes` beyond the kind's count must be zero.
    pub(crate) fn new(kind: ElementKind, tag: u64, nodes: [usize; MOST_NODES]) -> Self {
        Self { kind, tag, nodes, incompatible_modes: false }
    }

    pub(crate) fn with_incompatible_modes(self, incompatible_modes: bool) -> Self {
        Self { incompatible_modes, ..self }
    }

    /// Whether the file asks for incompatible modes: Abaqus' C3D8I and C3D8IH. It says nothing of shape and nodes.
    pub fn has_incompatible_modes(&self) -> bool {
        self.incompatible_modes
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

    /// The facets of a triangle or a quadrilateral: itself, or those between its nodes if it has nodes in the middle of its edges. Empty
    /// for other kinds.
    pub fn facets(&self) -> Vec<Facet> {
        if self.kind.dimension() != 2 {
            return Vec::new();
        }
        let corners: Vec<usize> = (0..self.kind.corner_count()).collect();
        self.numbered(self.kind.facets_of(&corners))
    }

    /// The facets of a face of a solid element, outward, `number` counted from 0; none if there is no such face.
    pub(crate) fn face(&self, number: usize) -> Vec<Facet> {
        let corners = self.kind.faces().get(number).copied().unwrap_or_default();
        self.numbered(self.kind.facets_of(corners))
    }

    fn numbered(&self, facets: Vec<Facet>) -> Vec<Facet> {
        facets.into_iter().map(|facet| facet.map(|node| self.nodes[node])).collect()
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

    /// The facet with other node indices.
    pub fn map(self, f: impl FnMut(usize) -> usize) -> Self {
        match self {
            Facet::Triangle(nodes) => Facet::Triangle(nodes.map(f)),
            Facet::Quadrilateral(nodes) => Facet::Quadrilateral(nodes.map(f)),
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

    /// Nodes of a solid with straight edges, from its corners.
    fn with_middles(kind: ElementKind, corners: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mean = |nodes: &[usize]| -> [f64; 3] {
            std::array::from_fn(|k| nodes.iter().map(|&i| corners[i][k]).sum::<f64>() / nodes.len() as f64)
        };
        let middles = kind.edges().iter().map(|ends| mean(ends));
        let centres = kind.table().centres.iter().map(|around| mean(around));
        let mut points: Vec<[f64; 3]> = corners.iter().copied().chain(middles).chain(centres).collect();
        if points.len() < kind.node_count() {
            points.push(mean(&[0, 1, 2, 3, 4, 5, 6, 7]));
        }
        points
    }

    /// The faces of a solid point outward if each area vector points away from the centre, and they close the solid if the area vectors
    /// add up to zero. Each node of a face is a corner of one of its facets.
    fn assert_outward_and_closed(kind: ElementKind, corners: &[[f64; 3]]) {
        let points = with_middles(kind, corners);
        assert_eq!(points.len(), kind.node_count());
        let nodes = std::array::from_fn(|i| if i < kind.node_count() { i } else { 0 });
        let element = Element::new(kind, 1, nodes);
        let mean = |indices: &[usize]| -> [f64; 3] {
            std::array::from_fn(|k| indices.iter().map(|&i| points[i][k]).sum::<f64>() / indices.len() as f64)
        };
        let centre = mean(element.nodes());
        let (mut sum, mut on_faces) = ([0.0; 3], std::collections::BTreeSet::new());
        for number in 0..kind.faces().len() {
            for facet in element.face(number) {
                let area = area_vector(facet, &points);
                let away = mean(facet.nodes());
                let outward: f64 = (0..3).map(|k| area[k] * (away[k] - centre[k])).sum();
                assert!(outward > 0.0, "face {number} of {kind:?} points inward");
                (0..3).for_each(|k| sum[k] += area[k]);
                on_faces.extend(facet.nodes().to_vec());
            }
        }
        assert!(sum.iter().all(|sum| sum.abs() < 1e-15), "{sum:?}");
        let inside = usize::from(kind == ElementKind::Hexahedron27);
        assert_eq!(on_faces.len(), kind.node_count() - inside);
        assert!(element.face(kind.faces().len()).is_empty() && element.facets().is_empty());
    }

    #[test]
    fn faces_of_solids_point_outward() {
        let cube = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i % 4];
            [corner[0], corner[1], (i / 4) as f64]
        });
        for kind in [ElementKind::Hexahedron8, ElementKind::Hexahedron20, ElementKind::Hexahedron27] {
            assert_outward_and_closed(kind, &cube);
        }
        let wedge = [cube[0], cube[1], cube[3], cube[4], cube[5], cube[7]];
        assert_outward_and_closed(ElementKind::Wedge6, &wedge);
        assert_outward_and_closed(ElementKind::Wedge15, &wedge);
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_outward_and_closed(ElementKind::Tetrahedron4, &corner);
        assert_outward_and_closed(ElementKind::Tetrahedron10, &corner);
    }

    #[test]
    fn flat_elements_are_made_of_facets() {
        let counts = [
            (ElementKind::Triangle3, 1),
            (ElementKind::Triangle6, 4),
            (ElementKind::Quadrilateral4, 1),
            (ElementKind::Quadrilateral8, 5),
            (ElementKind::Quadrilateral9, 4),
        ];
        for (kind, count) in counts {
            let flat = std::array::from_fn(|i| if i < kind.node_count() { i } else { 0 });
            let facets = Element::new(kind, 1, flat).facets();
            assert_eq!(facets.len(), count, "{kind:?}");
            let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            let points = with_middles(kind, &square[..kind.corner_count()]);
            let area: f64 = facets.iter().map(|&facet| 0.5 * area_vector(facet, &points)[2]).sum();
            assert!((area - if kind.corner_count() == 3 { 0.5 } else { 1.0 }).abs() < 1e-15, "{kind:?}");
            assert!(facets.iter().all(|&facet| area_vector(facet, &points)[2] > 0.0));
        }
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
