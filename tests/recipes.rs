//! The commands of `scenes/README.md` that make pictures from data, run as they
//! stand there.

// Shells, pipes and links are those of Unix.
#![cfg(unix)]

#[path = "common/program.rs"]
mod program;

use std::{fmt::Write as _, fs, os::unix::fs::symlink};

use program::{Ran, SFERA, Workshop};
use sfera::{scene::Scene, spheres::Sphere};

const README: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/README.md");
const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// The indented lines of a chapter.
fn commands(chapter: &str) -> Vec<String> {
    let readme = fs::read_to_string(README).expect("the README");
    let begin = format!("## {chapter}\n");
    let text = readme.split(&begin).nth(1).expect("the chapter");
    let text = text.split("\n#").next().unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.strip_prefix("    "));
    lines.map(str::to_owned).collect()
}

/// A folder as a user has it: the scenes of the project, and sfera in the PATH.
fn folder() -> Workshop {
    let shop = Workshop::new();
    symlink(SCENES, shop.path("scenes")).expect("a link");
    fs::create_dir(shop.path("bin")).expect("a folder");
    symlink(SFERA, shop.path("bin/sfera")).expect("a link");
    shop
}

fn run(shop: &Workshop, command: &str) -> Ran {
    let ran = shop.run_shell(&format!("PATH=\"$PWD/bin:$PATH\"\n{command}"));
    assert_eq!((ran.code, &*ran.stderr), (0, ""), "{command}");
    ran
}

/// A line of a PDB file: coordinates fill their columns, so no blanks separate them.
fn atom(name: &str, [x, y, z]: [f64; 3], element: &str) -> String {
    format!(
        "ATOM      1 {name:<4} ALA A   1    {x:>8.3}{y:>8.3}{z:>8.3}  1.00  0.00          {element:>2}\n"
    )
}

