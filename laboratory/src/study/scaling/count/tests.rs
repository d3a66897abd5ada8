//! Counts beside the parts, windows and patterns of the library.

use diffuse_contact::assembly::{CsrPattern, DofMap};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions, PartFacets, SurfacePart};
use diffuse_contact::surface::window::{Box3, Extents, Window, boxes_around};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::super::super::patch::Patch;
use super::super::partition::Kind;
use super::*;

const SIDE: i64 = 56;

fn scene() -> Scene {
    let contact = Rect([[14, 42], [15, 41]]);
    Scene { side: SIDE, contact, limit: 0.7, skin: 0.4, stencil: Stencil::new().unwrap() }
}

fn cells(rects: &[Rect]) -> impl Iterator<Item = [i64; 2]> {
    rects.iter().flat_map(|&Rect([[a, b], [c, d]])| (c..d).flat_map(move |y| (a..b).map(move |x| [x, y])))
}

/// Of the slave in a cell.
fn at([x, y]: [i64; 2]) -> Point {
    [x as f64 + SHIFT[0], y as f64 + SHIFT[1], 0.0]
}

fn facet([x, y]: [i64; 2]) -> usize {
    (x + SIDE * y) as usize
}

/// A rank's part of the surface as a host makes it; its facets, nodes and whether it knows everything are those of the library.
fn part(patch: &Patch, own: &[usize], extents: Extents) -> (SurfacePart, Vec<Point>, usize) {
    let bounds = |facets: &[usize]| {
        let corners = facets.iter().flat_map(|&facet| patch.facets[facet].corners());
        boxes_around(&corners.map(|&node| patch.positions[node]).collect::<Vec<_>>(), 0.0, 1)[0]
    };
    let [low, high] = bounds(own);
    let known: Box3 = [low.map(|x| x - WIDTH as f64), high.map(|x| x + WIDTH as f64)];
    let meets = |facet: &usize| {
        let [low, high] = bounds(&[*facet]);
        (0..3).all(|k| low[k] <= known[1][k] && known[0][k] <= high[k])
    };
    let all: Vec<usize> = (0..patch.facets.len()).filter(meets).collect();
    let mut nodes: Vec<usize> =
        all.iter().flat_map(|&facet| patch.facets[facet].corners()).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let positions: Vec<Point> = nodes.iter().map(|&node| patch.positions[node]).collect();
    let facets: Vec<Facet> = all
        .iter()
        .filter_map(|&facet| {
            let corners: [usize; 4] = patch.facets[facet].corners().try_into().ok()?;
            Some(Facet::Quadrilateral(corners.map(|node| nodes.binary_search(&node).unwrap())))
        })
        .collect();
    let number = |all: &[usize]| all.iter().map(|&k| k as u64).collect::<Vec<u64>>();
    let owned: Vec<bool> = all.iter().map(|facet| own.binary_search(facet).is_ok()).collect();
    let part = PartFacets {
        positions: &positions,
        node_numbers: &number(&nodes),
        facets: &facets,
        facet_numbers: &number(&all),
        owned: &owned,
        known,
        extents,
    };
    let made = SurfacePart::new(&part, &InterfaceOptions::default(), &[]).unwrap();
    (made, positions, all.len())
}

/// The library's parts and windows of the same scene have as many facets, nodes and bytes as are counted, to the last one.
#[test]
fn counts_are_those_of_the_library() {
    let scene = scene();
    let patch = Patch::new([SIDE as usize; 2], |x, y| [x, y, 0.0]);
    let high = [SIDE as f64, SIDE as f64, 0.0];
    let extents = Extents { low: [0.0; 3], high, facet: 1.0 };
    let cases =
        [(Kind::Blocks, 6, true), (Kind::Blocks, 4, false), (Kind::Strips, 5, true), (Kind::Curve, 6, true)];
    for (kind, count, is_dealt) in cases {
        let partition = Partition::new(kind, SIDE, count).unwrap();
        let slaves = if is_dealt { scene.slaves_dealt(&partition) } else { scene.slaves_owned(&partition) };
        let counted = scene.count(&partition, &slaves);
        let mut parts = Vec::new();
        for (region, rank) in partition.regions().iter().zip(&counted) {
            let mut own: Vec<usize> = cells(region).map(facet).collect();
            own.sort_unstable();
            let (part, positions, facets) = part(&patch, &own, extents);
            assert_eq!((own.len() as u64, facets as u64), (rank.own, rank.part), "{kind:?}");
            parts.push((part, positions));
        }
        for round in [false, true] {
            let demands: Vec<_> = parts.iter().map(|(part, _)| part.demands()).collect();
            parts.iter_mut().for_each(|(part, _)| assert_eq!(part.settle(&demands).unwrap(), round));
        }
        let mut sent: BTreeMap<usize, (u64, u64)> = BTreeMap::new();
        for (k, (slaves, rank)) in slaves.iter().zip(&counted).enumerate() {
            let boxes = boxes_around(&cells(slaves).map(at).collect::<Vec<_>>(), scene.reach(), BOXES);
            let windows: Vec<(usize, Window)> = parts
                .iter()
                .map(|(part, positions)| part.window(positions, &boxes, scene.skin).unwrap())
                .enumerate()
                .filter(|(_, window)| window.facets().len() > 0)
                .collect();
            let bytes = |window: &Window| {
                let (integers, reals) = window.to_numbers();
                8 * (integers.len() + reals.len()) as u64
            };
            let mut gets = Flow::default();
            for (owner, window) in windows.iter().filter(|(owner, _)| *owner != k) {
                let bytes = bytes(window) + NODE * window.nodes().len() as u64;
                gets.add(bytes);
                let sent = sent.entry(*owner).or_default();
                *sent = (sent.0 + bytes, sent.1 + 1);
            }
            assert_eq!(gets, rank.gets.windows, "{kind:?} {count} {k}");
            let windows: Vec<Window> = windows.into_iter().map(|(_, window)| window).collect();
            let joined = Window::joined(&windows).unwrap();
            let found = (joined.facets().len() as u64, joined.nodes().len() as u64, bytes(&joined));
            let size = rank.window;
            let expected = (size.facets, size.nodes, size.bytes(boxes.len(), scene.stencil.listed));
            assert_eq!(found, expected, "{kind:?} {count} {k}");
            let node = |number: u64| [number as i64 % (SIDE + 1), number as i64 / (SIDE + 1)];
            let others = joined
                .nodes()
                .filter(|number| partition.nodes(&[Rect::cell(node(*number))])[0].0 != k)
                .count();
            let masters = rank.gets.nodes.count - rank.gets.slaves.count;
            assert_eq!(others as u64, masters, "{kind:?} {count} {k}");
        }
        for (k, rank) in counted.iter().enumerate() {
            let (bytes, ranks) = sent.get(&k).copied().unwrap_or_default();
            assert_eq!(rank.sends.windows, Flow { count: bytes, ranks }, "{kind:?} {count} {k}");
        }
    }
}

