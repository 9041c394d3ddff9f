//! Windows and chunks of any size give the same results as the parser alone.

use std::{
    fmt::Write,
    io::{self, Read},
};

use proptest::prelude::*;

use super::{
    super::{excerpt::Excerpt, text::MAX_WORD, windows::Sizes},
    read,
};
use crate::{spheres::Sphere, testing::families::cloud};

/// The parser alone, on the whole text at once.
const PARSER_ALONE: Sizes = Sizes {
    first: usize::MAX >> 1,
    window: 1,
    chunk: 1,
    parallel: usize::MAX,
    fast: usize::MAX,
};

/// A source that gives a few bytes at a time, as a pipe can, and is interrupted between.
struct Trickle<'a> {
    text: &'a [u8],
    at_most: usize,
    interrupted: bool,
}

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.interrupted = !self.interrupted;
        if self.interrupted {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let at_most = self.at_most.min(buffer.len());
        self.text.read(&mut buffer[..at_most])
    }
}

/// The scene or the message that the reader gives for a text.
fn outcome(text: &[u8], sizes: Sizes, at_most: usize) -> Result<String, String> {
    // The first window is allocated, so that it must not be much larger than the text.
    let sizes = Sizes {
        first: sizes.first.min(text.len() + 1),
        ..sizes
    };
    let source = &mut Trickle {
        text,
        at_most,
        interrupted: false,
    };
    let size = Some(text.len() as u64);
    let scene = read(source, size, sizes, |_| |_: &Sphere| true).map_err(|error| {
        let kind = format!("{:?}", error.kind());
        format!("{:?} {:?} {kind}\n{error}", error.line(), error.column())
    })?;
    Ok(format!("{scene:?}"))
}

fn agree(text: &[u8], sizes: Sizes, at_most: usize) {
    let expected = outcome(text, PARSER_ALONE, usize::MAX);
    let found = outcome(text, sizes, at_most);
    assert_eq!(found, expected, "{sizes:?} {}", text.escape_ascii());
}

const TINY: Sizes = Sizes {
    first: 64,
    window: 160,
    chunk: 48,
    parallel: 1,
    fast: 1,
};

/// A text with indents, broken lines, comments, CRLF and exponents; from the sixth seed
/// on, as the scene writes it.
fn varied(seed: u64) -> Vec<u8> {
    let scene = cloud(12, seed);
    if seed >= 6 {
        return scene.to_string().into_bytes();
    }
    let mut text = String::from("# A scene.\nVP 1 1\t1\r\nBG 0 1 2 OBJ_N 12 # S\n");
    for (index, sphere) in scene.spheres.iter().enumerate() {
        let [x, y, z] = sphere.centre;
        let (radius, [red, green, blue]) = (sphere.radius, sphere.colour);
        let _ = match (index as u64 + seed) % 6 {
            0 => writeln!(text, "\tS {x:e} {y} {z} {radius:e} {red} {green} {blue}"),
            1 => write!(text, "S\n{x}\n{y}\n{z} {radius}\n{red} {green} {blue}\n\n"),
            2 => write!(text, "S {x} {y} {z} {radius} {red} {green} {blue} "),
            3 => write!(
                text,
                "\x0bS {x} {y} {z} {radius} {red} {green} {blue}#S 1\r\n"
            ),
            4 => writeln!(
                text,
                "S {x:+} {y} {z}   {radius} # S S\n 0{red} {green} {blue}"
            ),
            _ => writeln!(text, "S {x} {y} {z} {radius} {red} {green} {blue}"),
        };
    }
    text.into_bytes()
}

#[test]
fn windows_of_every_size() {
    for seed in 0..7 {
        let text = varied(seed);
        assert!(outcome(&text, PARSER_ALONE, usize::MAX).is_ok());
        let cut_short = &text[..text.len() - 20];
        for size in 1..text.len() + 2 {
            let sizes = Sizes {
                first: size,
                window: size,
                chunk: size.div_ceil(3),
                ..TINY
            };
            agree(&text, sizes, usize::MAX);
            agree(cut_short, sizes, 1 + size / 2);
        }
    }
}

/// Ordinary spheres, and the blanks and comments behind them, that end at every place of the
/// 64 bytes that are read at a time.
#[test]
fn spheres_and_gaps_of_every_length() {
    for width in 1..60 {
        for gap in 1..20 {
            let gap = " ".repeat(gap);
            let mut text = String::from("VP 1 1 1 BG 0 0 0 OBJ_N 6\n");
            for behind in ["", "\r\n", "#S\n", "\n", "# S 1\n\n", ""] {
                let _ = write!(text, "S {:<width$} 0 5 1 9 9 9{gap}{behind}", 0.5);
            }
            text.push_str(&"\n".repeat(100));
            assert!(outcome(text.as_bytes(), PARSER_ALONE, usize::MAX).is_ok());
            agree(
                text.as_bytes(),
                Sizes {
                    fast: 1,
                    ..PARSER_ALONE
                },
                usize::MAX,
            );
        }
    }
}

