//! How the time grows with spheres, with pixels and with threads.
//!
//! The figures of Embree and of splat are those of the last `make peers`; without them these
//! curves are not drawn.

use std::{fmt::Write, fs, path::Path, time::Duration};

use plotters::{prelude::*, style::text_anchor::HPos};
use rayon::prelude::*;
use sfera::{
    camera::ImageSize,
    render::{Form, Method},
    scene::Scene,
    testing::families,
};

use crate::{
    measure::{frame, median},
    plot::{Area, Decades, Drawn, LARGE, SMALL, WIDTH, colour, draw_mesh, mark, text},
    splat,
};

const PEERS: &str = "benches/peers/results.csv";
const FULL_HD: (u32, u32) = (1920, 1080);

/// Widths of pictures of 16:9 with about 10^5, 10^5.5 .. 10^9 pixels.
const WIDTHS: [u32; 9] = [416, 752, 1_328, 2_368, 4_208, 7_488, 13_328, 23_696, 42_160];
const SPHERES: [usize; 6] = [100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];
const THREADS_SPHERES: usize = 100_000;

/// A curve ends with the first frame that takes longer than this.
const LONGEST: Duration = Duration::from_secs(3);

const MILLISECONDS: (f64, f64) = (0.01, 100_000.0);
const RADIUS: f64 = 9.0;

const TEXTBOOK: Method = Method::Textbook(Form::Packets);

/// The program or method of a curve.
#[derive(Clone, Copy, PartialEq)]
enum Subject {
    Exact,
    Textbook,
    Embree,
    Splat,
    Fill,
}

const SUBJECTS: [Subject; 5] = [
    Subject::Fill,
    Subject::Splat,
    Subject::Embree,
    Subject::Textbook,
    Subject::Exact,
];

impl Subject {
    fn name(self) -> &'static str {
        match self {
            Self::Exact => "sfera, exact",
            Self::Textbook => "sfera, textbook (f32)",
            Self::Embree => "Embree with its tree",
            Self::Splat => "splat (f32, C)",
            Self::Fill => "filling the memory",
        }
    }

    fn colour(self) -> RGBColor {
        match self {
            Self::Exact => colour(Method::Exact),
            Self::Textbook => colour(TEXTBOOK),
            Self::Embree => RGBColor(86, 180, 233),
            Self::Splat => splat::COLOUR,
            Self::Fill => BLACK,
        }
    }

    /// The curve of filling memory has no markers.
    fn mark(self, area: &Area, at: (i32, i32)) -> Drawn {
        match self {
            Self::Exact => mark(area, at, Method::Exact, RADIUS),
            Self::Textbook => mark(area, at, TEXTBOOK, RADIUS),
            Self::Embree | Self::Splat => {
                let side = RADIUS as i32;
                let corners = [(at.0 - side, at.1 - side), (at.0 + side, at.1 + side)];
                area.draw(&Rectangle::new(corners, self.colour().filled()))?;
                Ok(())
            }
            Self::Fill => Ok(()),
        }
    }
}

/// Milliseconds at each place on an axis.
type Curve = Vec<(f64, f64)>;

struct Panel {
    title: String,
    axis: &'static str,
    curves: Vec<(Subject, Curve)>,
}

/// Measures and draws the three panels.
pub(crate) fn draw(example: &Scene, folder: &Path) -> Drawn {
    let threads = rayon::current_num_threads();
    let peers = peers(threads);
    let by_spheres = by_spheres(&peers)?;
    let exact_reaches = by_spheres.curves.iter().any(|(subject, curve)| {
        *subject == Subject::Exact && curve.iter().any(|at| at.0 == THREADS_SPHERES as f64)
    });
    let panels = [
        by_spheres,
        by_pixels(example, &peers)?,
        by_threads(exact_reaches, &peers)?,
    ];
    let mut table = String::from("panel,subject,place,milliseconds\n");
    for panel in &panels {
        for (subject, curve) in &panel.curves {
            for (place, milliseconds) in curve {
                let axis = panel.axis;
                writeln!(
                    table,
                    "{axis},\"{}\",{place},{milliseconds:.4}",
                    subject.name()
                )?;
            }
        }
    }
    fs::write(folder.join("growth.csv"), table)?;
    plot(&panels, threads, &folder.join("growth.svg"))
}

fn by_spheres(peers: &[Measured]) -> Drawn<Panel> {
    let size = ImageSize::new(FULL_HD.0, FULL_HD.1)?;
    let mut pixels = vec![0; size.pixel_bytes()];
    let floor = fill(&mut pixels);
    let mut curves = Curves::default();
    for count in SPHERES {
        if curves.ended(Subject::Exact) && curves.ended(Subject::Textbook) {
            break;
        }
        println!("{count} spheres");
        let scene = families::cloud(count, 1);
        for (subject, method) in [
            (Subject::Exact, Method::Exact),
            (Subject::Textbook, TEXTBOOK),
        ] {
            curves.measure(subject, count as f64, || {
                frame(&scene, size, method, &mut pixels)
            });
        }
    }
    let clouds = |row: &&Measured| row.cloud && (row.width, row.height) == FULL_HD;
    let threads = rayon::current_num_threads();
    for row in peers.iter().filter(clouds) {
        if row.threads == threads {
            curves.add(row.subject, row.spheres, row.milliseconds);
        }
    }
    for count in SPHERES {
        curves.add(Subject::Fill, count as f64, floor);
    }
    Ok(Panel {
        title: format!("uniform clouds, {} x {}", FULL_HD.0, FULL_HD.1),
        axis: "spheres",
        curves: curves.0,
    })
}

