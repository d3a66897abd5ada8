//! Domains of influence where nobody holds the whole surface.

use super::nodal::check_model;
use super::{InterfaceError, InterfaceOptions};
use crate::surface::window::{
    Box3, Extents, LARGEST_NUMBER, Setup, Sheet, Window, WindowError, check_boxes, widened,
};
use crate::surface::{
    Carried, Creases, Demands, Facet, Listed, MasterSurface, NONE, NodalDomains, Ratios, SheetNodes, Sheets,
    SurfaceError, Symmetry, SymmetryPlane, check_facets, grown, shape_of, still_listed, trimmed,
};
use crate::{MaterialDomain, Point};

/// Facets of a surface around those that a rank owns, in their first positions.
#[derive(Clone, Copy, Debug)]
pub struct PartFacets<'a> {
    /// First positions of the nodes, length.
    pub positions: &'a [Point],
    /// Their numbers in the whole surface, each once, in any order.
    pub node_numbers: &'a [u64],
    /// Facets, with corners by place among the positions.
    pub facets: &'a [Facet],
    /// Their numbers in the whole surface, each once, in any order.
    pub facet_numbers: &'a [u64],
    /// Which of them the rank owns. Each facet of the whole surface is owned by one rank.
    pub owned: &'a [bool],
    /// Everything of the whole surface that meets this box is among the facets.
    pub known: Box3,
    /// Of the whole surface: those of all parts [joined](Extents::joined).
    pub extents: Extents,
}

/// What the fits at the facets of a rank ask of domains, by numbers of the whole surface. Other ranks with the same nodes and facets have
/// to know. Two rounds of them settle the domains.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartDemands {
    /// Nodes, ascending, each as often as sheets meet in it, …
    pub nodes: Vec<u64>,
    /// … and the factors of their domains there: the largest of all ranks is that of the sheet's node. In the second round those by which
    /// domains shrink.
    pub factors: Vec<f64>,
    /// … and, in the second round, whether any place has so many masters that this domain may shrink, 1 or 0; 0 in the first.
    pub crowded: Vec<u8>,
    /// Facets whose fits do not carry the quadratic basis, ascending, …
    pub facets: Vec<u64>,
    /// … and what they carry, 1 for the linear basis and 0 for nothing: the least of all ranks counts.
    pub bases: Vec<u8>,
}

/// A part of a surface that windows are cut from. See [`surface::window`](crate::surface::window).
///
/// ```text
/// new      facets around the own ones                    → demands of the fits at the own facets
/// settle   demands of all ranks with nodes in this part  → demands of the second round: how far domains can shrink
/// settle   those of all ranks                            → domains, lists of the own facets
/// window   boxes of another rank's slaves                → what they can need of the own facets
/// ```
#[derive(Debug)]
pub struct SurfacePart {
    surface: MasterSurface,
    setup: Setup,
    symmetry: Symmetry,
    creases: Creases,
    nodes: SheetNodes,
    /// By sheet node, and after them by auxiliary point.
    cells: Vec<MaterialDomain>,
    /// First positions, by place.
    first: Vec<Point>,
    /// Places of the own facets.
    own: Vec<u32>,
    /// By place, whether all facets at the node are here.
    complete: Vec<bool>,
    demands: Demands,
    stage: Stage,
    /// By place, ascending.
    node_numbers: Vec<u64>,
    facet_numbers: Vec<u64>,
    /// Where the node of a place is among the caller's.
    order: Vec<usize>,
    callers: usize,
}

/// How far the domains of a part are known.
#[derive(Debug)]
enum Stage {
    /// The own fits' demands.
    Demanded,
    /// Domains as the fits of all parts ask for, and by how much the own facets let them shrink.
    Grown {
        domains: Vec<MaterialDomain>,
        bases: Vec<Carried>,
        ratios: Ratios,
        /// Of the own facets.
        lists: Vec<Vec<Listed>>,
    },
    Settled(NodalDomains),
}

impl PartDemands {
    /// As integers and floating-point numbers, for a host to send.
    pub fn to_numbers(&self) -> (Vec<i64>, Vec<f64>) {
        let Self { nodes, factors, crowded, facets, bases } = self;
        let mut integers = vec![nodes.len() as i64, facets.len() as i64];
        integers.extend(nodes.iter().map(|&number| number as i64));
        integers.extend(crowded.iter().map(|&is| i64::from(is)));
        integers.extend(facets.iter().map(|&number| number as i64));
        integers.extend(bases.iter().map(|&base| i64::from(base)));
        (integers, factors.clone())
    }

