//! Recipes and changes to them.

use crate::{limits, scratch};
use eyot::{Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry};

pub(crate) const WORDS: &[&str] = &[
    "[grid]",
    "[[step]]",
    "[[export]]",
    "[view]",
    "size",
    "cell",
    "rim",
    "from",
    "generate",
    "simulate",
    "steps",
    "enabled",
    "layer",
    "mask",
    "merge",
    "\"cone\"",
    "\"fbm\"",
    "\"import\"",
    "[\"hydraulic\", \"reef\"]",
    "\"wrap\"",
    "what",
    "\"mask\"",
    "format",
    "\"glb\"",
    "[[layer]]",
    "[[rule]]",
    "next",
    "start",
    "set.water",
    "parameters",
    "layers",
    "prefix",
    "true",
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "4294967296",
    "18446744073709551615",
    "1979-05-27T07:32:00Z",
    "\"\"\"",
    "'''",
    "\\u",
    "=",
    ".",
    "{",
    "}",
    "[",
    "]",
    "\n",
    "#",
];

/// A document.
pub(crate) fn read(bytes: &[u8]) -> bool {
    check(&String::from_utf8_lossy(bytes), Vec::new())
}

/// Texts for `--set`, one a line, on a recipe that has everything.
pub(crate) fn read_flags(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    check(EVERYTHING, text.lines().take(20).map(str::to_owned).collect())
}

fn check(text: &str, set: Vec<String>) -> bool {
    // An empty folder: names of files lead nowhere.
    let folder = scratch("").join("empty");
    let source = RecipeSource { name: "fuzz.toml".into(), text: text.to_owned(), folder };
    // A check allocates nothing, and the recipes that come with Eyot shall pass.
    let limits = Limits { max_bytes: 1 << 30, ..limits() };
    match Recipe::parse(source, Overrides { presets: Vec::new(), set, size: None }, &Registry::standard(), &limits) {
        Ok(recipe) => {
            assert!(recipe.grid.cells() > 0 && recipe.grid.cells() as u64 <= limits.max_cells);
            true
        }
        Err(problems) => {
            assert!(!problems.diagnostics.is_empty(), "refused without a reason");
            for span in problems.diagnostics.iter().filter_map(|d| d.span.as_ref()) {
                let source = problems.source(span).expect("a source that is there");
                assert!(span.start <= span.end && span.end <= source.text.len(), "a place outside the text");
            }
            assert!(!problems.to_string().is_empty());
            false
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    RECIPES.iter().map(|r| r.text).chain([EVERYTHING]).map(|t| t.as_bytes().to_vec()).collect()
}

pub(crate) fn flags() -> Vec<Vec<u8>> {
    let lines = [
        "seed=3\nsea_level=-2.5",
        "grid.size=[64, 32]\ngrid.rim=open\ngrid.cell=2",
        "hydraulic.rain=0.004\nreef.every=3\nthermal.enabled=false",
        "hill.height=300\ncone.radius=0.4\nstep.2.amplitude=7\nstep.hill.layer=\"height\"",
        "moss.limit=0.5\ndrip.every=4\nlayer.moss.next=\"moss[1, -1]\"\nrule.1.mask=\"moss > 0.5\"",
        "export.1.format=\"r32\"\nview={ enabled = false }\nview.size=[64, 48]",
    ];
    lines.iter().map(|l| l.as_bytes().to_vec()).collect()
}

/// Every kind of step, table and value.
const EVERYTHING: &str = r#"
name = "Everything"
seed = 5
[grid]
size = [48, 32]
cell = [10.0, 12.0]
rim = ["wrap", "open"]
[[step]]
name = "hill"
generate = "cone"
height = 150.0
[[step]]
generate = "fbm"
amplitude = 60.0
merge = "multiply"
mask = "height"
[[step]]
generate = "constant"
layer = "springs"
[[layer]]
name = "moss"
unit = "1"
range = [0, 1]
start = "0.1 * random()"
next = "clamp(0.9 * moss + step(0.01, water), 0, limit)"
mask = "height > sea_level"
parameters = { limit = 0.9 }
[[rule]]
name = "drip"
set.water = "water + 0.001 * mean4(moss)"
every = 2
[[step]]
name = "rain"
simulate = ["hydraulic", "thermal", "seabed", "wetness", "reef", "moss", "drip"]
moss.limit = 0.8
steps = 100
thermal.every = 3
reef.sea_level_curve = [[0.0, 0.0], [100.0, 2.0]]
[[export]]
format = "png16"
layers = ["height", "water"]
prefix = "a_"
[[export]]
what = "terrain"
format = "glb"
levels = 2
[[export]]
what = "mask"
enabled = false
[view]
size = [64, 48]
azimuth = 20.0
"#;
