//! Arrays in huge pages, where the system has them.
//!
//! A ray that meets one of millions of triangles reads a dozen places that nothing has read for long. In pages of 4 KB the
//! processor has to look up where most of them are before it can wait for them: a tenth of the time of a path tracer on two
//! million triangles, a fifth of our own backend's. Use it for what is large, read at random and of fixed length; what is read in
//! order gains nothing. Small arrays stay on the heap, as do all where the system has no such pages.

use bytemuck::Pod;
use memmap2::MmapMut;
use std::fmt;
use std::ops::{Deref, DerefMut};

/// Bytes of a huge page, and of the smallest array that is worth some.
const HUGE: usize = 1 << 21;

/// An array of fixed length.
pub struct Pages<T>(Storage<T>);

enum Storage<T> {
    Heap(Box<[T]>),
    Huge {
        map: MmapMut,
        /// Bytes before the first element, which begins a huge page.
        start: usize,
        /// Bytes of all elements.
        size: usize,
    },
}

/// A copy of `items` in zeroed pages of their own; `None` if the system gives none.
fn mapped<T: Pod>(items: &[T]) -> Option<Storage<T>> {
    let size = size_of_val(items);
    let mut map = MmapMut::map_anon(size.checked_next_multiple_of(HUGE)?.checked_add(HUGE)?).ok()?;
    // It may be refused: then it is memory like any other.
    #[cfg(target_os = "linux")]
    let _ = map.advise(memmap2::Advice::HugePage);
    let start = map.as_ptr().align_offset(HUGE);
    map.get_mut(start..start.checked_add(size)?)?.copy_from_slice(bytemuck::cast_slice(items));
    Some(Storage::Huge { map, start, size })
}

impl<T: Pod> From<Vec<T>> for Pages<T> {
    fn from(items: Vec<T>) -> Self {
        if size_of_val(&items[..]) < HUGE { Pages(Storage::Heap(items.into())) } else { (&items[..]).into() }
    }
}

impl<T: Pod> From<&[T]> for Pages<T> {
    fn from(items: &[T]) -> Self {
        let huge = if size_of_val(items) < HUGE { None } else { mapped(items) };
        Pages(huge.unwrap_or_else(|| Storage::Heap(items.into())))
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Storage::Heap(items) => items,
            Storage::Huge { map, start, size } => bytemuck::cast_slice(&map[*start..*start + *size]),
        }
    }
}

impl<T: Pod> DerefMut for Pages<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Storage::Heap(items) => items,
            Storage::Huge { map, start, size } => bytemuck::cast_slice_mut(&mut map[*start..*start + *size]),
        }
    }
}

impl<T: Pod> Default for Pages<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T: Pod> Clone for Pages<T> {
    fn clone(&self) -> Self {
        (**self).into()
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_all_sizes_are_what_they_were_made_of() {
        for count in [0, 1, 1000, HUGE / 12, HUGE / 12 + 1, HUGE] {
            let items: Vec<[u32; 3]> = (0..count as u32).map(|i| [i, !i, 7]).collect();
            let pages = Pages::from(items.clone());
            assert!(*pages == items[..] && *pages.clone() == items[..], "{count}");
            assert_eq!(matches!(pages.0, Storage::Huge { .. }), 12 * count >= HUGE, "{count}");
        }
    }

    #[test]
    fn large_arrays_begin_a_huge_page() {
        let pages = Pages::from(vec![1u8; HUGE + 1]);
        assert_eq!(pages.as_ptr().align_offset(HUGE), 0);
    }
}
