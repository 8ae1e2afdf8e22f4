//! One client: its handshake, a thread that reads what it sends, and one that sends what waits for it.

use crate::door::Handshake;
use crate::frame;
use crate::line::{Item, Line};
use crate::origin;
use crate::record::{Body, Order, Permission, Record};
use crate::server::{Hub, Notice, Place};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tungstenite::error::ProtocolError;
use tungstenite::handshake::HandshakeError;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::StatusCode;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

/// Longest message of a client, bytes: most orders have 24, and a change is a name and a value.
const MAX_MESSAGE: usize = 1024;
/// After a close of ours, a client may take so long to answer.
const FAREWELL: Duration = Duration::from_secs(2);
/// Bytes of a client that are read after a close of ours, so that it comes to see it.
const MAX_FAREWELL: usize = 1 << 20;

/// Codes of closes, RFC 6455, section 7.4.1.
mod code {
    pub(super) const PROTOCOL: u16 = 1002;
    pub(super) const UNSUPPORTED: u16 = 1003;
    pub(super) const MALFORMED: u16 = 1007;
    pub(super) const POLICY: u16 = 1008;
    pub(super) const TOO_LONG: u16 = 1009;
}

/// A client from its first byte to its last.
pub(crate) fn receive(hub: &Arc<Hub>, stream: TcpStream, address: SocketAddr, handshake: Handshake) {
    let accepted = shake(hub, &stream, address);
    drop(handshake);
    let Guest { mut socket, place, may } = match accepted {
        Ok(accepted) => accepted,
        Err(reason) => {
            hub.tell(Notice::Refused { address, reason });
            return;
        }
    };
    let Some((line, sender)) = open(hub, &stream, address, may) else { return };
    socket.get_mut().turn_to(line.clone());
    listen(hub, &line, &mut socket);
    // The last item is on its way; the sender ends with it, or with the connection.
    say_farewell(&stream);
    line.cut("it went");
    // A thread that has broken has cut nothing: that is done.
    let _ = sender.join();
    hub.leave(&line);
    drop(place);
}

/// Whoever was let in.
struct Guest {
    socket: WebSocket<Wire>,
    place: Place,
    may: Permission,
}

/// The handshake, in the time that it may take.
// The library's callback returns a whole answer as its error.
#[allow(clippy::result_large_err)]
fn shake(hub: &Arc<Hub>, stream: &TcpStream, address: SocketAddr) -> Result<Guest, String> {
    let broken = |e: io::Error| e.to_string();
    // What is small must not wait for more. A system without it is only slower.
    let _ = stream.set_nodelay(true);
    stream.set_write_timeout(Some(hub.options.handshake)).map_err(broken)?;
    let wire = Wire {
        stream: stream.try_clone().map_err(broken)?,
        until: Some(Instant::now() + hub.options.handshake),
        line: None,
        held: Vec::new(),
    };
    let (mut place, mut refusal, mut may) = (None, None, Permission::Watch);
    let judge = |request: &Request, response: Response| {
        let mut refuse = |status: StatusCode, reason: String| {
            refusal = Some(reason.clone());
            let mut response = ErrorResponse::new(Some(format!("{reason}\n")));
            *response.status_mut() = status;
            Err(response)
        };
        for origin in request.headers().get_all("origin") {
            let origin = String::from_utf8_lossy(origin.as_bytes()).into_owned();
            if !origin::is_welcome(&origin, &hub.options.allow_origins) {
                let shown: String = origin.chars().filter(|c| !c.is_control()).take(200).collect();
                return refuse(StatusCode::FORBIDDEN, format!("pages of `{shown}` may not connect"));
            }
        }
        may = match hub.options.control.admits(request.uri().query()) {
            false => Permission::Watch,
            true if hub.options.changes => Permission::Change,
            true => Permission::Pause,
        };
        place = hub.place();
        if place.is_none() {
            return refuse(
                StatusCode::SERVICE_UNAVAILABLE,
                format!("{} clients are here already", hub.options.max_clients),
            );
        }
        Ok(response)
    };
    let config = WebSocketConfig::default()
        .read_buffer_size(4096)
        .write_buffer_size(0)
        .max_message_size(Some(MAX_MESSAGE))
        .max_frame_size(Some(MAX_MESSAGE));
    // The error holds on to the judge.
    let socket = tungstenite::accept_hdr_with_config(wire, judge, Some(config)).map_err(|e| match e {
        HandshakeError::Failure(e) => e,
        HandshakeError::Interrupted(_) => Error::Io(ErrorKind::TimedOut.into()),
    });
    match (socket, place) {
        (Ok(socket), Some(place)) => Ok(Guest { socket, place, may }),
        (Err(e), _) => Err(refusal.unwrap_or_else(|| {
            answer(stream, &e);
            format!("no handshake with {address}: {e}")
        })),
        (Ok(_), None) => Err("no place".to_owned()),
    }
}

