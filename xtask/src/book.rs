//! Builds the book: mdBook as a library, with the reference made from the schema.

use crate::reference::Reference;
use crate::{links, root, warnings};
use mdbook_driver::MDBook;
use std::path::Path;

/// Builds the book into a folder. Warnings and broken links are errors.
pub(crate) fn build(out: &Path) -> Result<(), String> {
    let out = std::path::absolute(out).map_err(|e| format!("{}: {e}", out.display()))?;
    let failed = |e| format!("the book was not built: {e:#}");
    let (built, warnings) = warnings::collect(|| {
        let mut book = MDBook::load(root().join("docs/book"))?;
        book.config.build.build_dir = out.clone();
        book.with_preprocessor(Reference);
        book.build()
    });
    built.map_err(failed)?;
    copy_pictures(&root().join("docs/gallery"), &out.join("gallery"))?;
    let problems: Vec<String> = warnings.into_iter().chain(links::broken_in_site(&out)).collect();
    if problems.is_empty() {
        println!("{}", out.join("index.html").display());
        return Ok(());
    }
    Err(problems.join("\n"))
}

/// Copies the pictures of generators, which lie outside the book.
fn copy_pictures(from: &Path, to: &Path) -> Result<(), String> {
    let fail = |e: std::io::Error| format!("{}: {e}", to.display());
    let Ok(pictures) = std::fs::read_dir(from) else { return Ok(()) };
    std::fs::create_dir_all(to).map_err(fail)?;
    for picture in pictures {
        let picture = picture.map_err(fail)?;
        std::fs::copy(picture.path(), to.join(picture.file_name())).map_err(fail)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_book_builds_without_warnings_and_its_links_lead_somewhere() {
        let folder = tempfile::tempdir().unwrap();
        build(folder.path()).unwrap_or_else(|problems| panic!("{problems}"));
        let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(page("reference/generators/cone.html").contains("1 - r^p"));
        assert!(page("reference/processes/hydraulic.html").contains("10.1109/PG.2007.15"));
        assert!(page("reference/recipe.html").contains("extent_m"));
    }
}
