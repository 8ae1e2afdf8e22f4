//! Eyot live: what changes in a world, step by step, to any number of clients.
//!
//! A [`Server`] knows the last [`Scene`] that was published and speaks WebSocket. Whoever connects gets a [`Hello`], the whole
//! state, and then the changes of each moment, as length-checked binary [`Record`]s; a [`Mirror`] puts the state together again,
//! exactly. Clients that the server allows it ([`Control`]) may pause, resume and step, and
//! where it allows that, too, change the run ([`Order`]); nothing else. None of that knows a recipe or a
//! process; what serves runs of recipes is the feature `serve`.
//!
//! ```
//! use eyot_live::{Client, Hello, Options, Scene, Server};
//!
//! let server = Server::bind(Options::default(), |_| {})?;
//! server.hello(Hello { recipe: "Reef".into(), ..Hello::default() });
//! server.publish(Scene::default());
//! let mut client = Client::connect(server.address())?;
//! while client.follow()?.is_none() {}
//! assert_eq!(client.mirror().hello().unwrap().recipe, "Reef");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How nobody gets in the way
//! [`Server::publish`] never waits: a thread of the server compares states, encodes a moment once if anybody needs it, and puts its frames
//! into a bounded queue for each client ([`Options::queue_bytes`]). Each client has a thread that sends and one that reads. Where a queue is
//! full or the client takes nothing for [`Options::lag`], its moments are dropped, and when it has read what was under way it gets the
//! state of that time as a whole. A client that takes nothing at all for [`Options::stall`], or leaves a ping without an answer, is cut off.

mod bytes;
mod client;
mod control;
mod door;
mod frame;
mod line;
mod mirror;
mod origin;
mod record;
mod scene;
#[cfg(feature = "serve")]
pub mod serve;
mod server;
mod visit;

pub use client::{Client, Gone};
pub use control::Control;
pub use mirror::Mirror;
pub use record::{
    Alga, Body, Changed, Colony, Ending, HEADER, Hello, LayerInfo, MAGIC, MAX_RECORD, MAX_STEPS, Malformed, Moment,
    Order, PART, Permission, RAYS, Record, SpeciesInfo, Status, Tile, VERSION, Why,
};
pub use scene::{Raster, Scene};
pub use server::{Error, Notice, Options, Server};
pub use tungstenite::Message;