    /// The demands that [`to_numbers`](Self::to_numbers) made numbers of, those of any number of ranks one after another.
    ///
    /// # Errors
    /// [`WindowError::Invalid`] for numbers that are none of demands.
    pub fn from_numbers(integers: &[i64], reals: &[f64]) -> Result<Vec<Self>, WindowError> {
        let (mut all, mut rest, mut factors) = (Vec::new(), integers, reals);
        while !rest.is_empty() {
            let place = integers.len() - rest.len();
            let invalid = |place| WindowError::Invalid { what: "integer", place };
            let mut take = |count: i64| -> Result<&[i64], WindowError> {
                let count = usize::try_from(count).map_err(|_| invalid(place))?;
                let (own, after) = rest.split_at_checked(count).ok_or_else(|| invalid(integers.len()))?;
                rest = after;
                Ok(own)
            };
            let &[nodes, facets] = take(2)? else { return Err(invalid(place)) };
            let numbers = |own: &[i64]| own.iter().map(|&x| u64::try_from(x).ok()).collect::<Option<_>>();
            let small = |own: &[i64]| own.iter().map(|&x| u8::try_from(x).ok()).collect::<Option<_>>();
            let lists =
                (numbers(take(nodes)?), small(take(nodes)?), numbers(take(facets)?), small(take(facets)?));
            let (Some(nodes), Some(crowded), Some(facets), Some(bases)) = lists else {
                return Err(invalid(place));
            };
            let nodes: Vec<u64> = nodes;
            let missing = WindowError::Invalid { what: "floating-point number", place: reals.len() };
            let (own, after) = factors.split_at_checked(nodes.len()).ok_or(missing)?;
            factors = after;
            let demands = Self { nodes, factors: own.to_vec(), crowded, facets, bases };
            demands.check()?;
            all.push(demands);
        }
        if factors.is_empty() {
            return Ok(all);
        }
        Err(WindowError::Invalid { what: "floating-point number", place: reals.len() - factors.len() })
    }

    fn check(&self) -> Result<(), WindowError> {
        let Self { nodes, factors, crowded, facets, bases } = self;
        if nodes.len() != factors.len() || nodes.len() != crowded.len() || facets.len() != bases.len() {
            return Err(WindowError::Invalid { what: "length of demands", place: 0 });
        }
        let invalid = |what, place: Option<usize>| match place {
            Some(place) => Err(WindowError::Invalid { what, place }),
            None => Ok(()),
        };
        invalid("factor", factors.iter().position(|factor| !(*factor >= 0.0 && factor.is_finite())))?;
        invalid("crowded node", crowded.iter().position(|&is| is > 1))?;
        invalid("basis", bases.iter().position(|&base| base > 1))
    }
}

impl PartFacets<'_> {
    /// Of the own facets alone, for the extents of the whole.
    ///
    /// # Errors
    /// [`SurfaceError`] for facets that are none, the others among them.
    pub fn own_extents(&self) -> Result<Extents, SurfaceError> {
        check_facets(self.positions, self.facets)?;
        let own = self.facets.iter().zip(self.owned).filter(|(_, owned)| **owned);
        Ok(own.fold(Extents::NONE, |all, (facet, _)| {
            let corners = facet.corners().iter().map(|&node| self.positions[node]);
            let all = corners.fold(all, |all, x| all.joined(Extents { low: x, high: x, facet: 0.0 }));
            all.joined(Extents { facet: shape_of(facet, self.positions).extent(), ..Extents::NONE })
        }))
    }

    fn check(&self) -> Result<(), InterfaceError> {
        let counts = [
            (self.node_numbers.len(), self.positions.len(), "numbers of nodes"),
            (self.facet_numbers.len(), self.facets.len(), "numbers of facets"),
            (self.owned.len(), self.facets.len(), "owned facets"),
        ];
        for (found, expected, what) in counts {
            if found != expected {
                return Err(WindowError::Invalid { what, place: found.min(expected) }.into());
            }
        }
        check_boxes(&[self.known], 0.0)?;
        let own = self.own_extents()?;
        // Planes of symmetry have images as far as the extents say. A rank without facets looks at none.
        if !self.facets.is_empty() {
            check_extents(&self.extents, &own)?;
        }
        Ok(())
    }
}

