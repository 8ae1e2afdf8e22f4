//! Strahler order of streams.
//!
//! # Rule
//! A source has order 1. Where streams meet, the order grows by one if the highest order comes from two or more of them,
//! else the highest order goes on.
//!
//! # Source
//! Strahler (1957), Quantitative analysis of watershed geomorphology, Eos 38, 913-920.

use eyot_core::Result;
use eyot_drainage::Routing;
use eyot_drainage::check_length;

/// Strahler order of each cell; 0 where `channel` (one flag a cell) is false.
///
/// # Errors
/// If `channel` has another length than the network.
pub fn strahler_orders(flow: &Routing, channel: &[bool]) -> Result<Vec<u8>> {
    check_length("channel", flow.cells(), channel.len())?;
    let mut order = vec![0_u8; channel.len()];
    // Highest order that has arrived at a cell, and from how many donors.
    let mut arrived = vec![(0_u8, 0_u8); channel.len()];
    for i in flow.order().into_iter().rev() {
        let i = i as usize;
        if !channel[i] {
            continue;
        }
        let (highest, times) = arrived[i];
        order[i] = if times == 1 { highest } else { highest + 1 };
        if !flow.is_outlet(i) {
            let at = &mut arrived[flow.receiver(i)];
            if order[i] > at.0 {
                *at = (order[i], 1);
            } else if order[i] == at.0 {
                at.1 += 1;
            }
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_made_by_hand() {
        // Sources 0, 1, 2, 3, 8. 0+1 -> 4, 2+3 -> 5, 4+5 -> 6, 6+8 -> 7 (root). 9 is no channel and flows into 8.
        let flow = Routing::by_hand(vec![4, 4, 5, 5, 6, 6, 7, 7, 7, 8], [1.0; 9]);
        let channel: Vec<bool> = (0..10).map(|i| i != 9).collect();
        assert_eq!(strahler_orders(&flow, &channel).unwrap(), [1, 1, 1, 1, 2, 2, 3, 3, 1, 0]);
    }

    #[test]
    fn three_equal_streams_count_once() {
        let flow = Routing::by_hand(vec![3, 3, 3, 3], [1.0; 9]);
        assert_eq!(strahler_orders(&flow, &[true; 4]).unwrap(), [1, 1, 1, 2]);
    }
}
