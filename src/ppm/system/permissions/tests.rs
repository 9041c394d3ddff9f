//! Nobody gains a right, and nothing is taken away without need.

use std::collections::BTreeSet;

use super::*;

/// The owner that can't be kept.
const FORMER: u32 = 1;
/// The owner that the file gets then.
const NEW: u32 = 2;
/// A user that the list names.
const NAMED: u32 = 3;
/// A user that it does not name.
const UNNAMED: u32 = 4;

/// The group that can't be kept, the one that the file gets then, and one that the list names.
const FORMER_GROUP: u32 = 11;
const NEW_GROUP: u32 = 12;
const NAMED_GROUP: u32 = 13;
const GROUPS: [u32; 3] = [FORMER_GROUP, NEW_GROUP, NAMED_GROUP];

/// A file as the kernel sees it.
struct Seen<'a> {
    user: u32,
    group: u32,
    rights: &'a Rights,
}

impl Seen<'_> {
    /// What a user may do who is in these groups; see acl(5). Of several groups each may
    /// give a right.
    fn may(&self, user: u32, groups: &BTreeSet<u32>) -> u16 {
        let Rights {
            owner,
            group,
            other,
            mask,
            users,
            groups: of_groups,
            is_list,
        } = self.rights;
        if user == self.user {
            return *owner;
        }
        let named = |list: &[Named]| if *is_list { list.to_vec() } else { Vec::new() };
        if let Some(entry) = named(users).iter().find(|entry| entry.id == user) {
            return entry.may & mask;
        }
        let own = Named {
            id: self.group,
            may: *group,
        };
        let of_groups = named(of_groups);
        let mut mine = of_groups
            .iter()
            .chain([&own])
            .filter(|entry| groups.contains(&entry.id))
            .peekable();
        if mine.peek().is_none() {
            return *other;
        }
        mine.fold(0, |any, entry| any | entry.may & mask)
    }
}

/// Every user but the new owner, in any of the groups.
fn others() -> impl Iterator<Item = (u32, BTreeSet<u32>)> {
    [FORMER, NAMED, UNNAMED].into_iter().flat_map(|user| {
        (0..1 << GROUPS.len()).map(move |set: u32| {
            let member = |at: &usize| set >> at & 1 == 1;
            let groups = (0..GROUPS.len()).filter(member).map(|at| GROUPS[at]);
            (user, groups.collect())
        })
    })
}

/// Each combination of rights in which every entry gives all of them or none.
fn every_combination() -> impl Iterator<Item = Rights> {
    (0..1 << 8).flat_map(|bits: u32| {
        let may = |at: u32| if bits >> at & 1 == 1 { ALL } else { 0 };
        let named = |id, at| vec![Named { id, may: may(at) }];
        let list = Rights {
            owner: may(0),
            group: may(1),
            other: may(2),
            mask: may(3),
            users: [named(FORMER, 4), named(NAMED, 5), named(NEW, 7)].concat(),
            groups: named(NAMED_GROUP, 6),
            is_list: true,
        };
        let without_former = Rights {
            users: named(NAMED, 5),
            ..list.clone()
        };
        let mode = Rights {
            mask: ALL,
            users: Vec::new(),
            groups: Vec::new(),
            is_list: false,
            ..list
        };
        [list, without_former, mode]
    })
}

/// Whether someone may do more than before, besides the new owner.
fn gives_more(before: &Seen<'_>, after: &Seen<'_>) -> bool {
    others().any(|(user, groups)| after.may(user, &groups) & !before.may(user, &groups) != 0)
}

/// Calls `check` with every file before, and with it under every owner and group after.
fn under_every_owner(check: impl Fn(&Seen<'_>, &Seen<'_>)) {
    for rights in every_combination() {
        let file = Permissions {
            user: FORMER,
            group: FORMER_GROUP,
            rights,
            attributes: Vec::new(),
        };
        let before = Seen {
            user: FORMER,
            group: FORMER_GROUP,
            rights: &file.rights,
        };
        for user in [FORMER, NEW] {
            for group in [FORMER_GROUP, NEW_GROUP] {
                let rights = &file.rights_of(user, group);
                check(
                    &before,
                    &Seen {
                        user,
                        group,
                        rights,
                    },
                );
            }
        }
    }
}

/// The rights without a list, as a mode says them.
fn as_mode(rights: &Rights) -> Rights {
    let mut rights = rights.clone();
    if rights.is_list {
        rights.narrow_to_mode();
    }
    Rights::of_mode(rights.mode())
}

#[test]
fn nobody_gains_a_right() {
    under_every_owner(|before, after| {
        for rights in [after.rights, &as_mode(after.rights)] {
            let more = gives_more(before, &Seen { rights, ..*after });
            assert!(!more, "{:?} {rights:?}", before.rights);
        }
    });
}

/// Each entry that lost a right would give it to someone who did not have it. (If the list
/// names the former owner, other entries lose more than they need to.)
#[test]
fn what_gives_nobody_more_is_kept() {
    under_every_owner(|before, after| {
        let old = before.rights;
        if old.users.iter().any(|named| named.id == FORMER) {
            return;
        }
        for new in [after.rights, &as_mode(after.rights)] {
            assert_eq!(old.owner, new.owner);
            let mut restored = vec![new.clone(), new.clone()];
            restored[0].group = old.group;
            restored[1].other = old.other;
            if new.is_list {
                assert_eq!(old.mask, new.mask);
                for at in 0..old.users.len() {
                    restored.push(new.clone());
                    restored.last_mut().expect("a list").users[at] = old.users[at];
                }
                for at in 0..old.groups.len() {
                    restored.push(new.clone());
                    restored.last_mut().expect("a list").groups[at] = old.groups[at];
                }
            }
            for rights in &restored {
                let same = rights.bytes() == new.bytes() || rights.mask == 0;
                let seen = Seen { rights, ..*after };
                assert!(same || gives_more(before, &seen), "{old:?} {new:?}");
            }
        }
    });
}

