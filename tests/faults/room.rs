//! Resources that may run out: blocks, inodes, descriptors.

use std::{
    fs,
    os::unix::net::UnixDatagram,
    process::{Command, Stdio},
};

use super::{Disk, OLD, assert_unharmed, make_picture_of_holes, without_nameless_files};
use crate::program::{self, Ran, Workshop};

/// Fills the disk.
fn fill(shop: &Workshop) {
    let filler = shop.path("filler");
    let _ = Command::new("dd")
        .args(["if=/dev/zero", "bs=4k"])
        .arg(format!("of={}", filler.display()))
        .stderr(Stdio::null())
        .status();
    let _ = Command::new("sync").arg("-f").arg(&filler).status();
}

#[test]
fn a_file_with_holes_on_a_full_disk_that_can_not_reserve_is_reported() {
    let Some(disk) = Disk::of_blocks("holes on a full ext2", "ext2", 8) else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    make_picture_of_holes(&shop);
    fill(&shop);
    shop.run("balls.txt image.ppm 1000 1000 --rows 0..1000")
        .fails(&["image.ppm", "no space left", "free some space"]);
}

#[test]
fn a_full_disk_that_can_not_reserve_is_reported_for_a_new_image() {
    let Some(disk) = Disk::of_blocks("a full ext2", "ext2", 8) else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.write("image.ppm", OLD);
    for options in ["", "--method double"] {
        shop.run(&format!("balls.txt image.ppm 2000 2000 {options}"))
            .fails(&["image.ppm", "no space left"]);
        assert_unharmed(&shop);
    }
    shop.run("balls.txt new.ppm 2000 2000 --rows 0..1")
        .fails(&["new.ppm", "no space left"]);
    assert_unharmed(&shop);
}

#[test]
fn blocks_shared_with_a_snapshot_are_not_counted_as_reserved() {
    let Some(disk) = Disk::of_blocks("a snapshot", "btrfs", 160) else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    let picture = "balls.txt image.ppm 4000 2000";
    shop.run(&format!("{picture} --rows 0..2000")).succeeds();
    let taken = Command::new("btrfs")
        .args(["subvolume", "snapshot"])
        .arg(disk.at.path())
        .arg(disk.at.path().join("snapshot"))
        .stdout(Stdio::null())
        .status();
    assert!(taken.expect("btrfs").success());
    fill(&shop);
    shop.run(&format!("{picture} --rows 0..2000")).fails(&[
        "image.ppm",
        "no space left",
        "free some space",
    ]);
}

#[test]
fn a_disk_without_inodes_is_reported() {
    let Some(disk) = Disk::new("a disk without inodes", "tmpfs", "nr_inodes=6") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    let mut files = 0;
    while fs::write(shop.path(&format!("file{files}")), "").is_ok() {
        files += 1;
    }
    for options in ["", "--rows 0..4"] {
        shop.run(&format!("balls.txt image.ppm 64 48 {options}"))
            .fails(&["image.ppm", "no inode left", "remove some files"]);
    }
    assert_eq!(shop.names().len(), files + 1);
}

#[test]
fn missing_descriptors_are_reported() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    let mut refused = 0;
    // Two images, so that one more is needed than the loader needs.
    let line = "balls.txt image.ppm 64 48 --method double --diff marks.ppm --quiet";
    for most in 3..8 {
        let plain = format!("ulimit -n {most}; exec $SFERA {line}");
        let named = without_nameless_files(&shop, line).map(|command| {
            let line = command.get_args().last().expect("a line").to_str();
            line.expect("text")
                .replace("exec $SFERA", &format!("ulimit -n {most} && exec $SFERA"))
        });
        for line in [Some(plain), named].into_iter().flatten() {
            let ran = shop.run_shell(&line);
            if ran.code == 0 {
                fs::remove_file(shop.path("marks.ppm")).expect("removed");
                shop.write("image.ppm", OLD);
            } else if ran.stderr.starts_with("sfera: ") {
                refused += 1;
                ran.fails(&["too many open files", "ulimit -n"]);
                assert_unharmed(&shop);
            }
        }
    }
    assert!(refused > 0);
}

