//! Which texts the chunks read. That they read them right is tested in `reader/tests.rs`.

use super::*;
use crate::testing::families::cloud;

const COUNT: usize = 20;

/// The text of spheres with `between` behind each of them.
fn spheres_with(between: &str) -> String {
    let scene = cloud(COUNT, 1).to_string();
    let lines: Vec<&str> = scene.lines().skip(3).collect();
    lines.join(between) + between
}

fn sizes(chunk: usize, parallel: usize) -> Sizes {
    Sizes {
        chunk,
        parallel,
        ..Sizes::USUAL
    }
}

/// What is read with chunks of this size, on one thread or on several.
fn read_in(text: &str, sizes: Sizes, max_spheres: u32) -> Option<(Read, Spheres)> {
    let mut spheres = Spheres::default();
    let read = read(text.as_bytes(), &mut spheres, max_spheres, sizes, &|_| true)?;
    Some((read, spheres))
}

#[test]
fn well_formed_spheres_are_read_whatever_is_between_them() {
    let expected: Vec<Sphere> = cloud(COUNT, 1).spheres.iter().collect();
    for between in [
        "\n",
        " ",
        "\r\n\t",
        "\n\n",
        " # S 1\n",
        "#S\n# S\n ",
        "\n \x0b\x0c",
    ] {
        let text = spheres_with(between);
        for chunk in [1, 100, 1000, 1 << 20] {
            for parallel in [0, usize::MAX] {
                let (read, spheres) = read_in(&text, sizes(chunk, parallel), COUNT as u32)
                    .unwrap_or_else(|| panic!("{between:?} in chunks of {chunk}"));
                assert_eq!(spheres.iter().collect::<Vec<_>>(), expected);
                assert_eq!(read.spheres, COUNT as u32);
                assert_eq!(read.line_feeds, text.matches('\n').count() as u64);
                assert!(!read.ends_in_comment);
            }
        }
    }
    let text = spheres_with("\n") + "# S";
    let (read, _) = read_in(&text, Sizes::USUAL, u32::MAX).expect("spheres");
    assert!(read.ends_in_comment);
    for (length, is_read) in [(MAX_WORD, true), (MAX_WORD + 1, false)] {
        let text = format!("S 0 0 {}5 1 9 9 9", "0".repeat(length - 1));
        let is_read_here = read_in(&text, Sizes::USUAL, u32::MAX).is_some();
        assert_eq!(is_read_here, is_read, "{length}");
    }
}

#[test]
fn what_is_not_spheres_alone_is_left_to_the_parser() {
    let text = spheres_with("\n");
    let damaged = text.replacen('S', "S S", 1);
    for text in [
        &damaged,
        &text[1..],
        &(text.clone() + "x"),
        &(text.clone() + "S"),
    ] {
        for parallel in [0, usize::MAX] {
            assert!(
                read_in(text, sizes(100, parallel), u32::MAX).is_none(),
                "{text}"
            );
        }
    }
    assert!(read_in(&text, Sizes::USUAL, COUNT as u32 - 1).is_none());
}

#[test]
fn a_text_is_split_before_spheres_into_chunks_of_about_the_size() {
    let line = "  S 0 0 5 1 9 9 9\n";
    let text = line.repeat(100);
    for lines in 1..10 {
        let chunks = split(text.as_bytes(), lines * line.len() - 3);
        assert_eq!(chunks.concat(), text.as_bytes());
        let (last, others) = chunks.split_last().expect("a chunk");
        assert_eq!(others.len(), 99 / lines);
        assert!(
            others
                .iter()
                .all(|chunk| chunk.len().abs_diff(lines * line.len()) <= 2)
        );
        assert!(last.len() <= lines * line.len());
        assert!(chunks[1..].iter().all(|chunk| chunk.starts_with(b"S ")));
    }
}

/// The others take another way, which takes longer.
#[test]
fn ordinary_spheres_are_read_at_once_with_the_blanks_behind_them() {
    let read = |text: &str| {
        let text = format!("{text}{}", "x".repeat(100));
        let span = Span::new(text.as_bytes()).expect("enough text");
        ordinary_sphere(&span)
    };
    let sphere = Sphere {
        centre: [-0.25, 1.5, 7.0],
        radius: 0.5,
        colour: [1, 20, 255],
    };
    for (text, behind) in [
        ("S -0.25 1.5 7 0.5 1 20 255", "\n"),
        ("S -0.25 1.5 7 0.5 1 20 255", "\r\n\t "),
        ("S\t-.25\n1.50\r7. 00.5  1 020\x0b255", " "),
    ] {
        let at_once = read(&format!("{text}{behind}"));
        assert_eq!(at_once, Some((sphere, text.len() + behind.len())), "{text}");
    }
    // Up to the end of the span.
    let words = ["S -0.25 1.5 7 0.5", "1 20 255"];
    let blanks = " ".repeat(SPAN - 1 - words.concat().len());
    let longest = words.join(&blanks);
    assert_eq!(read(&format!("{longest} ")), Some((sphere, SPAN)));
    for other in [
        &format!("{}{}", longest.replacen(' ', "  ", 1), " "),
        &format!(" {longest}"),
        "s -0.25 1.5 7 0.5 1 20 255 ",
        "SS -0.25 1.5 7 0.5 1 20 255 ",
        "S -0.25 1.5 7 0.5 1 20 256 ",
        "S -0.25 1.5 7 0 1 20 255 ",
        "S -0.25 1.5 7e0 0.5 1 20 255 ",
        "S -0.25 1.5 7 0.5 1 20 255#",
        "S -0.25 1.5 7 0.5 1 20#255 ",
    ] {
        assert_eq!(read(other), None, "{other}");
    }
}
