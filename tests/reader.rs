//! Which texts are scenes, and which messages the others give.

use std::{
    fs,
    io::Write as _,
    path::{Path, PathBuf},
};

use proptest::prelude::*;
use sfera::{
    scene::{Scene, SceneError, SceneErrorKind, Viewport},
    spheres::Sphere,
    testing::{Sizes, families::cloud, parse_in_windows},
};

const BAD: &str = "scenes/bad";

/// The messages for all files of `scenes/bad`, sorted, a blank line between two.
const MESSAGES: &str = "scenes/bad/messages";

fn bad_files() -> Vec<PathBuf> {
    let entries = fs::read_dir(BAD).expect(BAD);
    let paths = entries.map(|entry| entry.expect(BAD).path());
    let mut paths: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "txt"))
        .collect();
    paths.sort();
    paths
}

fn refusal(path: &Path) -> SceneError {
    match Scene::read(path) {
        Ok(_) => panic!("{} is taken", path.display()),
        Err(error) => error,
    }
}

fn refusal_of(text: &[u8]) -> SceneError {
    Scene::parse(text).expect_err("a text that is no scene")
}

#[test]
fn every_bad_file_is_refused_with_its_message() {
    let pinned = fs::read_to_string(MESSAGES).expect(MESSAGES);
    let mut pinned = pinned.trim_end().split("\n\n");
    let files = bad_files();
    assert!(files.len() >= 130, "{} files", files.len());
    for path in files {
        let message = refusal(&path).to_string();
        assert_eq!(
            pinned.next(),
            Some(&*message),
            "{}: if the new message is better, see pin_messages",
            path.display()
        );
    }
    assert_eq!(pinned.next(), None, "a message of no file");
}

/// Writes the pinned messages: `cargo test --test reader -- --ignored pin_messages`. Then
/// read the difference.
#[test]
#[ignore = "overwrites the pinned messages"]
fn pin_messages() {
    let messages: Vec<String> = bad_files()
        .iter()
        .map(|path| refusal(path).to_string())
        .collect();
    fs::write(MESSAGES, messages.join("\n\n") + "\n").expect(MESSAGES);
}

#[test]
fn a_message_is_printable_and_its_caret_stands_where_the_column_says() {
    for path in bad_files() {
        let error = refusal(&path);
        let message = error.to_string();
        assert!(
            message
                .chars()
                .all(|character| character == '\n' || !character.is_control()),
            "{message}"
        );
        assert_eq!(error.path(), Some(&*path));
        let (line, column) = (
            error.line().expect("a line"),
            error.column().expect("a column"),
        );
        let place = format!("{}:{line}:{column}: ", path.display());
        assert!(message.starts_with(&place), "{message}");

        let bytes = fs::read(&path).expect("the file");
        let text = bytes.split(|&byte| byte == b'\n').nth(line as usize - 1);
        let before = &text.expect("the line")[..column as usize - 1];
        let lines: Vec<&str> = message.lines().collect();
        let Some(caret) = lines.get(2).and_then(|line| line.find('^')) else {
            assert!(matches!(error.kind(), SceneErrorKind::Empty), "{message}");
            continue;
        };
        let begin = lines[1].find("| ").expect("a bar") + 2;
        let shown = &lines[1][begin..caret.min(lines[1].len())];
        let mut before = String::from_utf8_lossy(before).replace('\t', " ");
        for control in ['\r', '\x0b', '\x0c'] {
            before = before.replace(control, &format!("\\x{:02x}", u32::from(control)));
        }
        match shown.strip_prefix("...") {
            Some(shown) => assert!(before.ends_with(shown), "{message}"),
            None => assert_eq!(shown, before, "{message}"),
        }
    }
}

#[test]
fn the_same_bytes_in_memory_give_the_same_place_and_no_path() {
    for path in bad_files() {
        let from_file = refusal(&path);
        let from_memory = refusal_of(&fs::read(&path).expect("the file"));
        assert_eq!(from_memory.path(), None);
        assert_eq!(from_memory.line(), from_file.line());
        assert_eq!(from_memory.column(), from_file.column());
        let (file, memory) = (from_file.to_string(), from_memory.to_string());
        let place = |line, column| format!("line {line}, column {column}: ");
        let place = place(
            from_file.line().unwrap_or(0),
            from_file.column().unwrap_or(0),
        );
        assert!(memory.starts_with(&place), "{memory}");
        assert_eq!(
            memory[place.len()..],
            file[file.find(": ").expect("a colon") + 2..]
        );
    }
}

