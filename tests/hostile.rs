//! More than a hundred bad inputs, each given to the program as a process. Each must give one
//! clear message and exit code 1 or 2, and change nothing in the folder.

// Permissions, links and signals are those of Unix.
#![cfg(unix)]

#[path = "common/program.rs"]
mod program;

use std::{
    ffi::OsStr,
    fs,
    os::unix::{ffi::OsStrExt, fs::symlink, net::UnixListener},
};

use program::{Ran, Workshop};

const OLD: &[u8] = b"the image that was there before";

/// A folder with a scene and an image that must stay as they are.
fn workshop() -> Workshop {
    let shop = Workshop::new();
    shop.write("image.ppm", OLD);
    shop
}

/// Checks what holds of every message.
#[track_caller]
fn assert_clear(ran: &Ran, code: i32, word: &str) {
    let message = &ran.stderr;
    assert_eq!(ran.code, code, "{message}");
    assert!(message.contains(word), "no {word:?} in: {message}");
    assert!(message.len() < 2_000, "{} bytes", message.len());
    let begin = if code == 1 { "sfera: " } else { "error: " };
    assert!(message.starts_with(begin), "{message}");
    let odd = |character: char| character.is_control() && character != '\n';
    assert!(!message.contains(odd), "{message:?}");
    for ours in ["internal error", "panicked", "backtrace", "RUST_"] {
        assert!(!message.contains(ours), "{message}");
    }
    assert!(ran.stdout.is_empty(), "{:?}", ran.stdout);
}

/// A scene of one sphere, with one of its words replaced.
fn scene_with(place: usize, word: &[u8]) -> Vec<u8> {
    let plain = "VP 1 1 1 BG 0 0 0 OBJ_N 1 S 0 0 5 1 1 2 3";
    let words = plain.split(' ').enumerate();
    let words: Vec<&[u8]> = words
        .map(|(at, plain)| if at == place { word } else { plain.as_bytes() })
        .collect();
    words.join(&b' ')
}

const WIDTH: usize = 1;
const DISTANCE: usize = 3;
const RED: usize = 5;
const COUNT: usize = 9;
const S: usize = 10;
const X: usize = 11;
const RADIUS: usize = 14;
const BLUE: usize = 17;

