//! The legend of a layer map: name, unit, a bar of the colours and ticks at round values.

use crate::colour_map::ColourMap;
use crate::picture::{Picture, quantise};
use crate::text;
use eyot_core::layer::{Class, LayerSpec};

/// From values to places along the bar, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// Straight between the ends.
    Linear { from: f32, to: f32 },
    /// Straight on both sides of a middle value, which lies in the middle of the map.
    Middle { from: f32, middle: f32, to: f32 },
    /// Logarithmic.
    Log { from: f32, to: f32 },
}

impl Scale {
    /// `apart`: the two sides are scaled on their own, else by the longer of them.
    pub(crate) fn linear(from: f32, to: f32, middle: Option<f32>, apart: bool) -> Self {
        match middle {
            None => Self::Linear { from, to },
            Some(middle) if apart => Self::Middle { from, middle, to },
            Some(middle) => {
                let reach = (middle - from).max(to - middle);
                Self::Middle { from: middle - reach, middle, to: middle + reach }
            }
        }
    }

    pub(crate) fn log(from: f32, to: f32) -> Self {
        let to = to.max(f32::MIN_POSITIVE);
        Self::Log { from: from.max(1e-9 * to).min(0.999 * to), to }
    }

    fn ends(&self) -> (f32, f32) {
        match *self {
            Self::Linear { from, to } | Self::Middle { from, to, .. } | Self::Log { from, to } => (from, to),
        }
    }

