//! A client: connects, reads records, gives orders.

use crate::mirror::Mirror;
use crate::record::{Body, MAX_RECORD, Order, Record};
use std::io;
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;
use tungstenite::protocol::{CloseFrame, WebSocketConfig};
use tungstenite::{Message, WebSocket};

/// A connection to a server.
pub struct Client {
    socket: WebSocket<TcpStream>,
    mirror: Mirror,
}

/// What ended a connection.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Gone {
    /// A close, with its code and reason.
    #[error("closed with {0}: {1}")]
    Closed(u16, String),
    /// The connection broke, or the server never let us in.
    #[error("{0}")]
    Broken(String),
    /// The server sent what it should not.
    #[error("the server's records are wrong: {0}")]
    Wrong(String),
}

impl Client {
    /// Connects to a server, to watch.
    ///
    /// # Errors
    /// If nobody listens there, or the server refuses.
    pub fn connect(address: SocketAddr) -> Result<Self, Gone> {
        Self::open(address, "", None)
    }

    /// Connects with the token of the server, to give orders.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub fn connect_with(address: SocketAddr, token: &str) -> Result<Self, Gone> {
        Self::open(address, &format!("?token={token}"), None)
    }

    /// Connects as a page of this origin would.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub fn connect_from(address: SocketAddr, origin: &str) -> Result<Self, Gone> {
        Self::open(address, "", Some(origin))
    }

    fn open(address: SocketAddr, query: &str, origin: Option<&str>) -> Result<Self, Gone> {
        use tungstenite::client::IntoClientRequest;
        let broken = |e: &dyn std::fmt::Display| Gone::Broken(e.to_string());
        let stream = TcpStream::connect(address).map_err(|e| broken(&e))?;
        let mut request = format!("ws://{address}/{query}").into_client_request().map_err(|e| broken(&e))?;
        if let Some(origin) = origin {
            let value = origin.parse().map_err(|e: tungstenite::http::header::InvalidHeaderValue| broken(&e))?;
            request.headers_mut().insert("Origin", value);
        }
        let config = WebSocketConfig::default().max_message_size(Some(MAX_RECORD)).max_frame_size(Some(MAX_RECORD));
        let (socket, _) =
            tungstenite::client::client_with_config(request, stream, Some(config)).map_err(|e| broken(&e))?;
        Ok(Self { socket, mirror: Mirror::default() })
    }

    /// Gives up after so long without a byte; waits for ever without it.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn set_patience(&self, patience: Option<Duration>) -> io::Result<()> {
        self.socket.get_ref().set_read_timeout(patience)
    }

    /// The next record.
    ///
    /// # Errors
    /// If the connection ends, or what comes is no record.
    pub fn record(&mut self) -> Result<Record, Gone> {
        loop {
            match self.socket.read() {
                Ok(Message::Binary(bytes)) => return Record::decode(&bytes).map_err(|e| Gone::Wrong(e.to_string())),
                Ok(Message::Text(_)) => return Err(Gone::Wrong("a text".to_owned())),
                Ok(Message::Close(frame)) => {
                    // The answer is the library's; whether it arrives is the server's concern.
                    let _ = self.socket.flush();
                    let (code, reason) = frame
                        .map_or((1005, String::new()), |CloseFrame { code, reason }| (code.into(), reason.to_string()));
                    return Err(Gone::Closed(code, reason));
                }
                Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => {}
                Err(e) => return Err(Gone::Broken(e.to_string())),
            }
        }
    }

    /// Takes the next record into the [`Mirror`] and returns its moment's number if that is complete.
    ///
    /// # Errors
    /// As [`Client::record`], or if the record does not fit.
    pub fn follow(&mut self) -> Result<Option<u64>, Gone> {
        let record = self.record()?;
        let complete = self.mirror.take(record).map_err(Gone::Wrong)?;
        Ok(self.mirror.moment().filter(|_| complete).map(|m| m.number))
    }

    /// What is known.
    pub fn mirror(&self) -> &Mirror {
        &self.mirror
    }

    /// Gives an order.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn order(&mut self, order: Order) -> Result<(), Gone> {
        self.send(Message::Binary(Record::from(Body::Order(order)).encode().into()))
    }

    /// Asks for a change of the run, by a path such as `hydraulic.rain` and a value in JSON.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn set(&mut self, path: &str, value: &str) -> Result<(), Gone> {
        self.order(Order::Set { path: path.to_owned(), value: value.to_owned() })
    }

    /// Sends anything, as a client that is not of this crate might.
    ///
    /// # Errors
    /// If the connection has ended.
    pub fn send(&mut self, message: Message) -> Result<(), Gone> {
        self.socket.send(message).map_err(|e| Gone::Broken(e.to_string()))
    }

    /// The connection itself.
    pub fn stream(&self) -> &TcpStream {
        self.socket.get_ref()
    }
}