/// The whole scene, floats by their bits.
fn bits(scene: &Scene) -> Vec<u32> {
    let viewport = scene.viewport();
    let lengths = [viewport.width(), viewport.height(), viewport.distance()];
    let mut bits: Vec<u32> = lengths.map(f32::to_bits).into();
    bits.extend(scene.background().map(u32::from));
    for sphere in scene.spheres().iter() {
        let [x, y, z] = sphere.centre();
        bits.extend([x, y, z, sphere.radius()].map(f32::to_bits));
        bits.extend(sphere.colour().map(u32::from));
    }
    bits
}

#[test]
fn the_same_scene_in_many_shapes() {
    let plain = "VP 1.5 1 2\nBG 1 2 3\nOBJ_N 2\nS 0.5 -1 40 0.25 10 20 30\nS 1 2 3 4 5 6 7\n";
    let expected = bits(&Scene::parse(plain.as_bytes()).expect("a scene"));
    let shapes = [
        plain.trim_end().to_owned(),
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace('\n', " "),
        plain.replace(' ', "\n"),
        plain.replace(' ', "\t\x0b\x0c "),
        plain.replace('\n', "\n\n  \n"),
        plain.replace('\n', "# S 1 2 3\n"),
        plain.replace(' ', " # comment # comment\r\n"),
        plain.replace('\n', " # caf\u{e9} \u{7403} \u{202e}\n"),
        format!("\n\n# head\n  {plain}# tail without a line end"),
        "VP +1.5 1. 2.0 BG +1 02 003 OBJ_N 2\nS .5 -1e0 4E+1 25e-2 10 20 30 S 1 2 3 4 5 6 7".into(),
        "VP 15e-1 0.1e1 0.02e2 BG 1 2 3 OBJ_N +2 S 0.50000000000000000000000000000 -1 40 0.25 10 20 30 S 1 2 3 4 5 6 7 "
            .into(),
    ];
    for shape in shapes {
        let scene = Scene::parse(shape.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(bits(&scene), expected, "{shape:?}");
    }
    let invalid_in_comment = [b"#\xff\0\x1b\n", plain.as_bytes()].concat();
    assert!(Scene::parse(&invalid_in_comment).is_ok());
}

#[test]
fn a_byte_order_mark_at_the_very_beginning_is_skipped() {
    let mark = "\u{feff}";
    let plain = "VP 1.5 1 2\nBG 1 2 3\nOBJ_N 1\nS 0.5 -1 40 0.25 10 20 30\n";
    let expected = bits(&Scene::parse(plain.as_bytes()).expect("a scene"));
    let marked = format!("{mark}{plain}");
    for first in [1, 2, 3, 4, 5, 1000] {
        let sizes = Sizes {
            first,
            window: 1,
            ..Sizes::USUAL
        };
        let scene = parse_in_windows(marked.as_bytes(), sizes).expect("a scene");
        assert_eq!(bits(&scene), expected, "{first}");
    }
    // Places are those that an editor shows.
    let wrong = refusal_of(marked.replace("VP 1.5", "VP x").as_bytes());
    assert_eq!((wrong.line(), wrong.column()), (Some(1), Some(4)));
    let message = wrong.to_string();
    assert!(message.contains("\n 1 | VP x 1 2\n   |    ^"), "{message}");
    assert!(matches!(
        refusal_of(mark.as_bytes()).kind(),
        SceneErrorKind::Empty
    ));
}

/// The advice on common mistakes of programs, and that the reader takes what it advises.
#[test]
fn advice_says_what_to_write_and_the_reader_accepts_it() {
    for (written, advised) in [
        ("S -7.-1. 9 0.25 0 0 255", "-7. -1."),
        ("S 1-2+3 0.25 0 0 255", "1 -2 +3"),
        (
            "S -10.123-204.567-12.5 0.25 0 0 255",
            "-10.123 -204.567 -12.5",
        ),
        ("S 1e-5-2e+5 7 0.25 0 0 255", "1e-5 -2e+5"),
        ("S 0.123-103 0 0.25 0 0 255", "0.123 -103"),
        ("S 0.123-103 0 7 0.25 0 0 255", "0.123e-103"),
        ("S np.float64(0.1) 0 7 0.25 0 0 255", "0.1"),
        ("S 1 0 7 np.float32(2.5e-1) 0 0 255", "2.5e-1"),
        ("S 1 0 7 Decimal('0.25') 0 0 255", "0.25"),
        ("S 1 0 7 0.25 np.uint8(17) 0 255", "17"),
        ("S 1.5*^-7 0 7 0.25 0 0 255", "1.5e-7"),
        ("S -2*10^3 0 7 0.25 0 0 255", "-2e3"),
        ("S 1D2 0 7 0.25 0 0 255", "1e2"),
        ("S 1 0 7 -0.25 0 0 255", "0.25"),
        ("S 1 0 7 0.25 #0a10fF\n", "10 16 255"),
        ("S 1 0 7 0.25 #0a10ff80\n", "10 16 255"),
        ("S 1 0 7 0.25 #fC0 # yellow\n", "255 204 0"),
        ("S 1 0,5 7 0.25 0 0 255", "0.5"),
    ] {
        let scene = |sphere: &str| format!("VP 1 1 1 BG 0 0 0 OBJ_N 2 {sphere} S 0 0 3 1 9 9 9\n");
        let message = refusal_of(scene(written).as_bytes()).to_string();
        let help = message.split("help: ").nth(1).unwrap_or_default();
        assert!(help.contains(advised), "{written}: {message}");
        let wrong = written
            .split_whitespace()
            .skip(1)
            .find(|word| !word.parse::<f32>().is_ok_and(|number| number >= 0.0))
            .expect("a wrong word");
        let mended = written.replace(wrong, advised);
        assert!(
            Scene::parse(scene(&mended).as_bytes()).is_ok(),
            "{mended} after: {message}"
        );
    }
}

/// Found by fuzzing: a message depended on where the text was cut.
#[test]
fn advice_does_not_depend_on_windows() {
    let long = format!("VP 1 1 -1.#IND00{}", "x".repeat(120));
    for text in [
        &*long,
        "VP 1 1 -1.#IND00 \n BG 0 0 0 OBJ_N 0",
        "VP 1 1.#INF \n BG 0 0 0 OBJ_N 0",
        "VP 1 1 1 BG #ff0000 \n OBJ_N 0",
        "x1.#INF \n",
    ] {
        let expected = refusal_of(text.as_bytes()).to_string();
        assert_eq!(
            expected.contains("a # begins a comment"),
            text.starts_with("VP"),
            "{expected}"
        );
        for first in 1..90 {
            let sizes = Sizes {
                first,
                window: 1 + first % 5,
                ..Sizes::USUAL
            };
            let error = parse_in_windows(text.as_bytes(), sizes).expect_err(text);
            assert_eq!(error.to_string(), expected, "{sizes:?}");
        }
    }
}

#[test]
fn a_comment_that_is_meant_as_one_gets_no_advice_on_colours() {
    for (sphere, wanted) in [
        ("S 1 0 7 0.25 # bad\n", "only 4 of its 7 numbers"),
        ("S 1 0 7 #bad\n", "only 3 of its 7 numbers"),
        ("S 1 0 7 0.25 #blue\n", "only 4 of its 7 numbers"),
        ("S 1.#x\n", "only 1 of its 7 numbers"),
        ("S 1 #fff\n 2 3 4 5 6\n", "only 6 of its 7 numbers"),
    ] {
        let scene = format!("VP 1 1 1 BG 0 0 0 OBJ_N 2 {sphere} S 0 0 3 1 9 9 9\n");
        let message = refusal_of(scene.as_bytes()).to_string();
        assert!(message.contains(wanted), "{message}");
        assert!(
            message.contains("what follows a # is a comment"),
            "{message}"
        );
    }
    // Of the item that is wrong, not of one before it.
    let message = refusal_of(b"VP 1 #x\n1 1 BG 0 0 0 OBJ_N 1 S 1 2").to_string();
    assert!(message.ends_with("red green blue"), "{message}");
}

#[test]
fn the_example_and_a_scene_of_nothing() {
    let example = Scene::read("scenes/example.txt").expect("the example");
    assert_eq!(example.spheres().len(), 16);
    assert_eq!(example.background(), [255; 3]);
    assert_eq!(example.viewport().width().to_bits(), 1.777_f32.to_bits());
    let last = Sphere::new([-100.0, 0.0, 10_000.0], 3_000.0, [255, 255, 0]);
    assert_eq!(Ok(example.spheres().get(15)), last);

    let nothing = Scene::parse(b"VP 1 1 1 BG 0 0 0 OBJ_N 0").expect("a scene");
    assert!(nothing.spheres().is_empty());
}

#[test]
fn a_scene_of_many_windows_in_any_pool() {
    let scene = cloud(200_000, 3);
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    scene.write_text(&mut file).expect("a full disk?");
    let expected = bits(&scene);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        let read = pool.install(|| Scene::read(file.path())).expect("a scene");
        assert!(bits(&read) == expected, "{threads} threads");
        let far = |sphere: &Sphere| sphere.centre()[2] > 3.0;
        let kept = pool
            .install(|| Scene::read_kept(file.path(), |_| far))
            .expect("a scene");
        let expected: Vec<Sphere> = scene.spheres().iter().filter(far).collect();
        assert!(kept.spheres().iter().eq(expected), "{threads} threads");
    }
}

