//! The Rust of the book: `cargo test -p xtask --doc` compiles and runs it as users would who depend on the facade.

#[cfg(doctest)]
#[doc = include_str!("../../docs/book/src/tutorial/library.md")]
struct Library;
