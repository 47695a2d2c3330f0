//! Generational ids: what C holds instead of pointers. A slot's generation grows with every use, so an id whose thing
//! was destroyed is told apart from the thing that took its place; a slot whose generations are used up is never used
//! again.

use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance};
use crate::base::memory::may_fail;
use std::marker::PhantomData;

/// An id by value.
pub(super) trait Id: Copy {
    /// What it stands for, in messages.
    const NOUN: &'static str;
    fn new(index: u32, generation: u16, context: u16) -> Self;
    fn parts(self) -> (u32, u16, u16);
}

macro_rules! id {
    ($id:ident, $noun:literal) => {
        impl Id for $id {
            const NOUN: &'static str = $noun;
            fn new(index: u32, generation: u16, context: u16) -> Self {
                Self { index, generation, context }
            }
            fn parts(self) -> (u32, u16, u16) {
                (self.index, self.generation, self.context)
            }
        }
    };
}

id!(CrumpleExampleSet, "example set");
id!(CrumpleInstance, "instance");
id!(CrumpleBuffer, "buffer");

struct Slot<T> {
    generation: u16,
    value: Option<T>,
}

/// Things by id. An id's index is the slot's place plus one, so that zero is null.
pub(super) struct Slots<I, T> {
    context: u16,
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
    ids: PhantomData<I>,
}

impl<I: Id, T> Slots<I, T> {
    pub(super) fn new(context: u16) -> Self {
        Self { context, slots: Vec::new(), free: Vec::new(), ids: PhantomData }
    }

    /// Makes room for one more, so that `insert` and a later `remove` cannot fail.
    pub(super) fn reserve(&mut self) -> Result<(), Failure> {
        if !self.free.is_empty() {
            return Ok(());
        }
        if self.slots.len() >= u32::MAX as usize {
            return Err(Failure::invalid(format!("no more {}s: 4294967295 were made", I::NOUN)));
        }
        let full = |_| Failure::out_of_memory(&format!("one more {}", I::NOUN));
        may_fail(|| self.slots.try_reserve(1)).map_err(full)?;
        may_fail(|| self.free.try_reserve(self.slots.len() + 1)).map_err(full)
    }

    /// Adds a thing; call `reserve` before.
    pub(super) fn insert(&mut self, value: T) -> I {
        let place = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Slot { generation: 0, value: None });
            self.slots.len() as u32 - 1
        });
        let slot = &mut self.slots[place as usize];
        slot.generation += 1; // `remove` retires a slot before this overflows
        slot.value = Some(value);
        I::new(place + 1, slot.generation, self.context)
    }

    /// The slot of an id, or why there is none. `name` is the argument's.
    fn place(&self, id: I, name: &str) -> Result<usize, Failure> {
        let (index, generation, context) = id.parts();
        let wrong = |why: String| Err(Failure::new(CrumpleResult::CrumpleErrorInvalidId, format!("{name} {why}")));
        if index == 0 {
            return wrong(format!("is the null {}", I::NOUN));
        }
        if context != self.context {
            return wrong(format!("is an id of another context (tag {context}, this context's is {})", self.context));
        }
        match self.slots.get(index as usize - 1) {
            Some(slot) if slot.generation == generation && slot.value.is_some() => Ok(index as usize - 1),
            Some(slot) if generation != 0 && generation <= slot.generation => {
                wrong(format!("is stale: {} {index} (generation {generation}) was destroyed", I::NOUN))
            }
            _ => wrong(format!("is no id: there never was {} {index} (generation {generation})", I::NOUN)),
        }
    }

    pub(super) fn get(&self, id: I, name: &str) -> Result<&T, Failure> {
        let place = self.place(id, name)?;
        Ok(self.slots[place].value.as_ref().expect("place() checked it"))
    }

    pub(super) fn get_mut(&mut self, id: I, name: &str) -> Result<&mut T, Failure> {
        let place = self.place(id, name)?;
        Ok(self.slots[place].value.as_mut().expect("place() checked it"))
    }

    /// Two different things.
    pub(super) fn get_two_mut(
        &mut self,
        (a, a_name): (I, &str),
        (b, b_name): (I, &str),
    ) -> Result<(&mut T, &mut T), Failure> {
        let places = [self.place(a, a_name)?, self.place(b, b_name)?];
        let same = |_| Failure::invalid(format!("{a_name} and {b_name} are the same {}", I::NOUN));
        let [a, b] = self.slots.get_disjoint_mut(places).map_err(same)?;
        Ok((a.value.as_mut().expect("place() checked it"), b.value.as_mut().expect("place() checked it")))
    }

    pub(super) fn remove(&mut self, id: I, name: &str) -> Result<T, Failure> {
        let place = self.place(id, name)?;
        let slot = &mut self.slots[place];
        if slot.generation < u16::MAX {
            self.free.push(place as u32);
        }
        Ok(slot.value.take().expect("place() checked it"))
    }

    /// At least the number of things.
    pub(super) fn len(&self) -> usize {
        self.slots.len()
    }

    /// All things with their ids, in the order of their slots.
    pub(super) fn iter(&self) -> impl Iterator<Item = (I, &T)> {
        let context = self.context;
        self.slots.iter().enumerate().filter_map(move |(place, slot)| {
            Some((I::new(place as u32 + 1, slot.generation, context), slot.value.as_ref()?))
        })
    }

    /// All things with their ids, to change, in the order of their slots.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (I, &mut T)> {
        let context = self.context;
        self.slots.iter_mut().enumerate().filter_map(move |(place, slot)| {
            Some((I::new(place as u32 + 1, slot.generation, context), slot.value.as_mut()?))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_is_retired_before_its_generations_repeat() {
        let mut slots = Slots::<CrumpleBuffer, ()>::new(1);
        let first = slots.insert(());
        slots.remove(first, "buffer").unwrap();
        for _ in 1..u16::MAX {
            let id = slots.insert(());
            assert_eq!(id.index, 1);
            slots.remove(id, "buffer").unwrap();
        }
        let id = slots.insert(());
        assert_eq!((id.index, id.generation), (2, 1));
        let failure = slots.get(first, "buffer").unwrap_err();
        assert!(failure.message.contains("stale"), "{}", failure.message);
    }
}
