//! What the charts have in common: axes, colours, markers, the legend.

use std::error::Error;

use plotters::{
    chart::MeshStyle,
    coord::{
        Shift,
        ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter},
    },
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};
use sfera::render::{Form, Method};

pub(crate) type Area<'file> = DrawingArea<SVGBackend<'file>, Shift>;

pub(crate) type Panel<'panel, 'file> =
    ChartContext<'panel, SVGBackend<'file>, Cartesian2d<Decades, Decades>>;

pub(crate) type Drawn<T = ()> = Result<T, Box<dyn Error>>;

/// Twice the width of a picture on a page of GitHub.
pub(crate) const WIDTH: u32 = 1680;

/// Font sizes, 12 and 14 pixels on that page.
pub(crate) const SMALL: u32 = 24;
pub(crate) const LARGE: u32 = 28;

const GRID: RGBColor = RGBColor(225, 225, 225);
const ZERO_BAND: RGBColor = RGBColor(238, 243, 238);

pub(crate) fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&BLACK)
}

/// Colours that colour-blind readers can distinguish: M. Okabe, K. Ito, Color Universal Design, 2008.
pub(crate) fn colour(method: Method) -> RGBColor {
    match method {
        Method::Textbook(_) => RGBColor(230, 159, 0),
        Method::Geometric(_) => RGBColor(0, 114, 178),
        Method::Double(_) => RGBColor(0, 158, 115),
        Method::Reference => RGBColor(120, 120, 120),
        _ => RGBColor(213, 94, 0),
    }
}

pub(crate) fn name(method: Method) -> &'static str {
    match method {
        Method::Textbook(_) => "textbook (f32)",
        Method::Geometric(_) => "geometric (f32)",
        Method::Double(_) => "double (f64)",
        Method::Reference => "reference (integers)",
        _ => "exact",
    }
}

/// The marker of a method: its shape and its colour show the method, and it is filled unless
/// the form is scalar.
pub(crate) fn mark(area: &Area, at: (i32, i32), method: Method, radius: f64) -> Drawn {
    mark_filled(
        area,
        at,
        method,
        method.form() != Some(Form::Scalar),
        radius,
    )
}

/// Like [`mark`], filled or not.
pub(crate) fn mark_filled(
    area: &Area,
    at: (i32, i32),
    method: Method,
    filled: bool,
    radius: f64,
) -> Drawn {
    let outline = colour(method).stroke_width(3);
    let inside = if filled {
        colour(method).filled()
    } else {
        WHITE.filled()
    };
    // Corners from the top, in units of the radius, so that all shapes are about equally large.
    let (corners, far, near) = match method {
        Method::Textbook(_) => {
            area.draw(&Circle::new(at, radius.round() as i32, inside))?;
            area.draw(&Circle::new(at, radius.round() as i32, outline))?;
            return Ok(());
        }
        Method::Geometric(_) => (3, 1.4, None),
        Method::Double(_) => (4, 1.25, None),
        Method::Reference => (4, 1.35, None),
        _ => (10, 1.65, Some(0.7)),
    };
    let turn = if matches!(method, Method::Double(_)) {
        0.5
    } else {
        0.0
    };
    let corner = |index: usize| {
        let share = near.filter(|_| index % 2 == 1).unwrap_or(far);
        let angle = (index as f64 + turn) / f64::from(corners) * std::f64::consts::TAU;
        let x = f64::from(at.0) + share * radius * angle.sin();
        let y = f64::from(at.1) - share * radius * angle.cos();
        (x.round() as i32, y.round() as i32)
    };
    let corners: Vec<_> = (0..=corners as usize).map(corner).collect();
    area.draw(&Polygon::new(corners.clone(), inside))?;
    area.draw(&PathElement::new(corners, outline))?;
    Ok(())
}

pub(crate) fn text(area: &Area, at: (i32, i32), text: &str, size: u32, across: HPos) -> Drawn {
    let style = font(size).pos(Pos::new(across, VPos::Center));
    area.draw(&Text::new(text.to_owned(), at, style))?;
    Ok(())
}

/// A logarithmic axis, and beyond its smallest value a band for zero.
#[derive(Clone, Copy)]
pub(crate) struct Decades {
    /// Exponents of ten at both ends; the first may be the larger.
    first: f64,
    last: f64,
    /// Height of the band, in decades; 0 if there is none.
    band: f64,
}

/// Decades between the band and the smallest value above it.
const GAP: f64 = 0.4;

