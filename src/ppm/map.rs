//! The mapping of a window of a file, and what happens when its pages are lost:
//! the only `unsafe` of the library.

#[cfg(feature = "program")]
use std::{ffi::CString, os::unix::ffi::OsStrExt, path::Path};
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
    //   defined, and which `exit_when_lost` turns into a message.
    let window = unsafe {
        memmap2::MmapOptions::new()
            .offset(window.start)
            .len((window.end - window.start) as usize)
            .map_mut(file)
    }?;
    ask_for_huge(&window, 0..window.len());
    Ok(window)
}

/// Ends the process with `message` and exit code 1 if a mapped image is taken
/// away under it: shortened by another process, or its disk gone. `temporary`
/// is removed first. For programs, not libraries: it is the process's handler
/// of `SIGBUS` from then on.
///
/// # Errors
///
/// If there can be no such handler.
#[cfg(feature = "program")]
#[expect(
    unsafe_code,
    reason = "a signal is how the system tells of a lost page"
)]
pub fn exit_when_lost(message: String, temporary: Option<&Path>) -> io::Result<()> {
    let temporary = temporary.and_then(|path| CString::new(path.as_os_str().as_bytes()).ok());
    let action = move || {
        if let Some(name) = &temporary {
            let _ = rustix::fs::unlink(name.as_c_str());
        }
        let _ = rustix::io::write(rustix::stdio::stderr(), message.as_bytes());
        signal_hook::low_level::exit(1);
    };
    // SAFETY: the action does three system calls on memory made beforehand;
    // it takes no lock and allocates nothing.
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGBUS, action) }?;
    Ok(())
}
