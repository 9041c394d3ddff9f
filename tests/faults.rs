//! Faults of the environment: full disks, limits, signals, other processes. Each time there
//! must be one message, the right exit code, no other file left, and the earlier image
//! unharmed.
//!
//! Some faults need root (a small disk, another user). Without it these tests print that
//! they are skipped.

// Permissions, links and signals are those of Unix.
#![cfg(unix)]

#[path = "faults/names.rs"]
mod names;
#[path = "faults/permissions.rs"]
mod permissions;
#[path = "common/program.rs"]
mod program;
#[path = "faults/room.rs"]
mod room;
#[path = "faults/signals.rs"]
mod signals;

use std::{
    fs::{self, File, OpenOptions},
    io::Read,
    os::unix::fs::{PermissionsExt, symlink},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    thread,
    time::Duration,
};

use program::{Ran, Workshop, wait_until};
use tempfile::TempDir;

/// Takes minutes, so that it can be interrupted.
const SLOW: &str = "balls.txt image.ppm 4000 4000 --method reference";

/// Takes a second or two, so that something can be changed meanwhile.
const WHILE: &str = "balls.txt image.ppm 600 600 --method reference --threads 1";

const OLD: &[u8] = b"the image that was there before";

fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}

/// Whether a test that needs root can run; prints a line if not.
fn as_root(test: &str) -> bool {
    if !is_root() {
        eprintln!("{test}: skipped, this needs root");
    }
    is_root()
}

/// A mounted disk, unmounted when it is dropped.
struct Disk {
    at: TempDir,
}

impl Disk {
    /// `None`, and a printed line, where a test can't mount one.
    fn new(test: &str, kind: &str, options: &str) -> Option<Self> {
        if !as_root(test) {
            return None;
        }
        let disk = Self {
            at: TempDir::new().expect("a folder"),
        };
        let mounted = Command::new("mount")
            .args(["-t", kind, "-o", options, "sfera-test"])
            .arg(disk.at.path())
            .status()
            .is_ok_and(|status| status.success());
        if !mounted {
            eprintln!("{test}: skipped, can't mount {kind}");
        }
        mounted.then_some(disk)
    }

    /// A disk in a file of some megabytes.
    fn of_blocks(test: &str, kind: &str, megabytes: u64) -> Option<Self> {
        if !as_root(test) {
            return None;
        }
        let at = TempDir::new().expect("a folder");
        let blocks = tempfile::NamedTempFile::new().expect("a file");
        blocks
            .as_file()
            .set_len(megabytes << 20)
            .expect("blocks of a disk");
        let ran = |command: &mut Command| {
            let output = command.output();
            let done = output.as_ref().is_ok_and(|output| output.status.success());
            if !done {
                eprintln!("{test}: skipped: {command:?}: {output:?}");
            }
            done
        };
        // The file is removed; the mount keeps its blocks.
        (ran(Command::new(format!("mkfs.{kind}"))
            .arg("-q")
            .arg(blocks.path()))
            && ran(Command::new("mount")
                .args(["-o", "loop"])
                .arg(blocks.path())
                .arg(at.path())))
        .then_some(Self { at })
    }

