//! Sources with lines that fit on a screen: what stands far from a mistake is cut away.

use std::borrow::Cow;
use std::ops::Range;

/// Lines up to this length are shown whole, characters.
const LONGEST: usize = 240;
/// Characters that are kept on either side of a mistake in a longer line.
const AROUND: usize = 60;
const CUT: &str = "...";

/// `text` with its long lines cut, the place of `span` in it, and the column of the mistake (from 1, in characters) if its
/// line was cut. Lines keep their numbers.
pub(crate) fn excerpt(text: &str, span: Range<usize>) -> (String, Range<usize>, Option<usize>) {
    let start = text.floor_char_boundary(span.start.min(text.len()));
    let end = text.floor_char_boundary(span.end.clamp(start, text.len()));
    let (mut out, mut place, mut column) = (String::new(), 0..0, None);
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let here = at..at + line.len();
        at = here.end;
        let last = here.end == text.len();
        if !(here.contains(&start) || last && start == here.end) {
            out += &clipped(line.trim_end_matches('\n'), LONGEST);
            out += if line.ends_with('\n') { "\n" } else { "" };
            continue;
        }
        if line.chars().count() <= LONGEST {
            place = out.len() + start - here.start..out.len() + end - here.start;
            out += line;
            continue;
        }
        let before = &line[..start - here.start];
        column = Some(before.chars().count() + 1);
        let first = before.char_indices().rev().take(AROUND).last().map_or(before.len(), |(i, _)| i);
        let marked = &line[start - here.start..end.min(here.end) - here.start];
        let marked = marked.trim_end_matches('\n');
        let shown = marked.char_indices().nth(2 * AROUND).map_or(marked, |(i, _)| &marked[..i]);
        let rest = &line[start - here.start + shown.len()..];
        out += if first > 0 { CUT } else { "" };
        out += &line[first..start - here.start];
        place = out.len()..out.len() + shown.len();
        out += shown;
        out += &clipped(rest.trim_end_matches('\n'), AROUND);
        out += if line.ends_with('\n') { "\n" } else { "" };
    }
    let end = out.len();
    (out, place.start.min(end)..place.end.min(end), column)
}

/// At most `most` characters of a text, and dots if that is not all.
pub(crate) fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((i, _)) => Cow::Owned(format!("{}{CUT}", &text[..i])),
        None => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_lines_stay_as_they_are() {
        let text = "a = 1\nb = x\n";
        assert_eq!(excerpt(text, 10..11), (text.to_owned(), 10..11, None));
        assert_eq!(excerpt("", 5..9), (String::new(), 0..0, None));
        assert_eq!(excerpt("ab", 2..2), ("ab".to_owned(), 2..2, None));
    }

    #[test]
    fn long_lines_are_cut_around_the_mistake_and_beside_it() {
        let noise = "é".repeat(50_000);
        for (before, mistake, after) in [(noise.as_str(), "x", ""), ("", "x", &noise), (&noise, &noise, &noise)] {
            let text = format!("one\n{noise}\n{before}{mistake}{after}\nlast");
            let start = 4 + noise.len() + 1 + before.len();
            let (out, place, column) = excerpt(&text, start..start + mistake.len());
            assert!(out.len() < 1500 && out.lines().count() == 4, "{out}");
            assert!(mistake.starts_with(&out[place.clone()]) && !place.is_empty());
            assert_eq!(out[..place.start].matches('\n').count(), 2);
            assert_eq!(column, Some(before.chars().count() + 1));
        }
    }
}