    /// Place of a value in the colour map.
    pub(crate) fn place(&self, v: f32) -> f32 {
        let share = |v: f32, a: f32, b: f32| {
            if b > a { ((v - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 }
        };
        match *self {
            Self::Linear { from, to } => share(v, from, to),
            Self::Middle { from, middle, .. } if v < middle => 0.4999 * share(v, from, middle),
            Self::Middle { middle, to, .. } => 0.5 + 0.5 * share(v, middle, to),
            Self::Log { from, to } => share(v.max(from).ln(), from.ln(), to.ln()),
        }
    }

    /// Place of a value along the bar: as in the colour map, but for a middle at an end, whose empty half is left out.
    fn along(&self, v: f32) -> f32 {
        match *self {
            Self::Middle { from, middle, .. } if middle <= from => 2.0 * self.place(v) - 1.0,
            Self::Middle { middle, to, .. } if middle >= to => 2.0 * self.place(v),
            _ => self.place(v),
        }
    }

    /// Place in the colour map at a share of the bar.
    fn colour_at(&self, t: f32) -> f32 {
        match *self {
            Self::Middle { from, middle, .. } if middle <= from => 0.5 + 0.5 * t,
            Self::Middle { middle, to, .. } if middle >= to => 0.4999 * t,
            _ => t,
        }
    }

    /// Round values between the ends, at most about `count`.
    fn ticks(&self, count: usize) -> Vec<f32> {
        let (from, to) = self.ends();
        match *self {
            Self::Log { .. } => {
                let (lo, hi) = (from.log10().ceil() as i32, to.log10().floor() as i32);
                let step = ((hi - lo + 1).max(1) as usize).div_ceil(count.max(1)).max(1);
                let mut ticks: Vec<f32> = (lo..=hi).step_by(step).map(|e| 10f32.powi(e)).collect();
                if ticks.len() < 2 {
                    ticks = vec![from, to];
                }
                ticks
            }
            Self::Middle { middle, .. } if middle > from && middle < to => {
                let half = (count / 2).max(1);
                let mut ticks = round_values(from, middle, half);
                ticks.retain(|t| (middle - t).abs() > 0.12 * (middle - from));
                ticks.push(middle);
                ticks.extend(
                    round_values(middle, to, half).into_iter().filter(|t| (t - middle).abs() > 0.12 * (to - middle)),
                );
                ticks
            }
            _ => round_values(from, to, count),
        }
    }
}

/// Multiples of 1, 2 or 5 times a power of ten, at most `count` and one.
fn round_values(from: f32, to: f32, count: usize) -> Vec<f32> {
    let (from, to) = (f64::from(from), f64::from(to));
    let rough = (to - from) / count.max(1) as f64;
    if !(rough > 0.0 && rough.is_finite()) {
        return vec![from as f32];
    }
    let power = 10f64.powf(rough.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|s| *s >= 0.999 * rough).unwrap_or(10.0 * power);
    let (a, b) = ((from / step - 1e-6).ceil() as i64, (to / step + 1e-6).floor() as i64);
    (a..=b.min(a.saturating_add(32))).map(|i| (i as f64 * step) as f32).collect()
}

/// A value as short text.
fn label(v: f32) -> String {
    let a = v.abs();
    if a != 0.0 && !(1e-3..1e5).contains(&a) {
        return format!("{v:.0e}");
    }
    let digits = if a == 0.0 || a >= 100.0 { 0 } else { (2 - a.log10().floor() as i32).clamp(0, 5) as usize };
    let s = format!("{v:.digits$}");
    if s.contains('.') { s.trim_end_matches('0').trim_end_matches('.').to_owned() } else { s }
}

/// What stands over the bar.
pub(crate) fn title(spec: &LayerSpec) -> String {
    let name = spec.name.replace('_', " ");
    let unit = spec.unit.replace("m2", "m\u{b2}").replace("m3", "m\u{b3}");
    if unit.is_empty() || unit == "1" { name } else { format!("{name} ({unit})") }
}

const PAPER: [u8; 3] = [250, 250, 248];
const INK: [u8; 3] = [38, 40, 44];
const MARGIN: usize = 12;
const BAR: usize = 14;

/// `map` with a legend below it.
pub(crate) fn below(map: &Picture, spec: &LayerSpec, colours: ColourMap, scale: &Scale) -> Picture {
    let title = title(spec);
    let width = map.width.max(text::width(&title) + 2 * MARGIN).max(240);
    let strip = MARGIN + text::LINE + 4 + BAR + 6 + text::LINE + 8;
    let mut p = Picture::new(width, map.height + strip, PAPER);
    let left = (width - map.width) / 2;
    for (y, row) in map.pixels.chunks(map.width.max(1)).enumerate() {
        p.pixels[y * width + left..][..map.width].copy_from_slice(row);
    }
    let mut y = map.height + MARGIN - 4;
    text::draw(&mut p, MARGIN, y, &title, INK);
    y += text::LINE + 4;
    let bar = width - 2 * MARGIN;
    for x in 0..bar {
        let c = colours.at(scale.colour_at(x as f32 / (bar - 1) as f32));
        for dy in 0..BAR {
            p.pixels[(y + dy) * width + MARGIN + x] = quantise(c, x, dy);
        }
    }
    y += BAR;
    let mut free_from = 0;
    for v in scale.ticks((bar / 90).max(2)) {
        let x = MARGIN + (scale.along(v) * (bar - 1) as f32).round() as usize;
        let text = label(v);
        let half = text::width(&text) / 2;
        let at = x.saturating_sub(half).clamp(2, width - 2 - (2 * half).min(width - 4));
        if at < free_from {
            continue;
        }
        (0..5).for_each(|dy| p.pixels[(y + dy) * width + x] = INK);
        text::draw(&mut p, at, y + 6, &text, INK);
        free_from = at + 2 * half + 10;
    }
    p
}

/// `map` with the classes that occur in it below: colour, name, and share of the cells.
pub(crate) fn of_classes(map: &Picture, spec: &LayerSpec, classes: &[Class], cells: &[usize]) -> Picture {
    let all = cells.iter().sum::<usize>().max(1) as f64;
    let mut shown: Vec<(usize, String)> = (0..classes.len())
        .filter(|&i| cells[i] > 0)
        .map(|i| (i, format!("{} {:.1} %", classes[i].name, 100.0 * cells[i] as f64 / all)))
        .collect();
    shown.sort_by_key(|(i, _)| *i);
    let title = title(spec);
    let widest = shown.iter().map(|(_, t)| text::width(t)).max().unwrap_or(0) + 2 * BAR + MARGIN;
    let width = map.width.max(text::width(&title) + 2 * MARGIN).max(widest + 2 * MARGIN);
    let columns = ((width - MARGIN) / widest).max(1);
    let lines = shown.len().div_ceil(columns);
    let strip = MARGIN + text::LINE + 6 + lines * (text::LINE + 4) + 6;
    let mut p = Picture::new(width, map.height + strip, PAPER);
    let left = (width - map.width) / 2;
    for (y, row) in map.pixels.chunks(map.width.max(1)).enumerate() {
        p.pixels[y * width + left..][..map.width].copy_from_slice(row);
    }
    text::draw(&mut p, MARGIN, map.height + MARGIN - 4, &title, INK);
    let top = map.height + MARGIN + text::LINE + 2;
    for (k, (class, label)) in shown.iter().enumerate() {
        // Down the columns, as one reads a list.
        let (x, y) = (MARGIN + (k / lines) * widest, top + (k % lines) * (text::LINE + 4));
        for dy in 0..BAR {
            p.pixels[(y + 1 + dy) * width + x..][..BAR].fill(classes[*class].colour);
        }
        text::draw(&mut p, x + BAR + 6, y, label, INK);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(Scale::linear(0.0, 1.0, None, false).ticks(5), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(Scale::log(0.001, 100.0).ticks(6), [0.001, 0.01, 0.1, 1.0, 10.0, 100.0]);
        let ticks = Scale::linear(-812.0, 1130.0, Some(0.0), true).ticks(6);
        assert!(ticks.contains(&0.0) && ticks.len() <= 9, "{ticks:?}");
        assert!(Scale::linear(3.0, 3.0, None, false).ticks(5).len() == 1);
    }

    #[test]
    fn labels_are_short() {
        let cases = [(0.0, "0"), (1200.0, "1200"), (0.25, "0.25"), (1e-5, "1e-5"), (2e6, "2e6"), (-0.5, "-0.5")];
        cases.into_iter().for_each(|(v, text)| assert_eq!(label(v), text));
        assert_eq!(title(&known::HEIGHT), "height (m)");
        assert_eq!(title(&known::WETNESS), "wetness");
    }

    #[test]
    fn the_legend_holds_ink_and_every_colour() {
        let map = Picture::new(300, 10, [9, 9, 9]);
        let p = below(&map, &known::WATER, ColourMap::Viridis, &Scale::linear(0.0, 4.0, None, false));
        let strip = &p.pixels[10 * p.width..];
        assert!(strip.iter().filter(|c| c.iter().all(|v| *v < 90)).count() > 100, "no text");
        let close = |c: &[u8; 3], to: [f32; 3]| (0..3).all(|k| (f32::from(c[k]) - 255.0 * to[k]).abs() < 3.0);
        for t in [0.0, 0.5, 1.0] {
            assert!(strip.iter().any(|c| close(c, ColourMap::Viridis.at(t))));
        }
    }
}
