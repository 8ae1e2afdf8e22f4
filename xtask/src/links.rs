//! Finds links and pictures that lead nowhere.

use std::fs;
use std::path::{Path, PathBuf};

/// Broken links of a folder of HTML pages, those to places within a page included.
pub(crate) fn broken_in_site(folder: &Path) -> Vec<String> {
    let mut broken = Vec::new();
    for page in files(folder, "html") {
        // Served for any address that does not exist, so its links start at the root of a server.
        if page.ends_with("404.html") {
            continue;
        }
        let text = fs::read_to_string(&page).unwrap_or_default();
        for link in attribute(&text, "href").chain(attribute(&text, "src")) {
            let (path, place) = link.split_once('#').unwrap_or((link, ""));
            if leaves(link) {
                continue;
            }
            let target = if path.is_empty() { page.clone() } else { beside(&page, path) };
            let found = match (target.is_file(), place) {
                (true, "") => true,
                (true, place) => fs::read_to_string(&target).is_ok_and(|t| attribute(&t, "id").any(|id| id == place)),
                (false, _) => false,
            };
            if !found {
                broken.push(format!("{}: `{link}` leads nowhere", page.display()));
            }
        }
    }
    broken
}

/// Links of a Markdown file that lead to no file.
#[cfg(test)]
fn broken_in_markdown(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap_or_default();
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    links
        .filter(|link| !leaves(link) && !beside(page, link.split('#').next().unwrap_or_default()).exists())
        .map(|link| format!("{}: `{link}` leads nowhere", page.display()))
        .collect()
}

/// Is this a link to elsewhere, which nobody here can check?
fn leaves(link: &str) -> bool {
    ["http://", "https://", "mailto:", "data:", "javascript:"].iter().any(|scheme| link.starts_with(scheme))
}

/// The file that a link on a page means.
fn beside(page: &Path, link: &str) -> PathBuf {
    page.parent().unwrap_or(Path::new("")).join(link.replace("%20", " "))
}

/// Values of an attribute in HTML.
fn attribute<'a>(html: &'a str, name: &str) -> impl Iterator<Item = &'a str> {
    let start = format!(" {name}=\"");
    html.match_indices(&start)
        .map(|(at, found)| &html[at + found.len()..])
        .filter_map(|rest| rest.split('"').next())
        .collect::<Vec<_>>()
        .into_iter()
}

/// Files with an extension in a folder and all below it.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn links_of_the_documents_lead_somewhere() {
        let mut pages: Vec<PathBuf> =
            ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(|f| root().join(f)).into();
        for folder in ["docs", "crates/eyot-recipe/data", "benches"] {
            // The book has pages that exist only once it is built; its own test follows its links.
            pages.extend(
                files(&root().join(folder), "md")
                    .into_iter()
                    .filter(|p| !p.components().any(|c| c.as_os_str() == "book")),
            );
        }
        let broken: Vec<String> = pages.iter().flat_map(|p| broken_in_markdown(p)).collect();
        assert!(pages.len() > 5 && broken.is_empty(), "{}", broken.join("\n"));
    }

    #[test]
    fn broken_links_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("a.html");
        fs::write(&page, r##"<p id="here"><a href="#here"></a> <a href="#there"></a> <img src="b.png"> <a href="https://x.y"></a></p>"##).unwrap();
        let broken = broken_in_site(folder.path());
        assert_eq!(broken.len(), 2, "{broken:?}");
        assert!(broken[0].contains("#there") && broken[1].contains("b.png"));
        let page = folder.path().join("a.md");
        fs::write(&page, "[one](a.html#x) [two](b.html) ![three](https://x.y/z.png)").unwrap();
        assert_eq!(broken_in_markdown(&page).len(), 1);
    }
}
