//! Work on consecutive parts of an array, in parallel.

use std::ops::Range;

/// Entries below which parts are worked on one after the other: some ten microseconds' worth.
const GRAIN: usize = 4096;

/// Calls `work` with consecutive ranges that make up `range`, and with what they have of an array: that of k lies from `start(k)` to
/// `start(k + 1)`, which ascend, and `data` is that of `range`. Nothing is allocated.
pub fn for_each_part<T: Send>(
    range: Range<usize>,
    start: &(impl Fn(usize) -> usize + Sync),
    data: &mut [T],
    work: &(impl Fn(Range<usize>, &mut [T]) + Sync),
) {
    if range.len() > 1 && data.len() > GRAIN {
        let middle = range.start + range.len() / 2;
        let (left, right) = data.split_at_mut(start(middle) - start(range.start));
        rayon::join(
            || for_each_part(range.start..middle, start, left, work),
            || for_each_part(middle..range.end, start, right, work),
        );
        return;
    }
    work(range, data);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_worked_on_once() {
        // Parts of 0 to 6 entries, 60,000 in all.
        let mut offsets = vec![0];
        offsets.extend((0..20_000).scan(0, |sum, k| {
            *sum += k % 7;
            Some(*sum)
        }));
        let mut data = vec![0_usize; offsets[20_000]];
        for_each_part(0..20_000, &|k| offsets[k], &mut data, &|range, part: &mut [usize]| {
            let base = offsets[range.start];
            for k in range {
                part[offsets[k] - base..offsets[k + 1] - base].iter_mut().for_each(|entry| *entry += k + 1);
            }
        });
        for k in 0..20_000 {
            assert!(data[offsets[k]..offsets[k + 1]].iter().all(|&entry| entry == k + 1));
        }
        for_each_part(0..0, &|_| 0, &mut data[..0], &|range, part: &mut [usize]| {
            assert!(range.is_empty() && part.is_empty());
        });
    }
}
