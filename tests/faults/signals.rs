//! Signals and limits that end the program, which leaves nothing behind.

use std::{
    fs::{self, OpenOptions},
    path::PathBuf,
    process::{Child, Stdio},
    thread,
    time::Duration,
};

use super::{
    Disk, OLD, SLOW, as_root, assert_unharmed, begin, end, mapped, scene_of, send,
    without_nameless_files,
};
use crate::program::{Ran, Workshop, wait_until};

/// Starts a render whose unfinished image has a name, and waits for that name.
fn begin_named(shop: &Workshop, arguments: &str) -> Option<Child> {
    let mut command = without_nameless_files(shop, arguments)?;
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program runs");
    wait_until("a temporary file", || {
        shop.names().iter().any(|name| name.ends_with(".part"))
    });
    Some(child)
}

#[test]
fn no_signal_but_kill_leaves_a_temporary_file() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    for (signal, code) in [
        ("HUP", 129),
        ("INT", 130),
        ("QUIT", 131),
        ("TRAP", 133),
        ("ABRT", 1),
        ("USR1", 138),
        ("USR2", 140),
        ("ALRM", 142),
        ("TERM", 143),
        ("STKFLT", 144),
        ("VTALRM", 154),
        ("PROF", 155),
        ("IO", 157),
        ("PWR", 158),
        ("SYS", 159),
        ("40", 168),
        ("64", 192),
    ] {
        let Some(child) = begin_named(&shop, SLOW) else {
            return;
        };
        send(signal, &child);
        let ran = end(child);
        assert_eq!((ran.code, ran.stderr.as_str()), (code, ""), "{signal}");
        assert_unharmed(&shop);
    }
}

#[test]
fn a_limit_on_processor_time_is_reported() {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    for limit in ["ulimit -t 2", "ulimit -St 1"] {
        let arguments = format!("{SLOW} --threads 2");
        let Some(command) = without_nameless_files(&shop, &arguments) else {
            return;
        };
        let line = command.get_args().last().expect("a line").to_str();
        let line = format!("{limit}; {}", line.expect("text"));
        shop.run_shell(&line)
            .fails(&["processor time", "ulimit -t"]);
        assert_unharmed(&shop);
    }
}

#[test]
fn a_picture_that_is_filled_first_leaves_nothing_when_interrupted() {
    // Filled with zeros, because blocks can't be reserved there.
    let Some(disk) = Disk::new("a picture filled first", "ramfs", "mode=0755") else {
        return;
    };
    let shop = Workshop::within(disk.at.path());
    for signal in ["TERM", "HUP", "USR1"] {
        let rows = "balls.txt image.ppm 10000 10000 --rows 0..1";
        let Some(child) = begin_named(&shop, rows) else {
            return;
        };
        send(signal, &child);
        let ran = end(child);
        assert!(ran.code > 128, "{}", ran.stderr);
        assert_eq!(shop.names(), ["balls.txt"], "{signal}");
    }
}

#[test]
fn no_memory_leaves_no_temporary_file() {
    let shop = Workshop::new();
    shop.write("large.txt", scene_of(100_000).as_bytes());
    let mut reported = 0;
    for kilobytes in (8_000..60_000).step_by(2_000) {
        let limited = "large.txt image.ppm 500 500 --threads 2";
        let Some(command) = without_nameless_files(&shop, limited) else {
            return;
        };
        let line = command.get_args().last().expect("a line").to_str();
        let line = line.expect("text").replace(
            "exec $SFERA",
            &format!("ulimit -v {kilobytes} && timeout 5 $SFERA"),
        );
        let ran = shop.run_shell(&line);
        if ran.stderr.contains("out of memory") {
            reported += 1;
            assert!(ran.stderr.starts_with("sfera: "), "{}", ran.stderr);
            assert!(ran.stderr.contains("ulimit -v"), "{}", ran.stderr);
            assert!(!ran.stderr.contains("BACKTRACE"), "{}", ran.stderr);
        }
        let parts = shop
            .names()
            .into_iter()
            .filter(|name| name.ends_with(".part"));
        assert_eq!(parts.count(), 0, "{kilobytes}: {}", ran.stderr);
    }
    assert!(reported > 0);
}

#[test]
fn a_lost_page_of_the_difference_is_reported_for_the_difference() {
    let shop = Workshop::new();
    let arguments =
        "balls.txt image.ppm 1500 1500 --method textbook --scalar --threads 1 --diff marks.ppm";
    let Some(child) = begin_named(&shop, arguments) else {
        return;
    };
    // Two files, drawn one after the other.
    let mut first = None;
    let mut second: Option<PathBuf> = None;
    wait_until("the difference is drawn", || {
        let now = mapped(&child);
        match (&first, now) {
            (None, Some(now)) => first = Some(now),
            (Some(first), Some(now)) if *first != now => second = Some(now),
            _ => {}
        }
        second.is_some() || shop.names().len() == 3
    });
    let Some(second) = second else {
        eprintln!("skipped: the difference was drawn too fast");
        return;
    };
    let file = OpenOptions::new().write(true).open(second);
    file.and_then(|file| file.set_len(0)).expect("shortened");
    end(child).fails(&["marks.ppm", "shortened", "draw it again"]);
    assert_eq!(shop.names(), ["balls.txt"]);
}