    fn remount(&self, options: &str) {
        let status = Command::new("mount")
            .args(["-o", &format!("remount,{options}")])
            .arg(self.at.path())
            .status();
        assert!(status.expect("mount").success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount")
            .arg("-l")
            .arg(self.at.path())
            .status();
    }
}

/// Starts a render that takes long, and waits until it draws.
fn begin(command: &mut Command) -> Child {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    wait_until("the image is mapped", || mapped(&child).is_some());
    thread::sleep(Duration::from_millis(20));
    child
}

/// The name of the file that a process has mapped for writing.
fn mapped(child: &Child) -> Option<PathBuf> {
    let maps = fs::read_to_string(format!("/proc/{}/maps", child.id())).unwrap_or_default();
    let name = maps.lines().find_map(|line| {
        let (_, name) = line.split_once('/')?;
        let image = name.contains("(deleted)") || name.contains(".ppm") || name.contains(".part");
        (line.contains(" rw-s ") && image).then_some(name)
    })?;
    Some(Path::new("/").join(name))
}

/// The program without /proc, where an unfinished image needs a temporary name, because a
/// file without a name could not get one later. `None`, and a printed line, where that is
/// impossible.
fn without_nameless_files(shop: &Workshop, arguments: &str) -> Option<Command> {
    if !as_root("without nameless files") {
        return None;
    }
    let ran = shop.run_shell("exec unshare --mount mount -t tmpfs none /proc");
    if ran.code != 0 {
        eprintln!("skipped: {}", ran.stderr);
        return None;
    }
    Some(shop.shell(&format!(
        "exec env --default-signal unshare --mount sh -c 'mount -t tmpfs none /proc && exec $SFERA {arguments}'"
    )))
}

fn set(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("chmod");
}

fn send(signal: &str, child: &Child) {
    let status = Command::new("kill")
        .args([&format!("-{signal}"), &child.id().to_string()])
        .status();
    assert!(status.expect("kill").success());
}

fn end(child: Child) -> Ran {
    child.wait_with_output().expect("it ends").into()
}

/// The text of a scene of many spheres.
fn scene_of(spheres: u32) -> String {
    let lines: String = (0..spheres)
        .map(|i| format!("S {i} 0 5 1 1 2 3\n"))
        .collect();
    format!("VP 1 1 1\nBG 0 0 0\nOBJ_N {spheres}\n{lines}")
}

/// `image.ppm`, 1000 x 1000, with a header and no blocks.
fn make_picture_of_holes(shop: &Workshop) {
    shop.write("image.ppm", b"P6\n1000 1000\n255\n");
    let file = OpenOptions::new().write(true).open(shop.path("image.ppm"));
    file.and_then(|file| file.set_len(17 + 3_000_000))
        .expect("a hole");
}

#[track_caller]
fn assert_unharmed(shop: &Workshop) {
    assert_eq!(shop.read("image.ppm"), OLD);
    assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
}

// Full disks.

#[test]
fn a_full_disk_is_reported_before_anything_is_drawn() {
    let Some(disk) = Disk::new("a full disk", "tmpfs", "size=1m") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.write("image.ppm", OLD);
    shop.run("balls.txt image.ppm 1000 1000").fails(&[
        "image.ppm",
        "reserve its blocks",
        "no space left",
        "free some space",
    ]);
    assert_unharmed(&shop);
    shop.run("balls.txt new.ppm 1000 1000 --rows 0..1").fails(&[
        "new.ppm",
        "reserve its blocks",
        "no space left",
        "free some space",
    ]);
    assert_unharmed(&shop);
}

#[test]
fn a_picture_with_holes_on_a_full_disk_is_reported_too() {
    let Some(disk) = Disk::new("a picture with holes", "tmpfs", "size=1m") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    make_picture_of_holes(&shop);
    shop.run("balls.txt image.ppm 1000 1000 --rows 0..1000")
        .fails(&["image.ppm", "reserve its blocks", "no space left"]);
}

#[test]
fn a_disk_that_fills_while_a_stream_is_written_is_reported() {
    let shop = Workshop::new();
    shop.run("balls.txt /dev/full 64 48")
        .fails(&["/dev/full", "no space left"]);
    shop.run_shell("exec $SFERA balls.txt - 64 48 > /dev/full")
        .fails(&["standard output", "no space left", "free some space"]);
    assert_eq!(shop.names(), ["balls.txt"]);
}

#[test]
fn a_disk_that_can_not_reserve_is_written_and_not_mapped() {
    let Some(disk) = Disk::new("a disk that can't reserve", "ramfs", "mode=0755") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.run("balls.txt image.ppm 640 480").succeeds();
    shop.run("balls.txt rows.ppm 640 480 --rows 0..480")
        .succeeds();
    assert_eq!(shop.read("image.ppm"), shop.balls(640, 480));
    assert_eq!(shop.read("rows.ppm"), shop.balls(640, 480));
}

#[test]
fn messages_that_can_not_be_written_change_nothing() {
    let shop = Workshop::new();
    for (line, code) in [
        ("balls.txt image.ppm 64 48 --stats", 0),
        ("balls.txt missing/image.ppm 64 48", 1),
        ("balls.txt image.ppm 0 48", 2),
    ] {
        let ran = shop.run_shell(&format!("exec $SFERA {line} 2> /dev/full"));
        assert_eq!(ran.code, code, "{line}");
    }
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

// Limits.

#[test]
fn a_limit_on_file_sizes_is_reported() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    shop.run_shell("ulimit -f 8; exec $SFERA balls.txt image.ppm 640 480")
        .fails(&["image.ppm", "file too large", "ulimit -f"]);
    shop.run_shell("ulimit -f 8; exec $SFERA balls.txt new.ppm 640 480 --rows 0..1")
        .fails(&["new.ppm", "ulimit -f"]);
    assert_unharmed(&shop);
    shop.run_shell("ulimit -f 8; exec $SFERA balls.txt - 640 480 > out.ppm")
        .fails(&["standard output", "ulimit -f"]);
}

#[test]
fn a_limit_on_addresses_is_reported_and_never_a_signal() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    let mut refused = 0;
    for kilobytes in (12_000..150_000).step_by(6_000) {
        let ran = shop.run_shell(&format!(
            "ulimit -v {kilobytes}; exec $SFERA balls.txt image.ppm 5000 4000 --method textbook"
        ));
        // Too few for the loader.
        if ran.stderr.contains("shared librar") {
            continue;
        }
        assert!(
            [0, 1].contains(&ran.code),
            "{kilobytes}: {} {}",
            ran.code,
            ran.stderr
        );
        if ran.code == 1 {
            refused += 1;
            assert!(!ran.stderr.contains("panicked"), "{}", ran.stderr);
            if ran.stderr.contains("image.ppm") {
                ran.fails(&["ulimit -v"]);
            }
            assert_unharmed(&shop);
        } else {
            shop.write("image.ppm", OLD);
        }
    }
    assert!(refused > 0);
}

