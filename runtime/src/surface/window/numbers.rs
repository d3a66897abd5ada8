//! Windows as plain numbers, for a host to send.

use super::super::auxiliary::AuxiliaryKind;
use super::{
    Auxiliary, Box3, Carried, Extents, LARGEST_NUMBER, Listed, MaterialDomain, NONE, Setup, SymmetryPlane,
    Window, WindowError, WindowFacet, WindowNode, check_boxes, core_places,
};
use crate::{Basis, Point, Weight};

/// Of the integers: what they are, so that others are refused.
const MAGIC: i64 = 0x0064_6377_696e_0003;
/// Integers before those of nodes.
const HEADER: usize = 10;
/// Integers of a facet: number, corners, bits, length of its list.
const FACET: usize = 7;
/// Integers of an auxiliary point: its ends and its kind.
const AUXILIARY: usize = 3;
/// Bits of a facet.
const ENDS: u32 = 4;
const CARRIED: u32 = 8;
const IS_CORE: i64 = 1 << 10;
/// An image in the number of a listed sheet node or auxiliary point; 0: itself.
const IMAGE: u32 = 32;
/// Numbers before those of planes, and of a sheet node.
const REALS: usize = 9;
const NODE: usize = 9;
const BOX: usize = 6;

impl Window {
    /// How many integers and floating-point numbers [`to_numbers`](Self::to_numbers) gives.
    pub fn count_numbers(&self) -> (usize, usize) {
        let lists = self.nodes.len() + self.sheet_nodes.len() + self.listed.len();
        let integers = HEADER + lists + AUXILIARY * self.auxiliary.len() + FACET * self.facets.len();
        let boxes = BOX * (self.setup.planes.len() + self.boxes.len());
        (integers, REALS + boxes + NODE * self.sheet_nodes.len() + 3 * self.cut.len())
    }

    /// The window as integers and floating-point numbers, from which [`from_numbers`](Self::from_numbers) makes the same one. About 90
    /// bytes for each node, 50 for each facet and 280 for each facet of the core.
    pub fn to_numbers(&self) -> (Vec<i64>, Vec<f64>) {
        let Setup { weight, basis, feature_angle_degrees, planes, extents } = &self.setup;
        let weight = *weight as i64;
        let counts = [
            planes.len(),
            self.boxes.len(),
            self.nodes.len(),
            self.sheet_nodes.len(),
            self.auxiliary.len(),
            self.facets.len(),
            self.listed.len(),
        ];
        let mut integers = vec![MAGIC, weight, basis.size() as i64];
        integers.extend(counts.map(|count| count as i64));
        integers.extend(self.nodes.iter().map(|&number| number as i64));
        integers.extend(self.sheet_nodes.iter().map(|node| i64::from(node.place)));
        let point = |&Auxiliary { ends: [from, to], kind }: &Auxiliary| {
            [i64::from(from), i64::from(to), kind.number()]
        };
        integers.extend(self.auxiliary.iter().flat_map(point));
        for WindowFacet { number, corners, borders, ends, core } in &self.facets {
            let corner = |&corner: &u32| if corner == NONE { -1 } else { i64::from(corner) };
            integers.push(*number as i64);
            integers.extend(corners.iter().map(corner));
            let (carried, count) =
                core.map_or((0, 0), |(carried, count)| (IS_CORE | (carried as i64) << CARRIED, count));
            integers.extend([i64::from(*borders) | i64::from(*ends) << ENDS | carried, i64::from(count)]);
        }
        integers.extend(self.listed.iter().map(|listed| {
            let image = if listed.image == NONE { 0 } else { i64::from(listed.image) + 1 };
            i64::from(listed.node) | image << IMAGE
        }));
        let mut reals = vec![*feature_angle_degrees];
        reals.extend(extents.low.iter().chain(&extents.high));
        reals.extend([extents.facet, self.skin]);
        reals.extend(planes.iter().flat_map(|plane| plane.point.into_iter().chain(plane.normal)));
        reals.extend(self.boxes.as_flattened().as_flattened());
        let node = |node: &WindowNode| {
            let MaterialDomain { position: [x, y, z], metric: [a, b, c, d, e, f] } = node.domain;
            [x, y, z, a, b, c, d, e, f]
        };
        reals.extend(self.sheet_nodes.iter().flat_map(node));
        reals.extend(self.cut.as_flattened());
        (integers, reals)
    }

