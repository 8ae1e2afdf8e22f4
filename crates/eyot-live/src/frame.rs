//! Records as frames of the WebSocket, made once for all clients.

use crate::record::Record;
use tungstenite::protocol::frame::coding::{CloseCode, Data, OpCode};
use tungstenite::protocol::frame::{CloseFrame, Frame, FrameHeader};

/// A message for each record, one after the other.
pub(crate) fn messages(records: &[Record]) -> Vec<u8> {
    let mut out = Vec::new();
    for record in records {
        let bytes = record.encode();
        let header = FrameHeader { is_final: true, opcode: OpCode::Data(Data::Binary), ..FrameHeader::default() };
        // Writing to memory cannot fail.
        let _ = header.format(bytes.len() as u64, &mut out);
        out.extend_from_slice(&bytes);
    }
    out
}

/// A ping without a text.
pub(crate) fn ping() -> Vec<u8> {
    let mut out = Vec::new();
    // As above.
    let _ = Frame::ping(Vec::new()).format(&mut out);
    out
}

/// A close with its reason, which may have 123 bytes.
pub(crate) fn close(code: u16, reason: &str) -> Vec<u8> {
    let reason = &reason[..reason.floor_char_boundary(123)];
    let frame = Frame::close(Some(CloseFrame { code: CloseCode::from(code), reason: reason.to_owned().into() }));
    let mut out = Vec::new();
    // As above.
    let _ = frame.format(&mut out);
    out
}
