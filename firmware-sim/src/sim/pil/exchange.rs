//! The host's side of an exchange, over any line.

use std::io::{self, ErrorKind, Read, Write};

use firmware_sim::pil::{EndAnswer, Greeting, Opening, PairAnswer};
use thiserror::Error;
use zerocopy::{FromBytes, IntoBytes};

/// Why the controller has not answered.
#[derive(Debug, Error)]
pub(super) enum ExchangeError {
    /// Nothing came in time.
    #[error("the controller has not sent {0} in time")]
    TimedOut(&'static str),
    /// The line was closed.
    #[error("the controller ended before it sent {0}")]
    Ended(&'static str),
    /// What came is something else.
    #[error("the controller sent something else than {0}")]
    Garbage(&'static str),
    /// The opening was refused.
    #[error("the controller does not take the cameras (error {0})")]
    Refused(u16),
    /// The answer is about another frame.
    #[error("the controller answered frame {answered}, not {sent}")]
    Sequence {
        /// Number of the frame that was sent.
        sent: u32,
        /// Number in the answer.
        answered: u32,
    },
    /// The line failed.
    #[error("the line to the controller: {0}")]
    Line(#[source] io::Error),
}

impl ExchangeError {
    /// * `awaited`: what should have come.
    fn of(error: io::Error, awaited: &'static str) -> Self {
        match error.kind() {
            // A read past its time is the one or the other, by the system.
            ErrorKind::WouldBlock | ErrorKind::TimedOut => Self::TimedOut(awaited),
            ErrorKind::UnexpectedEof
            | ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::BrokenPipe => Self::Ended(awaited),
            _ => Self::Line(error),
        }
    }
}

/// An exchange with a controller at the other end of `line`, whose reads and writes end in time.
pub(super) struct Exchange<L> {
    line: L,
    /// Correspondences a pair that the controller has room for.
    pub(super) capacity: u16,
}

impl<L: Read + Write> Exchange<L> {
    /// Opens: cameras there, greeting back.
    ///
    /// # Errors
    /// [`ExchangeError`].
    pub(super) fn open(mut line: L, opening: &Opening) -> Result<Self, ExchangeError> {
        const AWAITED: &str = "its greeting";
        send(&mut line, &opening.encode(), AWAITED)?;
        let greeting: Greeting = receive(&mut line, AWAITED)?;
        match (greeting.is_valid(), greeting.refused()) {
            (false, _) => Err(ExchangeError::Garbage(AWAITED)),
            (true, Some(code)) => Err(ExchangeError::Refused(code)),
            (true, None) => Ok(Self { line, capacity: greeting.capacity() }),
        }
    }

    /// A frame there, what became of it back.
    ///
    /// * `sequence`: number of the frame.
    ///
    /// # Errors
    /// [`ExchangeError`].
    pub(super) fn pair(
        &mut self,
        sequence: u32,
        frame: &[u8],
    ) -> Result<PairAnswer, ExchangeError> {
        const AWAITED: &str = "what became of a pair";
        send(&mut self.line, frame, AWAITED)?;
        let answer: PairAnswer = receive(&mut self.line, AWAITED)?;
        if !answer.is_valid() {
            return Err(ExchangeError::Garbage(AWAITED));
        }
        if answer.sequence() != sequence {
            return Err(ExchangeError::Sequence { sent: sequence, answered: answer.sequence() });
        }
        Ok(answer)
    }

    /// What is in use after the last pair.
    ///
    /// # Errors
    /// [`ExchangeError`].
    pub(super) fn end(mut self) -> Result<EndAnswer, ExchangeError> {
        const AWAITED: &str = "what is in use";
        let answer: EndAnswer = receive(&mut self.line, AWAITED)?;
        if answer.is_valid() { Ok(answer) } else { Err(ExchangeError::Garbage(AWAITED)) }
    }
}

fn send(line: &mut impl Write, bytes: &[u8], awaited: &'static str) -> Result<(), ExchangeError> {
    let sent = line.write_all(bytes).and_then(|()| line.flush());
    sent.map_err(|error| ExchangeError::of(error, awaited))
}

fn receive<A: FromBytes + IntoBytes>(
    line: &mut impl Read,
    awaited: &'static str,
) -> Result<A, ExchangeError> {
    let mut answer = A::new_zeroed();
    line.read_exact(answer.as_mut_bytes()).map_err(|error| ExchangeError::of(error, awaited))?;
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_tests::data::Dataset;

    /// Answers from a script; behind its end it is silent, or gone.
    struct Script {
        answers: io::Cursor<Vec<u8>>,
        silent: bool,
        sent: Vec<u8>,
    }

    impl Script {
        fn new(answers: &[&[u8]]) -> Self {
            Self { answers: io::Cursor::new(answers.concat()), silent: false, sent: Vec::new() }
        }

        fn silent(self) -> Self {
            Self { silent: true, ..self }
        }
    }

    impl Read for Script {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            match self.answers.read(buffer)? {
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

    fn opening() -> Opening {
        let set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
        Opening { pairs: 1, cameras: set.cameras().unwrap() }
    }

    fn greeting() -> Greeting {
        Greeting::new(None, 512)
    }

    fn opened(answers: &[&[u8]]) -> Exchange<Script> {
        let greeting = greeting();
        let all = [&[greeting.as_bytes()], answers].concat();
        Exchange::open(Script::new(&all), &opening()).unwrap()
    }

    #[test]
    fn an_opening_is_sent_and_the_greeting_read() {
        let exchange = opened(&[]);
        assert_eq!(exchange.capacity, 512);
        assert_eq!(exchange.line.sent, opening().encode());
    }

    #[test]
    fn silence_is_a_time_out_and_an_early_end_is_none() {
        let open = |script: Script| Exchange::open(script, &opening()).err().unwrap();
        assert!(matches!(open(Script::new(&[]).silent()), ExchangeError::TimedOut(_)));
        assert!(matches!(open(Script::new(&[b"SCPG"]).silent()), ExchangeError::TimedOut(_)));
        assert!(matches!(open(Script::new(&[b"SCPG"])), ExchangeError::Ended(_)));
        assert!(matches!(opened(&[]).pair(0, b"x"), Err(ExchangeError::Ended(_))));
        assert!(matches!(opened(&[]).end(), Err(ExchangeError::Ended(_))));
    }

    #[test]
    fn garbage_is_told_from_an_answer() {
        let garbage = [0x55_u8; 300];
        let open = Exchange::open(Script::new(&[&garbage]), &opening());
        assert!(matches!(open, Err(ExchangeError::Garbage(_))));
        assert!(matches!(opened(&[&garbage]).pair(0, b"x"), Err(ExchangeError::Garbage(_))));
        assert!(matches!(opened(&[&garbage]).end(), Err(ExchangeError::Garbage(_))));
    }

    #[test]
    fn a_refusal_is_told_with_its_code() {
        use firmware_sim::pil::OpeningError;
        let refusal = Greeting::new(Some(OpeningError::Version(2)), 512);
        let open = Exchange::open(Script::new(&[refusal.as_bytes()]), &opening());
        assert!(matches!(open, Err(ExchangeError::Refused(2))));
    }

    #[test]
    fn an_answer_about_another_frame_is_refused() {
        let mut answer = [0; size_of::<PairAnswer>()];
        answer[..5].copy_from_slice(b"SCPA\x07");
        let wrong = opened(&[&answer]).pair(8, b"x");
        assert!(matches!(wrong, Err(ExchangeError::Sequence { sent: 8, answered: 7 })));
        assert!(opened(&[&answer]).pair(7, b"x").is_ok());
    }
}
