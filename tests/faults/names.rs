//! Which file a name refers to: links, descriptors, mounts, and files that get the name while
//! an image is drawn.

use std::{
    fs,
    os::unix::fs::{FileTypeExt, symlink},
    process::{Command, Stdio},
};

use super::{Disk, OLD, WHILE, as_root, assert_unharmed, begin, end, set};
use crate::program::{self, Ran, Workshop};

#[test]
fn links_that_the_system_does_not_follow_are_not_followed() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("folder")).expect("a folder");
    symlink("folder", shop.path("hop")).expect("a link");
    // 25 links, each through a linked folder: more than the system follows.
    for step in 1..25 {
        let next = format!("../hop/{}", step + 1);
        symlink(next, shop.path(&format!("folder/{step}"))).expect("a link");
    }
    symlink("../balls.txt", shop.path("folder/25")).expect("a link");
    for options in ["", "--rows 0..4"] {
        shop.run(&format!("balls.txt hop/1 64 48 {options}"))
            .fails(&["hop/1", "symbolic links", "name the file itself"]);
    }
    shop.run("balls.txt image.ppm 64 48 --method double --diff hop/1")
        .fails(&["hop/1", "symbolic links"]);
    assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes());
    assert_eq!(shop.names(), ["balls.txt", "folder", "hop"]);
}

#[test]
fn links_on_a_disk_without_links_are_not_followed() {
    let Some(disk) = Disk::new("a disk without links", "tmpfs", "nosymfollow") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    symlink("balls.txt", shop.path("link.ppm")).expect("a link");
    if fs::metadata(shop.path("link.ppm")).is_ok() {
        eprintln!("skipped: this system follows links everywhere");
        return;
    }
    shop.run("balls.txt link.ppm 64 48").fails(&[
        "link.ppm",
        "symbolic links",
        "name the file itself",
    ]);
    assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes());
}

#[test]
fn a_file_behind_a_descriptor_is_written_through_it() {
    let shop = Workshop::new();
    let right = shop.balls(64, 48);
    symlink("/dev/stdout", shop.path("link.ppm")).expect("a link");
    for name in [
        "/dev/stdout",
        "/dev/fd/1",
        "/proc/self/fd/1",
        "/proc/thread-self/fd/1",
        "link.ppm",
    ] {
        shop.write("log", b"before\n");
        shop.run_shell(&format!("exec $SFERA balls.txt {name} 64 48 >> log"))
            .succeeds();
        assert!(
            shop.read("log") == [b"before\n", &right[..]].concat(),
            "{name}"
        );
        // The file has lost its name and gets no new one.
        shop.run_shell(&format!(
            "exec > lost 8< lost; rm lost; $SFERA balls.txt {name} 64 48 && cat <&8 > copy"
        ))
        .succeeds();
        assert_eq!(shop.names(), ["balls.txt", "copy", "link.ppm", "log"]);
        assert!(shop.read("copy") == right, "{name}");
    }
    let ran =
        shop.run_shell("exec 7> lost; rm lost; $SFERA balls.txt /dev/fd/7 64 48 && cat /dev/fd/7");
    if ran.stderr.contains("operation not permitted") {
        eprintln!("skipped: no pidfd_getfd here");
    } else {
        assert!(ran.succeeds().stdout == right);
    }
    shop.run("balls.txt /dev/fd/9 64 48")
        .fails(&["/dev/fd/9", "closed, or not open for writing"]);
    shop.run_shell("exec $SFERA balls.txt /dev/stdin 64 48 < balls.txt")
        .fails(&["/dev/stdin"]);
    shop.run_shell("exec $SFERA balls.txt /dev/stdout 64 48 --rows 0..4 >> log")
        .fails(&["--rows needs a file"]);
    assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes());
}

