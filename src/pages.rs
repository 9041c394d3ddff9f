//! Huge pages, on the one system that is asked for them.

use std::ops::Range;

use memmap2::MmapMut;

/// What a huge page holds.
pub(crate) const HUGE_PAGE: usize = 2 << 20;

/// Asks for huge pages in a range of a map's bytes. Only advice: without them what uses
/// the memory is slower and otherwise the same.
#[cfg(target_os = "linux")]
pub(crate) fn ask_for_huge(map: &MmapMut, range: Range<usize>) {
    let _ = map.advise_range(memmap2::Advice::HugePage, range.start, range.len());
}

/// Other systems are not asked.
#[cfg(not(target_os = "linux"))]
pub(crate) fn ask_for_huge(_map: &MmapMut, _range: Range<usize>) {}
