//! What a replaced file passes on: owner, permissions, access control list and other
//! extended attributes.
//!
//! Nobody may gain a right by the replacement. What can be kept is kept. A right that
//! can't be kept is narrowed to what everybody to whom it now applies had before.

use std::{
    ffi::{CStr, CString},
    fs::{self, File, Metadata},
    io,
    os::unix::fs::{MetadataExt, PermissionsExt, fchown},
    path::Path,
};

use rustix::io::Errno;

use super::extended;
use crate::ppm::errors::{ImageError, refused};

/// The extended attribute that holds the access control list.
const LIST: &CStr = c"system.posix_acl_access";

/// Extended attributes that describe the bytes of the old file, so they are not passed on.
const ABOUT_BYTES: [&[u8]; 3] = [b"security.capability", b"security.ima", b"security.evm"];

/// The mode before the umask; of a private file, only what its owner may do.
pub(super) fn mode_of_new(private: bool) -> u32 {
    if private { 0o600 } else { 0o666 }
}

/// What a file passes on.
#[derive(Debug)]
pub(in crate::ppm) struct Permissions {
    user: u32,
    group: u32,
    rights: Rights,
    attributes: Vec<(CString, Vec<u8>)>,
}

impl Permissions {
    pub(in crate::ppm) fn of(path: &Path, metadata: &Metadata) -> Result<Self, ImageError> {
        let refuse = |error: Errno| refused(path, "read its permissions")(error);
        let names = extended::names(path).map_err(refuse)?;
        let list = if names.iter().any(|name| name.as_c_str() == LIST) {
            extended::get(path, LIST).map_err(refuse)?
        } else {
            None
        };
        let rights = match list.map(|bytes| Rights::parse(&bytes)) {
            Some(Some(rights)) => rights,
            Some(None) => return Err(refuse(Errno::OPNOTSUPP)),
            None => Rights::of_mode(metadata.permissions().mode()),
        };
        let attributes = names
            .into_iter()
            .filter(|name| !name.to_bytes().starts_with(b"system.posix_acl_"))
            .filter(|name| !ABOUT_BYTES.contains(&name.to_bytes()))
            // An attribute that may not be read can't be kept; it gives no right.
            .filter_map(|name| Some((extended::get(path, &name).ok()??, name)))
            .map(|(value, name)| (name, value))
            .collect();
        Ok(Self {
            user: metadata.uid(),
            group: metadata.gid(),
            rights,
            attributes,
        })
    }

    /// Gives all of it to `file`, which is to replace the other one.
    pub(in crate::ppm) fn pass_on(&self, file: &File) -> io::Result<()> {
        // Nobody else may do anything until everything is set. A list that the directory
        // gave to the new file was not the old file's.
        set_mode(file, 0o600)?;
        extended::remove(file, LIST)?;
        let (user, group) = self.pass_on_owner(file)?;
        let mut rights = self.rights_of(user, group);
        for (name, value) in &self.attributes {
            let kept = extended::set(file, name, value);
            // Another access control list, of a kind that is not understood here.
            if kept.is_err() && name.to_bytes().starts_with(b"system.") {
                rights = Rights::of_mode(rights.mode() & 0o700);
            }
        }
        if rights.is_list {
            match extended::set(file, LIST, &rights.bytes()) {
                Ok(()) => return Ok(()),
                Err(_) => rights.narrow_to_mode(),
            }
        }
        set_mode(file, rights.mode())
    }

    /// The rights of a file that has this owner and this group.
    fn rights_of(&self, user: u32, group: u32) -> Rights {
        let mut rights = self.rights.clone();
        if user != self.user {
            rights.narrow_for_former_owner(self.user);
        }
        if group != self.group {
            rights.narrow_for_former_group();
        }
        rights
    }

    /// Gives the file the owner and the group, or only the group, if that is allowed.
    /// Returns those that it has then.
    fn pass_on_owner(&self, file: &File) -> io::Result<(u32, u32)> {
        let now = file.metadata()?;
        if (now.uid(), now.gid()) == (self.user, self.group) {
            return Ok((self.user, self.group));
        }
        if fchown(file, Some(self.user), Some(self.group)).is_err() {
            let _ = fchown(file, None, Some(self.group));
        }
        let now = file.metadata()?;
        Ok((now.uid(), now.gid()))
    }
}

fn set_mode(file: &File, mode: u32) -> io::Result<()> {
    if file.metadata()?.permissions().mode() & 0o7777 == mode {
        return Ok(());
    }
    file.set_permissions(fs::Permissions::from_mode(mode))
}