/// Some containers forbid copying descriptors.
#[test]
fn a_descriptor_that_can_not_be_copied_is_opened_or_reported() {
    let shop = Workshop::new();
    let strace =
        "strace -f -o /dev/null -e inject=pidfd_getfd:error=EPERM $SFERA balls.txt /dev/fd/7 64 48";
    let ran = shop.run_shell(&format!("mkfifo pipe; cat pipe > copy & exec 7> pipe; {strace}; code=$?; exec 7>&-; wait; exit $code"));
    if ran.stderr.contains("strace") {
        eprintln!("skipped: no strace here: {}", ran.stderr);
        return;
    }
    ran.succeeds();
    assert!(shop.read("copy") == shop.balls(64, 48));
    shop.run_shell(&format!("exec 7>> copy; {strace}"))
        .fails(&["/dev/fd/7", "redirect standard output to it"]);
    assert!(shop.read("copy") == shop.balls(64, 48));
}

/// Files of other processes, through the library.
#[test]
fn a_link_to_a_file_without_a_name_is_refused() {
    let shop = Workshop::new();
    let ran = shop.run_shell(
        "exec 8> lost; rm lost; sleep 20 & exec 8>&-; $SFERA balls.txt /proc/$!/fd/8 64 48; code=$?; kill $!; exit $code",
    );
    ran.fails(&["no such name"]);
    assert_eq!(shop.names(), ["balls.txt"]);
}

#[test]
fn the_image_and_its_difference_are_two_files() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("folder")).expect("a folder");
    symlink("folder", shop.path("hop")).expect("a link");
    symlink("../image.ppm", shop.path("folder/link.ppm")).expect("a link");
    let whole = shop.path("image.ppm");
    for _ in 0..2 {
        for marks in [
            "./image.ppm",
            "folder/../image.ppm",
            "hop/link.ppm",
            whole.to_str().expect("text"),
        ] {
            shop.run(&format!(
                "balls.txt image.ppm 64 48 --method double --diff {marks}"
            ))
            .fails(&[marks, "the other image too", "another name"]);
        }
        // Once without an existing file and once with one.
        let _ = fs::hard_link(shop.path("folder/kept.ppm"), &whole);
        shop.write("image.ppm", OLD);
        let _ = fs::hard_link(&whole, shop.path("folder/hard.ppm"));
    }
    shop.run("balls.txt image.ppm 64 48 --method double --diff folder/hard.ppm")
        .fails(&["the other image too"]);
    shop.run_shell("exec $SFERA balls.txt image.ppm 64 48 --method double --diff - >> image.ppm")
        .fails(&["the other image too"]);
    assert_eq!(shop.read("image.ppm"), OLD);
}

#[test]
fn a_difference_that_can_not_be_made_is_reported_before_anything_is_drawn() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    fs::create_dir(shop.path("folder")).expect("a folder");
    for (marks, word) in [
        ("missing/marks.ppm", "make the directory first"),
        ("folder", "directory"),
    ] {
        // Drawing takes minutes.
        shop.run_shell(&format!(
            "exec timeout 10 $SFERA balls.txt image.ppm 9000 9000 --method reference --diff {marks}"
        ))
        .fails(&[marks, word]);
    }
    assert_eq!(shop.read("image.ppm"), OLD);
}

#[test]
fn a_file_is_examined_again_before_it_is_replaced() {
    let shop = Workshop::new();
    let drawn_while = |change: &dyn Fn()| {
        let _ = fs::remove_file(shop.path("image.ppm"));
        shop.write("image.ppm", OLD);
        let child = begin(&mut shop.sfera(WHILE));
        change();
        end(child)
    };
    let image = shop.path("image.ppm");
    drawn_while(&|| set(&image, 0o444)).fails(&["image.ppm", "write-protected"]);
    assert_eq!(shop.read("image.ppm"), OLD);

    drawn_while(&|| {
        fs::remove_file(&image).expect("removed");
        let made = Command::new("mkfifo").arg(&image).status();
        assert!(made.expect("mkfifo").success());
    })
    .fails(&["image.ppm", "not a file took its name", "draw it again"]);
    let kind = fs::symlink_metadata(&image)
        .expect("it is there")
        .file_type();
    assert!(kind.is_fifo());

    drawn_while(&|| {
        fs::remove_file(&image).expect("removed");
        symlink("balls.txt", &image).expect("a link");
    })
    .fails(&["image.ppm", "the scene itself"]);
    drawn_while(&|| {
        fs::remove_file(&image).expect("removed");
        symlink("other", &image).expect("a link");
    })
    .fails(&["image.ppm", "not a file took its name"]);
    drawn_while(&|| {
        fs::remove_file(&image).expect("removed");
        fs::hard_link(shop.path("balls.txt"), &image).expect("a link");
    })
    .fails(&["image.ppm", "the scene itself"]);
    assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes());

    // A removed image is made again, with its permissions.
    let ran = drawn_while(&|| fs::remove_file(&image).expect("removed"));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
}

