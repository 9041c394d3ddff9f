//! `--verify` on pictures of other programs: a small renderer with common mistakes.

// Shells, pipes and links are those of Unix.
#![cfg(unix)]

#[path = "common/program.rs"]
mod program;

use std::{fmt::Write as _, fs};

use program::{Ran, Workshop};
use sfera::render::differing_pixels;

const WIDTH: usize = 160;
const HEIGHT: usize = 90;

/// Spheres on all sides: in front of the camera, behind it, around it, and intersecting one
/// another. Nothing is symmetric.
const SPHERES: [([f64; 4], [u8; 3]); 9] = [
    ([0.25, 1.0, 4.0, 0.25], [200, 0, 0]),
    ([0.25, 1.75, 5.0, 0.5], [150, 0, 0]),
    ([-0.5, -0.25, 3.0, 0.25], [127, 0, 0]),
    ([0.125, 0.0, 10.0, 1.5], [255, 0, 0]),
    ([1.25, 0.25, 10.0, 1.0], [0, 0, 225]),
    ([-35.0, 0.5, 100.0, 20.0], [127, 127, 127]),
    ([3.0, 2.0, -8.0, 1.25], [0, 200, 0]),
    ([-1.0, -2.5, -6.0, 1.0], [0, 160, 0]),
    ([2.0, 0.0, -20.0, 600.0], [255, 255, 0]),
];

fn scene() -> String {
    let mut text = "# Made by hand.\nVP 1.75 1 1\nBG 250 250 250\n".to_owned();
    let _ = writeln!(text, "OBJ_N {}", SPHERES.len());
    for ([x, y, z, radius], [red, green, blue]) in SPHERES {
        let _ = writeln!(text, "S {x} {y} {z} {radius} {red} {green} {blue}");
    }
    text
}

/// A simple renderer in doubles, as people write it.
#[derive(Clone, Copy)]
struct Renderer {
    /// The position in the viewport of column `i` of `n`, and of row `j` of `n`, from 0 to 1.
    column: fn(f64, f64) -> f64,
    row: fn(f64, f64) -> f64,
    upside_down: bool,
    mirrored: bool,
    /// The t of the hit that counts, of a sphere hit at these least and greatest t.
    depth: fn(f64, f64) -> Option<f64>,
}

fn edges(i: f64, n: f64) -> f64 {
    i / (n - 1.0)
}

fn nearest(least: f64, greatest: f64) -> Option<f64> {
    [least, greatest].into_iter().find(|&t| t > 0.0)
}

const RIGHT: Renderer = Renderer {
    column: edges,
    row: edges,
    upside_down: false,
    mirrored: false,
    depth: nearest,
};

impl Renderer {
    fn pixels(&self) -> Vec<u8> {
        let mut pixels = Vec::with_capacity(WIDTH * HEIGHT * 3);
        for j in 0..HEIGHT {
            for i in 0..WIDTH {
                let j = if self.upside_down { HEIGHT - 1 - j } else { j };
                let i = if self.mirrored { WIDTH - 1 - i } else { i };
                let x = 1.75 * ((self.column)(i as f64, WIDTH as f64) - 0.5);
                let y = 0.5 - (self.row)(j as f64, HEIGHT as f64);
                pixels.extend(self.colour([x, y, 1.0]));
            }
        }
        pixels
    }

    fn colour(&self, v: [f64; 3]) -> [u8; 3] {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut best = f64::INFINITY;
        let mut colour = [250; 3];
        for ([x, y, z, radius], own) in SPHERES {
            let centre = [x, y, z];
            let (a, b) = (dot(v, v), -2.0 * dot(v, centre));
            let c = dot(centre, centre) - radius * radius;
            let d = b * b - 4.0 * a * c;
            if d < 0.0 {
                continue;
            }
            let (least, greatest) = ((-b - d.sqrt()) / (2.0 * a), (-b + d.sqrt()) / (2.0 * a));
            if let Some(t) = (self.depth)(least, greatest)
                && t < best
            {
                (best, colour) = (t, own);
            }
        }
        colour
    }

    fn picture(&self) -> Vec<u8> {
        let header = format!("P6\n{WIDTH} {HEIGHT}\n255\n");
        [header.as_bytes(), &self.pixels()].concat()
    }
}

fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.write("scene.txt", scene().as_bytes());
    shop
}