/// On waves as high as a facet, sixteen long, a window has as many facets as counted for the flat surface, and hardly fewer bytes.
#[test]
fn waves_need_no_wider_windows() {
    let scene = scene();
    let wave = std::f64::consts::TAU / 16.0;
    for (amplitude, least) in [(0.0, 1.0), (0.25, 1.0), (1.0, 0.99)] {
        let height = |x: f64, y: f64| amplitude * (wave * x).sin() * (wave * y).cos();
        let Patch { mut positions, facets } = Patch::new([SIDE as usize; 2], |x, y| [x, y, height(x, y)]);
        let master = MasterSurface::new(&positions, facets).unwrap();
        let slaves: Vec<Point> = cells(&[scene.contact])
            .map(|cell| {
                let [x, y, _] = at(cell);
                [x, y, height(x, y)]
            })
            .collect();
        positions.push(slaves[0]);
        let nodes = vec![positions.len() - 1];
        let mut interface =
            ContactInterface::new(master, nodes, &[], &positions, InterfaceOptions::default()).unwrap();
        interface.refresh_pairing(&positions).unwrap();
        let window = interface.window(&boxes_around(&slaves, scene.reach(), 1), scene.skin).unwrap();
        let core = scene.core(&[scene.contact]);
        let core = [bounds(&core).unwrap()];
        let size = scene.size(&core, &scene.facets(&core));
        let (integers, reals) = window.to_numbers();
        let bytes = 8 * (integers.len() + reals.len()) as u64;
        let over = bytes as f64 / size.bytes(1, scene.stencil.listed) as f64;
        assert_eq!(window.facets().len() as u64, size.facets, "{amplitude}");
        assert!((least..=1.0).contains(&over), "{amplitude} {over}");
    }
}

/// The tangent of all slaves has hardly fewer entries than rows as full as inside: the contact's rim is what differs.
#[test]
fn rows_of_the_tangent_are_as_full_as_counted() {
    let scene = scene();
    let Patch { mut positions, facets } = Patch::new([SIDE as usize; 2], |x, y| [x, y, 0.0]);
    let master = MasterSurface::new(&positions, facets).unwrap();
    let masters = positions.len();
    positions.extend(cells(&[scene.contact]).map(at));
    let slaves = (masters..positions.len()).collect();
    let mut interface =
        ContactInterface::new(master, slaves, &[], &positions, InterfaceOptions::default()).unwrap();
    interface.refresh_pairing(&positions).unwrap();
    let contacts = interface.evaluate(Mode::Hessian).unwrap();
    let pattern = CsrPattern::union(contacts, &DofMap::standard(positions.len())).unwrap();
    let entries = ENTRY * pattern.entries() as u64;
    let [master, slave] = scene.row_bytes();
    let counted = master * count(&scene.touched(&[scene.contact])) + slave * count(&[scene.contact]);
    assert!(entries <= counted && 10 * entries > 8 * counted, "{entries} {counted}");
}

/// What some get others send, dealt shares differ by one slave at most, and no slave is lost.
#[test]
fn nothing_is_lost_between_ranks() {
    let scene = scene();
    for kind in Kind::ALL {
        let partition = Partition::new(kind, SIDE, 10).unwrap();
        let dealt = scene.slaves_dealt(&partition);
        let sizes: Vec<u64> = dealt.iter().map(|own| count(own)).collect();
        assert_eq!(sizes.iter().sum::<u64>(), scene.contact.count());
        assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1, "{sizes:?}");
        for slaves in [dealt, scene.slaves_owned(&partition)] {
            let mut all: Vec<[i64; 2]> = slaves.iter().flat_map(|own| cells(own)).collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len() as u64, scene.contact.count());
            let mut ranks = scene.count(&partition, &slaves);
            let mut totals = [[0; 2]; 10];
            for rank in &mut ranks {
                for (k, traffic) in [&mut rank.gets, &mut rank.sends].into_iter().enumerate() {
                    for (flow, total) in traffic.flows().into_iter().zip(totals.as_chunks_mut::<2>().0) {
                        total[0][k] += flow.count;
                        total[1][k] += flow.ranks;
                    }
                }
            }
            assert!(totals.iter().all(|[gets, sends]| gets == sends), "{kind:?} {totals:?}");
        }
    }
}
