//! Memory that was given back to the allocator and may go back to the system.

/// Asks the allocator for what it keeps of freed memory: a film's sums are many small pieces, which glibc keeps for others of
/// their size, and what comes after a film is large. Where the allocator is another one it decides by itself.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        unsafe extern "C" {
            /// glibc, `malloc.h` (malloc_trim(3)): keeps `pad` bytes at the top of the heap; thread-safe.
            fn malloc_trim(pad: usize) -> i32;
        }
        // SAFETY: takes no pointer and frees only what is free; it may be called at any time by any thread.
        unsafe { malloc_trim(0) };
    }
}
