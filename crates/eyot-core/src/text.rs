//! What texts of recipes and grammars have in common.

/// Bytes of the number without sign that a text begins with, such as `12`, `.5` or `2.5e-3`; an `e` without digits behind it is no
/// part of it.
pub fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut n = digits(0);
    if bytes.get(n) == Some(&b'.') {
        n += 1 + digits(n + 1);
    }
    if matches!(bytes.get(n), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(n + 1), Some(b'+' | b'-')));
        let exponent = digits(n + 1 + sign);
        if exponent > 0 {
            n += 1 + sign + exponent;
        }
    }
    n
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_end_where_they_end() {
        for (text, number) in
            [("12+3", "12"), (".5 m", ".5"), ("2.5e-3x", "2.5e-3"), ("3e", "3"), ("3e+", "3"), ("1.", "1."), ("x", "")]
        {
            assert_eq!(&text[..super::number_length(text)], number);
        }
    }
}
