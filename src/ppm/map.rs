//! The mapping of a window of a file: the only `unsafe` of the library.

use std::{fs::File, io, ops::Range};

use crate::pages::ask_for_huge;

#[expect(unsafe_code, reason = "a mapped image is what this module is for")]
pub(super) fn map(file: &File, window: Range<u64>) -> io::Result<memmap2::MmapMut> {
    // SAFETY: nobody else may change these bytes or take them away.
    // - A new image has no name (or one made up for it), so no other process
    //   knows it; this one maps a window at a time, and nothing else of it.
    // - A shared image is mapped for rows that the user gave to this process.
    //   One that is given the same rows stores the same bytes, and the drawing
    //   only stores bytes, never asks what they are.
    // - The blocks are reserved, so no store finds the disk full. Whoever
    //   shortens the file all the same ends this process with SIGBUS, which is
    //   defined, and which the program turns into a message. (Windows lets nobody
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