/// Says to whoever asked for something else what there is; the library says nothing.
fn answer(mut stream: &TcpStream, error: &Error) {
    use ProtocolError as P;
    let (status, headers, text) = match error {
        // Gone, or cut: nobody listens.
        Error::Protocol(P::HandshakeIncomplete) | Error::ConnectionClosed => return,
        Error::Io(e) if e.kind() == ErrorKind::TimedOut => ("408 Request Timeout", "", "the request took too long"),
        Error::Io(_) => return,
        Error::Protocol(P::WrongHttpMethod) => ("405 Method Not Allowed", "Allow: GET\r\n", "only GET is answered"),
        Error::Protocol(P::WrongHttpVersion) => ("505 HTTP Version Not Supported", "", "only HTTP/1.1 is spoken"),
        Error::Protocol(
            P::MissingConnectionUpgradeHeader
            | P::MissingUpgradeWebSocketHeader
            | P::MissingSecWebSocketVersionHeader
            | P::MissingSecWebSocketKey,
        ) => (
            "426 Upgrade Required",
            "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n",
            "this is a stream of Eyot: connect by WebSocket (RFC 6455), version 13",
        ),
        _ => ("400 Bad Request", "", "this is no request for a WebSocket (RFC 6455)"),
    };
    let length = text.len() + 1;
    let answer = format!(
        "HTTP/1.1 {status}\r\n{headers}Connection: close\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\n\r\n{text}\n"
    );
    // Whoever does not take it has nobody to complain to.
    if stream.write_all(answer.as_bytes()).is_ok() && stream.shutdown(Shutdown::Write).is_ok() {
        say_farewell(stream);
    }
}

/// Lets the client in and begins to send.
fn open(
    hub: &Arc<Hub>,
    stream: &TcpStream,
    address: SocketAddr,
    may: Permission,
) -> Option<(Arc<Line>, std::thread::JoinHandle<()>)> {
    stream.set_read_timeout(None).ok()?;
    stream.set_write_timeout(Some(hub.options.stall)).ok()?;
    let (cutter, mut writer) = (stream.try_clone().ok()?, stream.try_clone().ok()?);
    let line = hub.join(cutter, address, may)?;
    let (theirs, here) = (hub.clone(), line.clone());
    let sender =
        std::thread::Builder::new().name("eyot-send".to_owned()).spawn(move || send(&theirs, &here, &mut writer));
    match sender {
        Ok(sender) => Some((line, sender)),
        Err(e) => {
            line.cut(&format!("no thread for it: {e}"));
            hub.leave(&line);
            None
        }
    }
}

/// Sends what waits, until the last item.
fn send(hub: &Hub, line: &Line, stream: &mut TcpStream) {
    loop {
        let Some(item) = hub.next(line) else { return line.cut("it answered no ping") };
        if let Err(e) = stream.write_all(item.bytes()) {
            let stalled = matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
            let reason = if stalled { "it took nothing for too long".to_owned() } else { e.to_string() };
            return line.cut(&reason);
        }
        if matches!(item, Item::Last(_)) {
            // Whoever listens sees the other side close, or waits no longer than a farewell takes.
            let _ = stream.shutdown(Shutdown::Write);
            return;
        }
    }
}

