//! Calls of a program under test.

use std::io::Write;
use std::process::{Command, Output, Stdio};

/// A call of a program: its arguments and its input.
#[derive(Debug)]
pub struct Program {
    command: Command,
    input: Vec<u8>,
}

/// Output and exit status of a call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
    /// Exit status.
    pub status: i32,
}

impl Program {
    /// A call of the program at `path`, such as `env!("CARGO_BIN_EXE_selfcal")`.
    #[must_use]
    pub fn new(path: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(path);
        command.args(arguments);
        Self { command, input: Vec::new() }
    }

    /// The call with these bytes on standard input.
    #[must_use]
    pub fn reading(self, input: impl Into<Vec<u8>>) -> Self {
        Self { input: input.into(), ..self }
    }

    /// The call in this working folder.
    #[must_use]
    pub fn inside(mut self, folder: &std::path::Path) -> Self {
        self.command.current_dir(folder);
        self
    }

    /// Runs the program to its end.
    ///
    /// # Panics
    /// If the program does not start, a signal ends it, or its output is not UTF-8.
    #[must_use]
    pub fn ended(mut self) -> Ended {
        let output = self.output();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("no UTF-8");
        let status = output.status.code().expect("a signal ended the program");
        Ended { out: text(output.stdout), err: text(output.stderr), status }
    }

    /// Runs the program to its end, and checks its exit status.
    ///
    /// # Panics
    /// As [`Program::ended`], or if the program ends with another exit status.
    #[must_use]
    #[track_caller]
    pub fn ends_with(self, status: i32) -> Ended {
        let call = format!("{:?}", self.command);
        let ended = self.ended();
        assert_eq!(ended.status, status, "{call}:\n{}\n{}", ended.out, ended.err);
        ended
    }

    /// Standard output of a call that succeeds.
    ///
    /// # Panics
    /// As [`Program::ended`], or if the exit status is not 0.
    #[allow(clippy::must_use_candidate, reason = "a test may ask for the exit status alone")]
    #[track_caller]
    pub fn stdout(self) -> String {
        self.ends_with(0).out
    }

    /// Standard error of a call that fails with this exit status.
    ///
    /// # Panics
    /// As [`Program::ends_with`].
    #[must_use]
    #[track_caller]
    pub fn failure(self, status: i32) -> String {
        self.ends_with(status).err
    }

    fn output(&mut self) -> Output {
        self.command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = self.command.spawn().expect("the program does not start");
        let mut stdin = child.stdin.take().expect("standard input is piped");
        let input = std::mem::take(&mut self.input);
        // A thread writes the input while this one reads the output, because either pipe may fill. A failed write is no
        // error, because the program may end before it has read all input.
        let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
        let output = child.wait_with_output().expect("the program does not end");
        writer.join().expect("the writer panicked");
        output
    }
}