#[test]
fn scenes() {
    let long = |byte: u8| vec![byte; 100_000];
    let with = |place: usize, word: &str| scene_with(place, word.as_bytes());
    let bytes = |text: &str| text.as_bytes().to_vec();
    let scenes: Vec<(Vec<u8>, &str)> = vec![
        // Numbers in other notations.
        (with(X, "1e"), "exponent has no digits"),
        (with(X, "1e+"), "exponent has no digits"),
        (with(X, "1E400"), "largest number"),
        (with(X, "-1e39"), "largest number"),
        (
            with(X, "340282356779733661637539395458142568448"),
            "largest number",
        ),
        (with(X, "1e99999999999999999999"), "largest number"),
        (with(X, "0x1p-3"), "in decimal"),
        (with(X, "0b101"), "decimal number"),
        (with(X, "1'000"), "decimal number"),
        (with(X, "1_0"), "without underscores"),
        (with(X, "1,5"), "write it with a point: 1.5"),
        (with(X, "1.5."), "at most one point"),
        (with(X, "1.2.3"), "at most one point"),
        (with(X, "..5"), "at most one point"),
        (with(X, "+-1"), "one sign"),
        (with(X, "--1"), "one sign"),
        (with(X, "\u{2212}5"), "typographic minus"),
        (with(X, "\u{ff11}"), "decimal number"),
        (with(X, "\u{661}"), "decimal number"),
        (with(X, "\u{bd}"), "decimal number"),
        (with(X, "5\u{a0}5"), "no-break space"),
        (with(X, "5\u{202e}5"), "\\u{202e}"),
        (with(X, "5\u{200b}"), "\\u{200b}"),
        (with(X, "5\x1b[2J"), "\\x1b[2J"),
        (with(X, "5\x07"), "\\x07"),
        (with(X, "$HOME"), "decimal number"),
        (with(X, "`reboot`"), "decimal number"),
        (with(X, "%s%n%x"), "%s%n%x"),
        (with(X, "{}"), "decimal number"),
        (with(X, "1e5f"), "without a suffix"),
        (with(X, "1.0f64"), "decimal number"),
        (with(X, "-nan(0x7)"), "finite"),
        (with(X, "Infinity"), "finite"),
        (with(X, "1/0"), "in decimal"),
        (with(X, "sqrt(2)"), "decimal number"),
        (with(X, "\"1\""), "without quotes"),
        (with(X, "(1)"), "without brackets"),
        (with(X, "1;"), "by blanks alone"),
        (with(X, "l0"), "letter l or I"),
        (with(X, "1O"), "letter O"),
        (scene_with(X, b"\xff"), "not UTF-8"),
        (scene_with(X, b"1\0"), "NUL"),
        (scene_with(X, b"\xed\xa0\x80"), "not UTF-8"),
        (scene_with(X, b"\xf4\x90\x80\x80"), "not UTF-8"),
        (scene_with(X, b"\xc0\xae"), "not UTF-8"),
        (
            scene_with(X, &long(b'9')),
            "a word of more than 65536 bytes",
        ),
        (
            scene_with(X, &long(b'-')),
            "a word of more than 65536 bytes",
        ),
        (scene_with(X, &long(0)), "a word of more than 65536 bytes"),
        (
            scene_with(X, &long(0xff)),
            "a word of more than 65536 bytes",
        ),
        (
            scene_with(X, &[b"1,".as_slice(), &long(b'0')[..60_000]].concat()),
            "instead of the comma",
        ),
        (
            scene_with(X, &[&long(b'0')[..60_000], b"x"].concat()),
            "60001 bytes",
        ),
        // Numbers that are not valid lengths, colours or counts.
        (with(WIDTH, "0"), "greater than 0"),
        (with(WIDTH, "-1"), "greater than 0"),
        (with(DISTANCE, "1e-46"), "rounds to 0"),
        (with(DISTANCE, "0e9"), "greater than 0"),
        (with(RADIUS, "-0"), "greater than 0"),
        (with(RADIUS, "-1e-60"), "rounds to 0"),
        (with(RED, "256"), "0 to 255"),
        (with(RED, "-1"), "0 to 255"),
        (with(RED, "1e2"), "without a fraction"),
        (with(RED, "#ff0000"), "the red of the background"),
        (with(BLUE, "0.5"), "0 to 255"),
        (with(BLUE, "99999999999999999999999"), "0 to 255"),
        (with(BLUE, "0xff"), "in decimal"),
        (with(COUNT, "0"), "another one follows"),
        (with(COUNT, "2"), "the file ends after 1"),
        (with(COUNT, "4294967295"), "the file ends after 1"),
        (with(COUNT, "4294967296"), "0 to 4294967295"),
        (with(COUNT, "18446744073709551617"), "0 to 4294967295"),
        (with(COUNT, "-1"), "0 to 4294967295"),
        (with(COUNT, "1.0"), "without a fraction"),
        // Misplaced words.
        (with(S, "s"), "capital letters"),
        (with(S, "SPHERE"), "a sphere is: S x y z"),
        (with(S, "S,"), "a sphere is: S x y z"),
        (with(S, "S1"), "a blank after S"),
        (with(S, "T"), "a sphere is: S x y z"),
        (with(0, "vp"), "capital letters"),
        (with(0, "\u{feff}\u{feff}VP"), "byte order mark"),
        (with(0, "VP,"), "expected VP"),
        (with(4, "BACKGROUND"), "expected BG"),
        (with(8, "N"), "expected OBJ_N"),
        (bytes("S 0 0 5 1 1 2 3"), "expected VP"),
        (bytes("VP 1 1 1 VP 1 1 1"), "expected BG"),
        (
            bytes("VP 1 1 1 BG 0 0 0 OBJ_N 0 OBJ_N 0"),
            "a file holds one scene",
        ),
        (
            bytes("VP 1 1 1 BG 0 0 0 OBJ_N 0 \u{1a}"),
            "control characters",
        ),
        (bytes("VP 1 1 1 BG 0 0 0 OBJ_N 0 // end"), "begins with #"),
        (bytes("<?xml version=\"1.0\"?>"), "XML"),
        (bytes("{\"VP\": [1, 1, 1]}"), "JSON"),
        (bytes("#!/bin/sh\nrm -rf /\n"), "expected VP"),
        (bytes("VP 1 1 1 # BG 0 0 0 OBJ_N 0"), "the file ends"),
        (bytes("# VP 1 1 1\r# BG 0 0 0\r"), "nothing but blanks"),
        (bytes("VP"), "the file ends"),
        (bytes("V"), "expected VP"),
        (bytes("\n"), "nothing but blanks"),
        (Vec::new(), "empty"),
        (b"P6\n64 48\n255\n".to_vec(), "a PPM image"),
        (b"\x7fELF\x02\x01\x01".to_vec(), "a program"),
        (b"\x1f\x8b\x08".to_vec(), "gzip"),
        (b"\xff\xfeV\0P\0".to_vec(), "UTF-16"),
        // Long texts without a scene.
        (vec![0; 1_000_000], "a word of more than 65536 bytes"),
        (vec![b'\n'; 1_000_000], "nothing but blanks"),
        (vec![b'#'; 1_000_000], "nothing but blanks"),
        (b"VP ".repeat(300_000), "expected the width"),
        (b"#\n".repeat(300_000), "nothing but blanks"),
        (
            [
                b"VP 1 1 1 BG 0 0 0 OBJ_N 4294967295 ".to_vec(),
                b"S 0 0 5 1 1 2 3\n".repeat(50_000),
            ]
            .concat(),
            "the file ends after 50000",
        ),
        (
            [
                b"VP 1 1 1 BG 0 0 0 OBJ_N 7 ".to_vec(),
                b"S 0 0 5 1 1 2 3\n".repeat(50_000),
            ]
            .concat(),
            "another one follows",
        ),
        (
            [
                b"VP 1 1 1 BG 0 0 0 OBJ_N 50000 ".to_vec(),
                b"S 0 0 5 1 1 2 3\n".repeat(49_999),
                b"S 0 0 5 1 1 2 3x".to_vec(),
            ]
            .concat(),
            "of sphere 50000",
        ),
    ];
    assert!(scenes.len() >= 100);
    let shop = workshop();
    for (scene, word) in scenes {
        shop.write("bad.txt", &scene);
        let ran = shop.run("bad.txt image.ppm 64 48");
        assert_clear(&ran, 1, word);
        assert!(ran.stderr.starts_with("sfera: bad.txt:"), "{}", ran.stderr);
        assert_eq!(shop.names(), ["bad.txt", "balls.txt", "image.ppm"]);
        assert!(shop.read("bad.txt") == scene && shop.read("image.ppm") == OLD);
    }
}

