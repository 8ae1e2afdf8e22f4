//! Small PNG files: pictures in 96 colours, found by median cut (Heckbert 1982).

use eyot_render::Picture;
use std::error::Error;
use std::path::Path;

const COLOURS: usize = 96;

/// Colours with how often they occur, cut in halves along their widest channel until there are enough boxes.
fn choose(pixels: &[[u8; 3]]) -> Vec<[u8; 3]> {
    let mut sorted = pixels.to_vec();
    sorted.sort_unstable();
    let mut boxes = vec![sorted];
    let spread = |b: &[[u8; 3]]| {
        let range = |k: usize| {
            let (low, high) = b.iter().fold((255, 0), |(l, h), c| (c[k].min(l), c[k].max(h)));
            u32::from(high.saturating_sub(low))
        };
        (0..3).map(|k| (range(k), k)).max_by_key(|&(r, k)| (r, 3 - k)).unwrap_or((0, 0))
    };
    while boxes.len() < COLOURS {
        // Wide boxes with many pixels first.
        let weight = |b: &Vec<[u8; 3]>| u64::from(spread(b).0) * (b.len() as u64).isqrt();
        let Some(widest) = (0..boxes.len()).max_by_key(|&i| (weight(&boxes[i]), i)) else { break };
        let (range, channel) = spread(&boxes[widest]);
        if range == 0 {
            break;
        }
        let mut low = boxes.swap_remove(widest);
        low.sort_unstable_by_key(|c| (c[channel], *c));
        // All pixels of one value stay together.
        let middle = low[low.len() / 2][channel];
        let cut = low.partition_point(|c| c[channel] < middle);
        let cut = if cut == 0 { low.partition_point(|c| c[channel] <= middle) } else { cut };
        let high = low.split_off(cut);
        boxes.extend([low, high]);
    }
    let mean = |b: &Vec<[u8; 3]>| {
        let n = b.len() as u64;
        [0, 1, 2].map(|k| ((b.iter().map(|c| u64::from(c[k])).sum::<u64>() + n / 2) / n) as u8)
    };
    let mut palette: Vec<[u8; 3]> = boxes.iter().filter(|b| !b.is_empty()).map(mean).collect();
    palette.sort_unstable();
    palette.dedup();
    palette
}

/// Writes a picture in few colours.
pub(crate) fn write(path: &Path, picture: &Picture) -> Result<(), Box<dyn Error>> {
    let palette = choose(&picture.pixels);
    let distance = |a: &[u8; 3], b: &[u8; 3]| (0..3).map(|k| i32::from(a[k].abs_diff(b[k])).pow(2)).sum::<i32>();
    let nearest = |c: &[u8; 3]| (0..palette.len()).min_by_key(|&i| distance(&palette[i], c)).unwrap_or(0) as u8;
    let indices: Vec<u8> = picture.pixels.iter().map(nearest).collect();
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.as_flattened());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header()?.write_image_data(&indices)?;
    Ok(())
}