/// Width, height and pixels of a picture.
fn picture(shop: &Workshop, name: &str) -> (usize, usize, Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(fs::File::open(shop.path(name)).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("pixels");
    let (pixels, _) = bytes.as_chunks::<3>();
    (info.width as usize, info.height as usize, pixels.to_vec())
}

/// Checks that all of the scene is in the picture, and fills most of it.
fn assert_fits(name: &str, (width, height, pixels): &(usize, usize, Vec<[u8; 3]>)) {
    let painted = |index: &usize| pixels[*index] != [255; 3];
    let painted: Vec<usize> = (0..width * height).filter(painted).collect();
    let columns: Vec<usize> = painted.iter().map(|index| index % width).collect();
    let rows: Vec<usize> = painted.iter().map(|index| index / width).collect();
    let extent = |places: &[usize]| {
        let low = *places.iter().min().expect("something");
        (low, *places.iter().max().expect("something"))
    };
    let ((left, right), (top, bottom)) = (extent(&columns), extent(&rows));
    assert!(left > 0 && top > 0, "{name}: {left} {top}");
    assert!(
        right + 1 < *width && bottom + 1 < *height,
        "{name}: {right} {bottom}"
    );
    assert!(
        2 * (bottom - top).max(right - left) > *height,
        "{name} is small"
    );
}

#[test]
fn every_command_does_what_it_says() {
    let commands = commands("From data to a picture");
    assert_eq!(commands.len(), 5);
    let shop = folder();

    // Nitrogen is nearest to the viewer, at +z, and hides oxygen. Carbon is at the right,
    // sulphur above, and two atoms of unknown radii are farther away.
    let mut pdb = "HEADER    MADE UP\nMODEL        1\n".to_owned();
    for (name, place, element) in [
        (" N", [-100.25, -200.5, 303.0], " N"),
        (" O", [-100.25, -200.5, 300.0], " O"),
        (" CA", [-94.25, -200.5, 300.0], ""),
        (" SG", [-100.25, -194.5, 300.0], " S"),
        ("ZN", [-104.25, -204.5, 297.0], "ZN"),
        (" X1", [-103.25, -196.5, 297.0], " X"),
    ] {
        pdb += &atom(name, place, element);
    }
    assert!(pdb.contains("-100.250-200.500 303.000"), "{pdb}");
    pdb += "ENDMDL\nMODEL        2\n";
    pdb += &atom(" FE", [900.0, 0.0, 0.0], "FE");
    shop.write("molecule.pdb", pdb.as_bytes());
    let xyz =
        "6\nmade up\r\nN 0 0 3\r\no 0.0 0 0\nC 6 0 0\n\nCl 0 6 0\n Br -4e0 -4 -3\nX -3 4 -3\n";
    shop.write("molecule.xyz", xyz.as_bytes());
    let mut csv = "x,y,z\n".to_owned();
    for number in 0..500 {
        let angle = f64::from(number) * 0.1;
        let _ = writeln!(csv, "{},{},{}", angle.cos(), 0.05 * angle, angle.sin());
    }
    shop.write("points.csv", csv.as_bytes());

    for command in &commands {
        run(&shop, command);
    }

    let scene = Scene::read(shop.path("molecule.txt")).expect("a scene");
    let spheres: Vec<_> = scene.spheres().iter().collect();
    assert_eq!(spheres.len(), 6);
    let radii: Vec<f32> = spheres.iter().map(Sphere::radius).collect();
    assert_eq!(radii, [1.55, 1.52, 1.7, 1.8, 1.39, 2.0]);
    for (one, other, axis, distance) in [(0, 1, 2, -3.0), (2, 1, 0, 6.0), (3, 1, 1, 6.0)] {
        let difference = spheres[one].centre()[axis] - spheres[other].centre()[axis];
        assert!(
            (difference - distance).abs() < 1e-4,
            "{one} {other} {difference}"
        );
    }
    let molecule = picture(&shop, "molecule.png");
    assert_fits("molecule", &molecule);
    let (width, _, pixels) = &molecule;
    let mean = |colour: [u8; 3]| -> (f64, f64) {
        let places: Vec<usize> = (0..pixels.len())
            .filter(|&index| pixels[index] == colour)
            .collect();
        assert!(!places.is_empty(), "{colour:?}");
        let sum = |part: fn(usize, usize) -> usize| -> f64 {
            places.iter().map(|&index| part(index, *width) as f64).sum()
        };
        let count = places.len() as f64;
        (
            sum(|index, width| index % width) / count,
            sum(|index, width| index / width) / count,
        )
    };
    let (nitrogen, carbon, sulphur) = (mean([48, 80, 248]), mean([144; 3]), mean([255, 200, 50]));
    assert!(carbon.0 > nitrogen.0 + 100.0 && sulphur.1 < nitrogen.1 - 100.0);
    assert!(!pixels.contains(&[255, 13, 13]), "oxygen is behind");

    let wide = picture(&shop, "wide.png");
    assert_eq!((wide.0, wide.1), (1920, 1080));
    assert_fits("wide", &wide);
    for colour in [[31, 240, 31], [166, 41, 41], [200, 100, 200]] {
        assert!(wide.2.contains(&colour), "{colour:?}");
    }
    assert_fits("points", &picture(&shop, "points.png"));
}

#[test]
fn points_may_have_radii_and_colours_and_be_few() {
    let shop = folder();
    for (points, spheres) in [
        ("0 0 0 2 10 20 30\\n4 0 0 1 200 0 0\\n", "2"),
        ("0 0 0 2\\n", "1"),
        ("5 5 5\\n", "1"),
        ("", "0"),
    ] {
        run(
            &shop,
            &format!(
                "printf '{points}' | awk -f scenes/fit.awk > scene.txt && sfera scene.txt a.png 99 99"
            ),
        );
        let text = String::from_utf8(shop.read("scene.txt")).expect("text");
        assert!(text.contains(&format!("OBJ_N {spheres}\n")), "{text}");
        if !points.is_empty() {
            assert_fits(points, &picture(&shop, "a.png"));
        }
    }
    for bad in ["1 2", "1 2 x", "1 2 3 4 5", "1,2,3"] {
        let ran = shop.run_shell(&format!("echo '{bad}' | awk -f scenes/fit.awk"));
        assert_ne!(ran.code, 0, "{bad}");
        assert!(
            ran.stderr.contains("line 1: expected x y z"),
            "{}",
            ran.stderr
        );
        assert!(ran.stdout.is_empty());
    }
}
