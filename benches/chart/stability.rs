//! Where methods fail: wrong pixels per million against difficulty.

use std::{fmt::Write, fs, path::Path};

use plotters::{prelude::*, style::text_anchor::HPos};
use sfera::{
    camera::ImageSize,
    render::{Form, Method, differing_pixels},
    testing::families::{FAMILIES, Family},
};

use crate::{
    measure::{judge, picture},
    plot::{Area, Decades, Drawn, LARGE, SMALL, WIDTH, colour, mark, name, panel, text},
    speed::zero_row,
};

/// Rays through pixel centres are tangent only on this grid or a multiple of it.
const COLUMNS: u32 = 129;
const ROWS: u32 = 97;
const SEEDS: u64 = 8;

/// The radius of the markers.
const RADIUS: f64 = 8.0;

/// The methods, in drawing order: later ones are on top.
const METHODS: [Method; 4] = [
    Method::Exact,
    Method::Double(Form::Packets),
    Method::Geometric(Form::Packets),
    Method::Textbook(Form::Packets),
];

/// Wrong pixels per million of each method at each difficulty.
type Curves = Vec<(f64, [f64; METHODS.len()])>;

/// Measures every family and draws a panel for each.
pub(crate) fn draw(folder: &Path) -> Drawn {
    let mut table =
        String::from("family,parameter,difficulty,method,pixels,wrong_pixels,wrong_per_million\n");
    let mut measured = Vec::new();
    for family in FAMILIES {
        println!("{}", family.name);
        measured.push((family, measure(family, &mut table)?));
    }
    fs::write(folder.join("stability.csv"), table)?;
    plot(&measured, &folder.join("stability.svg"))
}

fn measure(family: &Family, table: &mut String) -> Drawn<Curves> {
    let size = ImageSize::new(COLUMNS, ROWS)?;
    let small = ImageSize::new(17, 13)?;
    let mut curves = Vec::new();
    for &difficulty in family.difficulties {
        let mut sums = [0; METHODS.len()];
        let mut pixels = [0; METHODS.len()];
        for seed in 0..SEEDS {
            let scene = family.scene(difficulty, seed);
            let judge = judge(&scene);
            let right = picture(&scene, size, judge);
            for (index, method) in METHODS.into_iter().enumerate() {
                if method == judge {
                    let right = picture(&scene, small, Method::Reference);
                    sums[index] += differing_pixels(&picture(&scene, small, method), &right);
                    pixels[index] += small.pixels();
                } else {
                    sums[index] += differing_pixels(&picture(&scene, size, method), &right);
                    pixels[index] += size.pixels();
                }
            }
        }
        let mut per_million = [0.0; METHODS.len()];
        for (index, method) in METHODS.into_iter().enumerate() {
            per_million[index] = sums[index] as f64 * 1e6 / pixels[index] as f64;
            writeln!(
                table,
                "{},{},{difficulty:e},{},{},{},{:.3}",
                family.name,
                family.parameter,
                method,
                pixels[index],
                sums[index],
                per_million[index],
            )?;
        }
        curves.push((difficulty, per_million));
    }
    Ok(curves)
}

fn plot(measured: &[(&Family, Curves)], path: &Path) -> Drawn {
    const LEGEND: u32 = 150;
    const PANEL: u32 = 440;
    const PANELS_A_ROW: usize = 3;
    let rows = measured.len().div_ceil(PANELS_A_ROW);
    let root = SVGBackend::new(path, (WIDTH, LEGEND + PANEL * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    legend(&root)?;
    let (_, below) = root.split_vertically(LEGEND);
    for (index, (area, (family, curves))) in below
        .split_evenly((rows, PANELS_A_ROW))
        .iter()
        .zip(measured)
        .enumerate()
    {
        let easiest = family.difficulties[0];
        let hardest = family.difficulties[family.difficulties.len() - 1];
        let y_description = (index % PANELS_A_ROW == 0).then_some("wrong per million");
        let mut chart = panel(
            area,
            family.name,
            (Decades::new(easiest, hardest), family.parameter),
            (Decades::with_zero(1.6, 1.0, 1e6), y_description),
        )?;
        for (column, method) in METHODS.into_iter().enumerate() {
            let curve = curves.iter().map(|&(difficulty, per_million)| {
                let height = match per_million[column] {
                    0.0 => zero_row(method),
                    wrong => wrong,
                };
                (difficulty, height)
            });
            let curve: Vec<_> = curve.collect();
            chart.draw_series(LineSeries::new(
                curve.clone(),
                colour(method).stroke_width(4),
            ))?;
            for point in curve {
                mark(&root, chart.backend_coord(&point), method, RADIUS)?;
            }
        }
    }
    root.present()?;
    Ok(())
}

fn legend(root: &Area) -> Drawn {
    let title = "Where methods fail: wrong pixels against difficulty, harder to the right";
    text(root, (WIDTH as i32 / 2, 28), title, LARGE, HPos::Center)?;
    let mut x = 200;
    for method in METHODS.into_iter().rev() {
        mark(root, (x, 78), method, RADIUS)?;
        text(root, (x + 24, 78), name(method), SMALL, HPos::Left)?;
        x += 360;
    }
    let note = format!(
        "wrong pixels per million, {SEEDS} scenes of {COLUMNS} x {ROWS} at each point; the shaded row is none at all"
    );
    text(root, (WIDTH as i32 / 2, 122), &note, SMALL, HPos::Center)
}