#[test]
fn a_scene_without_the_memory_for_it_is_reported_and_never_a_signal() {
    let shop = Workshop::new();
    shop.write("large.txt", scene_of(100_000).as_bytes());
    let mut refused = 0;
    for kilobytes in (6_000..60_000).step_by(1_000) {
        let limited = |arguments: &str| {
            shop.run_shell(&format!("ulimit -v {kilobytes}; exec $SFERA {arguments}"))
        };
        // Too little for the program to start.
        if limited("--version").code != 0 {
            continue;
        }
        let ran = limited("large.txt image.ppm 64 48 --threads 2");
        if ran.code != 0 {
            assert_eq!(ran.code, 1, "{kilobytes}: {}", ran.stderr);
            assert!(!ran.stderr.is_empty());
            refused += 1;
        }
    }
    assert!(refused > 0);
}

#[test]
fn a_large_picture_needs_few_addresses() {
    let shop = Workshop::new();
    shop.run_shell(
        "ulimit -v 190000; exec $SFERA balls.txt image.ppm 12000 9000 --method textbook --threads 1",
    )
    .succeeds();
    let length = fs::metadata(shop.path("image.ppm"))
        .expect("the image")
        .len();
    assert_eq!(length, 18 + 12_000 * 9_000 * 3);
}

#[test]
fn a_picture_is_drawn_with_the_threads_that_can_be_started() {
    let shop = Workshop::new();
    let line = if is_root() {
        // Root has no limit.
        fs::set_permissions(shop.folder(), fs::Permissions::from_mode(0o777)).expect("chmod");
        if fs::metadata("/root").is_ok_and(|root| {
            program::SFERA.starts_with("/root") && root.permissions().mode() & 1 == 0
        }) {
            eprintln!("skipped: another user can't run {}", program::SFERA);
            return;
        }
        "exec setpriv --reuid=65534 --clear-groups prlimit --nproc=1 $SFERA balls.txt image.ppm 64 48 --threads 8 --method textbook"
    } else {
        "exec prlimit --nproc=1 $SFERA balls.txt image.ppm 64 48 --threads 8 --method textbook"
    };
    shop.run_shell(line).succeeds();
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

// Names.

#[test]
fn a_directory_is_not_an_image() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("folder")).expect("a folder");
    for name in ["folder", "folder/", "."] {
        shop.run(&format!("balls.txt {name} 64 48")).fails(&[
            name,
            "directory",
            "name a file in it",
        ]);
        shop.run(&format!("balls.txt {name} 64 48 --rows 0..4"))
            .fails(&[name, "directory"]);
    }
    shop.run("balls.txt new/ 64 48")
        .fails(&["new/", "directory"]);
    shop.run("balls.txt missing/image.ppm 64 48")
        .fails(&["missing/image.ppm", "make the directory first"]);
    shop.run("balls.txt balls.txt/image.ppm 64 48")
        .fails(&["balls.txt/image.ppm", "not a directory"]);
    let long = "n".repeat(300);
    shop.run(&format!("balls.txt {long} 64 48"))
        .fails(&["shorter name"]);
    assert_eq!(shop.names(), ["balls.txt", "folder"]);
}

