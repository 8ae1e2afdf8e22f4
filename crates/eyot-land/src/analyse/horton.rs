//! Horton's ratios: how number, length and area of streams change from order to order; and drainage density.
//!
//! # Equations
//! A *stream* of order w is a connected run of channel cells of order w, with the link from its last cell downstream. With
//! `N(w)`, mean length `L(w)` and mean drained area at the lower end `A(w)`, the ratio `R` is `10^|slope|` of the
//! least-squares line through `log10` over `w`: `R_B` from N, `R_L` from L, `R_A` from A.
//! Drainage density is the length of all channel links over the area.
//!
//! # Source
//! Horton (1945), GSA Bulletin 56, 275-370; Schumm (1956), GSA Bulletin 67, 597-646 (areas).
//!
//! # Reading
//! Any routed surface obeys these laws, noise too; and the density follows from the channel threshold. They describe a
//! network and prove nothing.

use super::moments::line_slope;
use eyot_core::Result;
use eyot_drainage::Routing;
use eyot_drainage::check_length;

/// Streams of one Strahler order.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct StreamOrder {
    /// How many streams.
    pub streams: u32,
    /// Their length together, m.
    pub length_m: f64,
    /// The cells that drain through their lower ends, summed over the streams.
    pub drained_cells: u64,
}

/// Horton's ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HortonRatios {
    /// Bifurcation ratio, 1.
    pub bifurcation: f64,
    /// Length ratio, 1.
    pub length: f64,
    /// Area ratio, 1.
    pub area: f64,
}

/// Streams by order (order 1 first), from Strahler orders and accumulated cells.
///
/// # Errors
/// If the slices differ in length from the network.
pub fn streams_by_order(flow: &Routing, order: &[u8], accumulation: &[u32]) -> Result<Vec<StreamOrder>> {
    check_length("orders", flow.cells(), order.len())?;
    check_length("accumulation", flow.cells(), accumulation.len())?;
    let mut streams = vec![StreamOrder::default(); usize::from(order.iter().copied().max().unwrap_or(0))];
    for (i, &w) in order.iter().enumerate().filter(|&(_, &w)| w > 0) {
        let s = &mut streams[usize::from(w) - 1];
        s.length_m += flow.distance_m(i);
        // Two streams of one order never join into a cell of that order, so each has one lower end.
        if flow.is_outlet(i) || order[flow.receiver(i)] != w {
            s.streams += 1;
            s.drained_cells += u64::from(accumulation[i]);
        }
    }
    Ok(streams)
}

/// Horton's ratios; `None` with fewer than two orders, or if streams of an order have no length.
pub fn horton_ratios(streams: &[StreamOrder]) -> Option<HortonRatios> {
    let ratio = |f: &dyn Fn(&StreamOrder) -> f64| {
        let points: Vec<_> = streams.iter().enumerate().map(|(w, s)| (w as f64, f(s).log10())).collect();
        line_slope(&points).map(|slope| 10.0_f64.powf(slope.abs()))
    };
    Some(HortonRatios {
        bifurcation: ratio(&|s| f64::from(s.streams))?,
        length: ratio(&|s| s.length_m / f64::from(s.streams))?,
        area: ratio(&|s| s.drained_cells as f64 / f64::from(s.streams))?,
    })
}

#[cfg(test)]
mod tests {
    use super::super::strahler::strahler_orders;
    use super::*;

    #[test]
    fn a_perfect_tree_has_its_ratios() {
        // 4 sources, 2 of order 2, 1 of order 3; two cells a stream.
        let receiver = vec![1, 8, 3, 8, 5, 10, 7, 10, 9, 12, 11, 12, 13, 13];
        let flow = Routing::by_hand(receiver, [1.0; 9]);
        let order = strahler_orders(&flow, &[true; 14]).unwrap();
        assert_eq!(order, [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3]);
        let streams = streams_by_order(&flow, &order, &flow.upstream_cells()).unwrap();
        let expect = |streams, length_m, drained_cells| StreamOrder { streams, length_m, drained_cells };
        assert_eq!(streams, [expect(4, 8.0, 8), expect(2, 4.0, 12), expect(1, 2.0, 14)]);
        let r = horton_ratios(&streams).unwrap();
        assert!((r.bifurcation - 2.0).abs() < 1e-12 && (r.length - 1.0).abs() < 1e-12);
        assert!((r.area - 7.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn nothing_or_one_order_has_no_ratio() {
        assert_eq!(horton_ratios(&[]), None);
        assert_eq!(horton_ratios(&[StreamOrder { streams: 3, length_m: 0.0, drained_cells: 9 }]), None);
        assert_eq!(horton_ratios(&[StreamOrder { streams: 3, length_m: 0.0, drained_cells: 9 }; 2]), None);
    }
}
