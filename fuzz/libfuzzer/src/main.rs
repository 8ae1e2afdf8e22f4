//! All targets under libFuzzer; the environment says which:
//!
//! ```sh
//! cargo install cargo-fuzz
//! EYOT_TARGET=png cargo +nightly fuzz run --fuzz-dir fuzz/libfuzzer eyot fuzz/corpus/png -- -rss_limit_mb=512 -max_len=65536
//! ```

#![no_main]

use std::sync::LazyLock;

static TARGET: LazyLock<&'static eyot_fuzz::Target> = LazyLock::new(|| {
    let name = std::env::var("EYOT_TARGET").unwrap_or_default();
    eyot_fuzz::target(&name).unwrap_or_else(|| panic!("set EYOT_TARGET to the name of a target, not `{name}`"))
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    (TARGET.run)(data);
});
