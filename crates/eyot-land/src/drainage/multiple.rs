//! Multiple-flow routing: water spreads over all lower neighbours, more to the steeper ones.
//!
//! # Equation
//! Neighbour `j` gets the share `s_j^p / sum s_k^p`, `s = (z - z_j) / distance`, over all lower neighbours. The exponent `p`
//! decides how much water gathers: 1 spreads it most (Quinn et al. 1991 without their contour lengths), 1.1 is right on
//! cones (Freeman 1991), towards infinity it becomes D8. Cells without a lower neighbour, on flats, hand everything to their
//! single receiver.
//!
//! # Source
//! Freeman (1991), Calculating catchment area with divergent flow based on a regular grid, Computers & Geosciences 17,
//! 413-422; Quinn, Beven, Chevallier & Planchon (1991), Hydrological Processes 5, 59-79.
//!
//! # Conserves
//! What arrives at the outlets is the sum of all amounts, to rounding in double precision.

use super::{Height, Neighbours, Routing, check_length, check_sizes};
use eyot_core::{Control, Error, Grid, Result, math};

/// Cells between two looks at the stop button.
const BATCH: usize = 1 << 20;

impl Routing {
    /// Adds to each cell's amount its share of what lies upstream, spread with the exponent `p` over the lower neighbours on
    /// `surface`, from which this routing was made. See [`Routing::accumulate`] for amounts.
    ///
    /// # Errors
    /// If `surface` or `amounts` has another size than the network, the exponent is not within 0..=100, or on a request to
    /// stop.
    pub fn accumulate_multiple<T: Height>(
        &self,
        surface: &[T],
        grid: &Grid,
        p: f64,
        amounts: &mut [f64],
        control: &Control<'_>,
    ) -> Result<()> {
        check_sizes(grid, &[("surface", surface.len()), ("amounts", amounts.len())])?;
        check_length("cells of the network", grid.cells(), self.cells())?;
        if !(0.0..=100.0).contains(&p) {
            let reason = format!("is {p}, it must lie within 0..=100");
            return Err(Error::BadParameter { owner: "multiple flow".into(), field: "exponent".into(), reason });
        }
        let near = Neighbours::new(grid);
        let per_m = near.distance_m.map(|d| 1.0 / d);
        let gives = |i: usize, mut f: &mut dyn FnMut(usize, f64)| self.gives(surface, &near, &per_m, i, &mut f);
        let mut waiting = vec![0_u8; self.cells()];
        for i in 0..self.cells() {
            gives(i, &mut |j, _| waiting[j] += 1);
        }
        let mut ready: Vec<u32> = (0..self.cells() as u32).filter(|&i| waiting[i as usize] == 0).collect();
        let mut done = 0;
        while let Some(i) = ready.pop() {
            let i = i as usize;
            if done % BATCH == 0 {
                control.tick(done as u64, self.cells() as u64)?;
            }
            done += 1;
            let mut sum = 0.0;
            let mut shares = [(0, 0.0); 8];
            let mut n = 0;
            gives(i, &mut |j, slope| {
                let share = if p == 1.0 { slope } else { math::pow(slope, p) };
                sum += share;
                shares[n] = (j, share);
                n += 1;
            });
            let amount = amounts[i];
            for &(j, share) in &shares[..n] {
                amounts[j] += amount * (share / sum);
                waiting[j] -= 1;
                if waiting[j] == 0 {
                    ready.push(j as u32);
                }
            }
        }
        Ok(())
    }

    /// Calls `f(neighbour, slope relative to the steepest)` for each cell that gets water from cell `i`.
    #[inline(always)]
    fn gives<T: Height>(&self, z: &[T], near: &Neighbours, per_m: &[f64; 8], i: usize, f: &mut impl FnMut(usize, f64)) {
        if self.is_outlet(i) {
            return;
        }
        let to = self.receiver[i] as usize;
        let fall = |j: usize| z[i].to_f64() - z[j].to_f64();
        let steepest = fall(to) * per_m[usize::from(self.direction[i])];
        if steepest <= 0.0 {
            return f(to, 1.0);
        }
        near.each(i, |d, j| {
            if z[j] < z[i] {
                f(j, fall(j) * per_m[d] / steepest);
            }
        });
    }
}
