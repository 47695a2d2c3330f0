//! Lists in one piece of memory.

/// A list of items for each number from 0 on.
#[derive(Debug)]
pub(crate) struct Lists<T> {
    /// Where the items of each list end.
    ends: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Sorts items into `count` lists. `all` gives each with the number of its list, twice alike. Items of a list keep their order.
    pub(crate) fn new<I: Iterator<Item = (usize, T)>>(count: usize, all: impl Fn() -> I) -> Self {
        let mut ends = vec![0usize; count];
        all().for_each(|(list, _)| ends[list] += 1);
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum - *end;
        }
        let mut items = vec![T::default(); sum];
        for (list, item) in all() {
            items[ends[list]] = item;
            ends[list] += 1;
        }
        Lists { ends, items }
    }

    /// Appends a list.
    pub(crate) fn push(&mut self, items: &[T]) {
        self.items.extend_from_slice(items);
        self.ends.push(self.items.len());
    }

    /// The items of a list; none of a list that is not there.
    pub(crate) fn of(&self, list: usize) -> &[T] {
        let start = list.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.ends.get(list).map_or(&[], |end| &self.items[start..*end])
    }

    /// The lists one after the other, to be changed.
    pub(crate) fn all_mut(&mut self) -> impl Iterator<Item = &mut [T]> {
        let (mut start, mut rest) = (0, &mut self.items[..]);
        self.ends.iter().map(move |end| {
            let own = rest.split_off_mut(..*end - start).unwrap_or_default();
            start = *end;
            own
        })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Lists { ends: Vec::new(), items: Vec::new() }
    }
}
