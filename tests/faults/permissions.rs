//! Permissions of a replaced image: nobody may do more than before.

use std::{
    fs,
    os::unix::fs::{MetadataExt, PermissionsExt, chown},
};

use super::{OLD, as_root, set, without_nameless_files};
use crate::program::{self, Ran, Workshop, wait_until};

/// Runs a tool. Returns whether it succeeded; prints a line if it is missing.
fn tool(shop: &Workshop, line: &str) -> bool {
    let ran = Ran::of(&mut shop.shell(line));
    if ran.code != 0 {
        eprintln!("skipped: {line}: {}", ran.stderr);
    }
    ran.code == 0
}

fn output_of(shop: &Workshop, line: &str) -> String {
    let ran = Ran::of(&mut shop.shell(line));
    String::from_utf8(ran.stdout).expect("text")
}

fn mode(shop: &Workshop, name: &str) -> u32 {
    let metadata = fs::metadata(shop.path(name)).expect("a file");
    metadata.permissions().mode() & 0o7777
}

#[test]
fn an_access_control_list_and_other_attributes_are_kept() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    if !tool(
        &shop,
        "setfacl -m g::---,u:65534:rw-,g:4000:r-- image.ppm && setfattr -n user.artist -v me image.ppm",
    ) {
        return;
    }
    let before = output_of(&shop, "getfacl -cn image.ppm; getfattr -d image.ppm");
    assert!(before.contains("group::---") && before.contains("artist"));
    shop.run("balls.txt image.ppm 64 48").succeeds();
    assert_eq!(
        output_of(&shop, "getfacl -cn image.ppm; getfattr -d image.ppm"),
        before
    );
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

#[test]
fn a_list_that_the_directory_gives_to_new_files_is_not_the_old_ones() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    set(&shop.path("image.ppm"), 0o660);
    if !tool(&shop, "setfacl -d -m u:65534:rw- .") {
        return;
    }
    let before = output_of(&shop, "getfacl -cn image.ppm");
    shop.run("balls.txt image.ppm 64 48").succeeds();
    assert_eq!(output_of(&shop, "getfacl -cn image.ppm"), before);
    // A new image gets the list of the directory.
    shop.run("balls.txt new.ppm 64 48").succeeds();
    assert!(output_of(&shop, "getfacl -cn new.ppm").contains("user:65534:rw-"));
}

/// Bob (3002) replaces a file of Alice's (3001). Returns its owner, group and mode.
fn replaced_by_another(mode_before: u32, groups: &str) -> Option<(u32, u32, u32)> {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    chown(shop.path("image.ppm"), Some(3001), Some(4000)).expect("chown");
    set(&shop.path("image.ppm"), mode_before);
    set(shop.folder(), 0o777);
    let ran = shop.run_shell(&format!(
        "exec setpriv --reuid=3002 --regid=3002 {groups} $SFERA balls.txt image.ppm 64 48"
    ));
    if ran.stderr.contains("setpriv") {
        eprintln!("skipped: another user can't run {}", program::SFERA);
        return None;
    }
    ran.succeeds();
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
    let metadata = fs::metadata(shop.path("image.ppm")).expect("the image");
    Some((metadata.uid(), metadata.gid(), mode(&shop, "image.ppm")))
}

#[test]
fn what_can_not_be_passed_on_is_narrowed() {
    if !as_root("another user's image replaced") {
        return;
    }
    let member = "--groups=4000";
    let stranger = "--clear-groups";
    for (before, groups, after) in [
        // The group is kept, although the owner can't be.
        (0o660, member, (3002, 4000, 0o660)),
        // Alice is now a member of the group only, and may not do more than before.
        (0o460, member, (3002, 4000, 0o440)),
        // The group can't be kept: its members are others now, and Bob's own group had
        // no more rights than the others.
        (0o666, stranger, (3002, 3002, 0o666)),
        (0o626, stranger, (3002, 3002, 0o622)),
        (0o606, stranger, (3002, 3002, 0o600)),
        (0o676, stranger, (3002, 3002, 0o666)),
    ] {
        let Some(is) = replaced_by_another(before, groups) else {
            return;
        };
        assert_eq!(is, after, "{before:o} {groups}: {:o}", is.2);
    }
}