#[test]
fn a_list_is_read_and_written_in_the_form_of_the_kernel() {
    #[rustfmt::skip]
    let bytes = [
        2, 0, 0, 0,
        1, 0, 6, 0, 255, 255, 255, 255,
        2, 0, 5, 0, 1, 2, 3, 4,
        4, 0, 4, 0, 255, 255, 255, 255,
        8, 0, 3, 0, 5, 0, 0, 0,
        16, 0, 7, 0, 255, 255, 255, 255,
        32, 0, 1, 0, 255, 255, 255, 255,
    ];
    let list = Rights::parse(&bytes).expect("a list");
    assert_eq!(list.bytes(), bytes);
    assert!(list.is_list);
    assert_eq!(list.mode(), 0o641);
    let [named_user, named_group] = [list.users[0], list.groups[0]];
    assert_eq!((named_user.id, named_user.may), (0x0403_0201, 5));
    assert_eq!((named_group.id, named_group.may), (5, 3));

    let [mut other_version, mut other_tag] = [bytes, bytes];
    other_version[0] = 3;
    other_tag[4] = 64;
    for other in [
        &other_version[..],
        &other_tag,
        &bytes[..bytes.len() - 1],
        &[2],
    ] {
        assert!(Rights::parse(other).is_none(), "{other:?}");
    }
    // Without a mask there is only a mode.
    let mode = Rights::parse(&[&bytes[..12], &bytes[20..28], &bytes[44..]].concat());
    let mode = mode.expect("three entries");
    assert!(!mode.is_list);
    assert_eq!(mode.mode(), 0o641);
}

#[test]
fn a_mode_is_read_and_written() {
    for mode in 0..0o1000 {
        assert_eq!(Rights::of_mode(0o7000 | mode).mode(), mode);
    }
}

/// A file of this mode and, where the file system has lists, with this one.
fn file(path: &Path, mode: u32, list: Option<&Rights>) -> Option<File> {
    let file = File::create(path).expect("a file");
    set_mode(&file, mode).expect("its mode");
    if let Some(list) = list
        && let Err(error) = extended::set(&file, LIST, &list.bytes())
    {
        eprintln!("skipped: no access control lists here: {error}");
        return None;
    }
    Some(file)
}

fn mode_of(file: &File) -> u32 {
    file.metadata().expect("metadata").mode() & 0o7777
}

#[test]
fn a_list_and_attributes_pass_from_file_to_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let [old_path, new_path] = ["old", "new"].map(|name| folder.path().join(name));
    let named = |id, may| vec![Named { id, may }];
    let list = Rights {
        users: named(NAMED, 6),
        groups: named(NAMED_GROUP, 4),
        is_list: true,
        ..Rights::of_mode(0o604)
    };
    let of_folder = Rights {
        users: named(UNNAMED, 6),
        ..list.clone()
    };
    let Some(old) = file(&old_path, 0o600, Some(&list)) else {
        return;
    };
    let artist = c"user.artist";
    let has_attributes = extended::set(&old, artist, b"me").is_ok();
    let Some(new) = file(&new_path, 0o644, Some(&of_folder)) else {
        return;
    };
    let metadata = old.metadata().expect("metadata");
    let permissions = Permissions::of(&old_path, &metadata).expect("permissions");
    permissions.pass_on(&new).expect("all of them");
    let passed = |name| extended::get(&new_path, name).expect("an attribute or none");
    assert_eq!(passed(LIST), Some(list.bytes()));
    assert_eq!(mode_of(&new), 0o674);
    assert_eq!(passed(artist), has_attributes.then(|| b"me".to_vec()));
    assert_eq!(passed(c"user.other"), None);
}

#[test]
fn a_list_that_the_old_file_did_not_have_is_removed() {
    let folder = tempfile::tempdir().expect("a folder");
    let [old_path, new_path] = ["old", "new"].map(|name| folder.path().join(name));
    let old = file(&old_path, 0o640, None).expect("no list to set");
    let list = Rights {
        users: vec![Named { id: NAMED, may: 6 }],
        is_list: true,
        ..Rights::of_mode(0o666)
    };
    let Some(new) = file(&new_path, 0o666, Some(&list)) else {
        return;
    };
    let metadata = old.metadata().expect("metadata");
    let permissions = Permissions::of(&old_path, &metadata).expect("permissions");
    permissions.pass_on(&new).expect("its mode");
    assert_eq!(extended::get(&new_path, LIST), Ok(None));
    assert_eq!(mode_of(&new), 0o640);
}

/// A list of a kind that this file system does not have gives others no right. Attributes
/// without meaning may be lost.
#[test]
fn what_can_not_be_set_leaves_no_right_to_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("new");
    let new = file(&path, 0o666, None).expect("no list to set");
    let metadata = new.metadata().expect("metadata");
    for (name, mode) in [(c"system.nfs4_acl", 0o600), (c"nonsense", 0o664)] {
        let permissions = Permissions {
            user: metadata.uid(),
            group: metadata.gid(),
            rights: Rights::of_mode(0o664),
            attributes: vec![(name.to_owned(), b"x".to_vec())],
        };
        permissions.pass_on(&new).expect("a mode");
        assert_eq!(mode_of(&new), mode, "{name:?}");
    }
}
