//! The parameters of glibc's allocator. The allocator keeps freed memory, so a process takes more memory than
//! it counts. Other allocators are left unchanged.

/// Freed blocks from this size on are returned to the system immediately.
#[cfg(target_env = "gnu")]
const RETURNED_BYTES: i32 = 4 << 20;

/// Makes the allocator return large blocks to the system as soon as they are freed. Call it once, when the
/// program begins. Without it, the allocator keeps blocks of up to 32 MiB once a block of that size has been
/// freed, such as the tables that sort a scene's triangles.
pub(crate) fn return_large_blocks() {
    #[cfg(target_env = "gnu")]
    for parameter in [libc::M_MMAP_THRESHOLD, libc::M_TRIM_THRESHOLD] {
        #[expect(unsafe_code, reason = "the standard library does not reach the allocator's parameters")]
        // SAFETY: `mallopt` takes two numbers, and holds the allocator's own lock while it stores them. It
        // refuses parameters that it does not know.
        let is_set = unsafe { libc::mallopt(parameter, RETURNED_BYTES) };
        debug_assert_eq!(is_set, 1, "parameter {parameter}");
    }
}

/// Returns the free pages of all threads to the system, and whether there were any. Takes milliseconds.
pub(crate) fn return_free_pages() -> bool {
    #[cfg(target_env = "gnu")]
    #[expect(unsafe_code, reason = "the standard library does not reach the allocator")]
    // SAFETY: `malloc_trim` takes the number of bytes to keep, and holds the allocator's own locks.
    let were_any = unsafe { libc::malloc_trim(0) } == 1;
    #[cfg(not(target_env = "gnu"))]
    let were_any = false;
    were_any
}

#[cfg(all(test, target_env = "gnu"))]
mod tests {
    use super::*;

    #[test]
    fn free_pages_between_kept_blocks_return_to_the_system() {
        let mut blocks: Vec<Option<Vec<u8>>> = (0..256).map(|i| Some(vec![i as u8; 16 << 10])).collect();
        blocks.iter_mut().step_by(2).for_each(|block| *block = None);
        assert!(return_free_pages());
        assert!(
            blocks
                .iter()
                .skip(1)
                .step_by(2)
                .zip(0..)
                .all(|(block, i)| block.as_ref().unwrap()[7] == 2 * i + 1)
        );
    }
}