#[test]
fn a_list_that_can_not_be_passed_on_whole_is_narrowed() {
    if !as_root("another user's list") {
        return;
    }
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    chown(shop.path("image.ppm"), Some(3001), Some(4000)).expect("chown");
    set(&shop.path("image.ppm"), 0o664);
    set(shop.folder(), 0o777);
    if !tool(
        &shop,
        "setfacl -m u:3002:rw-,u:3001:r--,g:5000:---,g:5001:rw- image.ppm",
    ) {
        return;
    }
    let ran = shop.run_shell(
        "exec setpriv --reuid=3002 --regid=3002 --clear-groups $SFERA balls.txt image.ppm 64 48",
    );
    if ran.stderr.contains("setpriv") {
        eprintln!("skipped: another user can't run {}", program::SFERA);
        return;
    }
    ran.succeeds();
    let list = output_of(&shop, "getfacl -cn image.ppm");
    // Bob's group had the rights of others, except for its members that are also in 5000.
    for entry in [
        "user::rw-",
        "user:3001:r--",
        "user:3002:rw-",
        "group::---",
        "group:5000:---",
        "group:5001:rw-",
        "mask::rw-",
        "other::r--",
    ] {
        assert!(list.lines().any(|line| line == entry), "{entry}: {list}");
    }
}

#[test]
fn root_passes_on_the_owner_too() {
    if !as_root("the owner handed on") {
        return;
    }
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    chown(shop.path("image.ppm"), Some(3001), Some(4000)).expect("chown");
    set(&shop.path("image.ppm"), 0o640);
    shop.run("balls.txt image.ppm 64 48").succeeds();
    let metadata = fs::metadata(shop.path("image.ppm")).expect("the image");
    assert_eq!((metadata.uid(), metadata.gid()), (3001, 4000));
    assert_eq!(mode(&shop, "image.ppm"), 0o640);
}

#[test]
fn only_its_owner_can_read_a_draft() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    set(&shop.path("image.ppm"), 0o600);
    let Some(mut command) = without_nameless_files(&shop, super::SLOW) else {
        return;
    };
    let mut child = command.spawn().expect("the program runs");
    wait_until("a temporary file", || shop.names().len() == 3);
    let part = shop
        .names()
        .into_iter()
        .find(|name| name.ends_with(".part"));
    let part_mode = mode(&shop, &part.expect("a temporary file"));
    super::send("TERM", &child);
    child.wait().expect("it ends");
    assert_eq!(part_mode, 0o600);
}

#[test]
fn rows_can_be_drawn_in_what_rows_made_whatever_the_umask() {
    let shop = Workshop::new();
    let line = "umask 0222; exec $SFERA balls.txt image.ppm 64 48 --rows";
    for rows in ["0..24", "24..48"] {
        let mut command = shop.shell(&format!("{line} {rows}"));
        Ran::of(&mut command).succeeds();
    }
    assert_eq!(mode(&shop, "image.ppm"), 0o644);
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

/// As on a file system that has no permissions of its own.
#[test]
fn permissions_that_are_right_already_are_not_set() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    set(&shop.path("image.ppm"), 0o600);
    let ran = shop.run_shell(
        "exec strace -f -o /dev/null -e inject=fchmod:error=EPERM $SFERA balls.txt image.ppm 64 48",
    );
    if ran.stderr.contains("strace") {
        eprintln!("skipped: no strace here: {}", ran.stderr);
        return;
    }
    ran.succeeds();
    assert_eq!(mode(&shop, "image.ppm"), 0o600);
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}
