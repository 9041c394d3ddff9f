//! Huge pages, on Linux only.

use std::ops::Range;

use memmap2::MmapMut;

/// Bytes of a huge page.
pub(crate) const HUGE_PAGE: usize = 2 << 20;

/// Asks for huge pages in a range of a map's bytes. This is only advice: without them
/// access to the memory is slower.
#[cfg(target_os = "linux")]
pub(crate) fn ask_for_huge(map: &MmapMut, range: Range<usize>) {
    let _ = map.advise_range(memmap2::Advice::HugePage, range.start, range.len());
}

/// Does nothing on other systems.
#[cfg(not(target_os = "linux"))]
pub(crate) fn ask_for_huge(_map: &MmapMut, _range: Range<usize>) {}