#[test]
fn rows_of_a_file_that_goes_away_are_reported() {
    let shop = Workshop::new();
    let rows = format!("{WHILE} --rows 0..600");
    for replaced in [false, true] {
        let child = begin(&mut shop.sfera(&rows));
        fs::rename(shop.path("image.ppm"), shop.path("old.ppm")).expect("renamed");
        if replaced {
            fs::copy(shop.path("old.ppm"), shop.path("image.ppm")).expect("copied");
        }
        end(child).fails(&["image.ppm", "removed or replaced", "draw it again"]);
        let _ = fs::remove_file(shop.path("image.ppm"));
    }
}

#[test]
fn an_append_only_directory_is_reported_before_anything_is_drawn() {
    let Some(disk) = Disk::of_blocks("a directory that only grows", "ext4", 16) else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.write("image.ppm", OLD);
    let chattr = |change: &str, name: &str| {
        let done = Command::new("chattr")
            .arg(change)
            .arg(shop.path(name))
            .status();
        assert!(done.expect("chattr").success());
    };
    chattr("+a", ".");
    let slow = format!("exec timeout 20 $SFERA {}", super::SLOW);
    let ran = shop.run_shell(&slow);
    let new = shop.run("balls.txt new.ppm 64 48");
    chattr("-a", ".");
    ran.fails(&["image.ppm", "chattr -a"]);
    new.succeeds();
    assert_eq!(shop.names(), ["balls.txt", "image.ppm", "new.ppm"]);

    chattr("+i", ".");
    let ran = ["image.ppm", "new.ppm", "other.ppm"]
        .map(|name| shop.run(&format!("balls.txt {name} 64 48")));
    let rows = shop.run("balls.txt other.ppm 64 48 --rows 0..4");
    chattr("-i", ".");
    for ran in ran {
        ran.fails(&[".ppm", "chattr -i"]);
    }
    rows.fails(&["other.ppm", "chattr -i"]);

    for (attribute, remedy) in [("i", "chattr -i"), ("a", "chattr -a")] {
        chattr(&format!("+{attribute}"), "image.ppm");
        let ran = ["", "--rows 0..4"]
            .map(|options| shop.run(&format!("balls.txt image.ppm 64 48 {options}")));
        chattr(&format!("-{attribute}"), "image.ppm");
        for ran in ran {
            ran.fails(&["image.ppm", remedy]);
        }
    }
    assert_eq!(shop.read("image.ppm"), OLD);
    assert_eq!(shop.names(), ["balls.txt", "image.ppm", "new.ppm"]);
}

#[test]
fn a_file_that_is_mounted_by_itself_is_reported_before_anything_is_drawn() {
    if !as_root("a mounted file") {
        return;
    }
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    shop.write("inside.ppm", OLD);
    let ran = shop.run_shell(&format!(
        "exec unshare --mount sh -c 'mount --bind inside.ppm image.ppm && timeout 20 $SFERA {}'",
        super::SLOW
    ));
    if ran.stderr.contains("unshare") || ran.stderr.contains("mount:") {
        eprintln!("skipped: {}", ran.stderr);
        return;
    }
    ran.fails(&["image.ppm", "mounted by itself", "mount its directory", "-"]);
    assert_eq!(shop.read("image.ppm"), OLD);
    assert_eq!(shop.names(), ["balls.txt", "image.ppm", "inside.ppm"]);
}