#[test]
fn a_device_is_written_as_a_stream() {
    let shop = Workshop::new();
    shop.run("balls.txt /dev/null 64 48").succeeds();
    assert!(!fs::metadata("/dev/null").expect("the device").is_file());
    shop.run("balls.txt /dev/null 64 48 --rows 0..4")
        .fails(&["/dev/null", "--rows needs a file"]);
    let to_stdout = shop.run("balls.txt /dev/stdout 64 48").succeeds().stdout;
    assert_eq!(to_stdout, shop.balls(64, 48));
}

#[test]
fn a_pipe_with_a_name_is_written_as_a_stream() {
    let shop = Workshop::new();
    assert!(
        Command::new("mkfifo")
            .arg(shop.path("pipe"))
            .status()
            .expect("mkfifo")
            .success()
    );
    let pipe = shop.path("pipe");
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        File::open(pipe)
            .and_then(|mut pipe| pipe.read_to_end(&mut bytes))
            .expect("bytes");
        bytes
    });
    shop.run("balls.txt pipe 640 480").succeeds();
    assert_eq!(reader.join().expect("the reader"), shop.balls(640, 480));
    assert_eq!(shop.names(), ["balls.txt", "pipe"]);
}

#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("folder")).expect("a folder");
    shop.write("folder/old.ppm", OLD);
    symlink("folder/old.ppm", shop.path("link.ppm")).expect("a link");
    symlink("link.ppm", shop.path("second.ppm")).expect("a link");
    symlink("folder/new.ppm", shop.path("dangling.ppm")).expect("a link");
    symlink("folder/rows.ppm", shop.path("rows.ppm")).expect("a link");
    shop.run("balls.txt second.ppm 64 48").succeeds();
    shop.run("balls.txt dangling.ppm 64 48").succeeds();
    shop.run("balls.txt rows.ppm 64 48 --rows 0..48").succeeds();
    for (link, target) in [
        ("link.ppm", "folder/old.ppm"),
        ("dangling.ppm", "folder/new.ppm"),
        ("rows.ppm", "folder/rows.ppm"),
    ] {
        assert_eq!(
            fs::read_link(shop.path(link)).expect("still a link"),
            Path::new(target)
        );
        assert_eq!(shop.read(target), shop.balls(64, 48));
    }
    symlink("round.ppm", shop.path("round.ppm")).expect("a link");
    shop.run("balls.txt round.ppm 64 48")
        .fails(&["round.ppm", "circle"]);
}

#[test]
fn the_scene_is_never_the_image() {
    let shop = Workshop::new();
    fs::hard_link(shop.path("balls.txt"), shop.path("hard.txt")).expect("a link");
    symlink("balls.txt", shop.path("soft.txt")).expect("a link");
    for image in ["balls.txt", "./balls.txt", "hard.txt", "soft.txt"] {
        for options in ["", "--rows 0..4", "--compare"] {
            shop.run(&format!("balls.txt {image} 64 48 {options}"))
                .fails(&[image, "the scene itself", "another name"]);
        }
    }
    shop.run("soft.txt hard.txt 64 48")
        .fails(&["the scene itself"]);
    shop.run("balls.txt image.ppm 64 48 --method double --diff hard.txt")
        .fails(&["hard.txt", "the scene itself"]);
    shop.run_shell("exec $SFERA balls.txt - 64 48 >> hard.txt")
        .fails(&["the scene itself"]);
    assert_eq!(shop.read("hard.txt"), program::BALLS.as_bytes());
    assert_eq!(shop.names(), ["balls.txt", "hard.txt", "soft.txt"]);
}

// Permissions.

#[test]
fn a_write_protected_image_is_left_alone() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    fs::set_permissions(shop.path("image.ppm"), fs::Permissions::from_mode(0o444)).expect("chmod");
    for options in ["", "--rows 0..4"] {
        shop.run(&format!("balls.txt image.ppm 64 48 {options}"))
            .fails(&["image.ppm", "write-protected", "chmod u+w"]);
    }
    assert_unharmed(&shop);
}

