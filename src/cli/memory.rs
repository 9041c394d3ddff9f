//! Memory that can't be had: a message of ours instead of the standard library's.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    io::Write,
};

use super::signals;

/// The system's allocator, which ends the program when it has no memory left.
struct Allocator;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

#[expect(
    unsafe_code,
    reason = "the standard library's message can't be replaced in another way"
)]
// SAFETY: every call is the system's, with the same arguments, whose contract is
// the caller's. What differs is that a null pointer ends the program.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        had(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        had(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promises.
        had(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }
}

fn had(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        out_of_memory(bytes);
    }
    memory
}

#[cold]
fn out_of_memory(bytes: usize) -> ! {
    let mut message = [0; 200];
    let mut rest = &mut message[..];
    let _ = writeln!(
        rest,
        "sfera: out of memory: {bytes} bytes more can't be had; raise the limit on addresses (ulimit -v), or free some memory"
    );
    let left = rest.len();
    signals::end_with(&message[..message.len() - left], 1)
}