fn verify(shop: &Workshop, options: &str) -> Ran {
    shop.run(&format!(
        "scene.txt picture.ppm {WIDTH} {HEIGHT} --verify {options}"
    ))
}

fn stdout(ran: &Ran) -> String {
    String::from_utf8(ran.stdout.clone()).expect("text")
}

#[test]
fn a_right_picture_is_right_with_any_header_and_from_any_source() {
    let shop = shop();
    for header in [
        "P6\n160 90\n255\n",
        "P6 160 90 255 ",
        "P6\n# CREATOR: GIMP PNM Filter Version 1.1\n160 90\n255\n",
        "P6\r\n160 90\r\n255\r\n",
        "P6  # magic\n\n160\t\n# rows\n   90\n255\t",
    ] {
        shop.write(
            "picture.ppm",
            &[header.as_bytes(), &RIGHT.pixels()].concat(),
        );
        for line in [
            "$SFERA scene.txt picture.ppm 160 90 --verify",
            "$SFERA scene.txt - 160 90 --verify < picture.ppm",
            "cat picture.ppm | $SFERA scene.txt - 160 90 --verify",
            "(head -c 9 picture.ppm; sleep 0.05; tail -c +10 picture.ppm) \
             | $SFERA scene.txt /dev/stdin 160 90 --verify",
            "cat scene.txt | $SFERA - picture.ppm 160 90 --verify",
            "$SFERA scene.txt picture.ppm 160 90 --verify --rows 33..90",
            "cat picture.ppm | $SFERA scene.txt - 160 90 --verify --rows 33..60",
        ] {
            let ran = shop.run_shell(line).succeeds();
            let text = stdout(&ran);
            assert!(
                text.ends_with("pixels are right\n"),
                "{header:?} {line}: {text}"
            );
            assert!(
                line.contains("--rows") != text.contains("all 14400 pixels"),
                "{text}"
            );
        }
    }
    let quiet = verify(&shop, "--quiet").succeeds();
    assert_eq!(stdout(&quiet), "");
}

#[test]
fn common_mistakes_are_named() {
    let shop = shop();
    let mistakes: [(&str, Renderer, &[&str]); 15] = [
        (
            "upside down",
            Renderer {
                upside_down: true,
                ..RIGHT
            },
            &["it is upside down (row 0"],
        ),
        (
            "mirrored",
            Renderer {
                mirrored: true,
                ..RIGHT
            },
            &["it is mirrored, left for right"],
        ),
        (
            "both",
            Renderer {
                mirrored: true,
                upside_down: true,
                ..RIGHT
            },
            &["it is upside down and mirrored"],
        ),
        (
            "centres of pixels",
            Renderer {
                column: |i, n| (i + 0.5) / n,
                row: |i, n| (i + 0.5) / n,
                ..RIGHT
            },
            &["through (i+1/2)/W and (j+1/2)/H of"],
        ),
        (
            "corners of pixels",
            Renderer {
                column: |i, n| i / n,
                row: |i, n| i / n,
                ..RIGHT
            },
            &["through i/W and j/H of"],
        ),
        (
            "other corners of pixels",
            Renderer {
                column: |i, n| i / n,
                row: |i, n| (i + 1.0) / n,
                ..RIGHT
            },
            &["through i/W and (j+1)/H of"],
        ),
        (
            "half a pixel to the right",
            Renderer {
                column: |i, n| (i + 0.5) / (n - 1.0),
                ..RIGHT
            },
            &["through (i+1/2)/(W-1) and j/(H-1) of"],
        ),
        (
            "half a pixel up",
            Renderer {
                row: |i, n| (i - 0.5) / (n - 1.0),
                ..RIGHT
            },
            &["through i/(W-1) and (j-1/2)/(H-1) of"],
        ),
        (
            "half a pixel off both ways",
            Renderer {
                column: |i, n| (i - 0.5) / (n - 1.0),
                row: |i, n| (i + 0.5) / (n - 1.0),
                ..RIGHT
            },
            &["through (i-1/2)/(W-1) and (j+1/2)/(H-1) of"],
        ),
        (
            "centres and columns alone",
            Renderer {
                column: |i, n| (i + 0.5) / n,
                ..RIGHT
            },
            &["through (i+1/2)/W and j/(H-1) of"],
        ),
        (
            "upside down through centres",
            Renderer {
                column: |i, n| (i + 0.5) / n,
                row: |i, n| (i + 0.5) / n,
                upside_down: true,
                ..RIGHT
            },
            &["it is upside down", "through (i+1/2)/W and (j+1/2)/H of"],
        ),
        (
            "spheres on either side",
            Renderer {
                depth: |least, greatest| Some(least.abs().min(greatest.abs())),
                ..RIGHT
            },
            &["spheres behind the camera are seen too (t < 0"],
        ),
        (
            "the least t",
            Renderer {
                depth: |least, _| Some(least),
                ..RIGHT
            },
            &["spheres behind the camera hide those in front of it"],
        ),
        (
            "no sphere from inside",
            Renderer {
                depth: |least, _| (least > 0.0).then_some(least),
                ..RIGHT
            },
            &["spheres that contain the camera are not seen"],
        ),
        (
            "spheres on either side, mirrored, through centres",
            Renderer {
                column: |i, n| (i + 0.5) / n,
                row: |i, n| (i + 0.5) / n,
                mirrored: true,
                depth: |least, greatest| Some(least.abs().min(greatest.abs())),
                ..RIGHT
            },
            &[
                "it is mirrored",
                "(i+1/2)/W and (j+1/2)/H",
                "seen too (t < 0",
            ],
        ),
    ];
    for (name, renderer, words) in mistakes {
        shop.write("picture.ppm", &renderer.picture());
        let ran = verify(&shop, "").fails(&["picture.ppm: ", "of 14400 pixels differ"]);
        let text = stdout(&ran);
        for word in words {
            assert!(ran.stderr.contains(word), "{name}: {}{text}", ran.stderr);
        }
        assert!(
            text.contains("then 0 of 14400 pixels differ"),
            "{name}: {text}"
        );
        for absent in ["upside down", "mirrored", "of the viewport", "camera"] {
            let meant = words.iter().any(|word| word.contains(absent));
            let meant = meant || absent == "of the viewport" && words.concat().contains("(W-1)");
            let meant = meant || absent == "of the viewport" && words.concat().contains("/W");
            let meant = meant || absent == "camera" && words.concat().contains("t < 0");
            assert_eq!(ran.stderr.contains(absent), meant, "{name}: {}", ran.stderr);
        }
    }
}