#[test]
fn a_protected_folder_is_reported() {
    let shop = Workshop::new();
    fs::create_dir(shop.path("closed")).expect("a folder");
    fs::set_permissions(shop.path("closed"), fs::Permissions::from_mode(0o555)).expect("chmod");
    let user = if is_root() {
        fs::set_permissions(shop.folder(), fs::Permissions::from_mode(0o755)).expect("chmod");
        "setpriv --reuid=65534 --clear-groups"
    } else {
        ""
    };
    for options in ["", "--rows 0..4"] {
        let ran = shop.run_shell(&format!(
            "exec {user} $SFERA balls.txt closed/image.ppm 64 48 {options}"
        ));
        if ran.stderr.contains("setpriv") {
            eprintln!("skipped: another user can't run {}", program::SFERA);
            return;
        }
        ran.fails(&["closed/image.ppm", "permission denied", "another directory"]);
    }
}

#[test]
fn a_disk_for_reading_only_is_reported() {
    let Some(disk) = Disk::new("a disk for reading only", "tmpfs", "size=1m") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    shop.write("image.ppm", OLD);
    disk.remount("ro");
    for name in ["image.ppm", "new.ppm"] {
        for options in ["", "--rows 0..4"] {
            shop.run(&format!("balls.txt {name} 64 48 {options}"))
                .fails(&[name, "read-only file system"]);
        }
    }
    assert_unharmed(&shop);
    disk.remount("rw");
}

// Signals.

#[test]
fn an_interrupt_leaves_the_old_image_and_nothing_else() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let shop = Workshop::new();
        shop.write("image.ppm", OLD);
        // The process that runs the tests may ignore them (`nohup`), and so would the program.
        let line = format!("exec env --default-signal $SFERA {SLOW}");
        let child = begin(&mut shop.shell(&line));
        send(signal, &child);
        let ran = end(child);
        assert_eq!((ran.code, ran.stderr.as_str()), (code, ""), "{signal}");
        assert_unharmed(&shop);
    }
}

#[test]
fn being_killed_leaves_the_old_image_and_nothing_else() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    let child = begin(&mut shop.sfera(SLOW));
    send("KILL", &child);
    assert_eq!(end(child).code, -9);
    assert_unharmed(&shop);
}

#[test]
fn ignored_signals_stay_ignored() {
    let shop = Workshop::new();
    let line = format!("trap '' HUP INT; exec env --default-signal=TERM $SFERA {SLOW}");
    let child = begin(&mut shop.shell(&line));
    send("HUP", &child);
    send("INT", &child);
    thread::sleep(Duration::from_millis(50));
    send("TERM", &child);
    assert_eq!(end(child).code, 143);
}

#[test]
fn without_nameless_files_an_interrupt_cleans_up() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    let hidden = |arguments: &str| without_nameless_files(&shop, arguments);
    let Some(mut command) = hidden("balls.txt image.ppm 64 48") else {
        return;
    };
    Ran::of(&mut command).succeeds();
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
    assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
    let mut command = hidden("balls.txt rows.ppm 64 48 --rows 0..48").expect("as before");
    Ran::of(&mut command).succeeds();
    assert_eq!(shop.read("rows.ppm"), shop.balls(64, 48));
    fs::remove_file(shop.path("rows.ppm")).expect("removed");

    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        shop.write("image.ppm", OLD);
        let mut command = hidden(SLOW).expect("as before");
        let child = command
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        wait_until("a temporary file", || shop.names().len() == 3);
        thread::sleep(Duration::from_millis(100));
        send(signal, &child);
        assert_eq!(end(child).code, code);
        assert_unharmed(&shop);
    }
}

#[test]
fn a_file_shortened_under_the_drawing_is_reported() {
    let shop = Workshop::new();
    let child = begin(&mut shop.sfera(&format!("{SLOW} --rows 0..4000")));
    let file = OpenOptions::new().write(true).open(shop.path("image.ppm"));
    file.and_then(|file| file.set_len(0)).expect("shortened");
    end(child).fails(&["image.ppm", "shortened", "draw it again"]);
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let shop = Workshop::new();
    let mut child = shop
        .sfera("balls.txt - 2000 2000 --method textbook")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    let mut bytes = [0; 10];
    child
        .stdout
        .take()
        .expect("a pipe")
        .read_exact(&mut bytes)
        .expect("ten bytes");
    let ran = end(child);
    assert_eq!((ran.code, ran.stderr.as_str()), (141, ""));
    assert_eq!(&bytes, b"P6\n2000 20");
    let ran = shop.run_shell("$SFERA --help | true; $SFERA --generate man | true");
    assert_eq!(ran.stderr, "");
}

// Other processes.

