//! Memory that is reused.

use std::{
    ops::{Deref, DerefMut},
    sync::{Mutex, PoisonError},
};

/// Objects of one kind that are not in use.
#[derive(Debug)]
pub(super) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    /// Takes one of them, or a new one.
    pub(super) fn take(&self) -> T {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.pop().unwrap_or_default()
    }

    pub(super) fn give(&self, one: T) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.push(one);
    }

    /// Like [`take`](Self::take), but gives it back when it is dropped.
    pub(super) fn lend(&self) -> Lent<'_, T> {
        Lent {
            one: self.take(),
            pool: self,
        }
    }
}

/// An object that returns to its pool when it is dropped.
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

#[cfg(test)]
mod tests {
    use super::Pool;

    #[test]
    fn what_was_lent_is_lent_again() {
        let pool = Pool::<Vec<u8>>::default();
        pool.lend().reserve_exact(1000);
        assert!(pool.lend().capacity() >= 1000);
        assert_eq!(pool.lend().len(), 0);
        let [first, second] = [pool.take(), pool.take()];
        assert!(first.capacity() >= 1000 && second.capacity() == 0);
        pool.give(first);
        assert!(pool.take().capacity() >= 1000);
    }
}
