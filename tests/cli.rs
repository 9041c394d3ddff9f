//! The command line: every option, exit code and stream, of the program as a process.

// Permissions, links and signals are those of Unix.
#![cfg(unix)]

#[path = "common/program.rs"]
mod program;

use std::{fs, os::unix::fs::PermissionsExt, process::Stdio};

use program::{Ran, SFERA, Workshop};

#[test]
fn an_image_is_a_header_and_three_bytes_a_pixel() {
    let shop = Workshop::new();
    shop.run("balls.txt balls.ppm 64 48").succeeds();
    let image = shop.read("balls.ppm");
    assert!(image.starts_with(b"P6\n64 48\n255\n"));
    assert_eq!(image.len(), 13 + 64 * 48 * 3);
    let centre = 13 + (24 * 64 + 32) * 3;
    assert_eq!(image[centre..centre + 3], [200, 0, 0]);
    assert_eq!(image[13..16], [255, 255, 255]);
    assert_eq!(shop.names(), ["balls.ppm", "balls.txt"]);
}

#[test]
fn a_dash_writes_the_same_bytes_to_standard_output() {
    let shop = Workshop::new();
    let written = shop.run("balls.txt - 64 48").succeeds().stdout;
    assert_eq!(written, shop.balls(64, 48));
    shop.run_shell("$SFERA balls.txt - 64 48 > out.ppm")
        .succeeds();
    assert_eq!(shop.read("out.ppm"), written);
}

#[test]
fn a_dash_reads_the_scene_from_standard_input() {
    let shop = Workshop::new();
    let right = shop.balls(64, 48);
    for line in [
        "$SFERA - image.ppm 64 48 < balls.txt",
        "cat balls.txt | $SFERA - image.ppm 64 48",
        "(head -c 30 balls.txt; sleep 0.1; tail -c +31 balls.txt) | $SFERA - image.ppm 64 48",
        "$SFERA - - 64 48 < balls.txt > image.ppm",
        "$SFERA - image.ppm 64 48 --rows 0..30 < balls.txt && \
         cat balls.txt | $SFERA - image.ppm 64 48 --rows 30..48",
    ] {
        let _ = fs::remove_file(shop.path("image.ppm"));
        shop.run_shell(line).succeeds();
        assert_eq!(shop.read("image.ppm"), right, "{line}");
    }
    shop.run_shell("$SFERA - image.ppm 64 48 --verify < balls.txt")
        .succeeds();
    shop.run("- image.ppm 64 48").says(&[
        "sfera: standard input:1:1: expected VP",
        "the file is empty",
    ]);
    shop.run_shell("sed s/200/red/ balls.txt | $SFERA - image.ppm 64 48")
        .says(&["sfera: standard input:4:11: expected the red of sphere 1"]);
    shop.run_shell("$SFERA - image.ppm 64 48 < .")
        .says(&["sfera: standard input: can't read the scene", "folder"]);
    assert_eq!(shop.read("image.ppm"), right);
}

#[test]
fn a_scene_on_standard_input_is_not_replaced_either() {
    let shop = Workshop::new();
    for line in [
        "$SFERA - balls.txt 64 48 < balls.txt",
        "ln -sf balls.txt link; $SFERA - link 64 48 < balls.txt",
        "$SFERA - - 64 48 < balls.txt >> balls.txt",
    ] {
        shop.run_shell(line).fails(&["this is the scene itself"]);
        assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes(), "{line}");
    }
}

#[test]
fn strips_and_single_pixels_are_images() {
    let shop = Workshop::new();
    for (width, height) in [(1, 1), (1, 1000), (1000, 1), (1_000_000, 1), (1, 1_000_000)] {
        shop.run(&format!(
            "balls.txt strip.ppm {width} {height} --method textbook"
        ))
        .succeeds();
        let header = format!("P6\n{width} {height}\n255\n");
        let image = shop.read("strip.ppm");
        assert!(image.starts_with(header.as_bytes()));
        assert_eq!(image.len(), header.len() + width * height * 3);
    }
}

