//! One scene: the exact picture, the textbook one, and the pixels that differ.

use std::path::Path;

use plotters::{prelude::*, style::text_anchor::HPos};
use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    render::{Form, Method, differing_pixels},
    scene::Scene,
};

use crate::{
    measure::picture,
    plot::{Area, Drawn, LARGE, WIDTH, text},
};

const COLUMNS: u32 = 132;
const ROWS: u32 = 99;

/// Side of a pixel in the chart.
const SIDE: i32 = 4;

/// Draws the three pictures side by side.
pub(crate) fn draw(scene: &Scene, folder: &Path) -> Drawn {
    const CAPTION: i32 = 56;
    let size = ImageSize::new(COLUMNS, ROWS)?;
    let exact = picture(scene, size, Method::Exact);
    let textbook = picture(scene, size, Method::Textbook(Form::default()));
    let marked: Vec<u8> = exact
        .chunks_exact(BYTES_PER_PIXEL)
        .zip(textbook.chunks_exact(BYTES_PER_PIXEL))
        .flat_map(|(pixel, other)| match pixel == other {
            true => [0, 1, 2].map(|channel| 255 - (255 - pixel[channel]) / 5),
            false => [0, 0, 0],
        })
        .collect();

    let height = CAPTION + ROWS as i32 * SIDE + 8;
    let path = folder.join("difference.svg");
    let root = SVGBackend::new(&path, (WIDTH, height as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    let different = differing_pixels(&textbook, &exact);
    let share = 100.0 * different as f64 / size.pixels() as f64;
    let titles = [
        "exact".to_owned(),
        "textbook (f32)".to_owned(),
        format!("black: {different} wrong pixels, {share:.1} %"),
    ];
    let panels = root.split_evenly((1, 3));
    for ((panel, title), pixels) in panels.iter().zip(titles).zip([&exact, &textbook, &marked]) {
        let (width, _) = panel.dim_in_pixel();
        text(
            panel,
            (width as i32 / 2, CAPTION / 2),
            &title,
            LARGE,
            HPos::Center,
        )?;
        let left = (width as i32 - COLUMNS as i32 * SIDE) / 2;
        draw_pixels(panel, (left, CAPTION), pixels)?;
    }
    root.present()?;
    Ok(())
}

/// A rectangle for each run of equal pixels in a row.
fn draw_pixels(area: &Area, (left, top): (i32, i32), pixels: &[u8]) -> Drawn {
    let rows = pixels.chunks_exact(COLUMNS as usize * BYTES_PER_PIXEL);
    for (row, pixels) in rows.enumerate() {
        let (pixels, _) = pixels.as_chunks::<BYTES_PER_PIXEL>();
        let mut column = 0;
        for run in pixels.chunk_by(|one, next| one == next) {
            let [red, green, blue] = run[0];
            let corner =
                |column: usize, row: usize| (left + column as i32 * SIDE, top + row as i32 * SIDE);
            let rectangle = [corner(column, row), corner(column + run.len(), row + 1)];
            let colour = RGBColor(red, green, blue);
            area.draw(&Rectangle::new(rectangle, colour.filled()))?;
            column += run.len();
        }
    }
    Ok(())
}