/// The textbook formula in floats.
fn textbook_pixels() -> Vec<u8> {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut pixels = Vec::new();
    for j in 0..HEIGHT {
        for i in 0..WIDTH {
            let x = 1.75 * (i as f32 / (WIDTH - 1) as f32 - 0.5);
            let y = 0.5 - j as f32 / (HEIGHT - 1) as f32;
            let length = dot([x, y, 1.0], [x, y, 1.0]).sqrt();
            let v = [x / length, y / length, 1.0 / length];
            let mut best = f32::INFINITY;
            let mut colour = [250; 3];
            for (sphere, own) in SPHERES {
                let [x, y, z, radius] = sphere.map(|number| number as f32);
                let b = -2.0 * dot(v, [x, y, z]);
                let c = dot([x, y, z], [x, y, z]) - radius * radius;
                let d = b * b - 4.0 * c;
                if d >= 0.0 {
                    let roots = [(-b - d.sqrt()) / 2.0, (-b + d.sqrt()) / 2.0];
                    if let Some(t) = roots.into_iter().find(|&t| t > 0.0)
                        && t < best
                    {
                        (best, colour) = (t, own);
                    }
                }
            }
            pixels.extend(colour);
        }
    }
    pixels
}

#[test]
fn rounding_is_distinguished_from_a_mistake() {
    let shop = Workshop::new();
    // A sphere whose outline passes through pixels, and two that nearly tie in a pixel.
    shop.write(
        "ties.txt",
        b"VP 2 2 1\nBG 9 9 9\nOBJ_N 4\nS 0 0 10 1 200 0 0\nS 0 0 10 0.99999994 0 200 0\n\
          S 30 30 50 0.125 0 0 200\nS 3 4 12 0 0 0 0\n",
    );
    let text = fs::read_to_string(shop.path("ties.txt")).expect("the scene");
    shop.write(
        "ties.txt",
        text.replace("S 3 4 12 0 0 0 0\n", "")
            .replace('4', "3")
            .as_bytes(),
    );
    shop.run("ties.txt picture.ppm 65 65").succeeds();
    let mut picture = shop.read("picture.ppm");
    let header = picture.len() - 65 * 65 * 3;
    let at = |column: usize, row: usize| header + (row * 65 + column) * 3;
    // The sphere that is farther by 6e-8 of its radius is shown.
    let centre = at(32, 32);
    assert_eq!(picture[centre..centre + 3], [200, 0, 0]);
    picture[centre..centre + 3].copy_from_slice(&[0, 200, 0]);
    shop.write("picture.ppm", &picture);
    let ran = shop.run("ties.txt picture.ppm 65 65 --verify").fails(&[
        "1 of 4225 pixels differ, 236.686 per million, in 1 of 65 rows: 32..33; this is rounding",
    ]);
    let text = stdout(&ran);
    assert!(
        text.contains("200   0   0  sphere 1 (line 4); sphere 2 (line 5) is farther by 6.6e-9"),
        "{text}"
    );
    // A colour of a sphere elsewhere, and one that no sphere has.
    for wrong in [[0, 0, 200], [1, 2, 3]] {
        picture[centre..centre + 3].copy_from_slice(&wrong);
        shop.write("picture.ppm", &picture);
        shop.run("ties.txt picture.ppm 65 65 --verify")
            .fails(&["1 of 4225 pixels differ", "this is more than rounding"]);
    }
    let ran = shop.run("ties.txt picture.ppm 65 65 --verify");
    assert!(stdout(&ran).contains("nothing of the colour found is near"));
}