#[test]
fn a_filter_is_made_for_the_viewport_and_sees_only_what_is_checked() {
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    file.write_all(b"VP 4 3 2 BG 0 0 0 OBJ_N 2 S 0 0 9 1 0 0 0 S 0 0 9 0 0 0 0")
        .expect("a full disk?");
    let mut seen = None;
    let read = Scene::read_kept(file.path(), |viewport| {
        seen = Some(viewport);
        |_: &Sphere| false
    });
    let error = read.expect_err("the second radius is 0");
    assert!(matches!(error.kind(), SceneErrorKind::NotPositive));
    let viewport = seen.expect("a viewport");
    assert_eq!(
        (viewport.width(), viewport.height(), viewport.distance()),
        (4.0, 3.0, 2.0)
    );
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("missing.txt");
    for path in [missing.as_path(), folder.path()] {
        let error = refusal(path);
        assert!(matches!(error.kind(), SceneErrorKind::Read(_)));
        assert_eq!((error.line(), error.column()), (None, None));
        let message = error.to_string();
        let begin = format!("{}: can't read the scene: ", path.display());
        assert!(message.starts_with(&begin), "{message}");
        assert!(message.contains("\nhelp: "), "{message}");
    }
    let nasty = folder.path().join("a\u{1b}[31m\n.txt");
    assert!(!refusal(&nasty).to_string().contains('\u{1b}'));
}

