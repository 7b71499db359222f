//! The host's side of a session, over any line.

use std::io::{self, ErrorKind, Read, Write};

use firmware_sim::pil::{EndReply, PairReply, SessionReply, SessionRequest};
use thiserror::Error;
use zerocopy::{FromBytes, IntoBytes};

/// Why a reply of the controller is missing or wrong.
#[derive(Debug, Error)]
pub(super) enum SessionError {
    /// The reply did not come in time.
    #[error("the controller has not sent {0} in time")]
    TimedOut(&'static str),
    /// The line was closed.
    #[error("the controller ended before it sent {0}")]
    Ended(&'static str),
    /// The bytes are not the reply.
    #[error("the controller sent something else than {0}")]
    Garbage(&'static str),
    /// The request was refused.
    #[error("the controller refuses the cameras (error {0})")]
    Refused(u16),
    /// The reply is about another frame.
    #[error("the controller replied to frame {replied}, not {sent}")]
    Sequence {
        /// Number of the frame that was sent.
        sent: u32,
        /// Number in the reply.
        replied: u32,
    },
    /// The line failed.
    #[error("the line to the controller: {0}")]
    Line(#[source] io::Error),
}

impl SessionError {
    /// Returns the error of a read or a write on the line.
    ///
    /// * `awaited`: the reply, in words.
    fn of(error: io::Error, awaited: &'static str) -> Self {
        match error.kind() {
            // A read times out with one or the other, depending on the system.
            ErrorKind::WouldBlock | ErrorKind::TimedOut => Self::TimedOut(awaited),
            ErrorKind::UnexpectedEof
            | ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::BrokenPipe => Self::Ended(awaited),
            _ => Self::Line(error),
        }
    }
}

/// A session with a controller at the other end of `line`, whose reads and writes have a timeout.
pub(super) struct Session<L> {
    line: L,
    /// Correspondences per pair that fit the batch of the controller.
    pub(super) capacity: u16,
}

impl<L: Read + Write> Session<L> {
    /// Sends the request and receives its reply.
    ///
    /// # Errors
    /// [`SessionError`].
    pub(super) fn open(mut line: L, request: &SessionRequest) -> Result<Self, SessionError> {
        const AWAITED: &str = "the session reply";
        send(&mut line, &request.encode(), AWAITED)?;
        let reply: SessionReply = receive(&mut line, AWAITED)?;
        match (reply.is_valid(), reply.refused()) {
            (false, _) => Err(SessionError::Garbage(AWAITED)),
            (true, Some(code)) => Err(SessionError::Refused(code)),
            (true, None) => Ok(Self { line, capacity: reply.capacity() }),
        }
    }

    /// Sends a frame and receives the result of the pair.
    ///
    /// * `sequence`: number of the frame.
    ///
    /// # Errors
    /// [`SessionError`].
    pub(super) fn pair(&mut self, sequence: u32, frame: &[u8]) -> Result<PairReply, SessionError> {
        const AWAITED: &str = "the result of a pair";
        send(&mut self.line, frame, AWAITED)?;
        let reply: PairReply = receive(&mut self.line, AWAITED)?;
        if !reply.is_valid() {
            return Err(SessionError::Garbage(AWAITED));
        }
        if reply.sequence() != sequence {
            return Err(SessionError::Sequence { sent: sequence, replied: reply.sequence() });
        }
        Ok(reply)
    }

    /// Receives the extrinsics in use after the last pair.
    ///
    /// # Errors
    /// [`SessionError`].
    pub(super) fn end(mut self) -> Result<EndReply, SessionError> {
        const AWAITED: &str = "the extrinsics in use";
        let reply: EndReply = receive(&mut self.line, AWAITED)?;
        if reply.is_valid() { Ok(reply) } else { Err(SessionError::Garbage(AWAITED)) }
    }
}

fn send(line: &mut impl Write, bytes: &[u8], awaited: &'static str) -> Result<(), SessionError> {
    let sent = line.write_all(bytes).and_then(|()| line.flush());
    sent.map_err(|error| SessionError::of(error, awaited))
}

fn receive<A: FromBytes + IntoBytes>(
    line: &mut impl Read,
    awaited: &'static str,
) -> Result<A, SessionError> {
    let mut reply = A::new_zeroed();
    line.read_exact(reply.as_mut_bytes()).map_err(|error| SessionError::of(error, awaited))?;
    Ok(reply)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rigs::data::Dataset;

    /// Replies from a script; after its end the line is silent or closed.
    struct Script {
        replies: io::Cursor<Vec<u8>>,
        silent: bool,
        sent: Vec<u8>,
    }

    impl Script {
        fn new(replies: &[&[u8]]) -> Self {
            Self { replies: io::Cursor::new(replies.concat()), silent: false, sent: Vec::new() }
        }

        fn silent(self) -> Self {
            Self { silent: true, ..self }
        }
    }

    impl Read for Script {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            match self.replies.read(buffer)? {
                0 if self.silent => Err(ErrorKind::WouldBlock.into()),
                count => Ok(count),
            }
        }
    }

    impl Write for Script {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.sent.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn request() -> SessionRequest {
        let set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
        SessionRequest { pairs: 1, cameras: set.cameras().unwrap() }
    }

    fn accepted() -> SessionReply {
        SessionReply::new(None, 512)
    }

    fn opened(replies: &[&[u8]]) -> Session<Script> {
        let accepted = accepted();
        let all = [&[accepted.as_bytes()], replies].concat();
        Session::open(Script::new(&all), &request()).unwrap()
    }

    #[test]
    fn the_request_is_sent_and_its_reply_read() {
        let session = opened(&[]);
        assert_eq!(session.capacity, 512);
        assert_eq!(session.line.sent, request().encode());
    }

    #[test]
    fn a_silent_line_times_out_and_a_closed_one_has_ended() {
        let open = |script: Script| Session::open(script, &request()).err().unwrap();
        assert!(matches!(open(Script::new(&[]).silent()), SessionError::TimedOut(_)));
        assert!(matches!(open(Script::new(&[b"SCPG"]).silent()), SessionError::TimedOut(_)));
        assert!(matches!(open(Script::new(&[b"SCPG"])), SessionError::Ended(_)));
        assert!(matches!(opened(&[]).pair(0, b"x"), Err(SessionError::Ended(_))));
        assert!(matches!(opened(&[]).end(), Err(SessionError::Ended(_))));
    }

    #[test]
    fn other_bytes_are_not_a_reply() {
        let garbage = [0x55_u8; 300];
        let open = Session::open(Script::new(&[&garbage]), &request());
        assert!(matches!(open, Err(SessionError::Garbage(_))));
        assert!(matches!(opened(&[&garbage]).pair(0, b"x"), Err(SessionError::Garbage(_))));
        assert!(matches!(opened(&[&garbage]).end(), Err(SessionError::Garbage(_))));
    }

    #[test]
    fn a_refusal_has_its_code() {
        use firmware_sim::pil::RequestError;
        let refusal = SessionReply::new(Some(RequestError::Version(2)), 512);
        let open = Session::open(Script::new(&[refusal.as_bytes()]), &request());
        assert!(matches!(open, Err(SessionError::Refused(2))));
    }

    #[test]
    fn a_reply_to_another_frame_is_refused() {
        let mut reply = [0; size_of::<PairReply>()];
        reply[..5].copy_from_slice(b"SCPA\x07");
        let wrong = opened(&[&reply]).pair(8, b"x");
        assert!(matches!(wrong, Err(SessionError::Sequence { sent: 8, replied: 7 })));
        assert!(opened(&[&reply]).pair(7, b"x").is_ok());
    }
}
