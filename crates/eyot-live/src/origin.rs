//! Which web pages may connect. Browsers let every page open a WebSocket to the machine they run on, and say in the header
//! `Origin` whose page it is; programs send no such header.

/// True for an origin that is a page of this machine itself, or one of those allowed.
pub(crate) fn is_welcome(origin: &str, allowed: &[String]) -> bool {
    let same = |a: &String| a.trim_end_matches('/').eq_ignore_ascii_case(origin);
    allowed.iter().any(same) || is_local(origin)
}

fn is_local(origin: &str) -> bool {
    let lower = origin.to_ascii_lowercase();
    let Some(host) = lower.strip_prefix("http://").or_else(|| lower.strip_prefix("https://")) else { return false };
    let (name, port) = match host.strip_prefix('[').and_then(|h| h.split_once(']')) {
        Some((name, rest)) => (name, rest),
        None => host.split_at(host.find(':').unwrap_or(host.len())),
    };
    let has_port = port.strip_prefix(':').is_some_and(|p| p.parse::<u16>().is_ok());
    matches!(name, "localhost" | "127.0.0.1" | "::1") && (port.is_empty() || has_port)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_from_elsewhere_are_not_welcome() {
        for origin in ["http://localhost", "http://127.0.0.1:8000", "https://[::1]:8443", "HTTP://LOCALHOST:1"] {
            assert!(is_welcome(origin, &[]), "{origin}");
        }
        for origin in [
            "https://example.org",
            "http://localhost.example.org",
            "http://127.0.0.1.example.org",
            "http://localhost:80@example.org",
            "http://[::1].example.org",
            "http://example.org/localhost",
            "null",
            "file://",
            "",
        ] {
            assert!(!is_welcome(origin, &[]), "{origin}");
        }
        let allowed = ["https://example.org".to_owned(), "null".to_owned()];
        assert!(is_welcome("https://example.org", &allowed) && is_welcome("null", &allowed));
        assert!(!is_welcome("https://example.org:8443", &allowed) && !is_welcome("http://example.org", &allowed));
    }
}
