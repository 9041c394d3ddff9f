//! The mapping of a window of a file: the only `unsafe` of the library.

use std::{fs::File, io, ops::Range};

use crate::pages::ask_for_huge;

#[expect(unsafe_code, reason = "this module exists to map images")]
pub(super) fn map(file: &File, window: Range<u64>) -> io::Result<memmap2::MmapMut> {
    // SAFETY: the bytes must not be changed or removed by anyone else while they are mapped.
    // - A new image has no name (or a temporary one), so no other process knows it. This
    //   process maps one window of it at a time.
    // - A shared image is mapped for rows that the user assigned to this process. Another
    //   process with the same rows stores the same bytes, and the drawing only stores
    //   bytes and never reads them.
    // - The blocks are reserved, so no store finds the disk full. If another process
    //   shortens the file nevertheless, this process receives SIGBUS, which is defined
    //   behaviour and which the program turns into a message. (On Windows nobody can
    //   shorten a mapped file.)
    let window = unsafe {
        memmap2::MmapOptions::new()
            .offset(window.start)
            .len((window.end - window.start) as usize)
            .map_mut(file)
    }?;
    ask_for_huge(&window, 0..window.len());
    Ok(window)
}