/// Extents of the whole surface are finite and hold those of the own facets.
fn check_extents(whole: &Extents, own: &Extents) -> Result<(), WindowError> {
    let ways = |extents: &Extents| {
        let Extents { low, high, facet } = *extents;
        [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]], [0.0, facet]]
    };
    for ((along, given), own) in ["x", "y", "z", "a facet"].into_iter().zip(ways(whole)).zip(ways(own)) {
        let is_finite = given.iter().all(|x| x.is_finite());
        // Of no own facet there is nothing to hold.
        let holds = own[0] > own[1] || (given[0] <= own[0] && own[1] <= given[1]);
        if !(is_finite && given[0] <= given[1] && holds) {
            return Err(WindowError::InvalidExtents { along, given, own });
        }
    }
    Ok(())
}

/// Places in ascending order of their numbers, which are different and not too large.
fn in_order(numbers: &[u64], what: &'static str) -> Result<Vec<usize>, WindowError> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_unstable_by_key(|&k| numbers[k]);
    let invalid = |place| Err(WindowError::Invalid { what, place });
    if let Some(pair) = order.windows(2).find(|pair| numbers[pair[0]] == numbers[pair[1]]) {
        return invalid(pair[1]);
    }
    match order.last() {
        Some(&place) if numbers[place] >= LARGEST_NUMBER => invalid(place),
        _ => Ok(order),
    }
}

impl SurfacePart {
    /// Finds what the fits at the own facets ask of domains. `planes` of symmetry; of the options those of domains count: weight, basis
    /// and feature angle.
    ///
    /// # Errors
    /// [`InterfaceError::Window`]: [`WindowError::TooNarrow`] if the fits of an own facet may depend on what does not meet the known box,
    /// [`WindowError::Invalid`] for numbers that are none, [`WindowError::NeedsDomains`], [`WindowError::InvalidBox`],
    /// [`WindowError::InvalidExtents`]. [`InterfaceError::Surface`] for facets that are no surface, named by their place by number, and for
    /// the planes.
    pub fn new(
        part: &PartFacets<'_>,
        options: &InterfaceOptions,
        planes: &[SymmetryPlane],
    ) -> Result<Self, InterfaceError> {
        options.check()?;
        let setup = Setup::new(options, planes, part.extents)?;
        part.check()?;
        let nodes = in_order(part.node_numbers, "node")?;
        let facets = in_order(part.facet_numbers, "facet")?;
        let mut places = vec![NONE; nodes.len()];
        nodes.iter().enumerate().for_each(|(place, &node)| places[node] = place as u32);
        let positions: Vec<Point> = nodes.iter().map(|&node| part.positions[node]).collect();
        let [low, high] = part.known;
        let is_known = |x: &Point| (0..3).all(|k| low[k] <= x[k] && x[k] <= high[k]);
        let complete: Vec<bool> = positions.iter().map(is_known).collect();
        let corners = |&facet: &usize| {
            let mut own = [NONE; 4];
            for (own, &node) in own.iter_mut().zip(part.facets[facet].corners()) {
                *own = places[node];
            }
            own
        };
        let corners: Vec<[u32; 4]> = facets.iter().map(corners).collect();
        // All facets at a node in the box are here, so that an edge with such an end is no cut.
        let is_border = |facet: usize, edge: usize| {
            let count = if corners[facet][3] == NONE { 3 } else { 4 };
            let ends = [corners[facet][edge], corners[facet][(edge + 1) % count]];
            ends.iter().any(|&place| complete[place as usize])
        };
        let surface = MasterSurface::part(positions.len(), corners.clone(), is_border)?;
        let index = surface.at(&positions)?;
        check_model(&index, planes)?;
        let symmetry = Symmetry::of_surface(planes, &part.extents)?;
        let creases = Creases::new(&index, options.feature_angle_degrees.to_radians(), &symmetry);
        let sheet_nodes = SheetNodes::new(&index, &creases, &symmetry, Some(&complete));
        let is_settled = |(place, is_complete)| is_complete && sheet_nodes.is_settled(index.surface(), place);
        let complete: Vec<bool> = (0..).zip(complete).map(is_settled).collect();
        let sheets = Sheets {
            index: &index,
            creases: &creases,
            nodes: &sheet_nodes,
            symmetry: &symmetry,
            complete: Some(&complete),
        };
        let own = (0..facets.len()).filter(|&place| part.owned[facets[place]]).map(|place| place as u32);
        let own: Vec<u32> = own.collect();
        let cells = sheets.cells();
        let demands = sheets.demands(&cells, setup.weight, setup.basis, &own);
        let made = Self {
            nodes: sheet_nodes,
            cells,
            first: positions,
            demands,
            own,
            node_numbers: nodes.iter().map(|&node| part.node_numbers[node]).collect(),
            facet_numbers: facets.iter().map(|&facet| part.facet_numbers[facet]).collect(),
            callers: nodes.len(),
            order: nodes,
            setup,
            creases,
            symmetry,
            complete,
            stage: Stage::Demanded,
            surface,
        };
        made.check_width(&made.demands.open)?;
        Ok(made)
    }