/// Reads what the client sends, until it goes or is sent away.
fn listen(hub: &Hub, line: &Line, socket: &mut WebSocket<Wire>) {
    let mut purse = Purse::new(hub.options.messages_per_s);
    loop {
        let message = match socket.read() {
            Ok(message) => message,
            Err(Error::ConnectionClosed | Error::AlreadyClosed) => return line.closed_by_client(),
            Err(Error::Io(_) | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake)) => {
                return line.cut("it went");
            }
            Err(Error::Capacity(e)) => {
                return line.refuse(code::TOO_LONG, &format!("{e}; at most {MAX_MESSAGE} bytes"));
            }
            Err(Error::Utf8(e)) => return line.refuse(code::MALFORMED, &e),
            Err(e) => return line.refuse(code::PROTOCOL, &e.to_string()),
        };
        line.heard();
        if !purse.pay() {
            return line.refuse(code::POLICY, "too many messages");
        }
        match message {
            Message::Binary(bytes) => match Order::decode(&bytes) {
                Ok(order) if line.may < order.needs() => {
                    let reason = hub.options.control.refusal(order.needs(), hub.options.changes);
                    let refused = Record::from(Body::Refused(reason.to_owned()));
                    line.note(&Arc::new(frame::messages(&[refused])));
                }
                Ok(order) => hub.tell(Notice::Order { client: line.number, order }),
                Err(e) => return line.refuse(code::MALFORMED, &e.to_string()),
            },
            Message::Text(_) => return line.refuse(code::UNSUPPORTED, "send records as binary messages, not text"),
            // The library answers both; the answer to a close goes out with the next look.
            Message::Ping(_) | Message::Pong(_) | Message::Close(_) | Message::Frame(_) => {}
        }
    }
}

/// Reads on for a while, so that what was sent last arrives before the connection is closed.
fn say_farewell(mut stream: &TcpStream) {
    let until = Instant::now() + FAREWELL;
    let (mut waste, mut read) = ([0; 4096], 0);
    while read < MAX_FAREWELL {
        let Some(left) = until.checked_duration_since(Instant::now()).filter(|d| !d.is_zero()) else { return };
        match stream.set_read_timeout(Some(left)).and_then(|()| stream.read(&mut waste)) {
            Ok(0) | Err(_) => return,
            Ok(n) => read += n,
        }
    }
}

/// Messages that a client may still send.
struct Purse {
    per_s: f64,
    left: f64,
    last: Instant,
}

impl Purse {
    fn new(per_s: u32) -> Self {
        Self { per_s: per_s.into(), left: 2.0 * f64::from(per_s), last: Instant::now() }
    }

    fn pay(&mut self) -> bool {
        let now = Instant::now();
        self.left = (self.left + self.per_s * (now - self.last).as_secs_f64()).min(2.0 * self.per_s);
        self.last = now;
        self.left -= 1.0;
        self.left >= 0.0
    }
}

/// The connection as the WebSocket library sees it: it reads from it, and what it wants to send waits with everything else.
struct Wire {
    stream: TcpStream,
    /// End of the handshake.
    until: Option<Instant>,
    line: Option<Arc<Line>>,
    /// A frame that is not whole yet.
    held: Vec<u8>,
}

impl Wire {
    /// The handshake is done.
    fn turn_to(&mut self, line: Arc<Line>) {
        self.until = None;
        self.line = Some(line);
    }
}

impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let late = || io::Error::new(ErrorKind::TimedOut, "it took too long");
        if let Some(until) = self.until {
            let left = until.checked_duration_since(Instant::now()).filter(|d| !d.is_zero()).ok_or_else(late)?;
            self.stream.set_read_timeout(Some(left))?;
        }
        // To the library, what would block would be tried again.
        self.stream.read(buffer).map_err(|e| if e.kind() == ErrorKind::WouldBlock { late() } else { e })
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &self.line {
            None => self.stream.write(bytes),
            Some(_) => self.held.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &self.line {
            None => self.stream.flush(),
            Some(_) if self.held.is_empty() => Ok(()),
            Some(line) => {
                let is_read = line.answer(&std::mem::take(&mut self.held));
                is_read.then_some(()).ok_or_else(|| io::Error::new(ErrorKind::TimedOut, "answers are not read"))
            }
        }
    }
}
