//! A map that is quick without optimisation. Build scripts are compiled so, where the standard library's map takes a third of the
//! generator's time: its vector instructions are calls there.

use std::hash::{Hash, Hasher};

use rustc_hash::FxHasher;

/// A map with open addressing, whose entries stay in the order in which they came.
#[derive(Clone, Debug)]
pub(crate) struct Table<K, V> {
    entries: Vec<(K, V)>,
    /// Numbers of entries from 1 on, each at the place of its key's hash or at the first free one after it; 0 is free. Their count is a
    /// power of two, at least twice that of the entries.
    places: Vec<u32>,
}

impl<K, V> Default for Table<K, V> {
    fn default() -> Self {
        Self { entries: Vec::new(), places: vec![0; 8] }
    }
}

impl<K: Eq + Hash, V> Table<K, V> {
    pub fn get(&self, key: &K) -> Option<&V> {
        let number = self.places[self.find(key)] as usize;
        if number == 0 { None } else { Some(&self.entries[number - 1].1) }
    }

    /// Enters a value, in the place of one that is there.
    pub fn insert(&mut self, key: K, value: V) {
        let place = self.find(&key);
        let number = self.places[place] as usize;
        if number > 0 {
            self.entries[number - 1].1 = value;
            return;
        }
        self.entries.push((key, value));
        self.places[place] = self.entries.len() as u32;
        if 2 * self.entries.len() >= self.places.len() {
            self.widen();
        }
    }

    /// The place of a key, or the free one that it would have.
    fn find(&self, key: &K) -> usize {
        let last = self.places.len() - 1;
        let mut hasher = FxHasher::default();
        key.hash(&mut hasher);
        let mut place = hasher.finish() as usize & last;
        loop {
            let number = self.places[place] as usize;
            if number == 0 || self.entries[number - 1].0 == *key {
                return place;
            }
            place = (place + 1) & last;
        }
    }

    fn widen(&mut self) {
        self.places = vec![0; 2 * self.places.len()];
        for number in 0..self.entries.len() {
            let place = self.find(&self.entries[number].0);
            self.places[place] = number as u32 + 1;
        }
    }
}

impl<K: Eq + Hash, V> FromIterator<(K, V)> for Table<K, V> {
    fn from_iter<T: IntoIterator<Item = (K, V)>>(entries: T) -> Self {
        let mut table = Self::default();
        entries.into_iter().for_each(|(key, value)| table.insert(key, value));
        table
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    /// Keys that all have the same hash, so that all of them collide.
    #[derive(PartialEq, Eq)]
    struct Colliding(usize);

    impl std::hash::Hash for Colliding {
        fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
            state.write_u8(7);
        }
    }

    #[test]
    fn keys_have_their_values() {
        let mut table: Table<usize, usize> = (0..1000).map(|key| (7 * key, key)).collect();
        (0..500).for_each(|key| table.insert(14 * key, 3));
        for key in 0..1000 {
            assert_eq!(table.get(&(7 * key)), Some(&if key % 2 == 0 { 3 } else { key }));
            assert_eq!(table.get(&(7 * key + 1)), None);
        }
        let colliding: Table<Colliding, usize> = (0..40).map(|key| (Colliding(key), key)).collect();
        assert!((0..40).all(|key| colliding.get(&Colliding(key)) == Some(&key)));
        assert_eq!(colliding.get(&Colliding(40)), None);
    }
}