/// strace makes each system call of a kind fail in turn.
#[test]
fn a_system_call_that_fails_is_reported_and_harms_nothing() {
    let shop = Workshop::new();
    std::os::unix::fs::symlink("balls.txt", shop.path("link.ppm")).expect("a link");
    let trace = tempfile::NamedTempFile::new().expect("a file");
    let mut reported = 0;
    for image in ["image.ppm", "link.ppm"] {
        for (kind, error) in [
            ("%file", "ESTALE"),
            ("linkat,rename,renameat,renameat2,unlink", "EXDEV"),
            (
                "fallocate,fchmod,fchown,pwrite64,fsetxattr,lgetxattr,fcntl,rt_sigaction",
                "EIO",
            ),
        ] {
            for call in 1.. {
                shop.write("image.ppm", OLD);
                let ran = shop.run_shell(&format!(
                    "exec strace -f -o {} -e inject={kind}:error={error}:when={call} $SFERA balls.txt {image} 64 48 --threads 1",
                    trace.path().display()
                ));
                if ran.stderr.contains("strace") {
                    eprintln!("skipped: no strace here: {}", ran.stderr);
                    return;
                }
                let calls = fs::read_to_string(trace.path()).expect("a trace");
                if !calls.contains("INJECTED") {
                    break;
                }
                reported += u32::from(ran.code == 1);
                let what = format!("{kind} {error} {call}: {} {}", ran.code, ran.stderr);
                assert_harmless(&shop, image, &ran, &what);
            }
        }
    }

    assert!(reported > 0);
}

#[track_caller]
fn assert_harmless(shop: &Workshop, image: &str, ran: &Ran, what: &str) {
    assert_eq!(
        shop.names(),
        ["balls.txt", "image.ppm", "link.ppm"],
        "{what}"
    );
    assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes(), "{what}");
    match ran.code {
        0 => {
            assert_eq!(image, "image.ppm", "{what}");
            assert_eq!(shop.read(image).len(), 13 + 64 * 48 * 3, "{what}");
        }
        1 => {
            assert_eq!(shop.read("image.ppm"), OLD, "{what}");
            assert!(ran.stderr.starts_with("sfera: "), "{what}");
            let named = ran.stderr.contains(image) || ran.stderr.contains("balls.txt");
            assert!(named, "{what}");
        }
        // The loader's own calls.
        code => assert!(code == 127 || code == -6, "{what}"),
    }
}

/// As on a network disk, which may refuse data only when it is sent.
#[test]
fn a_disk_that_refuses_at_the_end_is_reported() {
    let Some(disk) = Disk::new("a disk that refuses at the end", "ramfs", "mode=0755") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.write("image.ppm", OLD);
    shop.run("balls.txt rows.ppm 64 48 --rows 0..4").succeeds();
    for line in [
        "image.ppm 64 48",
        "image.png 64 48",
        "rows.ppm 64 48 --rows 0..4",
    ] {
        let ran = shop.run_shell(&format!(
            "exec strace -f -o /dev/null -e inject=fdatasync:error=ENOSPC $SFERA balls.txt {line}"
        ));
        if ran.stderr.contains("strace") {
            eprintln!("skipped: no strace here: {}", ran.stderr);
            return;
        }
        ran.fails(&["no space left", "free some space"]);
        assert_eq!(shop.read("image.ppm"), OLD);
        assert_eq!(shop.names(), ["balls.txt", "image.ppm", "rows.ppm"]);
    }
}

#[test]
fn a_line_of_statistics_is_written_in_one_piece() {
    let shop = Workshop::new();
    let (ours, theirs) = UnixDatagram::pair().expect("sockets");
    let mut command = shop.sfera("balls.txt image.ppm 64 48 --stats=json");
    command.stderr(std::os::fd::OwnedFd::from(theirs));
    assert_eq!(Ran::of(&mut command).code, 0);
    // A datagram is what one call wrote.
    let mut bytes = [0; 4096];
    let length = ours.recv(&mut bytes).expect("a line");
    let line = std::str::from_utf8(&bytes[..length]).expect("text");
    assert!(line.starts_with('{') && line.ends_with("}\n"), "{line}");
}

#[test]
fn the_threads_of_statistics_are_those_that_drew() {
    let shop = Workshop::new();
    let ran = shop.run("balls.txt image.ppm 64 1 --method textbook --threads 8 --stats=json");
    assert!(ran.stderr.contains("\"threads\":1,"), "{}", ran.stderr);
}

#[test]
fn answers_that_can_not_be_written_are_reported() {
    let shop = Workshop::new();
    for line in ["--help", "--version", "--generate man", "--generate bash"] {
        shop.run_shell(&format!("exec $SFERA {line} > /dev/full"))
            .fails(&["standard output", "no space left"]);
    }
    shop.run_shell("exec $SFERA balls.txt image.ppm 64 48 --compare > /dev/full")
        .fails(&["standard output", "no space left"]);
}
