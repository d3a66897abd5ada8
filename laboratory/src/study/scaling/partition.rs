//! Which rank owns what: a grid of tiles, each of one rank.

use serde::Serialize;

use super::rects::{Rect, joined};

/// How cells are dealt to ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Rectangles as close to squares as the number of ranks allows.
    Blocks,
    /// Across the first axis.
    Strips,
    /// Runs along Hilbert's curve over tiles, at least sixteen of each rank.
    Curve,
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::Blocks, Self::Strips, Self::Curve];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Blocks => "blocks",
            Self::Strips => "strips",
            Self::Curve => "Hilbert's curve",
        }
    }
}

/// Tiles of a square grid of cells and their ranks.
pub struct Partition {
    side: i64,
    /// First cells of tiles along both axes, and the end.
    lines: [Vec<i64>; 2],
    /// By tile, the first axis running fastest.
    ranks: Vec<u32>,
    pub count: usize,
}

impl Partition {
    /// None where a rank would have no cell.
    pub fn new(kind: Kind, side: i64, count: usize) -> Option<Self> {
        let tiles = match kind {
            Kind::Blocks => {
                let rows =
                    (1..=count).take_while(|k| k * k <= count).filter(|k| count.is_multiple_of(*k)).last()?;
                [count / rows, rows]
            }
            Kind::Strips => [count, 1],
            Kind::Curve => {
                let size = (0..31).map(|level| 1_usize << level).find(|size| size * size >= 16 * count)?;
                [size; 2]
            }
        };
        if tiles.iter().any(|&tiles| tiles as i64 > side) {
            return None;
        }
        let all = tiles[0] * tiles[1];
        let rank = |tile: usize| match kind {
            Kind::Curve => hilbert(tiles[0], [tile % tiles[0], tile / tiles[0]]) * count / all,
            _ => tile,
        };
        let lines = tiles.map(|tiles| (0..=tiles as i64).map(|k| k * side / tiles as i64).collect());
        Some(Self { side, lines, ranks: (0..all).map(|tile| rank(tile) as u32).collect(), count })
    }

    fn tile(&self, [i, j]: [usize; 2]) -> Rect {
        Rect([[self.lines[0][i], self.lines[0][i + 1]], [self.lines[1][j], self.lines[1][j + 1]]])
    }

    /// The cells of every rank.
    pub fn regions(&self) -> Vec<Vec<Rect>> {
        let mut regions = vec![Vec::new(); self.count];
        let columns = self.lines[0].len() - 1;
        for (tile, &rank) in self.ranks.iter().enumerate() {
            regions[rank as usize].push(self.tile([tile % columns, tile / columns]));
        }
        regions.into_iter().map(joined).collect()
    }

    /// The cells of a rectangle by the ranks that own them, ascending.
    pub fn cells(&self, rects: &[Rect]) -> Vec<(usize, Vec<Rect>)> {
        self.owners(rects, 0)
    }

    /// Nodes by the ranks that own them, ascending: those that own the cell behind, at the ends of the surface the one before.
    pub fn nodes(&self, rects: &[Rect]) -> Vec<(usize, Vec<Rect>)> {
        self.owners(rects, 1)
    }

    /// With so many more behind the last cell.
    fn owners(&self, rects: &[Rect], more: i64) -> Vec<(usize, Vec<Rect>)> {
        let columns = self.lines[0].len() - 1;
        let mut found: Vec<(usize, Rect)> = Vec::new();
        for rect in rects {
            let [i, j] = [0, 1].map(|axis| {
                let ([from, to], lines) = (rect.0[axis], &self.lines[axis]);
                let last = lines.len() - 2;
                let tile = |x: i64| lines.partition_point(|line| *line <= x).saturating_sub(1).min(last);
                tile(from)..=tile(to - 1)
            });
            for j in j {
                for i in i.clone() {
                    let mut tile = self.tile([i, j]);
                    for [_, to] in &mut tile.0 {
                        *to += if *to == self.side { more } else { 0 };
                    }
                    let own = rect.common(tile).map(|own| (self.ranks[i + columns * j] as usize, own));
                    found.extend(own);
                }
            }
        }
        found.sort_unstable_by_key(|(rank, rect)| (*rank, rect.0));
        let runs = found.chunk_by(|one, other| one.0 == other.0);
        runs.map(|run| (run[0].0, run.iter().map(|(_, rect)| *rect).collect())).collect()
    }
}

/// The place along Hilbert's curve of a tile among `size`², a power of two along each axis.
fn hilbert(size: usize, [mut x, mut y]: [usize; 2]) -> usize {
    let (mut place, mut half) = (0, size / 2);
    while half > 0 {
        let [right, up] = [x & half, y & half].map(|bit| usize::from(bit > 0));
        place += half * half * ((3 * right) ^ up);
        if up == 0 {
            if right == 1 {
                (x, y) = (size - 1 - x, size - 1 - y);
            }
            (x, y) = (y, x);
        }
        half /= 2;
    }
    place
}

#[cfg(test)]
mod tests {
    use super::super::rects::count;
    use super::*;

    #[test]
    fn every_cell_and_every_node_has_one_rank() {
        for kind in Kind::ALL {
            for ranks in [1, 4, 6, 7, 10] {
                let partition = Partition::new(kind, 37, ranks).unwrap();
                let regions = partition.regions();
                let sizes: Vec<u64> = regions.iter().map(|own| count(own)).collect();
                assert_eq!(sizes.iter().sum::<u64>(), 37 * 37);
                assert!(sizes.iter().all(|size| *size as usize * ranks > 37 * 37 / 2), "{kind:?} {sizes:?}");
                let nodes = partition.nodes(&[Rect::square(38)]);
                assert_eq!(nodes.iter().map(|(_, own)| count(own)).sum::<u64>(), 38 * 38);
                for (rank, own) in partition.cells(&[Rect::square(37)]) {
                    assert_eq!(count(&own), sizes[rank]);
                }
            }
        }
        assert!(Partition::new(Kind::Strips, 37, 38).is_none());
    }

    #[test]
    fn the_curve_goes_from_tile_to_tile() {
        let mut order: Vec<[usize; 2]> = (0..256).map(|tile| [tile % 16, tile / 16]).collect();
        order.sort_unstable_by_key(|tile| hilbert(16, *tile));
        for pair in order.windows(2) {
            assert_eq!(pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]), 1);
        }
    }
}
