//! The slaves of the whole surface once more, dealt out to windows of it. Windows are cut from the whole and travel as plain numbers;
//! then the whole is forgotten, and each window pairs and evaluates its slaves alone, one window after another.

use std::fmt;

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactInterface, InterfaceError, InterfaceOptions};
use diffuse_contact::surface::MasterSurface;
use diffuse_contact::surface::window::{Window, boxes_around};
use serde::Serialize;

use super::bits::SlaveBits;
use super::{StudyError, each, memory, scene, timed};
use crate::progress::logged;
use crate::words::row;

/// How far a window reaches beyond its slaves, in cells. They lie closer to the facets.
pub const REACH: f64 = 0.3;
/// Boxes of a window at most, as many as the host in dolfinx takes.
const BOXES: usize = 8;
/// How far nodes have moved since domains were found, in cells, and the angle of that wave by cell: windows carry the domains of the
/// first positions.
const MOVED: [f64; 2] = [0.1, 0.7];

/// Times of pairing and evaluation.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Times {
    /// Index, search and pairing of all slaves.
    refresh_s: f64,
    /// Gap, N and M of all slaves, streamed, and their hash.
    evaluate_s: f64,
}

/// All windows, and the largest of them.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Sizes {
    sum: usize,
    largest: usize,
}

impl Sizes {
    fn add(&mut self, size: usize) {
        self.sum += size;
        self.largest = self.largest.max(size);
    }

    fn in_words(self, windows: usize) -> String {
        format!("{:.0} on average, {} at most", self.sum as f64 / windows as f64, self.largest)
    }
}

/// What was found.
#[derive(Debug, Default, Serialize)]
pub struct Windowed {
    /// Slave nodes, and master nodes.
    nodes: usize,
    threads: usize,
    windows: usize,
    /// Slaves with a gap, in the whole surface.
    contacts: usize,
    /// Slaves whose bits are not those of the whole surface, with those that say that they cannot know.
    different: usize,
    /// Slaves that say so.
    beyond_window: usize,
    /// Connecting the facets, domains of all nodes.
    make_s: f64,
    whole: Times,
    /// Windows from the whole surface to numbers, all of them.
    cut_s: f64,
    /// From numbers to interfaces.
    join_s: f64,
    /// Of all windows, one after another.
    parts: Times,
    /// Nodes that windows hold.
    window_nodes: Sizes,
    /// Those of them that another window holds, too.
    halo_nodes: Sizes,
    /// As numbers.
    window_bytes: Sizes,
    /// Peak memory of the process with the whole surface, if the system tells.
    whole_memory_mib: Option<f64>,
    /// Peak without it, with the numbers of all windows and the positions of all nodes.
    parts_memory_mib: Option<f64>,
}

/// A window on its way, and the slaves that it is for.
struct Part {
    slaves: Vec<usize>,
    numbers: (Vec<i64>, Vec<f64>),
}

