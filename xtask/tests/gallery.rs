//! The book shows every generator.

use std::path::Path;

#[test]
fn every_generator_has_its_picture_and_no_picture_is_left_over() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/gallery");
    let mut pictures: Vec<String> = std::fs::read_dir(&folder)
        .expect("docs/gallery")
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    pictures.sort();
    let mut wanted: Vec<String> =
        eyot::Registry::standard().generator_names().map(|name| format!("{name}.png")).collect();
    wanted.sort();
    assert_eq!(pictures, wanted, "run `cargo xtask gallery`");
}
