//! Failed allocations: a message of the program instead of the standard library's.

use std::{
    alloc::{GlobalAlloc, Layout, System},
    io::Write,
};

use super::signals;

/// The system's allocator, but a failed allocation ends the program.
struct Allocator;

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

#[expect(
    unsafe_code,
    reason = "there is no other way to replace the standard library's message"
)]
// SAFETY: every call is passed to the system's allocator with the same arguments, so the
// caller's promises are those that it asks for. The only difference is that a null pointer
// ends the program.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promises.
        checked(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }
}

fn checked(memory: *mut u8, bytes: usize) -> *mut u8 {
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
        "sfera: out of memory: can't allocate {bytes} bytes; raise the limit on addresses (ulimit -v), or free some memory"
    );
    let left = rest.len();
    signals::end_with(&message[..message.len() - left], 1)
}