    /// The window that [`to_numbers`](Self::to_numbers) made numbers of.
    ///
    /// # Errors
    /// [`WindowError::Invalid`] for numbers that are none of a window, [`WindowError::InvalidBox`].
    pub fn from_numbers(integers: &[i64], reals: &[f64]) -> Result<Self, WindowError> {
        let Header { weight, basis, counts } = Header::of(integers, reals)?;
        let [planes, boxes, nodes, sheet_nodes, auxiliary, facets, listed] = counts;
        let mut rest = &integers[HEADER..];
        let numbers = take(&mut rest, nodes);
        check_ascending("node", numbers.iter().copied())?;
        let places = take(&mut rest, sheet_nodes);
        check_places(places, nodes)?;
        let auxiliary = auxiliary_of(take(&mut rest, AUXILIARY * auxiliary), sheet_nodes)?;
        let listable = sheet_nodes + auxiliary.len();
        let rows = take(&mut rest, FACET * facets).as_chunks::<FACET>().0;
        check_ascending("facet", rows.iter().map(|row| row[0]))?;
        let invalid = |what, place| WindowError::Invalid { what, place };
        let facets = rows.iter().enumerate().map(|(k, row)| facet_of(row, nodes).ok_or(invalid("facet", k)));
        let facets = facets.collect::<Result<Vec<WindowFacet>, WindowError>>()?;
        let list = take(&mut rest, listed).iter().enumerate();
        let list = list.map(|(k, &number)| listed_of(number, listable).ok_or(invalid("listed node", k)));
        let list = list.collect::<Result<Vec<Listed>, WindowError>>()?;
        let counted: usize = facets.iter().filter_map(|facet| facet.core).map(|core| core.1 as usize).sum();
        if counted != listed {
            return Err(invalid("list", facets.len()));
        }
        check_lists(&facets, &list)?;
        let (reals, mut rest) = reals.split_at(REALS);
        let plane = |&[x, y, z, a, b, c]: &[f64; BOX]| SymmetryPlane { point: [x, y, z], normal: [a, b, c] };
        let planes = take(&mut rest, BOX * planes).as_chunks().0.iter().map(plane).collect();
        let own = |&[x, y, z, a, b, c]: &[f64; BOX]| [[x, y, z], [a, b, c]];
        let boxes: Vec<Box3> = take(&mut rest, BOX * boxes).as_chunks().0.iter().map(own).collect();
        let skin = reals[REALS - 1];
        check_boxes(&boxes, skin)?;
        let node = |(&place, &[x, y, z, a, b, c, d, e, f]): (&i64, &[f64; NODE])| WindowNode {
            place: place as u32,
            domain: MaterialDomain { position: [x, y, z], metric: [a, b, c, d, e, f] },
        };
        let own = take(&mut rest, NODE * sheet_nodes).as_chunks().0;
        let sheet_nodes = places.iter().zip(own).map(node).collect();
        let cut = rest.as_chunks().0.to_vec();
        if cut.len() != core_places(&facets).count() {
            return Err(invalid("position", cut.len()));
        }
        let nodes = numbers.iter().map(|&number| number as u64).collect();
        let point = |k: usize| -> Point { [reals[k], reals[k + 1], reals[k + 2]] };
        let extents = Extents { low: point(1), high: point(4), facet: reals[7] };
        let setup = Setup { weight, basis, feature_angle_degrees: reals[0], planes, extents };
        Ok(Self { setup, boxes, skin, nodes, sheet_nodes, auxiliary, facets, listed: list, cut })
    }
}

/// What the first integers say.
struct Header {
    weight: Weight,
    basis: Basis,
    /// Of planes, boxes, nodes, sheet nodes, auxiliary points, facets and listed nodes.
    counts: [usize; 7],
}

impl Header {
    /// Checks that there are as many numbers as it says, and that they are finite.
    fn of(integers: &[i64], reals: &[f64]) -> Result<Self, WindowError> {
        let invalid = |what, place| WindowError::Invalid { what, place };
        let Some((header, rest)) = integers.split_at_checked(HEADER) else {
            return Err(invalid("integer", integers.len()));
        };
        let weight = Weight::ALL.into_iter().find(|&weight| weight as i64 == header[1]);
        let basis = [Basis::Linear, Basis::Quadratic].into_iter().find(|own| own.size() as i64 == header[2]);
        let (MAGIC, Some(weight), Some(basis)) = (header[0], weight, basis) else {
            return Err(invalid("integer", 0));
        };
        let mut counts = [0; 7];
        for (count, (place, &number)) in counts.iter_mut().zip(header.iter().enumerate().skip(3)) {
            // More than there are numbers are none, so that no product below is too large.
            let most = integers.len() + reals.len();
            let number = usize::try_from(number).ok().filter(|&number| number <= most);
            *count = number.ok_or(invalid("integer", place))?;
        }
        let [planes, boxes, nodes, sheet_nodes, auxiliary, facets, listed] = counts;
        if rest.len() != nodes + sheet_nodes + AUXILIARY * auxiliary + FACET * facets + listed {
            return Err(invalid("integer", integers.len()));
        }
        // Positions come last, as many as the core has corners.
        let cut = reals.len().checked_sub(REALS + BOX * planes + BOX * boxes + NODE * sheet_nodes);
        if cut.is_none_or(|cut| cut % 3 != 0) {
            return Err(invalid("floating-point number", reals.len()));
        }
        // Nothing has no extents.
        let may_be_infinite = |place: usize| nodes == 0 && (1..REALS - 1).contains(&place);
        if let Some((place, _)) =
            reals.iter().enumerate().find(|&(place, x)| !(x.is_finite() || may_be_infinite(place)))
        {
            return Err(invalid("floating-point number", place));
        }
        Ok(Self { weight, basis, counts })
    }
}