#[test]
fn every_method_in_both_forms_on_any_number_of_threads_draws_the_same_easy_picture() {
    let shop = Workshop::new();
    let right = shop.balls(65, 33);
    for options in [
        "--method textbook",
        "--method textbook --scalar",
        "--method geometric --threads 1",
        "--method geometric --scalar --threads 3",
        "--method double",
        "--method double --scalar",
        "--method geometric --threads 1024",
        "--method exact --threads 1024",
        "--method reference",
        "--quiet",
    ] {
        shop.run(&format!("balls.txt image.ppm 65 33 {options}"))
            .succeeds();
        assert_eq!(shop.read("image.ppm"), right, "{options}");
    }
}

#[test]
fn wrong_widths_and_heights_are_refused() {
    let shop = Workshop::new();
    for side in [
        "0",
        "-1",
        "1e3",
        "12x",
        "99999999999",
        "1.5",
        "0x10",
        "''",
        "-",
    ] {
        shop.run(&format!("balls.txt image.ppm {side} 48"))
            .refuses(&["WIDTH", side]);
        shop.run(&format!("balls.txt image.ppm 64 {side}"))
            .refuses(&["HEIGHT", side]);
    }
    shop.run("balls.txt image.ppm 4294967295 4294967295")
        .refuses(&["4294967295 x 4294967295 pixels are more bytes"]);
    assert_eq!(shop.names(), ["balls.txt"]);
}

#[test]
fn wrong_command_lines_are_refused() {
    let shop = Workshop::new();
    for (line, words) in [
        ("", "required"),
        ("balls.txt", "required"),
        ("balls.txt image.ppm 64", "HEIGHT"),
        ("balls.txt image.ppm 64 48 extra", "extra"),
        ("balls.txt image.ppm 64 48 --fast", "--fast"),
        ("balls.txt image.ppm 64 48 --method quick", "textbook"),
        ("balls.txt image.ppm 64 48 --threads 0", "--threads"),
        ("balls.txt image.ppm 64 48 --threads 1025", "1..=1024"),
        ("balls.txt image.ppm 64 48 --scalar", "add --method"),
        (
            "balls.txt image.ppm 64 48 --scalar --method reference",
            "--scalar",
        ),
        ("balls.txt image.ppm 64 48 --rows 5", "A..B"),
        ("balls.txt image.ppm 64 48 --rows 5..5", "no row"),
        ("balls.txt image.ppm 64 48 --rows 9..5", "no row"),
        ("balls.txt image.ppm 64 48 --rows -1..5", "-1"),
        ("balls.txt image.ppm 64 48 --rows 0..49", "rows 0..48"),
        ("balls.txt - 64 48 --rows 0..4", "not -"),
        ("balls.txt - 64 48 --compare", "not -"),
        ("balls.txt image.ppm 64 48 --diff other.ppm", "add --method"),
        (
            "balls.txt image.ppm 64 48 --method double --diff image.ppm",
            "of its own",
        ),
        (
            "balls.txt image.ppm 64 48 --method double --diff other.ppm --rows 0..4",
            "--rows",
        ),
        (
            "balls.txt image.ppm 64 48 --compare --method double",
            "--method",
        ),
        ("balls.txt image.ppm 64 48 --compare --rows 0..4", "--rows"),
        ("balls.txt image.ppm 64 48 --compare --verify", "--verify"),
        ("balls.txt image.ppm 64 48 --compare --stats", "--stats"),
        ("balls.txt image.ppm 64 48 --stats --quiet", "--quiet"),
        ("balls.txt image.ppm 64 48 --stats=xml", "json"),
        ("balls.txt image.ppm 64 48 --generate man", "--generate"),
        ("--generate tcsh", "bash"),
    ] {
        shop.run(line).refuses(&[words]);
        assert_eq!(shop.names(), ["balls.txt"], "{line}");
    }
}

#[test]
fn help_and_version_are_printed() {
    let shop = Workshop::new();
    let help = shop.run_shell("COLUMNS=80 $SFERA --help").succeeds().stdout;
    assert_eq!(
        shop.run_shell("COLUMNS=80 $SFERA -h").succeeds().stdout,
        help
    );
    let help = String::from_utf8(help).expect("text");
    let widest = help.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80), "{help}");
    // Two screens.
    assert!(help.lines().count() <= 48, "{help}");
    let place = |word: &str| help.find(word).unwrap_or_else(|| panic!("{word}: {help}"));
    assert!(place("Examples:") < place("Arguments:") && place("Arguments:") < place("Options:"));
    for word in [
        "sfera scene.txt picture.png 1920 1080",
        "--method",
        "--scalar",
        "--threads",
        "--rows",
        "--verify",
        "--compare",
        "--diff",
        "--stats",
        "--quiet",
        "--generate",
        "Exit codes",
    ] {
        assert!(help.contains(word), "{word}");
    }
    let version = shop.run("--version").succeeds().stdout;
    assert_eq!(
        version,
        concat!("sfera ", env!("CARGO_PKG_VERSION"), "\n").as_bytes()
    );
}

