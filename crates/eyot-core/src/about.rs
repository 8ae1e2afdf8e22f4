//! The text at the head of a source file as a value, so that `eyot describe` and the book show what a reader of the code sees.

/// The `//!` lines at the head of a source file, without their slashes, as a `&'static str` of Markdown.
///
/// The path is relative to the file that contains the call, as for [`include_str!`]. A file without such a head does not
/// compile.
#[macro_export]
macro_rules! about {
    ($file:literal) => {{
        const SOURCE: &str = include_str!($file);
        // The first pass counts, the second one copies: only the head goes into the program.
        const HEAD: [u8; $crate::about::head::<0>(SOURCE).1] = $crate::about::head(SOURCE).0;
        match ::core::str::from_utf8(&HEAD) {
            Ok(text) => text,
            Err(_) => unreachable!(),
        }
    }};
}

/// The first `N` bytes of a file's head, and how many there are.
///
/// # Panics
/// If the file has no head.
pub const fn head<const N: usize>(source: &str) -> ([u8; N], usize) {
    let bytes = source.as_bytes();
    let (mut out, mut at, mut length) = ([0; N], 0, 0);
    while at + 3 < bytes.len() && bytes[at] == b'/' && bytes[at + 1] == b'/' && bytes[at + 2] == b'!' {
        at += if bytes[at + 3] == b' ' { 4 } else { 3 };
        let mut ended = false;
        while at < bytes.len() && !ended {
            if length < N {
                out[length] = bytes[at];
            }
            ended = bytes[at] == b'\n';
            (at, length) = (at + 1, length + 1);
        }
    }
    assert!(
        length > 0,
        "this file must begin with `//!` lines that say what it does, with equations and source: see CONTRIBUTING.md"
    );
    (out, length)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_head_of_a_file_without_its_slashes() {
        let text = about!("about.rs");
        assert!(text.starts_with("The text at the head of a source file"), "{text}");
        assert_eq!(text.lines().count(), 1);
        let (bytes, length) = super::head::<64>("//! Ü: `x'`\n//!\n//!   - deep\nuse x;\n//! no\n");
        assert_eq!(std::str::from_utf8(&bytes[..length]), Ok("Ü: `x'`\n\n  - deep\n"));
    }

    #[test]
    #[should_panic(expected = "see CONTRIBUTING.md")]
    fn a_file_without_a_head_is_refused() {
        super::head::<0>("// An ordinary comment.\nuse x;\n");
    }
}
