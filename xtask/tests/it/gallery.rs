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
    // Other choices than the default of these.
    for (name, key) in [("fbm", "basis"), ("worley", "distance"), ("smooth", "kernel")] {
        let about = eyot::describe(name, &eyot::Registry::standard()).unwrap();
        let parameter = about.parameters.iter().find(|p| p.name == key).unwrap();
        let others = parameter.choices.iter().filter(|c| parameter.default != c.value.as_str());
        wanted.extend(others.map(|c| format!("{name}-{}.png", c.value)));
    }
    wanted.sort();
    assert_eq!(pictures, wanted, "run `cargo xtask gallery`");
}
