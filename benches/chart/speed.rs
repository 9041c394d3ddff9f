//! Speed against accuracy: milliseconds a frame against wrong pixels per million.

use std::{fmt::Write, fs, path::Path};

use plotters::{prelude::*, style::text_anchor::HPos};
use sfera::{
    camera::ImageSize,
    render::{Form, Method, differing_pixels},
    scene::Scene,
    testing::{Bounds, Tuning, tuned},
};

use crate::{
    measure::{frame, judge, median},
    plot::{Area, Decades, Drawn, LARGE, SMALL, WIDTH, mark, mark_filled, name, panel, text},
    splat,
};

const COLUMNS: u32 = 1920;
const ROWS: u32 = 1080;

/// The radius of the markers.
const RADIUS: f64 = 12.0;

/// The method or program that draws.
#[derive(Clone, Copy)]
enum Painter {
    Method(Method),
    /// The engine with its error bounds ignored.
    BoundsIgnored,
    /// The best inexact rasteriser, in C.
    Splat,
}

impl Painter {
    fn name(self) -> String {
        match self {
            Self::Method(method) => method.to_string(),
            Self::BoundsIgnored => "bounds ignored".to_owned(),
            Self::Splat => "splat".to_owned(),
        }
    }

    fn form(self) -> String {
        let form = match self {
            Self::Method(method) => method.form(),
            Self::BoundsIgnored | Self::Splat => None,
        };
        form.map_or_else(|| "one form".to_owned(), |form| form.to_string())
    }

    fn mark(self, area: &Area, at: (i32, i32)) -> Drawn {
        match self {
            // The reference looks at one pixel at a time.
            Self::Method(Method::Reference) => {
                mark_filled(area, at, Method::Reference, false, RADIUS)
            }
            Self::Method(method) => mark(area, at, method, RADIUS),
            Self::BoundsIgnored => mark_filled(area, at, Method::Exact, false, RADIUS),
            Self::Splat => {
                let side = (0.9 * RADIUS) as i32;
                let corners = [(at.0 - side, at.1 - side), (at.0 + side, at.1 + side)];
                area.draw(&Rectangle::new(corners, splat::COLOUR.filled()))?;
                Ok(())
            }
        }
    }

    /// A place in the band of zero for each, so that equal points do not overlap.
    fn zero_row(self) -> f64 {
        match self {
            Self::Method(method) => zero_row(method),
            Self::BoundsIgnored => -0.72,
            Self::Splat => -0.6,
        }
    }
}

/// One painter on one scene.
struct Point {
    painter: Painter,
    milliseconds: f64,
    wrong: u64,
}

impl Point {
    fn per_million(&self) -> f64 {
        self.wrong as f64 * 1e6 / (f64::from(COLUMNS) * f64::from(ROWS))
    }
}

/// Measures every method in every form, and draws a panel for each scene.
pub(crate) fn draw(scenes: &[(String, Scene)], folder: &Path) -> Drawn {
    let threads = rayon::current_num_threads();
    let mut table = String::from(
        "scene,spheres,width,height,threads,method,form,milliseconds,\
         million_pixels_per_second,wrong_pixels,wrong_per_million\n",
    );
    let mut measured = Vec::new();
    for (name, scene) in scenes {
        let (points, floor) = measure(name, scene)?;
        let spheres = scene.spheres().len();
        println!("{name}, {spheres} spheres, {COLUMNS} x {ROWS}, {threads} threads");
        for point in &points {
            let method = point.painter.name();
            let form = point.painter.form();
            let rate = f64::from(COLUMNS) * f64::from(ROWS) / point.milliseconds / 1e3;
            println!(
                "  {method:14} {form:9} {:10.2} ms {rate:9.2} Mpixel/s {:8} wrong",
                point.milliseconds, point.wrong,
            );
            writeln!(
                table,
                "{name},{spheres},{COLUMNS},{ROWS},{threads},{method},{form},{:.3},{rate:.3},{},{:.3}",
                point.milliseconds,
                point.wrong,
                point.per_million(),
            )?;
        }
        println!("  memory filled with one colour {floor:.2} ms");
        writeln!(
            table,
            "{name},{spheres},{COLUMNS},{ROWS},{threads},fill,memory,{floor:.3},{:.3},,",
            f64::from(COLUMNS) * f64::from(ROWS) / floor / 1e3,
        )?;
        measured.push((format!("{name}: {spheres} spheres"), points, floor));
    }
    fs::write(folder.join("speed.csv"), table)?;
    plot(&measured, threads, &folder.join("speed.svg"))
}