fn by_pixels(example: &Scene, peers: &[Measured]) -> Drawn<Panel> {
    let mut curves = Curves::default();
    for width in WIDTHS {
        let size = ImageSize::new(width, width * 9 / 16)?;
        let place = size.pixels() as f64;
        println!("{width} x {} pixels", width * 9 / 16);
        let mut pixels = vec![0; size.pixel_bytes()];
        curves.add(Subject::Fill, place, fill(&mut pixels));
        for (subject, method) in [
            (Subject::Exact, Method::Exact),
            (Subject::Textbook, TEXTBOOK),
        ] {
            curves.measure(subject, place, || frame(example, size, method, &mut pixels));
        }
    }
    let threads = rayon::current_num_threads();
    for row in peers
        .iter()
        .filter(|row| row.example && row.threads == threads)
    {
        let pixels = f64::from(row.width) * f64::from(row.height);
        curves.add(row.subject, pixels, row.milliseconds);
    }
    Ok(Panel {
        title: format!("the example: {} spheres", example.spheres().len()),
        axis: "pixels",
        curves: curves.0,
    })
}

fn by_threads(exact_reaches: bool, peers: &[Measured]) -> Drawn<Panel> {
    let scene = families::cloud(THREADS_SPHERES, 1);
    let size = ImageSize::new(FULL_HD.0, FULL_HD.1)?;
    let mut pixels = vec![0; size.pixel_bytes()];
    let mut curves = Curves::default();
    for threads in 1..=rayon::current_num_threads() {
        println!("{threads} threads");
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let place = threads as f64;
        pool.install(|| {
            curves.add(Subject::Fill, place, fill(&mut pixels));
            if exact_reaches {
                curves.measure(Subject::Exact, place, || {
                    frame(&scene, size, Method::Exact, &mut pixels)
                });
            }
        });
        for row in peers {
            let same = row.spheres == THREADS_SPHERES as f64 && row.cloud;
            if same && row.threads == threads && (row.width, row.height) == FULL_HD {
                curves.add(row.subject, place, row.milliseconds);
            }
        }
    }
    Ok(Panel {
        title: format!("{THREADS_SPHERES} spheres"),
        axis: "threads",
        curves: curves.0,
    })
}

#[derive(Default)]
struct Curves(Vec<(Subject, Curve)>);

impl Curves {
    fn add(&mut self, subject: Subject, place: f64, milliseconds: f64) {
        match self.0.iter_mut().find(|(of, _)| *of == subject) {
            Some((_, curve)) => curve.push((place, milliseconds)),
            None => self.0.push((subject, vec![(place, milliseconds)])),
        }
    }

    fn ended(&self, subject: Subject) -> bool {
        let last = self.0.iter().find(|(of, _)| *of == subject);
        last.and_then(|(_, curve)| curve.last())
            .is_some_and(|&(_, milliseconds)| milliseconds > LONGEST.as_secs_f64() * 1e3)
    }

    /// The median of frames, or only the first if that already takes too long.
    fn measure(&mut self, subject: Subject, place: f64, mut frame: impl FnMut() -> Duration) {
        if self.ended(subject) {
            return;
        }
        let first = frame();
        let time = if first > LONGEST {
            first
        } else {
            median(frame)
        };
        self.add(subject, place, time.as_secs_f64() * 1e3);
    }
}

/// Milliseconds of filling the memory of a picture on all threads of the pool.
fn fill(pixels: &mut [u8]) -> f64 {
    let piece = pixels.len().div_ceil(rayon::current_num_threads());
    let time = median(|| {
        let start = std::time::Instant::now();
        pixels
            .par_chunks_mut(piece)
            .for_each(|bytes| bytes.fill(200));
        start.elapsed()
    });
    time.as_secs_f64() * 1e3
}

/// A figure of a peer from `make peers`.
struct Measured {
    subject: Subject,
    example: bool,
    cloud: bool,
    spheres: f64,
    width: u32,
    height: u32,
    threads: usize,
    milliseconds: f64,
}

impl Measured {
    fn of_line(line: &str) -> Option<Self> {
        let cells: Vec<_> = line.split(',').collect();
        let [
            scene,
            spheres,
            width,
            height,
            threads,
            "in memory",
            peer,
            _,
            milliseconds,
            ..,
        ] = cells[..]
        else {
            return None;
        };
        let subject = match peer {
            "Embree" => Subject::Embree,
            "splat" => Subject::Splat,
            _ => return None,
        };
        Some(Self {
            subject,
            example: scene == "example",
            cloud: scene.starts_with("cloud"),
            spheres: spheres.parse().ok()?,
            width: width.parse().ok()?,
            height: height.parse().ok()?,
            threads: threads.parse().ok()?,
            milliseconds: milliseconds.parse().ok()?,
        })
    }