#[test]
fn colour_is_for_terminals_only() {
    let shop = Workshop::new();
    for line in ["--help", "balls.txt image.ppm 0 0"] {
        let ran = shop.run(line);
        assert!(
            !ran.stdout.contains(&0x1b) && !ran.stderr.contains('\u{1b}'),
            "{line}"
        );
    }
}

/// What a command shows on a terminal.
fn on_a_terminal(shop: &Workshop, line: &str) -> Option<String> {
    let line = format!("exec script -qec \"{line}\" /dev/null");
    let ran = Ran::of(
        shop.shell(&line)
            .env("TERM", "xterm-256color")
            .env_remove("NO_COLOR"),
    );
    if ran.stderr.contains("script") {
        eprintln!("skipped: no script to be a terminal");
        return None;
    }
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    Some(String::from_utf8_lossy(&ran.stdout).into_owned())
}

#[test]
fn a_terminal_shows_colour_unless_no_color_is_set() {
    let shop = Workshop::new();
    let Some(plain) = on_a_terminal(&shop, "NO_COLOR=1 $SFERA --help") else {
        return;
    };
    assert!(!plain.contains('\u{1b}'));
    let coloured = on_a_terminal(&shop, "$SFERA --help").expect("a terminal");
    assert!(coloured.contains('\u{1b}'));
}

#[test]
fn a_terminal_shows_the_progress_of_long_drawing() {
    let shop = Workshop::new();
    let slow = "$SFERA balls.txt image.ppm 1500 1500 --method reference --threads 1";
    let Some(shown) = on_a_terminal(&shop, slow) else {
        return;
    };
    assert!(
        shown.contains("of 2,250,000 pixels") && shown.contains("left"),
        "{shown}"
    );
    let quiet = on_a_terminal(&shop, &format!("{slow} --quiet")).expect("a terminal");
    assert_eq!(quiet, "");
    let quick = on_a_terminal(&shop, "$SFERA balls.txt image.ppm 150 150").expect("a terminal");
    assert_eq!(quick, "");
    let piped = shop.run_shell(slow);
    assert_eq!(piped.stderr, "");
}

#[test]
fn completions_and_the_manual_page_are_printed() {
    let shop = Workshop::new();
    for (page, word) in [
        ("bash", "complete -F _sfera"),
        ("zsh", "#compdef sfera"),
        ("fish", "complete -c sfera"),
        ("man", ".TH sfera 1"),
    ] {
        let text = shop.run(&format!("--generate {page}")).succeeds().stdout;
        let text = String::from_utf8(text).expect("text");
        assert!(text.contains(word), "{page}");
        assert!(text.contains("compare"), "{page}");
    }
}

#[test]
fn stats_are_one_line_for_each_phase() {
    let shop = Workshop::new();
    let ran = shop.run("balls.txt image.ppm 64 48 --stats");
    assert_eq!(ran.code, 0);
    let first: Vec<_> = ran
        .stderr
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert_eq!(
        first,
        ["read", "prepare", "render", "publish", "total", "settled"]
    );
    assert!(ran.stderr.contains("million pixels a second"));
    assert!(ran.stderr.contains("pixels by integers"));
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));

    let ran = shop.run("balls.txt - 64 48 --method textbook --stats");
    assert!(!ran.stderr.contains("settled"));
    assert_eq!(ran.stdout, shop.balls(64, 48));
}

