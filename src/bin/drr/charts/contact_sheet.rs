//! Small pictures with names under each other and side by side.

use anyhow::Result;
use drr::formats::ColourPicture;
use plotters::drawing::IntoDrawingArea;
use plotters::element::Text;

use super::axes::wrapped;
use super::canvas::Canvas;
use super::drawing::{TEXT, TITLE, text_style};
use super::marker::{INK, PALE_INK};

const MARGIN: usize = 16;
/// Between pictures.
const GAP: usize = 14;
/// Rows of a picture's name and caption.
const TEXTS: usize = 42;
/// Pictures in a row.
const COLUMNS: usize = 6;

/// A picture with its name.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    pub(crate) name: String,
    /// In a second line.
    pub(crate) caption: String,
    pub(crate) picture: ColourPicture,
}

/// Panels of equal size under a title.
#[derive(Debug, Clone)]
pub(crate) struct ContactSheet {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) panels: Vec<Panel>,
}

impl ContactSheet {
    /// All of it.
    pub(crate) fn picture(&self) -> Result<ColourPicture> {
        let most = |side: fn(&ColourPicture) -> usize| self.panels.iter().map(|p| side(&p.picture)).max();
        // A narrow picture leaves room for its name.
        let cell = [most(|p| p.width).unwrap_or(1).max(200), most(|p| p.height).unwrap_or(1) + TEXTS];
        let columns = COLUMNS.min(self.panels.len()).max(1);
        let width = 2 * MARGIN + columns * (cell[0] + GAP) - GAP;
        let subtitle = wrapped(&self.subtitle, (width - 2 * MARGIN) as i32, TEXT, false);
        let top = MARGIN + TITLE as usize + 6 + subtitle.len() * (TEXT as usize + 2) + 12;
        let height = top + self.panels.len().div_ceil(columns) * (cell[1] + GAP);
        let mut sheet = ColourPicture::filled(width, height, [255; 3]);
        let place = |n: usize| [MARGIN + n % columns * (cell[0] + GAP), top + n / columns * (cell[1] + GAP)];
        for (n, panel) in self.panels.iter().enumerate() {
            put(&mut sheet, &panel.picture, place(n));
        }
        let area = Canvas::new(&mut sheet).into_drawing_area();
        let margin = MARGIN as i32;
        area.draw(&Text::new(self.title.clone(), (margin, margin - 4), text_style(TITLE, true, INK)))?;
        for (n, row) in subtitle.into_iter().enumerate() {
            let y = margin + TITLE as i32 + 4 + n as i32 * (TEXT as i32 + 2);
            area.draw(&Text::new(row, (margin, y), text_style(TEXT, false, PALE_INK)))?;
        }
        for (n, panel) in self.panels.iter().enumerate() {
            let [x, y] = place(n).map(|at| at as i32);
            let under = y + panel.picture.height as i32 + 3;
            area.draw(&Text::new(panel.name.clone(), (x, under), text_style(TEXT, true, INK)))?;
            let style = text_style(TEXT, false, PALE_INK);
            area.draw(&Text::new(panel.caption.clone(), (x, under + TEXT as i32 + 1), style))?;
        }
        drop(area);
        Ok(sheet)
    }
}

fn put(sheet: &mut ColourPicture, picture: &ColourPicture, [left, top]: [usize; 2]) {
    let rows = sheet.pixels.chunks_exact_mut(sheet.width).skip(top);
    for (to, from) in rows.zip(picture.pixels.chunks_exact(picture.width)) {
        to[left..left + picture.width].copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_is_there_as_it_is() {
        let panel = |n: u8| Panel {
            name: format!("picture {n}"),
            caption: String::new(),
            picture: ColourPicture::filled(210, 50, [10, n, 200]),
        };
        let sheet = ContactSheet {
            title: "title".into(),
            subtitle: "a subtitle".into(),
            panels: (0..8).map(panel).collect(),
        };
        let picture = sheet.picture().unwrap();
        for n in 0..8 {
            let own = picture.pixels.iter().filter(|pixel| **pixel == [10, n, 200]);
            assert_eq!(own.count(), 210 * 50, "{n}");
        }
        let none = ContactSheet { panels: vec![], ..sheet };
        assert!(none.picture().is_ok());
    }
}
