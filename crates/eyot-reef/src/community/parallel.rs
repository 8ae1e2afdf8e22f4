//! The same work for many: on all threads if they are enough to be worth it, which never changes a result.

use rayon::prelude::*;

/// Items of one task, enough that handing it out costs little.
const TASK: usize = 64;
/// Fewer are done on the spot: waking other threads takes longer.
const FEW: usize = 512;

/// Results of `f` for all items, in their order; `f` gets number and item.
pub(super) fn map<T: Sync, R: Send>(items: &[T], f: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    if items.len() < FEW {
        return items.iter().enumerate().map(|(i, item)| f(i, item)).collect();
    }
    items.par_iter().enumerate().with_min_len(TASK).map(|(i, item)| f(i, item)).collect()
}

/// As [`map`], where many are worked off in an order that keeps neighbours together, and so what they look at in the cache.
pub(super) fn map_in_order<T: Sync, R: Send + Clone + Default>(
    items: &[T],
    order: impl IndexedParallelIterator<Item = usize>,
    f: impl Fn(usize, &T) -> R + Sync,
) -> Vec<R> {
    if items.len() < FEW {
        return map(items, f);
    }
    let results: Vec<(usize, R)> = order.with_min_len(TASK).map(|i| (i, f(i, &items[i]))).collect();
    let mut out = vec![R::default(); items.len()];
    results.into_iter().for_each(|(i, r)| out[i] = r);
    out
}

/// As [`map`], for items that `f` changes.
pub(super) fn map_mut<T: Send, R: Send>(items: &mut [T], f: impl Fn(usize, &mut T) -> R + Sync) -> Vec<R> {
    if items.len() < FEW {
        return items.iter_mut().enumerate().map(|(i, item)| f(i, item)).collect();
    }
    items.par_iter_mut().enumerate().with_min_len(TASK).map(|(i, item)| f(i, item)).collect()
}
