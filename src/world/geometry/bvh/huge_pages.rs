//! Large arrays that rays visit at random, on large pages where the system gives them: with pages of 4 KiB nearly each
//! visit to a large tree also walks the page table.

/// Asks the memory for the start of an item that will be looked at soon.
#[inline(always)]
pub fn fetch<T>(items: &[T], place: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint that has no effect on what is computed, whatever the address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(items.as_ptr().wrapping_add(place).cast::<i8>()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, place);
}

/// The same items in an array on large pages, if it fills at least one.
pub fn settle<T: Copy>(items: Vec<T>) -> Vec<T> {
    const PAGE: usize = 1 << 21;
    let bytes = std::mem::size_of_val(items.as_slice());
    if bytes < PAGE {
        return items;
    }
    // Room for whole pages, wherever the array starts.
    let spare = PAGE.div_ceil(size_of::<T>().max(1));
    let mut settled: Vec<T> = Vec::new();
    if settled.try_reserve_exact(items.len().saturating_add(spare)).is_err() {
        return items;
    }
    #[cfg(target_os = "linux")]
    {
        unsafe extern "C" {
            /// madvise(2) of the C library that `std` is linked to.
            safe fn madvise(start: *mut u8, bytes: usize, advice: i32) -> i32;
        }
        /// MADV_HUGEPAGE of <linux/mman.h>, the same on all processors.
        const HUGE: i32 = 14;
        let start = settled.as_mut_ptr().cast::<u8>();
        let first = start.align_offset(PAGE);
        let room = settled.capacity() * size_of::<T>();
        // A refusal is no harm.
        let _ = room.checked_sub(first).map(|room| madvise(start.wrapping_add(first), room / PAGE * PAGE, HUGE));
    }
    settled.extend_from_slice(&items);
    settled
}