/// All points of a scene, and the milliseconds of filling the memory of a picture.
fn measure(name: &str, scene: &Scene) -> Drawn<(Vec<Point>, f64)> {
    let size = ImageSize::new(COLUMNS, ROWS)?;
    let both = |method: fn(Form) -> Method| [Form::Scalar, Form::Packets].map(method);
    let floats = [Method::Textbook, Method::Geometric, Method::Double]
        .into_iter()
        .flat_map(both);
    let mut right = vec![0; size.pixel_bytes()];
    let judge = judge(scene);
    let judged_in = frame(scene, size, judge, &mut right);
    let mut pixels = vec![0; size.pixel_bytes()];
    let mut points = Vec::new();
    for method in floats.chain([Method::Exact]) {
        let time = median(|| frame(scene, size, method, &mut pixels));
        points.push(Point {
            painter: Painter::Method(method),
            milliseconds: time.as_secs_f64() * 1e3,
            wrong: differing_pixels(&pixels, &right),
        });
    }
    let ignored = Tuning {
        bounds: Bounds::Ignored,
        ..Tuning::default()
    };
    let time = median(|| {
        let start = std::time::Instant::now();
        tuned(scene, size, Method::Exact, ignored).draw(0..size.height(), &mut pixels);
        start.elapsed()
    });
    points.push(Point {
        painter: Painter::BoundsIgnored,
        milliseconds: time.as_secs_f64() * 1e3,
        wrong: differing_pixels(&pixels, &right),
    });
    if let Some((milliseconds, picture)) = splat::measure(name, scene, size)? {
        points.push(Point {
            painter: Painter::Splat,
            milliseconds,
            wrong: differing_pixels(&picture, &right),
        });
    }
    if judge == Method::Reference {
        points.push(Point {
            painter: Painter::Method(judge),
            milliseconds: judged_in.as_secs_f64() * 1e3,
            wrong: 0,
        });
    }
    let floor = median(|| {
        use rayon::prelude::*;
        let start = std::time::Instant::now();
        pixels
            .par_chunks_mut(16 * size.row_bytes())
            .for_each(|band| band.fill(127));
        std::hint::black_box(&mut pixels);
        start.elapsed()
    });
    Ok((points, floor.as_secs_f64() * 1e3))
}

fn plot(measured: &[(String, Vec<Point>, f64)], threads: usize, path: &Path) -> Drawn {
    const LEGEND: u32 = 190;
    const PANEL: u32 = 600;
    let panels_a_row = measured.len().min(3);
    let rows = measured.len().div_ceil(3);
    let root = SVGBackend::new(path, (WIDTH, LEGEND + PANEL * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    legend(&root, threads)?;
    let (_, below) = root.split_vertically(LEGEND);

    let all = || measured.iter().flat_map(|(_, points, _)| points);
    let floors = measured.iter().map(|&(_, _, floor)| floor);
    let fastest = all()
        .map(|point| point.milliseconds)
        .chain(floors)
        .fold(f64::MAX, f64::min);
    let slowest = all().map(|point| point.milliseconds).fold(0.0, f64::max);
    for (area, (title, points, floor)) in below
        .split_evenly((rows, panels_a_row))
        .iter()
        .zip(measured)
    {
        let mut chart = panel(
            area,
            title,
            (Decades::new(fastest, slowest), "milliseconds per frame"),
            (
                Decades::with_zero(3.6, 0.1, 1e6),
                Some("wrong pixels per million"),
            ),
        )?;
        let grey = RGBColor(140, 140, 140);
        chart.draw_series(DashedLineSeries::new(
            [(*floor, -1.0), (*floor, 1e6)],
            8,
            8,
            grey.stroke_width(3),
        ))?;
        for point in points {
            let accuracy = match point.wrong {
                0 => point.painter.zero_row(),
                _ => point.per_million(),
            };
            let at = chart.backend_coord(&(point.milliseconds, accuracy));
            point.painter.mark(&root, at)?;
        }
    }
    root.present()?;
    Ok(())
}

/// A place in the band of zero for each method, so that equal points do not overlap.
pub(crate) fn zero_row(method: Method) -> f64 {
    match method {
        Method::Textbook(_) => -0.12,
        Method::Geometric(_) => -0.24,
        Method::Double(_) => -0.36,
        Method::Reference => -0.48,
        _ => -0.86,
    }
}

fn legend(root: &Area, threads: usize) -> Drawn {
    let title = format!(
        "Speed against accuracy at {COLUMNS} x {ROWS} on {threads} threads: the best is low and left"
    );
    text(root, (WIDTH as i32 / 2, 28), &title, LARGE, HPos::Center)?;
    let methods = [
        (110, Method::Textbook(Form::Packets)),
        (430, Method::Geometric(Form::Packets)),
        (770, Method::Double(Form::Packets)),
        (1070, Method::Exact),
        (1270, Method::Reference),
    ];
    for (x, method) in methods {
        mark(root, (x, 78), method, RADIUS)?;
        text(root, (x + 30, 78), name(method), SMALL, HPos::Left)?;
    }
    let inexact = [
        (
            110,
            Painter::Splat,
            "splat: the fastest inexact way known, in C",
        ),
        (770, Painter::BoundsIgnored, "exact with its bounds ignored"),
    ];
    for (x, painter, name) in inexact {
        painter.mark(root, (x, 120))?;
        text(root, (x + 30, 120), name, SMALL, HPos::Left)?;
    }
    let notes = [
        (110, "filled: packets of pixels"),
        (560, "hollow: one pixel at a time"),
        (1070, "dashed: filling that memory with one colour"),
    ];
    for (x, note) in notes {
        text(root, (x, 162), note, SMALL, HPos::Left)?;
    }
    Ok(())
}
