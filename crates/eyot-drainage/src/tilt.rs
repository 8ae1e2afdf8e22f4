//! Gradients for filled depressions: raises cells until each lies above its receiver.

use super::{Height, Routing, check_length};
use eyot_core::{Error, Result};

impl Routing {
    /// Raises cells of `surface`, on which this routing was made, until each falls towards its receiver with at least `slope`
    /// (1), and by no less than the type's precision. Cells that are steep enough keep their height.
    ///
    /// Water on the filled depressions then finds its way without resolving flats again; the rise over a flat is the length of
    /// the way to its outflow times `slope`, and may bury low ground beside it.
    ///
    /// # Errors
    /// If `surface` has another size than the network, or the slope is negative or not finite.
    pub fn tilt<T: Height>(&self, surface: &mut [T], slope: f64) -> Result<()> {
        check_length("surface", self.cells(), surface.len())?;
        if !(slope.is_finite() && slope >= 0.0) {
            let reason = format!("is {slope}, it must be 0 or a small positive number");
            return Err(Error::BadParameter { owner: "drainage".into(), field: "slope".into(), reason });
        }
        for i in self.order() {
            let i = i as usize;
            if !self.is_outlet(i) {
                let below = surface[self.receiver(i)];
                let even = T::of(below.to_f64() + slope * self.distance_m(i));
                let least = if even > below { even } else { below.above() };
                surface[i] = if surface[i] < least { least } else { surface[i] };
            }
        }
        Ok(())
    }
}