/// Checked by the system calls, since it is chance whether a second thread is in time.
#[test]
fn the_handler_of_a_lost_page_is_not_replaced_while_it_runs() {
    let shop = Workshop::new();
    let line = format!(
        "exec strace -f -o trace -e trace=rt_sigaction $SFERA {SLOW} --rows 0..4000 --threads 8"
    );
    let mut command = shop.shell(&line);
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    wait_until("a picture", || {
        fs::metadata(shop.path("image.ppm")).is_ok() || child_has_ended(&child)
    });
    if fs::metadata(shop.path("image.ppm")).is_err() {
        eprintln!("skipped: no strace here: {}", end(child).stderr);
        return;
    }
    thread::sleep(Duration::from_millis(500));
    let file = OpenOptions::new().write(true).open(shop.path("image.ppm"));
    file.and_then(|file| file.set_len(0)).expect("shortened");
    end(child).fails(&["image.ppm", "shortened", "draw it again"]);
    let trace = String::from_utf8(shop.read("trace")).expect("text");
    let (_, after) = trace.split_once("--- SIGBUS").expect("the signal");
    assert!(!after.contains("rt_sigaction(SIGBUS"), "{after}");
    assert!(!after.contains("killed by SIGBUS"), "{after}");
}

fn child_has_ended(child: &Child) -> bool {
    let stat = fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap_or_default();
    stat.is_empty() || stat.contains(") Z ")
}

#[test]
fn many_threads_that_lose_their_pages_end_by_one_message() {
    let shop = Workshop::new();
    for _ in 0..10 {
        let child = begin(&mut shop.sfera(&format!("{SLOW} --rows 0..4000 --threads 64")));
        let file = OpenOptions::new().write(true).open(shop.path("image.ppm"));
        file.and_then(|file| file.set_len(0)).expect("shortened");
        end(child).fails(&["image.ppm", "shortened", "draw it again"]);
        fs::remove_file(shop.path("image.ppm")).expect("removed");
    }
}

#[test]
fn ignored_signals_stay_ignored_without_proc() {
    if !as_root("ignored signals without /proc") {
        return;
    }
    let shop = Workshop::new();
    let Some(command) = without_nameless_files(&shop, SLOW) else {
        return;
    };
    let line = command.get_args().last().expect("a line").to_str();
    let line = line.expect("text").replace(
        "exec env --default-signal",
        "trap '' HUP; exec env --default-signal=TERM",
    );
    let child = shop.shell(&line).spawn().expect("a shell");
    wait_until("a temporary file", || shop.names().len() == 2);
    send("HUP", &child);
    thread::sleep(Duration::from_millis(50));
    send("TERM", &child);
    assert_eq!(end(child).code, 143);
}

/// Nobody reads the pipe, and the program must not wait for a reader.
#[test]
fn pipes_are_opened_when_there_is_something_to_write() {
    let shop = Workshop::new();
    let ran = |line: &str| shop.run_shell(&format!("exec timeout 20 $SFERA {line}"));
    assert_eq!(shop.run_shell("exec mkfifo pipe").code, 0);
    ran("missing.txt pipe 64 48").says(&["missing.txt"]);
    ran("balls.txt pipe 64 48 --rows 0..4").fails(&["pipe", "--rows needs a file"]);
    ran("balls.txt image.ppm 64 48 --method double --diff missing/pipe").fails(&["missing/pipe"]);
    ran("balls.txt pipe 64 48 --method double --diff missing/marks.ppm")
        .fails(&["missing/marks.ppm"]);
    ran("balls.txt pipe 64 48 --method double --diff pipe").refuses(&["a name of its own"]);
    ran("balls.txt pipe 64 48 --method double --diff ./pipe").fails(&["the other image too"]);
}

#[test]
fn waiting_for_a_pipe_is_reported() {
    let shop = Workshop::new();
    assert_eq!(shop.run_shell("exec mkfifo pipe").code, 0);
    for (options, word) in [("", "read it"), ("--verify", "write it")] {
        let ran = shop.run_shell(&format!(
            "exec timeout 3 $SFERA balls.txt pipe 64 48 {options}"
        ));
        assert!(ran.code == 124 || ran.code == 143, "{}", ran.code);
        ran.says(&[
            "sfera: pipe: this is a pipe",
            "waiting for another program",
            word,
        ]);
    }
}

#[test]
fn waiting_for_a_lock_is_reported() {
    let shop = Workshop::new();
    for (quiet, reported) in [("", true), ("--quiet", false)] {
        let ran = shop.run_shell(&format!(
            "flock . sleep 2.5 & sleep 0.3; $SFERA balls.txt image{quiet}.ppm 64 48 --rows 0..48 {quiet}"
        ));
        if ran.stderr.contains("flock: ") || ran.stderr.contains("not found") {
            eprintln!("skipped: no flock here");
            return;
        }
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert_eq!(
            ran.stderr.contains("another process has locked"),
            reported,
            "{}",
            ran.stderr
        );
        assert_eq!(shop.read(&format!("image{quiet}.ppm")), shop.balls(64, 48));
    }
}

#[test]
fn an_interrupt_clears_the_progress_bar() {
    let shop = Workshop::new();
    let line = format!(
        "exec script -qec 'stty cols 80; exec timeout -s INT 2 env --default-signal $SFERA {SLOW}' /dev/null"
    );
    let ran = Ran::of(shop.shell(&line).env("TERM", "xterm-256color"));
    if ran.stderr.contains("script") {
        eprintln!("skipped: no script to be a terminal");
        return;
    }
    let shown = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(shown.contains("pixels"), "{shown}");
    assert!(shown.ends_with("\r\u{1b}[K"), "{shown:?}");
    for line in shown
        .split(['\r', '\n'])
        .filter(|line| line.contains("pixels"))
    {
        let line = line.replace("\u{1b}[2K", "");
        assert!(line.chars().count() <= 80, "{line}");
        let (_, rate) = line.split_once("pixels, ").expect("a rate");
        let (rate, _) = rate.split_once(" million/s").expect("a rate");
        let (_, decimals) = rate.split_once('.').expect("decimals");
        assert_eq!(decimals.len(), 1, "{line}");
    }
}
