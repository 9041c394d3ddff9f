//! Memory that is used again from one picture to the next.

use std::{
    ops::{Deref, DerefMut},
    sync::{Mutex, PoisonError},
};

use super::{
    band::Scratch,
    bins::{Placements, Run},
};

/// Memory that drawing needs. Kept from one picture to the next, it need not be obtained
/// again: of a million spheres that is a sixth of the time.
#[derive(Debug, Default)]
pub struct Workspace {
    pub(super) runs: Pool<Run>,
    pub(super) placements: Pool<Placements>,
    pub(super) scratches: Pool<Scratch>,
}

/// Things of one kind that are not in use.
#[derive(Debug)]
pub(super) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    /// One of them, or a new one.
    pub(super) fn take(&self) -> T {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.pop().unwrap_or_default()
    }

    pub(super) fn give(&self, one: T) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.push(one);
    }

    /// As [`take`](Self::take), until it is dropped.
    pub(super) fn lend(&self) -> Lent<'_, T> {
        Lent {
            one: self.take(),
            pool: self,
        }
    }
}

/// A thing that goes back to its pool.
#[derive(Debug)]
pub(super) struct Lent<'a, T: Default> {
    one: T,
    pool: &'a Pool<T>,
}

impl<T: Default> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.one
    }
}

impl<T: Default> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.one
    }
}

impl<T: Default> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        self.pool.give(std::mem::take(&mut self.one));
    }
}