/// Who may do what, in bits: 4 to read, 2 to write, 1 to execute.
#[derive(Clone, Debug)]
struct Rights {
    owner: u16,
    group: u16,
    other: u16,
    /// The upper limit for the group and the entries of the list.
    mask: u16,
    users: Vec<Named>,
    groups: Vec<Named>,
    /// Whether there is an access control list, not only a mode.
    is_list: bool,
}

/// A user or a group, and what it may do.
#[derive(Clone, Copy, Debug)]
struct Named {
    id: u32,
    may: u16,
}

/// The kinds of entries of an access control list.
mod tag {
    pub(super) const OWNER: u16 = 1;
    pub(super) const USER: u16 = 2;
    pub(super) const OWNING_GROUP: u16 = 4;
    pub(super) const GROUP: u16 = 8;
    pub(super) const MASK: u16 = 16;
    pub(super) const OTHER: u16 = 32;
}

/// The version of the format, the first number of a list.
const VERSION: u32 = 2;

/// The `id` of entries that name no user or group.
const NOBODY: u32 = u32::MAX;

const ALL: u16 = 7;

impl Rights {
    fn of_mode(mode: u32) -> Self {
        let bits = |shift| (mode >> shift) as u16 & ALL;
        Self {
            owner: bits(6),
            group: bits(3),
            other: bits(0),
            mask: ALL,
            users: Vec::new(),
            groups: Vec::new(),
            is_list: false,
        }
    }

    /// Reads the bytes of a list; `None` if they are not one.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let (version, entries) = bytes.split_first_chunk()?;
        let (entries, rest) = entries.as_chunks::<8>();
        if u32::from_le_bytes(*version) != VERSION || !rest.is_empty() {
            return None;
        }
        let mut rights = Self::of_mode(0);
        for &[t0, t1, m0, m1, id @ ..] in entries {
            let (tag, may) = (u16::from_le_bytes([t0, t1]), u16::from_le_bytes([m0, m1]));
            let named = Named {
                id: u32::from_le_bytes(id),
                may,
            };
            match tag {
                tag::OWNER => rights.owner = may,
                tag::USER => rights.users.push(named),
                tag::OWNING_GROUP => rights.group = may,
                tag::GROUP => rights.groups.push(named),
                tag::MASK => (rights.mask, rights.is_list) = (may, true),
                tag::OTHER => rights.other = may,
                _ => return None,
            }
        }
        Some(rights)
    }

    fn bytes(&self) -> Vec<u8> {
        let mut bytes = VERSION.to_le_bytes().to_vec();
        let mut push = |tag: u16, Named { id, may }: Named| {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(may.to_le_bytes());
            bytes.extend(id.to_le_bytes());
        };
        let unnamed = |may| Named { id: NOBODY, may };
        push(tag::OWNER, unnamed(self.owner));
        for &user in &self.users {
            push(tag::USER, user);
        }
        push(tag::OWNING_GROUP, unnamed(self.group));
        for &group in &self.groups {
            push(tag::GROUP, group);
        }
        push(tag::MASK, unnamed(self.mask));
        push(tag::OTHER, unnamed(self.other));
        bytes
    }

    fn mode(&self) -> u32 {
        u32::from(self.owner << 6 | (self.group & self.mask) << 3 | self.other)
    }

    /// What all named entries allow.
    fn all_named(named: &[Named], mask: u16) -> u16 {
        named.iter().fold(ALL, |all, named| all & named.may & mask)
    }

    /// The owner could not be kept: the former owner is now one of the others.
    fn narrow_for_former_owner(&mut self, former: u32) {
        let had = self.owner;
        self.group &= had;
        self.other &= had;
        for named in &mut self.groups {
            named.may &= had;
        }
        for named in self.users.iter_mut().filter(|user| user.id == former) {
            named.may &= had;
        }
    }

    /// The group could not be kept: its former members are now others. Members of the new
    /// group were others, or in groups of the list.
    fn narrow_for_former_group(&mut self) {
        let had = self.group & self.mask;
        self.group = had & self.other & Self::all_named(&self.groups, self.mask);
        self.other &= had;
    }

    /// The list could not be kept: users that it names are now in the group or others, and
    /// members of groups that it names are others if they are not in the group.
    fn narrow_to_mode(&mut self) {
        let users = Self::all_named(&self.users, self.mask);
        self.group &= self.mask & users;
        self.other &= users & Self::all_named(&self.groups, self.mask);
        self.is_list = false;
    }
}

#[cfg(test)]
mod tests;