#[test]
fn the_textbook_in_floats_is_rounding() {
    let shop = shop();
    // A sphere whose outline touches the edge of the picture.
    let exact = RIGHT.pixels();
    let textbook = textbook_pixels();
    let wrong = differing_pixels(&exact, &textbook);
    let header = format!("P6 {WIDTH} {HEIGHT} 255\n");
    shop.write("picture.ppm", &[header.as_bytes(), &textbook].concat());
    let ran = verify(&shop, "");
    assert_eq!(ran.code, i32::from(wrong > 0), "{}", ran.stderr);
    // The example at 1920 x 1080 is known to have four.
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/example.txt");
    shop.run(&format!("{example} known.ppm 1920 1080 --method textbook"))
        .succeeds();
    let ran = shop
        .run(&format!("{example} known.ppm 1920 1080 --verify"))
        .fails(&[
            "4 of 2073600 pixels differ, 1.929 per million",
            "this is rounding",
        ]);
    let text = stdout(&ran);
    for line in [
        "      1228        525    0   0 195    0   0 225  sphere 12 (line 15); 6.6e-5 pixels to the outline of sphere 13 (line 16)",
        "      1132       1008    0 180   0  255 255 255  the background; 0.002 pixels to the outline of sphere 8 (line 11)",
    ] {
        assert!(text.contains(line), "{text}");
    }
    // Compared with its own method, the same picture is right.
    shop.run(&format!(
        "{example} known.ppm 1920 1080 --verify --method textbook"
    ))
    .succeeds();
}

/// In a large picture every other block of rows is examined.
#[test]
fn a_mistake_in_a_large_picture_is_named() {
    let shop = Workshop::new();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/example.txt");
    shop.run(&format!("{example} picture.ppm 1920 1080"))
        .succeeds();
    let picture = shop.read("picture.ppm");
    let (header, pixels) = picture.split_at(picture.len() - 1920 * 1080 * 3);
    let flipped: Vec<&[u8]> = pixels.chunks(1920 * 3).rev().collect();
    shop.write("picture.ppm", &[header, &flipped.concat()].concat());
    for rows in ["", "--rows 100..1077"] {
        let ran = shop
            .run(&format!("{example} picture.ppm 1920 1080 --verify {rows}"))
            .fails(&["the picture fits if it is upside down"]);
        let text = stdout(&ran);
        assert!(
            text.contains("then 0 of 1") || text.contains("then 0 of 9"),
            "{text}"
        );
    }
}

/// The textbook formula moves far spheres by many pixels, which is still rounding. A mistake
/// in a picture of them is not taken for rounding.
#[test]
fn far_spheres_are_judged_by_the_size_of_rounding_errors() {
    let shop = Workshop::new();
    let far = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/far.txt");
    shop.run(&format!("{far} picture.ppm 160 90 --method textbook"))
        .succeeds();
    let line = format!("{far} picture.ppm 160 90 --verify");
    shop.run(&line).fails(&["this is rounding in floats"]);

    shop.run(&format!("{far} fine.ppm 321 181")).succeeds();
    let fine = shop.read("fine.ppm");
    let fine: Vec<&[u8]> = fine[fine.len() - 321 * 181 * 3..].chunks(3).collect();
    let mut picture = b"P6 160 90 255 ".to_vec();
    for row in 0..90 {
        for column in 0..160 {
            picture.extend(fine[(2 * row + 1) * 321 + 2 * column + 1]);
        }
    }
    shop.write("picture.ppm", &picture);
    shop.run(&line)
        .fails(&["through (i+1/2)/W and (j+1/2)/H of"]);
}