#[test]
fn of_two_runs_onto_one_name_one_whole_image_wins() {
    let shop = Workshop::new();
    let images = [shop.balls(300, 200), shop.balls(200, 300)];
    for _ in 0..10 {
        let runs = ["300 200", "200 300", "300 200"].map(|size| {
            let mut command = shop.sfera(&format!("balls.txt image.ppm {size}"));
            command
                .stderr(Stdio::piped())
                .spawn()
                .expect("the program runs")
        });
        for run in runs {
            end(run).succeeds();
        }
        assert!(images.contains(&shop.read("image.ppm")));
        assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
        fs::remove_file(shop.path("image.ppm")).expect("removed");
    }
}

#[test]
fn a_file_that_another_process_replaces_all_the_time_is_found() {
    let shop = Workshop::new();
    let right = shop.balls(30, 20);
    let (image, other) = (shop.path("image.ppm"), shop.path("other.ppm"));
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                fs::write(&other, &right).expect("written");
                fs::rename(&other, &image).expect("renamed");
            }
        });
        let runs: Vec<_> = (0..800)
            .map(|_| shop.run("balls.txt image.ppm 30 20"))
            .collect();
        ended.store(true, Ordering::Relaxed);
        for run in runs {
            run.succeeds();
        }
    });
    assert_eq!(shop.read("image.ppm"), right);
}

#[test]
fn rows_drawn_by_many_processes_at_once_are_the_image() {
    let shop = Workshop::new();
    let right = shop.balls(251, 160);
    for _ in 0..5 {
        let runs: Vec<_> = (0..16)
            .map(|part| {
                let rows = format!("{}..{}", part * 10, part * 10 + 10);
                let mut command = shop.sfera(&format!("balls.txt image.ppm 251 160 --rows {rows}"));
                command
                    .stderr(Stdio::piped())
                    .spawn()
                    .expect("the program runs")
            })
            .collect();
        for run in runs {
            end(run).succeeds();
        }
        assert_eq!(shop.read("image.ppm"), right);
        assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
        fs::remove_file(shop.path("image.ppm")).expect("removed");
    }
}

#[test]
fn processes_that_make_one_picture_reserve_it_once() {
    // Room for one picture of 201 MB, not for two; reserving it takes a while.
    let Some(disk) = Disk::new("one picture reserved once", "tmpfs", "size=250m") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    let runs: Vec<_> = (0..8)
        .map(|row| {
            let rows = format!("{row}..{}", row + 1);
            let mut command = shop.sfera(&format!(
                "balls.txt image.ppm 8192 8192 --rows {rows} --quiet"
            ));
            command
                .stderr(Stdio::piped())
                .spawn()
                .expect("the program runs")
        })
        .collect();
    for run in runs {
        end(run).succeeds();
    }
}

#[test]
fn a_scene_that_changes_while_it_is_read_is_at_worst_refused() {
    let shop = Workshop::new();
    let text = scene_of(200_000);
    let scene: PathBuf = shop.path("large.txt");
    for delay in [0, 1, 2, 4, 8, 16] {
        fs::write(&scene, &text).expect("a scene");
        let mut command = shop.sfera("large.txt image.ppm 8 8 --method textbook");
        let child = command
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        thread::sleep(Duration::from_millis(delay));
        let file = OpenOptions::new()
            .write(true)
            .open(&scene)
            .expect("the scene");
        file.set_len(1000).expect("shortened");
        let ran = end(child);
        match ran.code {
            0 => assert_eq!(shop.read("image.ppm").len(), 11 + 8 * 8 * 3),
            // A refusal shows the line of the scene after the message.
            code => assert!(
                code == 1 && ran.stderr.starts_with("sfera: large.txt"),
                "{code}: {}",
                ran.stderr
            ),
        }
    }
}

#[test]
fn a_cpu_that_lacks_what_was_compiled_in_is_reported() {
    if !cfg!(target_feature = "avx2") {
        eprintln!("skipped: this build asks for nothing special");
        return;
    }
    let shop = Workshop::new();
    let ran = Command::new("qemu-x86_64")
        .args([
            "-cpu",
            "qemu64",
            program::SFERA,
            "balls.txt",
            "image.ppm",
            "8",
            "8",
        ])
        .current_dir(shop.folder())
        .output();
    let Ok(ran) = ran else {
        eprintln!("skipped: no qemu-x86_64 to be another CPU");
        return;
    };
    Ran::from(ran).fails(&["built for a CPU with", "make build"]);
    assert_eq!(shop.names(), ["balls.txt"]);
}
