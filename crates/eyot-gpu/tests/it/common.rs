//! A device for tests.

use eyot_gpu::{Choice, Gpu, blocking};

/// Any adapter. Where `EYOT_REQUIRE_GPU` is set a missing one fails the test, elsewhere the test is skipped and says so.
pub(crate) fn gpu() -> Option<Gpu> {
    match blocking::open(&Choice::Best) {
        Ok(gpu) => Some(gpu),
        Err(e) if std::env::var_os("EYOT_REQUIRE_GPU").is_some() => panic!("{e}"),
        Err(e) => {
            eprintln!("skipped: {e}");
            None
        }
    }
}