/// Pieces of scenes, and what scenes must not have.
const PIECES: [&[u8]; 30] = [
    b" ",
    b"\n",
    b"\r\n",
    b"\r",
    b"\t",
    b"#",
    b"# S",
    b"S",
    b"S ",
    b"\nS ",
    b"VP",
    b"-",
    b"+",
    b".",
    b"e",
    b"0",
    b"9",
    b",",
    b"256",
    b"1e39",
    b"1e-60",
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\n#\n",
    b"S 0 0 5 1 1 2 3\n",
    b"S 0 0 5 0 1 2 3\n",
    b"0.000000000000000000000000001",
    b"                                                                                     ",
    b"##################################################################################",
];

fn edited(mut text: Vec<u8>, edits: &[(usize, usize, usize)]) -> Vec<u8> {
    for &(place, piece, removed) in edits {
        let place = place % (text.len() + 1);
        let end = (place + removed).min(text.len());
        let piece = PIECES.get(piece).copied().unwrap_or_default();
        text.splice(place..end, piece.iter().copied());
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6_000))]

    #[test]
    fn a_damaged_text_gives_the_same_in_windows_as_to_the_parser(
        seed in 0_u64..12,
        edits in prop::collection::vec((any::<usize>(), 0..2 * PIECES.len(), 0_usize..4), 0..4),
        first in 1_usize..200,
        window in 1_usize..1_000,
        chunk in 1_usize..600,
        parallel in 1_usize..300,
        at_most in 1_usize..100,
    ) {
        let text = edited(varied(seed), &edits);
        agree(&text, Sizes { first, window, chunk, parallel, fast: 1 }, at_most);
    }

    #[test]
    fn a_filter_drops_spheres_and_keeps_the_order(
        seed in any::<u64>(),
        count in 0_usize..60,
        some in 1_u8..8,
        window in 1_usize..4_000,
        chunk in 1_usize..1_000,
    ) {
        let scene = cloud(count, seed);
        let text = scene.to_string();
        let keep = |sphere: &Sphere| !sphere.colour[0].is_multiple_of(some);
        let sizes = Sizes { window, chunk, ..TINY };
        let kept = read(&mut text.as_bytes(), None, sizes, |_| keep).expect("a scene");
        let expected: Vec<Sphere> = scene.spheres.iter().filter(keep).collect();
        let found: Vec<Sphere> = kept.spheres.iter().collect();
        prop_assert_eq!(&found, &expected);
        let again: crate::spheres::Spheres = expected.into_iter().collect();
        prop_assert_eq!(format!("{again:?}"), format!("{:?}", kept.spheres));
    }
}

/// The formats of both kinds of numbers are read in several ways; none takes what the
/// parser refuses.
#[test]
fn a_radius_of_nothing_is_refused_in_every_sphere() {
    for wrong in 0..12 {
        for radius in ["0", "-1", "-0.0", "0e9"] {
            let mut text = String::from("VP 1 1 1 BG 0 0 0 OBJ_N 12\n");
            for index in 0..12 {
                let radius = if index == wrong { radius } else { "0.5" };
                let _ = writeln!(text, "S 0.25 -1.5 7 {radius} 1 2 {index}");
            }
            // Chunks that hold one sphere, and one that holds all.
            for chunk in [TINY.chunk, 1000] {
                let sizes = Sizes {
                    window: chunk,
                    chunk,
                    ..TINY
                };
                agree(text.as_bytes(), sizes, usize::MAX);
                let error = outcome(text.as_bytes(), sizes, usize::MAX).expect_err(radius);
                assert!(error.contains("the radius of sphere"), "{error}");
            }
        }
    }
}

#[test]
fn damage_anywhere_in_a_text_of_many_chunks() {
    let sizes = Sizes {
        first: 1 << 8,
        window: 1 << 14,
        chunk: 1 << 10,
        parallel: 1 << 11,
        fast: 1,
    };
    let text = cloud(3_000, 7).to_string().into_bytes();
    agree(&text, sizes, usize::MAX);
    for trial in 0..60_usize {
        // On any word size some place far from the one before.
        let place = (trial as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) as usize;
        let second = place.rotate_left(17);
        agree(
            &edited(text.clone(), &[(place, trial, trial % 3)]),
            sizes,
            usize::MAX,
        );
        agree(
            &edited(text.clone(), &[(place, trial, 1), (second, trial / 2, 1)]),
            sizes,
            usize::MAX,
        );
    }
}

