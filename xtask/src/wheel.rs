//! The wheel of the Python package.

use std::path::Path;
use std::process::Command;

/// Builds `target/wheels/eyot-*.whl` with the Python of the path, or of `PYTHON`.
pub(crate) fn build(root: &Path) -> Result<(), String> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let (package, wheels) = (root.join("bindings/python"), root.join("target/wheels"));
    // With the workspace's own folder of artefacts: a copy of the sources elsewhere would be compiled from nothing.
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| root.join("target").into());
    let status = Command::new(python)
        .args(["-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir"])
        .args([&wheels, &package])
        .env("CARGO_TARGET_DIR", target)
        .status()
        .map_err(|e| format!("cannot start Python: {e}; install Python 3.11 or later, or name it in PYTHON"))?;
    if status.success() {
        println!("the wheel is in {}", wheels.display());
        return Ok(());
    }
    Err("pip could not build the wheel; it needs the module venv or ensurepip (python3-venv on Debian)".to_owned())
}
