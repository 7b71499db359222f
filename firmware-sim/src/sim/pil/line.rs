//! The line: a port of this computer that QEMU puts its UART on.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use super::super::emulator::Emulator;

/// How often it is asked whether QEMU is there.
const POLL: Duration = Duration::from_millis(10);

/// Waits for QEMU, on a port that is free.
pub(super) struct Listener(TcpListener);

impl Listener {
    /// # Errors
    /// If there is no port to be had.
    pub(super) fn open() -> Result<Self> {
        let open = || {
            let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
            listener.set_nonblocking(true)?;
            io::Result::Ok(listener)
        };
        open().map(Self).context("no port for the line to the controller")
    }

    /// The port in QEMU's words.
    ///
    /// # Errors
    /// If the system does not tell which it is.
    pub(super) fn serial(&self) -> Result<String> {
        Ok(format!("tcp:{}", self.0.local_addr()?))
    }

    /// The line, once QEMU is there; its reads and writes end in time.
    ///
    /// # Errors
    /// If QEMU ends or does not come.
    pub(super) fn accept(&self, emulator: &mut Emulator, limit: Duration) -> Result<TcpStream> {
        let end = Instant::now() + limit;
        loop {
            match self.0.accept() {
                Ok((line, _)) => return Ok(timed(line, limit)?),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => (),
                Err(error) => return Err(error).context("the line to the controller"),
            }
            if let Some(status) = emulator.status()? {
                bail!("QEMU ended before it was there, with {status}");
            }
            if Instant::now() >= end {
                bail!("QEMU did not come to the line within {} s", limit.as_secs());
            }
            thread::sleep(POLL);
        }
    }
}

fn timed(line: TcpStream, limit: Duration) -> io::Result<TcpStream> {
    line.set_nonblocking(false)?;
    line.set_nodelay(true)?;
    line.set_read_timeout(Some(limit))?;
    line.set_write_timeout(Some(limit))?;
    Ok(line)
}