#[cfg(unix)]
#[test]
fn a_pipe_is_a_scene_file_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo").success());
    let scene = cloud(30_000, 5);
    let text = scene.to_string();
    let writer = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::write(pipe, text)
    });
    let read = Scene::read(&pipe).expect("a scene");
    writer.join().expect("no panic").expect("a reader");
    assert!(bits(&read) == bits(&scene));
}

#[test]
fn a_file_that_is_cut_while_it_is_read_is_a_scene_or_an_error() {
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    let scene = cloud(100_000, 5);
    scene.write_text(&mut file).expect("a full disk?");
    let full = file.as_file().metadata().expect("a size").len();
    let handle = file.as_file().try_clone().expect("a handle");
    let cutter = std::thread::spawn(move || {
        for step in 0..200 {
            handle
                .set_len(full * (step * 37 % 100) / 100)
                .expect("a file");
            std::thread::yield_now();
        }
    });
    while !cutter.is_finished() {
        match Scene::read(file.path()) {
            Ok(read) => assert_eq!(read.spheres().len(), 100_000),
            Err(error) => assert!(error.line().is_some(), "{error}"),
        }
    }
    cutter.join().expect("no panic");
}

#[test]
fn long_lines_are_shown_in_part_with_the_right_place() {
    let spheres = "S 0 0 5 1 9 9 9 ".repeat(400_000);
    let text = format!("VP 1 1 1 BG 0 0 0 OBJ_N 400001 {spheres}S 0 0 5 1 9 9 900");
    let error = refusal_of(text.as_bytes());
    assert_eq!(error.line(), Some(1));
    assert_eq!(error.column(), Some(text.len() as u64 - 2));
    let message = error.to_string();
    assert!(message.len() < 400, "{message}");
    assert!(message.contains("1 | ... 9 9 9 S 0 0"), "{message}");
    assert!(message.contains("of sphere 400001"), "{message}");

    // The same with all on lines of their own, and line numbers.
    let text = text.replace(" S", "\nS");
    let error = refusal_of(text.as_bytes());
    assert_eq!((error.line(), error.column()), (Some(400_002), Some(15)));
}

