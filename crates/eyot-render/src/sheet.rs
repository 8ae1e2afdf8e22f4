//! Contact sheets: many small pictures in rows, each with its words below it.

use crate::picture::Picture;
use crate::text;

/// Space around pictures, pixels.
const GAP: usize = 12;
const PAPER: [u8; 3] = [250, 250, 248];
const INK: [u8; 3] = [40, 44, 48];
/// Where there is no picture.
const EMPTY: [u8; 3] = [214, 212, 208];

/// A picture of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetCell {
    /// Lines below it; what is too long for its width is cut.
    pub words: Vec<String>,
    /// The picture; nothing where there is none, which is drawn as a grey area.
    pub picture: Option<Picture>,
}

/// Draws cells row by row, `columns` in each, with `title` above. Pictures are `side` pixels long at most and as they are.
pub fn contact_sheet(title: &str, cells: &[SheetCell], columns: usize, side: usize) -> Picture {
    let columns = columns.clamp(1, cells.len().max(1));
    let lines = cells.iter().map(|c| c.words.len()).max().unwrap_or(0);
    let [step_x, step_y] = [side + GAP, side + GAP + lines * text::LINE];
    let top = GAP + text::LINE + GAP;
    let rows = cells.len().div_ceil(columns);
    let width = (columns * step_x + GAP).max(2 * GAP + text::width(title));
    let mut sheet = Picture::new(width, top + rows * step_y + GAP, PAPER);
    text::draw(&mut sheet, GAP, GAP, title, INK);
    for (i, cell) in cells.iter().enumerate() {
        let (x, y) = (GAP + i % columns * step_x, top + i / columns * step_y);
        let empty = Picture::new(side, side, EMPTY);
        let picture = cell.picture.as_ref().unwrap_or(&empty);
        let (w, h) = (picture.width.min(side), picture.height.min(side));
        let (left, above) = (x + (side - w) / 2, y + (side - h) / 2);
        for row in 0..h {
            let to = (above + row) * sheet.width + left;
            sheet.pixels[to..to + w].copy_from_slice(&picture.pixels[row * picture.width..][..w]);
        }
        for (line, words) in cell.words.iter().enumerate() {
            let fits = side / text::width("x").max(1);
            let cut: String = words.chars().take(fits).collect();
            text::draw(&mut sheet, x, y + side + 2 + line * text::LINE, &cut, INK);
        }
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_in_rows_above_their_words() {
        let cell = |i: usize| SheetCell {
            words: vec![format!("a={i}"), "b=2".to_owned()],
            picture: (i != 1).then(|| Picture::new(40, 30, [i as u8, 0, 255])),
        };
        let cells: Vec<SheetCell> = (0..5).map(cell).collect();
        let sheet = contact_sheet("t", &cells, 3, 40);
        let at = |i: usize| sheet.get(GAP + i % 3 * 52 + 20, GAP + 16 + GAP + i / 3 * (52 + 32) + 20);
        assert_eq!([0, 2, 3, 4].map(at), [0u8, 2, 3, 4].map(|i| [i, 0, 255]));
        assert_eq!(at(1), EMPTY);
        assert_eq!(sheet.width, 3 * 52 + GAP);
        // Nothing makes an empty sheet, and a column too many does no harm.
        assert!(contact_sheet("none", &[], 4, 40).height > 0);
    }
}