#[test]
fn stats_for_scripts_are_one_line_of_json() {
    let shop = Workshop::new();
    let ran = shop.run("balls.txt image.ppm 64 48 --rows 8..24 --threads 2 --stats=json");
    assert_eq!(ran.code, 0);
    assert_eq!(ran.stderr.lines().count(), 1);
    let json = ran.stderr.trim();
    for part in [
        "{\"width\":64,\"height\":48,\"rows\":[8,24],\"spheres\":2,\"method\":\"exact\",\"form\":\"packets\",\"threads\":",
        "\"milliseconds\":{\"read\":",
        "\"publish\":",
        "\"pixels_per_second\":",
        "\"settled_pixels\":{\"runs\":",
    ] {
        assert!(json.contains(part), "{part} in {json}");
    }
    assert_eq!(json.matches('{').count(), json.matches('}').count());
    let settled = json.split_once("\"settled_pixels\":").expect("counts").1;
    let sum: u64 = settled
        .split(',')
        .filter(|part| {
            ["runs", "packets", "doubles", "integers"]
                .iter()
                .any(|rung| part.contains(rung))
        })
        .map(|part| {
            part.chars()
                .filter(char::is_ascii_digit)
                .collect::<String>()
        })
        .map(|digits| digits.parse::<u64>().expect("a number"))
        .sum();
    assert_eq!(sum, 64 * 16);
}

#[test]
fn rows_drawn_in_any_order_and_again_are_the_image() {
    let shop = Workshop::new();
    for rows in ["30..48", "0..7", "5..31", "0..7"] {
        shop.run(&format!("balls.txt image.ppm 64 48 --rows {rows}"))
            .succeeds();
        assert_eq!(shop.read("image.ppm").len(), 13 + 64 * 48 * 3);
    }
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
    assert_eq!(shop.names(), ["balls.txt", "image.ppm"]);
}

#[test]
fn rows_touch_nothing_else() {
    let shop = Workshop::new();
    let mut image = b"P6\n64 48\n255\n".to_vec();
    image.resize(13 + 64 * 48 * 3, 77);
    shop.write("image.ppm", &image);
    shop.run("balls.txt image.ppm 64 48 --rows 10..20")
        .succeeds();
    let (first, end) = (13 + 10 * 192, 13 + 20 * 192);
    image[first..end].copy_from_slice(&shop.balls(64, 48)[first..end]);
    assert_eq!(shop.read("image.ppm"), image);
}

#[test]
fn rows_are_not_drawn_into_another_picture() {
    let shop = Workshop::new();
    let pixels = vec![9; 64 * 48 * 3];
    for (name, header) in [
        ("size", "P6\n48 64\n255\n"),
        ("kind", "P5\n64 48\n255\n"),
        ("depth", "P6\n64 48\n254\n"),
        ("length", "P6\n64 48\n255\n "),
        ("empty", ""),
    ] {
        let image = [header.as_bytes(), &pixels[..]].concat();
        let image = if name == "empty" { Vec::new() } else { image };
        shop.write(name, &image);
        shop.run(&format!("balls.txt {name} 64 48 --rows 0..4"))
            .fails(&[name, "not a 64 x 48 picture", "left as it is"]);
        assert_eq!(shop.read(name), image, "{name}");
    }
}

#[test]
fn verify_reports_which_rows_differ() {
    let shop = Workshop::new();
    shop.run("balls.txt image.ppm 64 48").succeeds();
    shop.run("balls.txt image.ppm 64 48 --verify").succeeds();
    let mut image = shop.read("image.ppm");
    for row in [3, 4, 5, 40] {
        image[13 + row * 192 + 100] ^= 1;
    }
    shop.write("image.ppm", &image);
    shop.run("balls.txt image.ppm 64 48 --verify").fails(&[
        "image.ppm: 4 of 3072 pixels differ",
        "in 4 of 48 rows: 3..6, 40..41;",
    ]);
    shop.run("balls.txt image.ppm 64 48 --verify --rows 6..40")
        .succeeds();
    shop.run("balls.txt image.ppm 64 48 --verify --rows 5..7")
        .fails(&["in 1 of 2 rows: 5..6;"]);
    shop.run("balls.txt image.ppm 64 47 --verify")
        .fails(&["not a 64 x 47 picture but one of 64 x 48"]);
    shop.run("balls.txt missing.ppm 64 48 --verify")
        .fails(&["missing.ppm"]);
    assert_eq!(shop.read("image.ppm"), image);
}

