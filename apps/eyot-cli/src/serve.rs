//! `serve`: a run whose steps go to other programs.

use crate::args::{Change, Work, bytes};
use crate::progress::Bars;
use crate::runs::{Interrupts, folder_name, options};
use crate::wording::CommandLine;
use crate::{Failure, print, recipe_cmd, report};
use clap::Args;
use eyot::live::{self, Control, ServeOptions, Serving};
use eyot::{Event, Registry, RunOptions};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Without --listen; EYOT on the keys of a telephone, after a 1.
const PORT: u16 = 13968;
/// After the run, clients may take so long to read what waits for them.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often an interrupt is looked for after the run.
const LOOK: Duration = Duration::from_millis(100);

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot serve reef                                   each month's changes, at 127.0.0.1:13968
  eyot serve reef --rate 2 --wait 1 --linger        two months a second, once somebody is there
  eyot serve island --layers height,water --every 20
  eyot serve reef --out reef --resume               go on with a stopped run

The book's page \"The network stream\" describes the protocol, and has clients to start from. Everybody may watch. Who connects with the \
token that is printed may pause, resume and step the run, and with --allow-changes change it. A client that is too slow for all changes gets the whole state again; it never \
delays the run.")]
pub(crate) struct Serve {
    /// A recipe file, or the name of a built-in recipe; not used with --resume
    #[arg(required_unless_present = "resume")]
    recipe: Option<String>,
    /// Folder for the results [default: as for `eyot run`]
    #[arg(long, short, value_name = "DIR", required_if_eq("resume", "true"))]
    out: Option<PathBuf>,
    #[command(flatten)]
    change: Change,
    #[command(flatten)]
    work: Work,
    /// Start over where a stopped run lies in the folder
    #[arg(long)]
    restart: bool,
    /// Overwrite files in the folder that are not of a former run
    #[arg(long, conflicts_with = "resume")]
    force: bool,
    /// Continue the stopped run in the folder, as `eyot resume` does
    #[arg(long, conflicts_with_all = ["restart", "seed", "size", "set"])]
    resume: bool,
    /// Address and port; port 0 is any that is free, and is printed
    #[arg(long, value_name = "IP:PORT", default_value_t = SocketAddr::from((Ipv4Addr::LOCALHOST, PORT)), value_parser = address)]
    listen: SocketAddr,
    /// Allow an address that other machines can reach; the stream is not encrypted and asks for no password
    #[arg(long)]
    public: bool,
    /// Let pages of this origin connect, such as `https://example.org`; may be repeated. Pages of this machine always may
    #[arg(long, value_name = "ORIGIN")]
    allow_origin: Vec<String>,
    /// Most clients at a time
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u16).range(1..=1024))]
    clients: u16,
    /// Bytes of changes that may wait for a slow client, such as 16M; then it gets the whole state instead
    #[arg(long, value_name = "BYTES", default_value = "16M", value_parser = bytes)]
    queue: u64,
    /// What clients give to pause, resume, step and change the run, `?token=TEXT` after the address [default: a new one for each run, printed]
    #[arg(long, value_name = "TEXT", value_parser = token)]
    token: Option<String>,
    /// Let those clients change the run, too: parameters, the sea, layers. The report lists what they did; `eyot run --replay` does it again
    #[arg(long, conflicts_with = "read_only")]
    allow_changes: bool,
    /// Take no orders from clients
    #[arg(long, conflicts_with = "token")]
    read_only: bool,
    /// Layers to send, such as height,water
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    layers: Vec<String>,
    /// Steps of simulation from one moment to the next
    #[arg(long, value_name = "STEPS", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Send colonies without their 24 rays: a third of the bytes
    #[arg(long)]
    no_rays: bool,
    /// Most steps of simulation a second [default: as fast as it goes]
    #[arg(long, value_name = "STEPS", value_parser = rate)]
    rate: Option<f64>,
    /// Wait for so many clients before the first step
    #[arg(long, value_name = "N", default_value_t = 0)]
    wait: u16,
    /// Serve the last state for so many seconds after the end; without a number until Ctrl-C
    #[arg(long, value_name = "S", num_args = 0..=1, default_missing_value = "inf", value_parser = seconds)]
    linger: Option<f64>,
}