    /// Rows with equal keys are the modes of one peer on one scene.
    fn place(&self) -> (u8, bool, f64, u32, usize) {
        let Self {
            subject,
            example,
            spheres,
            width,
            threads,
            ..
        } = *self;
        (subject as u8, example, spheres, width, threads)
    }
}

/// The best modes of the peers, at the thread counts of this machine.
fn peers(most_threads: usize) -> Vec<Measured> {
    let table = fs::read_to_string(PEERS).unwrap_or_default();
    let rows = table.lines().filter_map(Measured::of_line);
    let drawn = |row: &Measured| row.threads <= most_threads && (row.example || row.cloud);
    let mut rows: Vec<_> = rows.filter(drawn).collect();
    rows.sort_by(|one, other| {
        let order = |row: &Measured| (row.place(), row.milliseconds);
        order(one)
            .partial_cmp(&order(other))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    rows.dedup_by(|later, first| later.place() == first.place());
    for subject in [Subject::Embree, Subject::Splat] {
        if !rows.iter().any(|row| row.subject == subject) {
            let name = subject.name();
            println!("not drawn: {name}: no figures in {PEERS}; make peers measures them");
        }
    }
    rows
}

fn plot(panels: &[Panel], threads: usize, path: &Path) -> Drawn {
    const LEGEND: u32 = 140;
    const PANEL: u32 = 620;
    let root = SVGBackend::new(path, (WIDTH, LEGEND + PANEL)).into_drawing_area();
    root.fill(&WHITE)?;
    legend(&root, threads)?;
    let (_, below) = root.split_vertically(LEGEND);
    let (left, right) = below.split_horizontally(WIDTH * 39 / 100);
    let (middle, right) = right.split_horizontally(WIDTH * 37 / 100);
    for (index, (area, panel)) in [left, middle, right].iter().zip(panels).enumerate() {
        let places = panel.curves.iter().flat_map(|(_, curve)| curve);
        let most = places.fold(1.0_f64, |most, &(place, _)| most.max(place));
        let mut builder = ChartBuilder::on(area);
        builder
            .margin(10)
            .margin_right(24)
            .margin_top(48)
            .x_label_area_size(80)
            .y_label_area_size(if index == 0 { 110 } else { 70 });
        let (width, _) = area.dim_in_pixel();
        let title = (width as i32 / 2 + 30, 24);
        text(area, title, &panel.title, LARGE, HPos::Center)?;
        let y = Decades::new(MILLISECONDS.0, MILLISECONDS.1);
        let y_description = (index == 0).then_some("milliseconds a frame");
        if panel.axis == "threads" {
            let mut chart = builder.build_cartesian_2d(0.5..most + 0.5, y)?;
            let mut mesh = chart.configure_mesh();
            mesh.disable_x_mesh()
                .x_labels(2 * most as usize + 2)
                .x_label_formatter(&|place| match place.fract() {
                    0.0 => format!("{place}"),
                    _ => String::new(),
                });
            draw_mesh(&mut mesh, panel.axis, y_description)?;
            for (subject, curve) in &panel.curves {
                draw_curve(&root, &mut chart, *subject, curve)?;
            }
        } else {
            let least = if panel.axis == "pixels" { 1e5 } else { 1e2 };
            let x = Decades::new(least, most);
            let mut chart = builder.build_cartesian_2d(x, y)?;
            draw_mesh(
                chart.configure_mesh().x_labels(7),
                panel.axis,
                y_description,
            )?;
            for (subject, curve) in &panel.curves {
                draw_curve(&root, &mut chart, *subject, curve)?;
            }
        }
    }
    root.present()?;
    Ok(())
}

fn draw_curve<X: Ranged<ValueType = f64>>(
    root: &Area,
    chart: &mut ChartContext<SVGBackend, Cartesian2d<X, Decades>>,
    subject: Subject,
    curve: &[(f64, f64)],
) -> Drawn {
    let line = subject.colour().stroke_width(4);
    chart.draw_series(LineSeries::new(curve.iter().copied(), line))?;
    for point in curve {
        subject.mark(root, chart.backend_coord(point))?;
    }
    Ok(())
}

fn legend(root: &Area, threads: usize) -> Drawn {
    let title = format!("How the time of a frame grows, in memory, on {threads} threads");
    text(root, (WIDTH as i32 / 2, 32), &title, LARGE, HPos::Center)?;
    let mut x = 110;
    for subject in SUBJECTS.into_iter().rev() {
        let line = vec![(x - 36, 92), (x, 92)];
        let stroke = subject.colour().stroke_width(4);
        root.draw(&PathElement::new(line, stroke))?;
        subject.mark(root, (x - 18, 92))?;
        text(root, (x + 12, 92), subject.name(), SMALL, HPos::Left)?;
        x += 110 + 12 * subject.name().len() as i32;
    }
    Ok(())
}