#[test]
fn compare_prints_a_table_and_keeps_the_exact_image() {
    let shop = Workshop::new();
    let ran = shop.run("balls.txt image.ppm 64 48 --compare").succeeds();
    let table = String::from_utf8(ran.stdout).expect("text");
    let methods: Vec<_> = table
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert_eq!(
        methods,
        [
            "method",
            "textbook",
            "textbook",
            "geometric",
            "geometric",
            "double",
            "double",
            "reference",
            "exact"
        ]
    );
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

#[test]
fn compare_says_when_the_reference_is_left_out() {
    let shop = Workshop::new();
    let spheres = "S 0 0 50 1 1 2 3 ".repeat(5000);
    shop.write(
        "many.txt",
        format!("VP 1 1 1 BG 0 0 0 OBJ_N 5000 {spheres}").as_bytes(),
    );
    let table = shop
        .run("many.txt image.ppm 100 100 --compare")
        .succeeds()
        .stdout;
    assert!(String::from_utf8_lossy(&table).contains("left out: reference"));
}

#[test]
fn a_difference_marks_what_is_wrong() {
    let shop = Workshop::new();
    let far = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/far.txt");
    let ran = shop.run(&format!(
        "{far} textbook.ppm 64 48 --method textbook --diff marks.ppm"
    ));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    shop.run(&format!("{far} exact.ppm 64 48")).succeeds();
    let (textbook, exact, marks) = (
        shop.read("textbook.ppm"),
        shop.read("exact.ppm"),
        shop.read("marks.ppm"),
    );
    assert!(marks.starts_with(b"P6\n64 48\n255\n"));
    let mut wrong = 0;
    for ((one, other), mark) in textbook[13..]
        .chunks(3)
        .zip(exact[13..].chunks(3))
        .zip(marks[13..].chunks(3))
    {
        assert_eq!(one != other, mark == [255, 0, 0]);
        wrong += u32::from(one != other);
    }
    assert!(wrong > 0);
    assert_eq!(
        ran.stderr,
        format!("{wrong} of 3072 pixels differ from exact\n")
    );
}

#[test]
fn what_is_in_place_keeps_its_permissions_and_what_is_new_follows_the_umask() {
    let shop = Workshop::new();
    let mode = |name: &str| {
        let metadata = fs::metadata(shop.path(name)).expect("a file");
        metadata.permissions().mode() & 0o7777
    };
    shop.run_shell("umask 027; exec $SFERA balls.txt new.ppm 4 4")
        .succeeds();
    assert_eq!(mode("new.ppm"), 0o640);
    shop.run_shell("umask 077; exec $SFERA balls.txt rows.ppm 4 4 --rows 0..1")
        .succeeds();
    assert_eq!(mode("rows.ppm"), 0o600);
    shop.write("old.ppm", b"old");
    fs::set_permissions(shop.path("old.ppm"), fs::Permissions::from_mode(0o604)).expect("chmod");
    shop.run("balls.txt old.ppm 4 4").succeeds();
    assert_eq!(mode("old.ppm"), 0o604);
}

#[test]
fn a_replaced_image_is_another_file_and_rows_are_drawn_in_the_same() {
    let shop = Workshop::new();
    shop.run("balls.txt image.ppm 64 48 --rows 0..1").succeeds();
    let before = shop.read("image.ppm");
    fs::hard_link(shop.path("image.ppm"), shop.path("kept.ppm")).expect("a link");
    shop.run("balls.txt image.ppm 64 48 --rows 20..30")
        .succeeds();
    assert_ne!(shop.read("kept.ppm"), before);
    assert_eq!(shop.read("kept.ppm"), shop.read("image.ppm"));
    let before = shop.read("image.ppm");
    shop.run("balls.txt image.ppm 64 48").succeeds();
    assert_eq!(shop.read("kept.ppm"), before);
    assert_eq!(shop.read("image.ppm"), shop.balls(64, 48));
}

#[test]
fn names_may_hold_anything() {
    let shop = Workshop::new();
    for name in [
        "with space.ppm",
        "-dash.ppm",
        "ünïcode.ppm",
        "new\nline.ppm",
    ] {
        let ran = Ran::of(
            std::process::Command::new(SFERA)
                .args(["--threads", "1", "--", "balls.txt", name, "4", "4"])
                .current_dir(shop.folder())
                .stdin(Stdio::null()),
        );
        ran.succeeds();
        assert_eq!(shop.read(name), shop.balls(4, 4));
    }
}