    fn check_width(&self, open: &[u32]) -> Result<(), WindowError> {
        match open.first() {
            None => Ok(()),
            Some(&facet) => {
                let facet = self.facet_numbers[facet as usize];
                Err(WindowError::TooNarrow { count: open.len(), facet })
            }
        }
    }

    /// What other ranks have to know in this round: of the nodes and facets of this part, which may be theirs, too. Nothing once domains
    /// are settled.
    pub fn demands(&self) -> PartDemands {
        let mut all = PartDemands::default();
        match &self.stage {
            Stage::Demanded => {
                let Demands { factors, bases, .. } = &self.demands;
                self.ask(&mut all, factors, |_| false);
                let carried = self.facet_numbers.iter().zip(bases);
                for (&number, &carried) in carried.filter(|(_, carried)| **carried != Carried::Quadratic) {
                    all.facets.push(number);
                    all.bases.push(carried as u8);
                }
            }
            Stage::Grown { ratios: Ratios { ratios, crowded }, .. } => {
                self.ask(&mut all, ratios, |node| crowded[node]);
            }
            Stage::Settled(_) => {}
        }
        all
    }

    /// Adds nodes with their factors, of all sheets where there is one of any.
    fn ask(&self, all: &mut PartDemands, factors: &[f64], is_crowded: impl Fn(usize) -> bool) {
        for (place, &number) in (0..).zip(&self.node_numbers) {
            let own = self.nodes.at_place(place).map(|node| node as usize);
            if own.clone().any(|node| factors[node] > 0.0) {
                for node in own {
                    all.nodes.push(number);
                    all.factors.push(factors[node]);
                    all.crowded.push(u8::from(is_crowded(node)));
                }
            }
        }
    }

    /// The own sheet nodes that another part asks for, each with its place there. Sheets of a node are in the order of their facets, the same
    /// wherever all of these are known; what has nodes within reach of which some are not is open.
    fn asked(&self, other: &PartDemands) -> impl Iterator<Item = (usize, usize)> {
        let same = other.nodes.chunk_by(|one, two| one == two);
        let starts = same.scan(0, |end, numbers| {
            let start = *end;
            *end += numbers.len();
            Some((start, numbers))
        });
        starts.flat_map(|(start, numbers)| {
            let place = self.node_numbers.binary_search(&numbers[0]);
            let own = place.map_or(0..0, |place| self.nodes.at_place(place as u32));
            own.map(|node| node as usize).zip(start..start + numbers.len())
        })
    }

    /// Takes over what other ranks ask for, all those whose known boxes meet that of this part. What concerns nodes and facets that are
    /// not here is left out. Returns whether domains are settled: if not, [`demands`](Self::demands) are those of the next round, and ranks
    /// exchange them and call this once more. All ranks take the same number of rounds.
    ///
    /// # Errors
    /// [`WindowError::TooNarrow`] if what concerns an own facet may depend on what does not meet the known box; [`WindowError::Invalid`]
    /// for demands that are none. Nothing has changed then.
    pub fn settle(&mut self, others: &[PartDemands]) -> Result<bool, InterfaceError> {
        others.iter().try_for_each(PartDemands::check)?;
        self.stage = match &self.stage {
            Stage::Demanded => self.grow(others)?,
            Stage::Grown { domains, bases, ratios, lists } => {
                self.trim(others, domains, bases, (ratios, lists))?
            }
            Stage::Settled(_) => return Ok(true),
        };
        Ok(matches!(self.stage, Stage::Settled(_)))
    }