#[test]
fn words_and_comments_longer_than_windows() {
    let zeros = "0".repeat(MAX_WORD - 2);
    let long = |word: &str| format!("VP 1 1 1 BG 0 0 0 OBJ_N 1 S {word} 0 5 1 0 0 0");
    let comment = "S#".repeat(100_000);
    let texts = [
        long(&format!("0.{zeros}")),
        long(&format!("1.{zeros}0")),
        long(&"9".repeat(300_000)),
        long(&format!("{}1 # {comment}\n", " ".repeat(300_000))),
        long(&format!("1#{comment}\n")),
        long(&format!("1#{comment}")),
        format!("{}{comment}", long("1 #")),
        format!("{}{comment}", long("1")),
        format!("{} {comment}", long("1")),
        format!("{}{}", long("1"), "\n".repeat(200_000)),
        format!("VP 1 1 1 BG 0 0 0 OBJ_N 2{}", "\n".repeat(200_000)),
        comment.clone(),
        format!("#{comment}"),
        "\0".repeat(200_000),
        format!("VP{}", "\n1".repeat(100_000)),
    ];
    for text in texts {
        for window in [777, 1 << 13, 1 << 17] {
            agree(
                text.as_bytes(),
                Sizes {
                    window,
                    chunk: 500,
                    ..TINY
                },
                usize::MAX,
            );
        }
    }
}

/// A source that notes how many bytes it is asked for.
struct Asked<'a> {
    text: &'a [u8],
    sizes: Vec<usize>,
}

impl Read for Asked<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.sizes.push(buffer.len());
        self.text.read(buffer)
    }
}

/// The next window is filled while the threads parse one.
#[test]
fn windows_grow_with_the_threads_once_they_are_parsed_by_several() {
    let text = cloud(400, 3).to_string();
    let pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    };
    for (parallel, threads, factor) in [(600, 3, 3), (600, 1, 1), (usize::MAX, 3, 1)] {
        let mut source = Asked {
            text: text.as_bytes(),
            sizes: Vec::new(),
        };
        let sizes = Sizes {
            first: 500,
            window: 1000,
            parallel,
            ..TINY
        };
        let scene = pool(threads)
            .install(|| read(&mut source, None, sizes, |_| |_: &Sphere| true))
            .expect("a scene");
        assert_eq!(scene.spheres.len(), 400);
        let (ends, windows) = source.sizes.split_at(3);
        assert_eq!(ends, [500, 1000, factor * 1000], "{threads} threads");
        // Less only at the end of the text.
        let whole = (text.len() - ends.iter().sum::<usize>()) / (factor * 1000);
        assert!(windows[..whole].iter().all(|&asked| asked == factor * 1000));
    }
}

/// A piece that the chunks can't read is read again word by word, so the filter is shown its
/// spheres twice.
#[test]
fn short_pieces_are_read_word_by_word_and_others_in_chunks() {
    use std::sync::atomic::{AtomicU32, Ordering};
    let piece = format!("{} s", " S 0 0 5 1 9 9 9".repeat(8));
    let text = format!("VP 1 1 1 BG 0 0 0 OBJ_N 9{piece}");
    for (fast, shown) in [(piece.len() + 1, 8), (piece.len(), 16)] {
        let count = AtomicU32::new(0);
        let filter = |_: &Sphere| {
            count.fetch_add(1, Ordering::Relaxed);
            true
        };
        let sizes = Sizes {
            first: text.len() + 1,
            fast,
            ..PARSER_ALONE
        };
        assert!(read(&mut text.as_bytes(), None, sizes, |_| filter).is_err());
        assert_eq!(count.into_inner(), shown);
    }
}

/// An excerpt begins with three points if it does not begin with the line.
#[test]
fn a_long_line_before_the_end_of_the_text_is_cut() {
    let header = "VP 1 1 1 BG 0 0 0 OBJ_N 9\n";
    for length in 65..85 {
        let line = format!("S{}1", " ".repeat(length - 2));
        let text = format!("{header}{line}");
        for window in [1, 7, 60, 80] {
            let sizes = Sizes {
                first: 27,
                window,
                ..TINY
            };
            let message = outcome(text.as_bytes(), sizes, usize::MAX).expect_err("half a sphere");
            let is_cut = length > Excerpt::REACH;
            assert_eq!(
                message.contains("| ..."),
                is_cut,
                "{length} {window} {message}"
            );
            agree(text.as_bytes(), sizes, usize::MAX);
        }
    }
}

/// Otherwise there would be room for up to twice as many.
#[test]
fn a_scene_of_known_size_takes_no_more_memory_than_its_spheres() {
    let text = cloud(1100, 5).to_string();
    let size = Some(text.len() as u64);
    let scene = read(&mut text.as_bytes(), size, TINY, |_| |_: &Sphere| true).expect("a scene");
    assert_eq!(scene.spheres.len(), 1100);
    assert_eq!(scene.spheres.capacity(), 1104);
}