#[test]
fn a_slash_behind_a_file_is_reported() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    for options in ["", "--rows 0..4"] {
        shop.run(&format!("balls.txt image.ppm/ 64 48 {options}"))
            .fails(&["image.ppm/", "leave the slash out"]);
        shop.run(&format!("balls.txt image.ppm/x/ 64 48 {options}"))
            .fails(&["image.ppm/x/", "is not a directory"]);
    }
    assert_unharmed(&shop);
}

#[test]
fn another_users_file_in_a_shared_directory_is_reported_before_anything_is_drawn() {
    if !as_root("another user's file") {
        return;
    }
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    std::os::unix::fs::chown(shop.path("image.ppm"), Some(3001), Some(3001)).expect("chown");
    set(&shop.path("image.ppm"), 0o666);
    set(shop.folder(), 0o1777);
    let ran = shop.run_shell(&format!(
        "exec setpriv --reuid=3002 --regid=3002 --clear-groups timeout 20 $SFERA {}",
        super::SLOW
    ));
    if ran.stderr.contains("setpriv") || ran.stderr.contains("timeout") {
        eprintln!("skipped: another user can't run {}", program::SFERA);
        return;
    }
    ran.fails(&["image.ppm", "another user's", "name another file"]);
    assert_unharmed(&shop);
    // One's own file, and any file in one's own directory.
    for (file, folder) in [(3002, 0), (3001, 3002)] {
        std::os::unix::fs::chown(shop.path("image.ppm"), Some(file), Some(file)).expect("chown");
        std::os::unix::fs::chown(shop.folder(), Some(folder), None).expect("chown");
        shop.run_shell(
            "exec setpriv --reuid=3002 --regid=3002 --clear-groups $SFERA balls.txt image.ppm 64 48",
        )
        .succeeds();
        shop.write("image.ppm", OLD);
    }
}

#[test]
fn a_long_name_can_be_replaced() {
    let shop = Workshop::new();
    let mut folder = shop.folder().to_owned();
    // As long as a name can be, except for the last component.
    while folder.as_os_str().len() < 4095 - 2 * 10 {
        let left = 4095 - 10 - folder.as_os_str().len();
        folder.push("d".repeat(left.min(200) - 1));
        fs::create_dir(&folder).expect("a folder");
    }
    let image = folder.join("image.ppm");
    let image = image.to_str().expect("text");
    assert!(image.len() > 4080);
    for _ in 0..2 {
        shop.run(&format!("balls.txt {image} 64 48")).succeeds();
    }
    assert_eq!(fs::read(image).expect("the image"), shop.balls(64, 48));
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 1);
}

#[test]
fn a_name_is_shown_on_one_line() {
    let shop = Workshop::new();
    let run = |arguments: &[&str]| {
        Ran::of(
            Command::new(program::SFERA)
                .args(arguments)
                .current_dir(shop.folder())
                .stdin(Stdio::null()),
        )
    };
    for name in [
        "two\nlines/image.ppm",
        "bell\u{7}/image.ppm",
        "two\nlines\u{202e}/x",
    ] {
        let shown = if name.starts_with("two") {
            "two\\x0alines"
        } else {
            "bell\\x07"
        };
        run(&["balls.txt", name, "64", "48"]).fails(&[shown]);
        run(&["balls.txt", name, "64", "48", "--verify"]).fails(&[shown]);
        run(&[name, "image.ppm", "64", "48"]).says(&[shown]);
    }
    run(&["balls.txt", "image.ppm", "64", "48", "two\nlines\u{1b}[2J"])
        .refuses(&["two\\x0alines\\x1b[2J"]);
    run(&["balls.txt", "two\nlines.gif", "64", "48"]).refuses(&["two\\x0alines"]);
    fs::create_dir(shop.path("two\nlines")).expect("a folder");
    run(&["balls.txt", "two\nlines", "64", "48"]).fails(&["two\\x0alines", "directory"]);
}