    /// Runs with the sheets of the part.
    fn with_sheets<T>(&self, run: impl FnOnce(&Sheets<'_>) -> T) -> Result<T, InterfaceError> {
        let index = self.surface.at(&self.first)?;
        Ok(run(&Sheets {
            index: &index,
            creases: &self.creases,
            nodes: &self.nodes,
            symmetry: &self.symmetry,
            complete: Some(&self.complete),
        }))
    }

    fn grow(&self, others: &[PartDemands]) -> Result<Stage, InterfaceError> {
        let Demands { mut factors, mut bases, .. } = self.demands.clone();
        for other in others {
            for (node, k) in self.asked(other) {
                factors[node] = factors[node].max(other.factors[k]);
            }
            for (number, &carried) in other.facets.iter().zip(&other.bases) {
                if let Ok(place) = self.facet_numbers.binary_search(number) {
                    bases[place] = bases[place].min(Carried::of(carried));
                }
            }
        }
        let domains = grown(&self.cells, &factors, self.nodes.auxiliary());
        let fits = (&bases[..], self.setup.weight);
        let (lists, open, ratios) = self.with_sheets(|sheets| {
            let (lists, open) = sheets.lists(&domains, &self.own);
            // Other parts' places may crowd any node.
            let ratios = sheets.ratios(&domains, fits, (&self.own, &lists), |_| true);
            (lists, open, ratios)
        })?;
        self.check_width(&open)?;
        Ok(Stage::Grown { domains, bases, ratios, lists })
    }

    fn trim(
        &self,
        others: &[PartDemands],
        domains: &[MaterialDomain],
        bases: &[Carried],
        (own, lists): (&Ratios, &[Vec<Listed>]),
    ) -> Result<Stage, InterfaceError> {
        let mut all = own.clone();
        for other in others {
            for (node, k) in self.asked(other) {
                all.ratios[node] = all.ratios[node].max(other.factors[k]);
                all.crowded[node] |= other.crowded[k] != 0;
            }
        }
        let domains = trimmed(domains, &all, self.nodes.auxiliary());
        let mut found = lists.to_vec();
        self.with_sheets(|sheets| still_listed(sheets, &domains, &self.own, &mut found))?;
        let (mut open, mut lists) = (Vec::new(), vec![Vec::new(); self.surface.facet_count()]);
        for (&facet, list) in self.own.iter().zip(found) {
            // The facets at listed nodes are known with all that lies across their edges.
            let listed = list.iter().flat_map(|own| self.nodes.ends(own.node));
            let around = listed.flat_map(|node| self.surface.facets_of_place(self.nodes.place(node)));
            let mut corners = around.flat_map(|&facet| self.surface.corners_of(facet as usize));
            if !corners.all(|&place| self.complete[place as usize]) {
                open.push(facet);
            }
            lists[facet as usize] = list;
        }
        self.check_width(&open)?;
        let nodes = (self.nodes.places().to_vec(), self.nodes.auxiliary().to_vec());
        Ok(Stage::Settled(NodalDomains::given(nodes, domains, bases.to_vec(), &lists)))
    }

    /// What slaves in these boxes can need of the own facets, as [`ContactInterface::window`](super::ContactInterface::window). Positions
    /// are those of the moment, in the order of the [`PartFacets`]; only those of the corners of own facets are looked at.
    ///
    /// # Errors
    /// [`InterfaceError::Window`] for boxes that are none, and before [`settle`](Self::settle);
    /// [`InterfaceError::WrongNumberOfPositions`].
    pub fn window(&self, positions: &[Point], boxes: &[Box3], skin: f64) -> Result<Window, InterfaceError> {
        check_boxes(boxes, skin)?;
        InterfaceError::check_count(positions, self.callers)?;
        let Stage::Settled(domains) = &self.stage else {
            return Err(WindowError::Invalid { what: "domain", place: 0 }.into());
        };
        let boxes_with_skin: Vec<Box3> = boxes.iter().map(|own| widened(*own, skin)).collect();
        let is_near = |facet: u32| {
            let x = |place: u32| positions[self.order[place as usize]];
            let (lower, upper) = self.surface.shape_by(facet as usize, x).bounds();
            let (lower, upper) = (Point::from(lower), Point::from(upper));
            let meets = |[low, high]: &Box3| (0..3).all(|k| low[k] <= upper[k] && lower[k] <= high[k]);
            boxes_with_skin.iter().any(meets)
        };
        let core = self.own.iter().copied().filter(|&facet| is_near(facet)).collect();
        let sheet = Sheet {
            surface: &self.surface,
            domains,
            creases: &self.creases,
            setup: &self.setup,
            node_number: &|place| self.node_numbers[place as usize],
            facet_number: &|facet| self.facet_numbers[facet as usize],
            position: &|place| positions[self.order[place as usize]],
        };
        Ok(sheet.window(core, boxes, skin))
    }
}
