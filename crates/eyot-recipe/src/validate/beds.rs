//! Files with surfaces of beds, which have to fit the grid.

use super::Validator;
use crate::diagnostic::Diagnostic;
use crate::node::Node;
use serde_json::Value;

/// Layers that say where beds lie.
const SURFACES: [&str; 5] = ["bed_1", "bed_2", "bed_3", "bed_4", "bed_shift"];

impl Validator<'_> {
    /// Finds surfaces of beds in a file of another size than the grid that the recipe gives. A height map is resampled without a word; the
    /// surface of a bed that does not lie on the cells of the ground would cut it where no rock does.
    pub(super) fn bed_file(&mut self, node: &Node, parameters: &Value) {
        let layer = node.get("layer").and_then(Node::text).unwrap_or_default();
        let (Some(file), Some((width, height))) = (parameters["file"].as_str(), self.written) else { return };
        if !SURFACES.contains(&layer) || node.get("window").is_some() {
            return;
        }
        // What cannot be read is told by the generator, which knows how files without a header are read.
        let Ok(found) = self.registry.files().raster(file, self.limits) else { return };
        if (found.width, found.height) != (width, height) {
            let at = node.get("file").unwrap_or(node).span.clone();
            let message = format!(
                "the surface `{layer}` has {} x {} cells, the grid {width} x {height}",
                found.width, found.height
            );
            let help = "give the grid the size of the file, or say with `window` which part of the file covers the grid: that is resampled";
            self.out.push(Diagnostic::at(at, message, "another size").help(help));
        }
    }
}
