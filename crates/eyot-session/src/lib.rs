//! **Sessions and runs**: recipes being carried out.
//!
//! A [`Session`] is polled: its host gives it time, [`Command`]s go in and [`Event`]s come out. A [`Run`] is a session with a thread, a
//! thread pool and a folder. A recording of frames ([`Timeline`]) is a way back, a checkpoint one forth.
//!
//! What lies outside comes from the [`Host`]: the registry of generators and processes, the time, how engines are opened
//! ([`Engines`]), where checkpoints lie ([`Storage`](eyot_io::storage::Storage)), and who writes what a session has come to
//! ([`Outputs`]). Nothing here draws, exports or knows a graphics card.

mod clock;
pub mod engines;
mod error;
mod event;
mod files;
mod frames;
mod host;
mod lock;
mod run;
mod session;
mod state;
mod stream;
pub mod timeline;
mod watch;

pub use engines::{EngineChoice, EngineOptions, Engines, OpenEngine, Opened, Processor};
pub use error::{RunError, shell_word};
pub use event::{Command, Event, JournalEntry, Progress};
pub use eyot_io::timeline::Record;
pub use files::{CHECKPOINT_FILE, REPORT_FILE, TIMELINE_STORE, WORLD_FILE, former_outputs};
pub use host::{Branches, Clock, Events, Host, NewBranch, Outputs, Results};
pub use run::{Handle, Remote, Run, RunOptions};
pub use session::{Budget, Outcome, Session, SessionOptions, Status};
pub use state::State;
pub use stream::{OVERVIEW, Stream, streamed_memory};
pub use timeline::Timeline;
pub use watch::{Look, Watch, Watcher};

/// Version of the engine.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
