//! Extended attributes of files, on Linux; on other systems there are none.

use std::{
    ffi::{CStr, CString},
    fs::File,
    path::Path,
};

use rustix::io::Errno;

#[cfg(target_os = "linux")]
pub(super) use self::linux::{get, names, remove, set};
#[cfg(not(target_os = "linux"))]
pub(super) use self::none::{get, names, remove, set};

#[cfg(target_os = "linux")]
mod linux {
    use rustix::{
        buffer::spare_capacity,
        fs::{XattrFlags, fremovexattr, fsetxattr, lgetxattr, llistxattr},
    };

    use super::{CStr, CString, Errno, File, Path};

    /// The greatest length of an extended attribute, and of the list of them.
    const MAX_LENGTH: usize = 1 << 16;

    /// The names of a file's extended attributes.
    pub(in super::super) fn names(path: &Path) -> Result<Vec<CString>, Errno> {
        let mut names = Vec::with_capacity(MAX_LENGTH);
        match llistxattr(path, spare_capacity(&mut names)) {
            Ok(_) => {}
            Err(Errno::OPNOTSUPP | Errno::NOSYS) => return Ok(Vec::new()),
            Err(error) => return Err(error),
        }
        let names = names.split_inclusive(|&byte| byte == 0);
        Ok(names
            .filter_map(|name| Some(CStr::from_bytes_with_nul(name).ok()?.to_owned()))
            .collect())
    }

    /// The value of an extended attribute, if the file has it.
    pub(in super::super) fn get(path: &Path, name: &CStr) -> Result<Option<Vec<u8>>, Errno> {
        let mut value = Vec::with_capacity(MAX_LENGTH);
        match lgetxattr(path, name, spare_capacity(&mut value)) {
            Ok(_) => Ok(Some(value)),
            Err(Errno::NODATA | Errno::OPNOTSUPP) => Ok(None),
            Err(error) => Err(error),
        }
    }

    pub(in super::super) fn set(file: &File, name: &CStr, value: &[u8]) -> Result<(), Errno> {
        fsetxattr(file, name, value, XattrFlags::empty())
    }

    /// Removes an attribute, if the file has it.
    pub(in super::super) fn remove(file: &File, name: &CStr) -> Result<(), Errno> {
        match fremovexattr(file, name) {
            Ok(()) | Err(Errno::NODATA | Errno::OPNOTSUPP | Errno::NOSYS) => Ok(()),
            refused => refused,
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod none {
    use super::{CStr, CString, Errno, File, Path};

    pub(in super::super) fn names(_path: &Path) -> Result<Vec<CString>, Errno> {
        Ok(Vec::new())
    }

    pub(in super::super) fn get(_path: &Path, _name: &CStr) -> Result<Option<Vec<u8>>, Errno> {
        Ok(None)
    }

    pub(in super::super) fn set(_file: &File, _name: &CStr, _value: &[u8]) -> Result<(), Errno> {
        Err(Errno::NOTSUP)
    }

    pub(in super::super) fn remove(_file: &File, _name: &CStr) -> Result<(), Errno> {
        Ok(())
    }
}