#[test]
fn command_lines() {
    let shop = workshop();
    shop.write("-", b"not standard output");
    fs::create_dir(shop.path("folder")).expect("a folder");
    symlink("turn", shop.path("turn")).expect("a link to itself");
    let _socket = UnixListener::bind(shop.path("socket")).expect("a socket");
    let names = shop.names();
    let long = "x".repeat(300);
    let deep = "name/".repeat(300);
    let lines: Vec<(Vec<&[u8]>, i32, &str)> = [
        ("balls.txt image.ppm 64 48\n", 2, "HEIGHT"),
        ("balls.txt image.ppm +64 -48", 2, "-48"),
        ("balls.txt image.ppm 64 4_8", 2, "4_8"),
        ("balls.txt image.ppm 64 \u{664}\u{668}", 2, "HEIGHT"),
        ("balls.txt image.ppm \x1b[31m 48", 2, "WIDTH"),
        (
            "balls.txt image.ppm 64 18446744073709551616",
            2,
            "at most 4294967295",
        ),
        ("balls.txt image.ppm 4294967296 1", 2, "at most 4294967295"),
        ("balls.txt image.ppm 3037000500 3037000500", 2, "more bytes"),
        (
            "balls.txt image.ppm 4294967295 4294967295 --method reference",
            2,
            "more bytes",
        ),
        ("balls.txt image.ppm 64 48 --rows 0..4294967296", 2, "A..B"),
        ("balls.txt image.ppm 64 48 --rows 0..=47", 2, "A..B"),
        ("balls.txt image.ppm 64 48 --rows ..", 2, "A..B"),
        ("balls.txt image.ppm 64 48 --rows 0...5", 2, "A..B"),
        (
            "balls.txt image.ppm 64 48 --rows 4294967294..4294967295",
            2,
            "rows 0..48",
        ),
        ("balls.txt image.ppm 64 48 --threads -1", 2, "-1"),
        ("balls.txt image.ppm 64 48 --threads 65536", 2, "1..=1024"),
        ("balls.txt image.ppm 64 48 --threads 1e2", 2, "1e2"),
        ("balls.txt image.ppm 64 48 --method=", 2, "textbook"),
        ("balls.txt image.ppm 64 48 --method EXACT", 2, "exact"),
        (
            "balls.txt image.ppm 64 48 --method exact --method exact",
            2,
            "--method",
        ),
        ("balls.txt image.ppm 64 48 --stats=", 2, "json"),
        ("balls.txt image.ppm 64 48 -- --quiet", 2, "--quiet"),
        ("balls.txt image.ppm 64 48 --quiet=yes", 2, "--quiet"),
        ("balls.txt image.ppm 64 48 -q", 2, "-q"),
        ("--width 64 balls.txt image.ppm 48", 2, "--width"),
        ("image.ppm balls.txt 64 48", 1, "image.ppm:1:1"),
        ("balls.txt balls.txt 64 48", 1, "balls.txt"),
        ("balls.txt ./folder/../balls.txt 64 48", 1, "balls.txt"),
        ("missing.txt image.ppm 64 48", 1, "spelling"),
        ("folder image.ppm 64 48", 1, "folder"),
        ("turn image.ppm 64 48", 1, "turn"),
        ("socket image.ppm 64 48", 1, "socket"),
        ("balls.txt/ image.ppm 64 48", 1, "balls.txt/"),
        ("/proc/self/mem image.ppm 64 48", 1, "/proc/self/mem"),
        ("/dev/null image.ppm 64 48", 1, "empty"),
        ("- image.ppm 64 48", 1, "expected VP"),
        ("balls.txt folder 64 48", 1, "folder"),
        ("balls.txt turn 64 48", 1, "turn"),
        ("balls.txt socket 64 48", 1, "socket"),
        ("balls.txt image.ppm/ 64 48", 1, "image.ppm/"),
        ("balls.txt image.ppm/x 64 48", 1, "image.ppm/x"),
        ("balls.txt missing/x.ppm 64 48", 1, "missing/x.ppm"),
        ("balls.txt /proc/x.ppm 64 48", 1, "/proc/x.ppm"),
        (
            "balls.txt image.ppm 64 48 --rows 0..4",
            1,
            "not a 64 x 48 picture",
        ),
        ("balls.txt image.ppm 64 48 --verify", 1, "not a binary PPM"),
        ("balls.txt missing.ppm 64 48 --verify", 1, "missing.ppm"),
        ("balls.txt folder 64 48 --verify", 1, "folder"),
        ("balls.txt folder 64 48 --compare", 1, "folder"),
        (
            "balls.txt x.ppm 64 48 --method double --diff folder",
            1,
            "folder",
        ),
        (
            "balls.txt x.ppm 64 48 --method double --diff balls.txt",
            1,
            "balls.txt",
        ),
    ]
    .into_iter()
    .map(|(line, code, word)| (line.split(' ').map(str::as_bytes).collect(), code, word))
    .chain([
        (
            vec![b"".as_slice(), b"image.ppm", b"64", b"48"],
            2,
            "<SCENE>",
        ),
        (
            vec![b"balls.txt".as_slice(), b"", b"64", b"48"],
            2,
            "<IMAGE>",
        ),
        (
            vec![b"\xff\xfe".as_slice(), b"image.ppm", b"64", b"48"],
            1,
            "\\xff\\xfe",
        ),
        (
            vec![b"a\nb\x1b[2J".as_slice(), b"image.ppm", b"64", b"48"],
            1,
            "\\x1b[2J",
        ),
        (
            vec![b"balls.txt".as_slice(), b"\x1b[2J\n/x.ppm", b"64", b"48"],
            1,
            "\\x1b[2J",
        ),
        (
            vec![b"balls.txt".as_slice(), b"image.ppm", b"\xff", b"48"],
            2,
            "",
        ),
        (
            vec![b"balls.txt".as_slice(), long.as_bytes(), b"64", b"48"],
            1,
            "name too long",
        ),
        (
            vec![long.as_bytes(), b"image.ppm", b"64", b"48"],
            1,
            "name too long",
        ),
        (
            vec![deep.as_bytes(), b"image.ppm", b"64", b"48"],
            1,
            "name/name",
        ),
    ])
    .collect();
    for (arguments, code, word) in lines {
        let ran = Ran::of(
            shop.sfera("")
                .args(arguments.iter().map(|argument| OsStr::from_bytes(argument))),
        );
        assert_clear(&ran, code, word);
        assert_eq!(shop.names(), names);
        assert_eq!(shop.read("image.ppm"), OLD);
        assert_eq!(shop.read("balls.txt"), program::BALLS.as_bytes());
        assert_eq!(shop.read("-"), b"not standard output");
    }
}