#[test]
fn the_first_ten_are_shown_and_all_are_counted() {
    let shop = shop();
    let mut picture = RIGHT.picture();
    let header = picture.len() - WIDTH * HEIGHT * 3;
    for number in 0..200 {
        let at = header + number * 71 * 3;
        picture[at..at + 3].copy_from_slice(&[1, 1, 1]);
    }
    shop.write("picture.ppm", &picture);
    let ran = verify(&shop, "")
        .fails(&["200 of 14400 pixels differ, 13888.889 per million, in 89 of 90 rows"]);
    let text = stdout(&ran);
    assert!(
        text.contains("\n         0          0    1   1   1  "),
        "{text}"
    );
    assert!(
        text.contains("\n       ...\nthe worst of 200 examined:\n"),
        "{text}"
    );
    assert_eq!(
        text.lines()
            .filter(|line| line.contains("  1   1   1  "))
            .count(),
        11,
        "{text}"
    );
}

#[test]
fn the_report_as_json() {
    let shop = shop();
    let upside_down = Renderer {
        upside_down: true,
        ..RIGHT
    };
    shop.write("picture.ppm", &upside_down.picture());
    let ran = verify(&shop, "--stats=json");
    assert_eq!((ran.code, stdout(&ran).as_str()), (1, ""));
    assert_eq!(ran.stderr.lines().count(), 1);
    for part in [
        "{\"image\":\"picture.ppm\",\"width\":160,\"height\":90,\"rows\":[0,90],\"spheres\":9,\"method\":\"exact\",\"pixels\":14400,\"wrong\":",
        "\"wrong_per_million\":",
        "\"wrong_row_ranges\":[[",
        "\"first\":[{\"column\":",
        "\"found\":[",
        "\"right\":[",
        "\"sphere\":{\"number\":",
        "\"line\":",
        "\"worst\":{",
        "\"near\":",
        "\"fit\":{\"orientation\":\"upside down\",\"columns\":\"i/(W-1)\",\"rows\":\"j/(H-1)\",\"depth\":\"nearest\",\"wrong\":0,\"of\":14400}",
        "\"milliseconds\":{\"read\":",
        "\"compare\":",
    ] {
        assert!(ran.stderr.contains(part), "{part} in {}", ran.stderr);
    }
    let ran = shop.run_shell(
        "$SFERA scene.txt picture.ppm 160 90 --verify --stats=json 2>&1 | python3 -m json.tool",
    );
    assert!(
        ran.code == 0 || ran.stderr.contains("not found"),
        "{}",
        ran.stderr
    );

    shop.write("picture.ppm", &RIGHT.picture());
    let ran = verify(&shop, "--stats=json");
    assert_eq!(ran.code, 0);
    assert!(ran.stderr.contains("\"wrong\":0,"), "{}", ran.stderr);
    assert!(
        ran.stderr.contains("\"first\":[],\"worst\":null"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_difference_marks_what_is_wrong_in_a_picture_that_is_judged() {
    let shop = shop();
    let mirrored = Renderer {
        mirrored: true,
        ..RIGHT
    };
    shop.write("picture.ppm", &mirrored.picture());
    verify(&shop, "--diff marks.ppm").fails(&["it is mirrored"]);
    let marks = shop.read("marks.ppm");
    assert!(marks.starts_with(b"P6\n160 90\n255\n"));
    let marks = marks[marks.len() - WIDTH * HEIGHT * 3..].chunks(3);
    let mut wrong = 0;
    for ((found, right), mark) in mirrored
        .pixels()
        .chunks(3)
        .zip(RIGHT.pixels().chunks(3))
        .zip(marks)
    {
        assert_eq!(found != right, mark == [255, 0, 0]);
        wrong += u32::from(found != right);
    }
    assert!(wrong > 1000);
    // The image goes to standard output, so no text may.
    let ran = verify(&shop, "--diff -");
    assert_eq!(ran.stdout, shop.read("marks.ppm"));
    assert_eq!(ran.code, 1);
    // The marks of a right picture are all pale.
    shop.write("picture.ppm", &RIGHT.picture());
    verify(&shop, "--diff marks.ppm").succeeds();
    assert!(shop.read("marks.ppm")[15..].iter().all(|&byte| byte >= 192));

    for line in [
        "scene.txt picture.ppm 160 90 --verify --diff scene.txt",
        "scene.txt ./picture.ppm 160 90 --verify --diff picture.ppm",
    ] {
        let before = (shop.read("scene.txt"), shop.read("picture.ppm"));
        shop.run(line).fails(&["another name"]);
        assert_eq!((shop.read("scene.txt"), shop.read("picture.ppm")), before);
    }
    // For a picture that ends too early, no image of marks is left.
    shop.write("picture.ppm", &RIGHT.picture()[..10_000]);
    shop.run_shell(
        "rm marks.ppm; cat picture.ppm | $SFERA scene.txt - 160 90 --verify --diff marks.ppm",
    )
    .fails(&["standard input: this picture ends in row 20"]);
    assert_eq!(shop.names(), ["balls.txt", "picture.ppm", "scene.txt"]);
}

#[test]
fn what_is_no_such_picture_is_refused() {
    let shop = shop();
    let pixels = RIGHT.pixels();
    for (header, words) in [
        (
            "P6\n90 160\n255\n",
            "not a 160 x 90 picture but one of 90 x 160",
        ),
        ("P5\n160 90\n255\n", "without colour"),
        ("P6\n160 90\n65535\n", "pnmdepth 255"),
        ("P6\n160 90\n", "the greatest value is missing"),
        ("P6\n160 90\n255\nxxx", "binary mode"),
        ("", "not a binary PPM"),
    ] {
        shop.write("picture.ppm", &[header.as_bytes(), &pixels].concat());
        verify(&shop, "").fails(&["picture.ppm: ", words]);
        shop.run_shell("cat picture.ppm | $SFERA scene.txt - 160 90 --verify")
            .fails(&["standard input: ", words]);
    }
    shop.write("picture.ppm", &RIGHT.picture()[..1000]);
    verify(&shop, "")
        .fails(&["this picture ends in row 2: its pixels are 986 bytes instead of 43200"]);
    shop.run("- - 160 90 --verify").refuses(&["not both"]);
}

/// Wrong pictures of extreme scenes.
#[test]
fn any_scene_and_size_have_a_verdict() {
    let shop = Workshop::new();
    let scenes = [
        "VP 1 1 1 BG 9 9 9 OBJ_N 0",
        "VP 3e38 3e38 3e38 BG 9 9 9 OBJ_N 2 S 3e38 -3e38 3e38 3e38 1 2 3 S 0 0 -3e38 1e38 7 7 7",
        "VP 1e-45 1e-45 1e-45 BG 9 9 9 OBJ_N 2 S 0 0 1e-45 1e-45 7 7 7 S 1e-45 0 9e-45 1e-45 4 5 6",
        "VP 1e-45 3e38 1 BG 9 9 9 OBJ_N 3 S 0 0 5 5 7 7 7 S 0 0 5 5 7 7 7 S 3 4 12 13 7 7 7",
        "VP 3e38 1e-45 1 BG 7 7 7 OBJ_N 3 S 0 0 0 1e-45 7 7 7 S 0 0 -5 5 1 1 1 S 1 0 -2 1 2 2 2",
    ];
    for scene in scenes {
        shop.write("odd.txt", scene.as_bytes());
        for (width, height) in [
            (1, 1),
            (1, 9),
            (9, 1),
            (2, 2),
            (3, 2),
            (33, 17),
            (1_100_000, 1),
            (1, 5000),
        ] {
            for fill in [7, 8] {
                let mut picture = format!("P6 {width} {height} 255\n").into_bytes();
                picture.resize(picture.len() + width * height * 3, fill);
                shop.write("picture.ppm", &picture);
                let ran = shop.run(&format!("odd.txt picture.ppm {width} {height} --verify"));
                assert!(
                    ran.code == 0 || ran.stderr.contains(" pixels differ, "),
                    "{}",
                    ran.stderr
                );
                assert!(!ran.stderr.contains("internal"), "{scene}: {}", ran.stderr);
            }
        }
    }
}
