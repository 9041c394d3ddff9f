//! PNG, chosen by the name: the same pixels, whole or not at all.

// Shells, pipes and links are those of Unix.
#![cfg(unix)]

#[path = "common/program.rs"]
mod program;

use std::{fs, io::Cursor};

use program::Workshop;

/// Width, height and the pixels of a PNG.
fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(png))
        .read_info()
        .expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("pixels");
    reader.finish().expect("an end");
    assert_eq!(
        (info.color_type, info.bit_depth),
        (png::ColorType::Rgb, png::BitDepth::Eight)
    );
    (info.width, info.height, pixels)
}

fn pixels_of(ppm: &[u8], width: usize, height: usize) -> &[u8] {
    &ppm[ppm.len() - width * height * 3..]
}

/// A PNG of any kind, written by the png crate.
fn encoded(
    width: u32,
    height: u32,
    colour: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(data).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

#[test]
fn a_name_in_png_is_a_png_of_the_same_pixels() {
    let shop = Workshop::new();
    for (name, width, height) in [
        ("image.png", 64, 48),
        ("IMAGE.PNG", 1, 1),
        ("wide.png", 100_001, 1),
        ("high.png", 1, 100_001),
        // More than one group of rows.
        ("large.png", 3000, 2100),
    ] {
        shop.run(&format!("balls.txt {name} {width} {height}"))
            .succeeds();
        let (found_width, found_height, pixels) = decoded(&shop.read(name));
        assert_eq!((found_width, found_height), (width, height));
        let right = shop.balls(width, height);
        assert!(
            pixels == pixels_of(&right, width as usize, height as usize),
            "{name}"
        );
        shop.run(&format!("balls.txt {name} {width} {height} --verify"))
            .succeeds();
    }
    // By every method, and through a link, whose target is replaced.
    fs::write(shop.path("target.png"), "old").expect("a file");
    std::os::unix::fs::symlink("target.png", shop.path("link.png")).expect("a link");
    shop.run("balls.txt link.png 64 48 --method textbook --scalar")
        .succeeds();
    assert_eq!(
        decoded(&shop.read("target.png")).2,
        pixels_of(&shop.balls(64, 48), 64, 48)
    );
    assert!(shop.path("link.png").is_symlink());
}

#[test]
fn marks_and_comparisons_are_png_by_name_too() {
    let shop = Workshop::new();
    let far = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/far.txt");
    let ran = shop.run(&format!(
        "{far} a.ppm 64 48 --method textbook --diff marks.png"
    ));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    shop.run(&format!(
        "{far} b.png 64 48 --method textbook --diff marks.ppm"
    ));
    let marks = shop.read("marks.ppm");
    assert_eq!(
        decoded(&shop.read("marks.png")).2,
        pixels_of(&marks, 64, 48)
    );
    assert_eq!(
        decoded(&shop.read("b.png")).2,
        pixels_of(&shop.read("a.ppm"), 64, 48)
    );
    let ran = shop.run(&format!("{far} b.png 64 48 --verify --diff judged.png"));
    assert_eq!(ran.code, 1);
    assert_eq!(shop.read("judged.png"), shop.read("marks.png"));
    shop.run("balls.txt compared.png 64 48 --compare")
        .succeeds();
    assert_eq!(
        decoded(&shop.read("compared.png")).2,
        pixels_of(&shop.balls(64, 48), 64, 48)
    );
}

#[test]
fn a_pipe_with_such_a_name_gets_a_png() {
    let shop = Workshop::new();
    let ran =
        shop.run_shell("mkfifo pipe.png; cat pipe.png & exec $SFERA balls.txt pipe.png 64 48");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let (.., pixels) = decoded(&ran.stdout);
    assert_eq!(pixels, pixels_of(&shop.balls(64, 48), 64, 48));
}

#[test]
fn other_endings_of_pictures_are_refused_with_advice() {
    let shop = Workshop::new();
    for name in [
        "image.jpg",
        "image.JPEG",
        "image.bmp",
        "image.gif",
        "image.tif",
        "image.webp",
        "a.b.svg",
    ] {
        shop.run(&format!("balls.txt {name} 64 48")).refuses(&[
            name,
            "written as PPM or PNG, not as",
            "end the name in .png or .ppm",
        ]);
        shop.run(&format!(
            "balls.txt image.ppm 64 48 --method double --diff {name}"
        ))
        .refuses(&[name, "end the name in .png or .ppm"]);
        // The picture to check may have any name; its contents say what it is.
        shop.write(name, b"\xff\xd8\xff\xe0 not a picture at all");
        shop.run(&format!("balls.txt {name} 64 48 --verify"))
            .fails(&[name, "a JPEG"]);
        fs::remove_file(shop.path(name)).expect("a file");
    }
    shop.run("balls.txt image.png 64 48 --rows 0..4")
        .refuses(&["--rows draws in place", "pnmtopng"]);
    shop.run("balls.txt image.png 3000000000 1")
        .refuses(&["at most 2147483647"]);
    assert_eq!(shop.names(), ["balls.txt"]);
    let right = shop.balls(64, 48);
    for name in [
        "image",
        "image.ppm",
        "image.pnm",
        "image.dat",
        ".png",
        "png",
    ] {
        shop.run(&format!("balls.txt {name} 64 48")).succeeds();
        assert_eq!(shop.read(name), right, "{name}");
    }
}

#[test]
fn a_png_is_whole_or_not_at_all() {
    let shop = Workshop::new();
    shop.write("image.png", b"old");
    // A limit that the first bytes already exceed.
    let ran = shop.run_shell("ulimit -f 0; exec $SFERA balls.txt image.png 640 480");
    ran.fails(&["image.png: can't write to it", "ulimit -f"]);
    let ran = shop.run_shell(
        "$SFERA balls.txt image.png 4000 4000 --method reference & sleep 0.3; kill -9 $!; wait",
    );
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert_eq!(shop.read("image.png"), b"old");
    assert_eq!(shop.names(), ["balls.txt", "image.png"]);
    shop.run("balls.txt image.png 64 48").succeeds();
    assert_eq!(decoded(&shop.read("image.png")).0, 64);
}

#[test]
fn png_pictures_of_other_programs_are_checked() {
    use png::{
        BitDepth::{Eight, Sixteen},
        ColorType::{Grayscale, Rgb, Rgba},
    };
    let shop = Workshop::new();
    let right = shop.balls(64, 48);
    let right = pixels_of(&right, 64, 48);
    let with_opacity = |opacity: u8| -> Vec<u8> {
        right
            .chunks(3)
            .flat_map(|pixel| [pixel[0], pixel[1], pixel[2], opacity])
            .collect()
    };
    let line = "balls.txt image.png 64 48 --verify";
    for rows in ["", "--rows 20..48"] {
        shop.write(
            "image.png",
            &encoded(64, 48, Rgba, Eight, &with_opacity(255)),
        );
        shop.run(&format!("{line} {rows}")).succeeds();
    }
    let mut wrong = right.to_vec();
    wrong[(24 * 64 + 32) * 3] ^= 1;
    shop.write("image.png", &encoded(64, 48, Rgb, Eight, &wrong));
    shop.run(line)
        .fails(&["1 of 3072 pixels differ", "in 1 of 48 rows: 24..25"]);
    shop.run(&format!("{line} --rows 25..48")).succeeds();
    shop.write(
        "image.png",
        &encoded(64, 48, Grayscale, Eight, &[9; 64 * 48]),
    );
    shop.run(line).fails(&["3072 of 3072 pixels differ"]);

    shop.write(
        "image.png",
        &encoded(64, 48, Rgba, Eight, &with_opacity(254)),
    );
    shop.run(line).fails(&["transparent"]);
    shop.write(
        "image.png",
        &encoded(64, 48, Rgb, Sixteen, &[0; 64 * 48 * 6]),
    );
    shop.run(line).fails(&["16 bits a channel"]);
    shop.write("image.png", &encoded(48, 64, Rgb, Eight, right));
    shop.run(line)
        .fails(&["not a 64 x 48 picture but one of 48 x 64"]);
    let whole = encoded(64, 48, Rgb, Eight, right);
    for length in [8, 20, 60, whole.len() / 2, whole.len() - 13] {
        shop.write("image.png", &whole[..length]);
        shop.run(line).fails(&["image.png: this PNG can't be read"]);
    }
    shop.run_shell("cat image.png | $SFERA balls.txt - 64 48 --verify")
        .fails(&["standard input: this is a PNG", "pngtopnm"]);
}
