//! The door: takes connections, and bounds how many handshakes are under way.

use crate::server::Hub;
use crate::visit;
use std::collections::HashMap;
use std::net::{IpAddr, Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Connections whose handshake is not done yet. When one more comes, one of the address that has the most is cut, its oldest: whoever
/// says nothing keeps nobody out.
const MAX_HANDSHAKES: usize = 16;
/// So much time each handshake has; the next connection waits for it before the door. Who speaks at once is let in, however many come
/// that do not.
const GRACE: Duration = Duration::from_millis(250);
/// After a failure to accept, such as too many open files.
const PAUSE: Duration = Duration::from_millis(50);

/// Handshakes under way, oldest first.
#[derive(Default)]
pub(crate) struct Handshakes {
    waiting: Mutex<Vec<Waiting>>,
    /// One has ended.
    ended: Condvar,
    numbers: AtomicU64,
}

struct Waiting {
    number: u64,
    ip: IpAddr,
    since: Instant,
    /// A way to cut it.
    stream: TcpStream,
}

impl Handshakes {
    fn lock(&self) -> MutexGuard<'_, Vec<Waiting>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for room, which there is after [`GRACE`] at the latest.
    fn begin(&self, ip: IpAddr, stream: TcpStream) -> u64 {
        let number = self.numbers.fetch_add(1, Ordering::Relaxed);
        let mut waiting = self.lock();
        while waiting.len() >= MAX_HANDSHAKES {
            let oldest = oldest_of_the_most(&waiting);
            let age = waiting[oldest].since.elapsed();
            if age >= GRACE {
                // What is gone already needs no cut.
                let _ = waiting.remove(oldest).stream.shutdown(Shutdown::Both);
            } else {
                waiting = self.ended.wait_timeout(waiting, GRACE - age).unwrap_or_else(PoisonError::into_inner).0;
            }
        }
        waiting.push(Waiting { number, ip, since: Instant::now(), stream });
        number
    }
}

/// The place of the oldest one of the address that has the most.
fn oldest_of_the_most(waiting: &[Waiting]) -> usize {
    let mut counts = HashMap::new();
    waiting.iter().for_each(|w| *counts.entry(w.ip).or_insert(0) += 1);
    let most = counts.values().max().copied().unwrap_or_default();
    waiting.iter().position(|w| counts[&w.ip] == most).unwrap_or_default()
}

/// A handshake under way; ends when it is dropped.
pub(crate) struct Handshake(Arc<Hub>, u64);

impl Drop for Handshake {
    fn drop(&mut self) {
        self.0.handshakes.lock().retain(|w| w.number != self.1);
        self.0.handshakes.ended.notify_all();
    }
}

/// Takes connections until the server closes.
pub(crate) fn accept(listener: &TcpListener, hub: &Arc<Hub>) {
    loop {
        let (stream, address) = match listener.accept() {
            _ if hub.is_closing() => return,
            Ok(found) => found,
            Err(_) => {
                std::thread::sleep(PAUSE);
                continue;
            }
        };
        let Ok(cutter) = stream.try_clone() else { continue };
        let handshake = Handshake(hub.clone(), hub.handshakes.begin(address.ip(), cutter));
        let hub = hub.clone();
        // Without a thread the connection is dropped.
        let _ = std::thread::Builder::new()
            .name("eyot-client".to_owned())
            .spawn(move || visit::receive(&hub, stream, address, handshake));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn the_address_with_the_most_loses_its_oldest() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let waiting = |ips: &[u8]| -> Vec<Waiting> {
            let one = |(i, ip): (usize, &u8)| Waiting {
                number: i as u64,
                ip: IpAddr::from([10, 0, 0, *ip]),
                since: Instant::now(),
                stream: TcpStream::connect(listener.local_addr().unwrap()).unwrap(),
            };
            ips.iter().enumerate().map(one).collect()
        };
        assert_eq!(oldest_of_the_most(&waiting(&[1, 2, 2, 3, 2])), 1);
        assert_eq!(oldest_of_the_most(&waiting(&[1, 1, 1])), 0);
        assert_eq!(oldest_of_the_most(&waiting(&[3, 4, 5])), 0);
    }
}