/// The first numbers, which are there; the others stay.
fn take<'a, T>(rest: &mut &'a [T], count: usize) -> &'a [T] {
    rest.split_off(..count).unwrap_or_default()
}

fn check_ascending(what: &'static str, numbers: impl Iterator<Item = i64>) -> Result<(), WindowError> {
    let mut least = 0;
    for (place, number) in numbers.enumerate() {
        if number < least || number as u64 >= LARGEST_NUMBER {
            return Err(WindowError::Invalid { what, place });
        }
        least = number + 1;
    }
    Ok(())
}

/// Refuses places of sheet nodes that are not ascending, or do not name each of the nodes.
fn check_places(places: &[i64], nodes: usize) -> Result<(), WindowError> {
    let mut last = -1;
    for (place, &own) in places.iter().enumerate() {
        if own != last && own != last + 1 || own < 0 {
            return Err(WindowError::Invalid { what: "sheet node", place });
        }
        last = own;
    }
    if last + 1 == nodes as i64 {
        Ok(())
    } else {
        Err(WindowError::Invalid { what: "sheet node", place: places.len() })
    }
}

/// Refuses auxiliary points that are not ascending, or whose ends are not two sheet nodes.
fn auxiliary_of(numbers: &[i64], sheet_nodes: usize) -> Result<Vec<Auxiliary>, WindowError> {
    let mut all: Vec<Auxiliary> = Vec::new();
    for (place, &[from, to, kind]) in numbers.as_chunks::<AUXILIARY>().0.iter().enumerate() {
        let end = |end: i64| usize::try_from(end).ok().filter(|&end| end < sheet_nodes).map(|end| end as u32);
        let kind = AuxiliaryKind::of(kind);
        let point = || Some(Auxiliary { ends: [end(from)?, end(to)?], kind: kind? });
        let is_sound = |point: &Auxiliary| {
            let [from, to] = point.ends;
            (from < to || from > to && point.kind != AuxiliaryKind::Middle)
                && all.last().is_none_or(|last| last < point)
        };
        let invalid = WindowError::Invalid { what: "auxiliary point", place };
        all.push(point().filter(is_sound).ok_or(invalid)?);
    }
    Ok(all)
}

/// Refuses lists that are not ascending, a node before its images: they are searched as such.
fn check_lists(facets: &[WindowFacet], listed: &[Listed]) -> Result<(), WindowError> {
    let order = |own: &Listed| (own.node, own.image.wrapping_add(1));
    let mut start = 0;
    for (_, count) in facets.iter().filter_map(|facet| facet.core) {
        let list = &listed[start..][..count as usize];
        if let Some(k) = list.windows(2).position(|pair| order(&pair[0]) >= order(&pair[1])) {
            return Err(WindowError::Invalid { what: "listed node", place: start + k + 1 });
        }
        start += list.len();
    }
    Ok(())
}

fn facet_of(&[number, a, b, c, d, bits, count]: &[i64; FACET], nodes: usize) -> Option<WindowFacet> {
    let corner = |corner: i64| usize::try_from(corner).ok().filter(|&k| k < nodes).map(|k| k as u32);
    let corners = [corner(a)?, corner(b)?, corner(c)?, if d == -1 { NONE } else { corner(d)? }];
    let is_repeated = (0..4).any(|k| corners[..k].contains(&corners[k]));
    if is_repeated || !(0..IS_CORE << 1).contains(&bits) {
        return None;
    }
    let count = u32::try_from(count).ok()?;
    let carried = match bits >> CARRIED & 3 {
        0 => Carried::Nothing,
        1 => Carried::Linear,
        2 => Carried::Quadratic,
        _ => return None,
    };
    let core = (bits & IS_CORE != 0).then_some((carried, count));
    if core.is_none() && count != 0 {
        return None;
    }
    let (borders, ends) = ((bits & 15) as u8, (bits >> ENDS & 15) as u8);
    Some(WindowFacet { number: number as u64, corners, borders, ends, core })
}

fn listed_of(number: i64, listable: usize) -> Option<Listed> {
    let number = u64::try_from(number).ok()?;
    let (node, image) = (number & u64::from(u32::MAX), number >> IMAGE);
    let node = usize::try_from(node).ok().filter(|&node| node < listable)? as u32;
    let image = if image == 0 { NONE } else { u32::try_from(image - 1).ok()? };
    Some(Listed { node, image })
}
