//! Properties of files that keep them from being changed, other than permissions.

/// Properties of an inode other than its permissions.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::ppm) struct Attributes {
    /// `chattr +i`
    pub(in crate::ppm) immutable: bool,
    /// `chattr +a`
    pub(in crate::ppm) append_only: bool,
    /// Whether it is a mount point.
    pub(in crate::ppm) mount_root: bool,
}

impl Attributes {
    /// The attribute that keeps even root from changing the file, as `chattr` calls it.
    pub(in crate::ppm) fn lock(self) -> Option<char> {
        match self {
            Self {
                immutable: true, ..
            } => Some('i'),
            Self {
                append_only: true, ..
            } => Some('a'),
            _ => None,
        }
    }
}