impl Decades {
    pub(crate) fn new(first: f64, last: f64) -> Self {
        let (first, last) = (first.log10(), last.log10());
        // Room for half a marker at either end.
        let margin = 0.05 * (last - first);
        Self {
            first: first - margin,
            last: last + margin,
            band: 0.0,
        }
    }

    /// A band for zero `band` decades high, and above it from `smallest` to `largest`.
    pub(crate) fn with_zero(band: f64, smallest: f64, largest: f64) -> Self {
        Self {
            first: smallest.log10() - band - GAP,
            last: largest.log10(),
            band,
        }
    }

    /// Values up to zero are places in its band, that of -1 at its lower edge.
    fn place(&self, value: f64) -> f64 {
        if value > 0.0 {
            value.log10()
        } else {
            self.first + self.band * (1.0 + value)
        }
    }

    fn exponents(&self) -> std::ops::RangeInclusive<i32> {
        let low = if self.band > 0.0 {
            self.first + self.band + GAP
        } else {
            self.first.min(self.last)
        };
        let high = self.first.max(self.last);
        (low - 1e-9).ceil() as i32..=(high + 1e-9).floor() as i32
    }
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (self.place(*value) - self.first) / (self.last - self.first);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let exponents = self.exponents();
        let count = exponents.clone().count();
        let step = count.div_ceil(hint.bold_points().max(1)) as i32;
        // Round steps.
        let step = [1, 2, 3, 5, 10, 20, 40]
            .into_iter()
            .find(|&round| round >= step)
            .unwrap_or(100);
        let mut points: Vec<f64> = exponents
            .filter(|exponent| exponent % step == 0)
            .map(|exponent| 10_f64.powi(exponent))
            .collect();
        if self.band > 0.0 {
            points.push(ZERO_LABEL);
        }
        points
    }

    fn range(&self) -> std::ops::Range<f64> {
        10_f64.powf(self.first)..10_f64.powf(self.last)
    }
}

/// The middle of the band for zero.
const ZERO_LABEL: f64 = -0.5;

impl ValueFormatter<f64> for Decades {
    fn format(value: &f64) -> String {
        if *value <= 0.0 {
            return "0".to_owned();
        }
        let exponent = value.log10().round() as i32;
        if (-2..=3).contains(&exponent) {
            return format!("{value}");
        }
        let exponent = exponent.to_string();
        let raised = exponent.chars().map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '0' => '⁰',
            later => char::from_u32('⁴' as u32 + later as u32 - '4' as u32).unwrap_or(later),
        });
        format!("10{}", raised.collect::<String>())
    }
}

/// A panel of wrong pixels per million against something.
pub(crate) fn panel<'panel, 'file>(
    area: &'panel Area<'file>,
    title: &str,
    (x, x_description): (Decades, &str),
    (y, y_description): (Decades, Option<&str>),
) -> Drawn<Panel<'panel, 'file>> {
    const TITLE: i32 = 52;
    let mut panel = ChartBuilder::on(area)
        .margin_left(12)
        .margin_right(30)
        .margin_top(TITLE)
        .margin_bottom(8)
        .x_label_area_size(70)
        .y_label_area_size(104)
        .build_cartesian_2d(x, y)?;

    let (columns, rows) = panel.plotting_area().get_pixel_range();
    let (left, top) = area.get_base_pixel();
    let middle = (columns.start + columns.end) / 2 - left;
    text(area, (middle, TITLE / 2), title, LARGE, HPos::Center)?;
    let share = y.band / (y.last - y.first);
    let band = (share * f64::from(rows.end - rows.start)).round() as i32;
    area.draw(&Rectangle::new(
        [
            (columns.start - left, rows.end - band - top),
            (columns.end - left, rows.end - top),
        ],
        ZERO_BAND.filled(),
    ))?;

    let mut mesh = panel.configure_mesh();
    draw_mesh(mesh.x_labels(7), x_description, y_description)?;
    Ok(panel)
}

type Mesh<'one, 'two, 'file, X> = MeshStyle<'one, 'two, X, Decades, SVGBackend<'file>>;

/// Draws the grid and the labels of a panel.
pub(crate) fn draw_mesh<X>(
    mesh: &mut Mesh<'_, '_, '_, X>,
    x_description: &str,
    y_description: Option<&str>,
) -> Drawn
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    mesh.y_labels(8)
        .max_light_lines(0)
        .bold_line_style(GRID)
        .axis_style(RGBColor(90, 90, 90))
        .label_style(font(SMALL))
        .axis_desc_style(font(SMALL))
        .x_desc(x_description);
    if let Some(description) = y_description {
        mesh.y_desc(description);
    }
    mesh.draw()?;
    Ok(())
}