/// Runs a recipe, or goes on with a run, and serves it.
pub(crate) fn serve(args: &Serve) -> Result<(), Failure> {
    if usize::from(args.wait) > usize::from(args.clients) {
        let message = format!("--wait {} is more than the {} clients that may come", args.wait, args.clients);
        return Err(report::usage(&message, "wait for fewer, or allow more with --clients"));
    }
    let serve = ServeOptions {
        server: live::Options {
            listen: args.listen,
            public: args.public,
            max_clients: args.clients.into(),
            allow_origins: args.allow_origin.clone(),
            queue_bytes: usize::try_from(args.queue).unwrap_or(usize::MAX),
            control: match &args.token {
                _ if args.read_only => Control::Nobody,
                Some(token) => Control::Token(token.clone()),
                None => Control::random(),
            },
            changes: args.allow_changes,
            ..live::Options::default()
        },
        layers: args.layers.clone(),
        every: args.every,
        rays: !args.no_rays,
        rate: args.rate,
        wait: args.wait.into(),
    };
    let run = RunOptions { limits: recipe_cmd::limits(args.change.max_memory), ..options(&args.work)? };
    let interrupts = Interrupts::install();
    let host = eyot::host(&Registry::standard());
    let (serving, out) = match (&args.recipe, &args.out) {
        (_, Some(out)) if args.resume => {
            (Serving::resume(out, run, serve, &host).map_err(|e| report::run(&e))?, out.clone())
        }
        (Some(name), out) => {
            let recipe = recipe_cmd::read(name, &args.change, &[])?;
            let out = out.clone().unwrap_or_else(|| folder_name(name));
            let run = RunOptions { out: Some(out.clone()), restart: args.restart, force: args.force, ..run };
            (Serving::start(recipe, run, serve, &host).map_err(|e| report::run(&e))?, out)
        }
        // The command line asks for one of both.
        (None, _) => return Err(report::usage("nothing to serve", "give a recipe")),
    };
    interrupts.connect(serving.remote());
    if args.public && !args.listen.ip().is_loopback() {
        let address = serving.address();
        print::note(&format!(
            "warning: whoever can reach {address} can watch this run; nothing is encrypted, the token neither"
        ));
    }
    attend(serving, &interrupts, args, &out)
}

/// Shows what run and clients tell, until the run has ended and nobody is to be waited for.
fn attend(serving: Serving, interrupts: &Interrupts, args: &Serve, out: &Path) -> Result<(), Failure> {
    let mut bars = (!args.work.quiet && !args.work.json).then(Bars::new);
    let mut unheard = None;
    let mut show = |event: &Event| {
        if args.work.json {
            // As with `eyot run`, a reader that has gone does not stop the run.
            let text = serde_json::to_string(&event.worded(&CommandLine)).unwrap_or_default();
            if unheard.is_none() {
                unheard = print::line(&text).err();
            }
        } else if let Event::Serving { url, control, .. } = event {
            // Also when all else is quiet: nobody could know the port.
            if unheard.is_none() {
                let what =
                    if args.allow_changes { "to pause, resume, step and change" } else { "to pause, resume and step" };
                let control = control.as_ref().map_or_else(String::new, |c| format!("\n{what}: {c}"));
                unheard = print::line(&format!("serving at {url}{control}")).err();
            }
        } else if let Some(bars) = &mut bars {
            bars.show(event);
        }
    };
    let mut finished = false;
    for event in serving.events() {
        show(&event);
        if event.is_last() {
            finished = matches!(event, Event::Done { .. });
            break;
        }
    }
    if let Some(linger) = args.linger.filter(|_| finished) {
        if !args.work.quiet {
            print::note("the run is done; serving its last state until Ctrl-C");
        }
        let until = Duration::try_from_secs_f64(linger).ok().and_then(|d| Instant::now().checked_add(d));
        while !interrupts.came() && until.is_none_or(|u| Instant::now() < u) {
            match serving.events().recv_timeout(LOOK) {
                Ok(event) => show(&event),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    }
    drop(bars);
    let outcome = serving.join(PATIENCE).map_err(|e| report::run(&e))?;
    if outcome.finished {
        return unheard.filter(|f| !matches!(f, Failure::Closed)).map_or(Ok(()), Err);
    }
    let out = eyot::shell_word(out);
    print::note(&format!("stopped; continue with: eyot serve --resume --out {out}, or eyot resume {out}"));
    Err(Failure::Stopped)
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let numbers = text.strip_prefix("localhost:").map_or_else(|| text.to_owned(), |port| format!("127.0.0.1:{port}"));
    numbers.parse().map_err(|_| "write an address and a port, such as 127.0.0.1:0 or [::1]:9000".to_owned())
}

fn token(text: &str) -> Result<String, String> {
    if Control::is_token(text) {
        return Ok(text.to_owned());
    }
    Err("write 8 to 128 letters, digits, - and _".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(r) if (1e-6..=1e9).contains(&r) => Ok(r),
        _ => Err("write steps a second from 1e-6 to 1e9".to_owned()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(s) if s >= 0.0 => Ok(s),
        _ => Err("write seconds, or nothing to serve until Ctrl-C".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_need_a_port() {
        assert_eq!(address("localhost:9"), Ok(SocketAddr::from((Ipv4Addr::LOCALHOST, 9))));
        assert!(address("[::1]:0").is_ok() && address("0.0.0.0:80").is_ok());
        assert!(address("127.0.0.1").is_err() && address(":80").is_err() && address("example.org:80").is_err());
    }
}