/// A long line that is cut at a carriage return is shown as cut, and advice quotes only
/// short words.
#[test]
fn long_lines_and_words_are_shortened_in_messages() {
    let returns = format!("X{}1", "\r".repeat(90));
    let message = refusal_of(returns.as_bytes()).to_string();
    assert!(message.contains("\\x0d...\n"), "{message}");
    assert!(message.len() < 800, "{message}");

    let negative = format!("VP -{} 1 1", "1".repeat(38) + ".000");
    let message = refusal_of(negative.as_bytes()).to_string();
    assert!(
        message.ends_with("help: write it without the sign"),
        "{message}"
    );

    let digits = "1".repeat((1 << 16) + 1);
    for (scene, expected) in [
        (format!("VP {digits}"), "the width of the viewport"),
        (
            format!("VP 1 1 1 BG 0 0 0 OBJ_N 0 {digits}"),
            "the end of the file after OBJ_N 0",
        ),
    ] {
        let error = refusal_of(scene.as_bytes());
        assert!(matches!(error.kind(), SceneErrorKind::WordTooLong));
        let message = error.to_string();
        let begin = format!("expected {expected}");
        assert!(message.contains(&begin), "{message}");
        let found = format!(
            "found a word of more than 65536 bytes, \"{}...\"",
            &digits[..40]
        );
        assert!(message.contains(&found), "{message}");
        assert!(
            message.ends_with("help: no word of a scene needs more bytes than that"),
            "{message}"
        );
    }

    let comma = format!("VP 1 1,{} 1", "0".repeat(60_000));
    let message = refusal_of(comma.as_bytes()).to_string();
    assert!(
        message.contains("a point instead of the comma"),
        "{message}"
    );
    assert!(message.len() < 800, "{message}");
}

#[test]
fn hostile_sizes_are_refused_without_the_memory_they_claim() {
    let claims = b"VP 1 1 1 BG 0 0 0 OBJ_N 4294967295\nS 0 0 5 1 9 9 9\n";
    let error = refusal_of(claims);
    assert!(matches!(error.kind(), SceneErrorKind::TooFewSpheres));

    let junk = [b'a', b'0', 0, b'\r', 0xff];
    for byte in junk {
        let mut text = b"VP ".to_vec();
        text.resize(30_000_000, byte);
        let error = refusal_of(&text);
        assert!(error.to_string().len() < 800, "{error}");
        assert_eq!(error.line(), Some(1));
    }
    let comment = [b"#".as_slice(), &vec![b'x'; 30_000_000]].concat();
    assert!(matches!(refusal_of(&comment).kind(), SceneErrorKind::Empty));
}

fn any_float() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(|bits| {
        let float = f32::from_bits(bits);
        if float.is_finite() { float } else { 1.5 }
    })
}

fn any_length() -> impl Strategy<Value = f32> {
    any_float().prop_map(|float| if float == 0.0 { 1.0 } else { float.abs() })
}

proptest! {
    #[test]
    fn a_scene_written_and_read_is_the_same(
        viewport in [any_length(), any_length(), any_length()],
        background in any::<[u8; 3]>(),
        spheres in prop::collection::vec(
            ([any_float(), any_float(), any_float()], any_length(), any::<[u8; 3]>()),
            0..40,
        ),
    ) {
        let [width, height, distance] = viewport;
        let viewport = Viewport::new(width, height, distance).expect("a viewport");
        let spheres = spheres.into_iter().map(|(centre, radius, colour)| {
            Sphere::new(centre, radius, colour).expect("a sphere")
        });
        let scene = Scene::new(viewport, background, spheres).expect("a scene");
        let read: Scene = scene.to_string().parse().expect("a scene");
        prop_assert_eq!(bits(&read), bits(&scene));
    }

    #[test]
    fn no_bytes_cause_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        if let Err(error) = Scene::parse(&bytes) {
            prop_assert!(error.to_string().chars().all(|c| c == '\n' || !c.is_control()));
        }
    }
}