impl Windowed {
    /// `side`² slaves and as many masters in so many windows, which reach so far beyond their slaves.
    pub fn measure(side: usize, windows: usize, reach: f64) -> Result<Self, StudyError> {
        let nodes = side * side;
        let mut found = Self { nodes, windows, threads: rayon::current_num_threads(), ..Self::default() };
        let (mut positions, slaves, facets) = scene(side);
        let (mut whole, make_s) = timed(|| -> Result<_, StudyError> {
            let master = MasterSurface::new(&positions, facets)?;
            Ok(ContactInterface::new(master, slaves.clone(), &[], &positions, InterfaceOptions::default())?)
        })?;
        found.make_s = make_s;
        positions.iter_mut().for_each(|x| x[2] += MOVED[0] * (MOVED[1] * x[0]).sin());
        let expected = found.evaluate_whole(&mut whole, &positions)?;
        let parts = found.cut(&whole, &dealt(slaves, &positions, windows), &positions, reach)?;
        found.whole_memory_mib = memory::peak_mib();
        drop(whole);
        let is_forgotten = memory::forget_peak();
        let bar = logged("windows", windows);
        for part in parts {
            found.evaluate(&part, &positions, &expected)?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        found.parts_memory_mib = memory::peak_mib().filter(|_| is_forgotten);
        Ok(found)
    }

    fn evaluate_whole(
        &mut self,
        whole: &mut ContactInterface,
        positions: &[Point],
    ) -> Result<Vec<SlaveBits>, StudyError> {
        let (_, refresh_s) = timed(|| whole.refresh_pairing(positions))?;
        let (bits, evaluate_s) = timed(|| SlaveBits::of_all(whole, u64::from))?;
        self.whole = Times { refresh_s, evaluate_s };
        self.contacts = bits.iter().filter(|bits| bits.is_contact).count();
        Ok(bits)
    }

    /// Windows for these slaves, as numbers.
    fn cut(
        &mut self,
        whole: &ContactInterface,
        groups: &[Vec<usize>],
        positions: &[Point],
        reach: f64,
    ) -> Result<Vec<Part>, StudyError> {
        let mut holders = vec![0_u16; self.nodes];
        let mut windows = Vec::new();
        let mut parts = Vec::new();
        for slaves in groups {
            let own: Vec<Point> = slaves.iter().map(|&slave| positions[slave]).collect();
            let ((window, numbers), cut_s) = timed(|| -> Result<_, StudyError> {
                let window = whole.window(&boxes_around(&own, reach, BOXES), 0.0)?;
                let numbers = window.to_numbers();
                Ok((window, numbers))
            })?;
            self.cut_s += cut_s;
            self.window_bytes.add(8 * (numbers.0.len() + numbers.1.len()));
            let nodes: Vec<usize> = window.nodes().map(|node| node as usize).collect();
            nodes.iter().for_each(|&node| holders[node] += 1);
            windows.push(nodes);
            parts.push(Part { slaves: slaves.clone(), numbers });
        }
        for nodes in windows {
            self.window_nodes.add(nodes.len());
            self.halo_nodes.add(nodes.iter().filter(|&&node| holders[node] > 1).count());
        }
        Ok(parts)
    }

    /// Pairs and evaluates the slaves of a window, and compares them with the whole.
    fn evaluate(
        &mut self,
        part: &Part,
        positions: &[Point],
        expected: &[SlaveBits],
    ) -> Result<(), StudyError> {
        let ((mut interface, names, own), join_s) = timed(|| part.interface(positions))?;
        let (_, refresh_s) = timed(|| interface.refresh_pairing(&own))?;
        let (bits, evaluate_s) = timed(|| SlaveBits::of_all(&interface, |node| names[node as usize]))?;
        self.join_s += join_s;
        self.parts.refresh_s += refresh_s;
        self.parts.evaluate_s += evaluate_s;
        for (bits, slave) in bits.iter().zip(&part.slaves) {
            self.different += usize::from(*bits != expected[slave - self.nodes]);
            self.beyond_window += usize::from(bits.is_beyond_window);
        }
        Ok(())
    }
}

impl Part {
    /// The interface, numbers of its nodes in the whole surface, and positions of its nodes and slaves.
    fn interface(&self, positions: &[Point]) -> Result<(ContactInterface, Vec<u64>, Vec<Point>), StudyError> {
        let window = Window::from_numbers(&self.numbers.0, &self.numbers.1).map_err(InterfaceError::from)?;
        let names: Vec<u64> = window.nodes().collect();
        let mut own: Vec<Point> = names.iter().map(|&node| positions[node as usize]).collect();
        own.extend(self.slaves.iter().map(|&slave| positions[slave]));
        let slaves = (names.len()..own.len()).collect();
        let interface = ContactInterface::in_window(&window, slaves, &[], &own, InterfaceOptions::default())?;
        Ok((interface, names, own))
    }
}

/// Slaves in so many groups of equal size: halved across the longer side, again and again.
fn dealt(mut slaves: Vec<usize>, positions: &[Point], groups: usize) -> Vec<Vec<usize>> {
    if groups == 1 {
        slaves.sort_unstable();
        return vec![slaves];
    }
    let side = |axis: usize| {
        let along = slaves.iter().map(|&slave| positions[slave][axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    let axis = usize::from(side(1) > side(0));
    let first = groups / 2;
    let middle = slaves.len() * first / groups;
    if middle > 0 {
        slaves.select_nth_unstable_by(middle, |&i, &j| positions[i][axis].total_cmp(&positions[j][axis]));
    }
    let others = slaves.split_off(middle);
    let mut all = dealt(slaves, positions, first);
    all.append(&mut dealt(others, positions, groups - first));
    all
}

impl fmt::Display for Windowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let each = |seconds: f64| each(seconds, self.nodes);
        row(f, "slave, master nodes", &format!("{0}, {0}", self.nodes))?;
        row(f, "threads", &self.threads.to_string())?;
        row(f, "contacts", &self.contacts.to_string())?;
        row(f, "connect and domains", &each(self.make_s))?;
        row(f, "refresh, all paired", &each(self.whole.refresh_s))?;
        row(f, "gap, N, M and hash", &each(self.whole.evaluate_s))?;
        row(f, "peak memory", &memory::in_words(self.whole_memory_mib))?;
        row(f, "windows", &self.windows.to_string())?;
        row(f, "nodes of a window", &self.window_nodes.in_words(self.windows))?;
        row(f, "in another one, too", &self.halo_nodes.in_words(self.windows))?;
        row(f, "bytes of a window", &self.window_bytes.in_words(self.windows))?;
        row(f, "cut, to numbers", &each(self.cut_s))?;
        row(f, "numbers to interfaces", &each(self.join_s))?;
        row(f, "refresh in windows", &each(self.parts.refresh_s))?;
        row(f, "gap, N, M and hash", &each(self.parts.evaluate_s))?;
        row(f, "peak memory, windows", &memory::in_words(self.parts_memory_mib))?;
        row(f, "slaves beyond windows", &self.beyond_window.to_string())?;
        row(f, "slaves that differ", &self.different.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_windows_differ_and_others_have_the_bits_of_the_whole() {
        let [wide, narrow] = [REACH, 0.0].map(|reach| Windowed::measure(40, 5, reach).unwrap());
        assert_eq!((wide.contacts, wide.different, wide.beyond_window), (1600, 0, 0));
        assert!(0 < narrow.beyond_window && narrow.beyond_window < 1600, "{narrow:?}");
        assert_eq!(narrow.different, narrow.beyond_window);
        // A window holds what its slaves need, and no more.
        assert!(wide.window_nodes.largest < 1600 && wide.halo_nodes.largest < wide.window_nodes.largest);
        assert!(wide.window_nodes.sum > 1600, "{wide:?}");
    }

    #[test]
    fn slaves_are_dealt_out_evenly() {
        let positions: Vec<Point> = (0..103).map(|k| [f64::from(k * 37 % 103), 0.0, 0.0]).collect();
        let groups = dealt((0..103).collect(), &positions, 7);
        assert!(groups.iter().all(|group| group.len().abs_diff(103 / 7) <= 1), "{groups:?}");
        let mut all = groups.concat();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..103));
    }
}
