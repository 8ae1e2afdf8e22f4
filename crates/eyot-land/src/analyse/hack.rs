//! Hack's law: the longest stream grows as a power of the drained area, `L ~ A^h`.
//!
//! # Definition
//! Points are the confluences, channel cells that receive at least two channel cells: `A` is what drains through the cell,
//! `L` the longest way to it from the divide (hillslope included). `h` is the slope of the least-squares line through
//! `log L` over `log A`.
//!
//! # Source
//! Hack (1957), Studies of longitudinal stream profiles in Virginia and Maryland, USGS Professional Paper 294-B (h = 0.6).

use super::moments::line_slope;
use eyot_core::Result;
use eyot_drainage::Routing;
use eyot_drainage::check_length;

/// Hack's exponent over the confluences of `channel`; `None` with fewer than three of them or without spread of area.
///
/// # Errors
/// If the slices differ in length from the network.
pub fn hack_exponent(flow: &Routing, channel: &[bool], accumulation: &[u32]) -> Result<Option<f64>> {
    check_length("channel", flow.cells(), channel.len())?;
    check_length("accumulation", flow.cells(), accumulation.len())?;
    let mut donors = vec![0_u8; channel.len()];
    for i in (0..channel.len()).filter(|&i| channel[i] && !flow.is_outlet(i)) {
        donors[flow.receiver(i)] += 1;
    }
    let length_m = flow.longest_upstream_m();
    let points: Vec<(f64, f64)> = (0..channel.len())
        .filter(|&i| channel[i] && donors[i] >= 2)
        .map(|i| (f64::from(accumulation[i]).ln(), length_m[i].ln()))
        .collect();
    Ok(if points.len() < 3 { None } else { line_slope(&points) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comb_grows_in_proportion() {
        // A trunk 0 -> 1 -> ... -> 9 that receives one side cell (10 + k) at each cell k > 0: A = 2 k + 1, L = k.
        let mut receiver: Vec<u32> = (1..=9).chain([9]).collect();
        receiver.extend(1..=9);
        let flow = Routing::by_hand(receiver, [1.0; 9]);
        let h = hack_exponent(&flow, &[true; 19], &flow.upstream_cells()).unwrap().unwrap();
        let points: Vec<_> = (1..10).map(|k| (f64::from(2 * k + 1).ln(), f64::from(k).ln())).collect();
        assert_eq!(Some(h), line_slope(&points));
        assert_eq!(hack_exponent(&flow, &[false; 19], &flow.upstream_cells()).unwrap(), None);
    }
}
