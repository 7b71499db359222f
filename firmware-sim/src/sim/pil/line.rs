//! The serial line: a TCP port of this computer to which QEMU connects its UART.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use emulator::Emulator;
/// Interval of polls for the connection.
const POLL: Duration = Duration::from_millis(10);

/// Listens on a free port.
pub(super) struct Listener(TcpListener);

impl Listener {
    /// Opens a free port.
    ///
    /// # Errors
    /// If no port is free.
    pub(super) fn open() -> Result<Self> {
        let open = || {
            let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
            listener.set_nonblocking(true)?;
            io::Result::Ok(listener)
        };
        open().map(Self).context("cannot open a port for the line to the controller")
    }

    /// The port in the form of QEMU's option `-serial`.
    ///
    /// # Errors
    /// If the system does not return the port.
    pub(super) fn serial(&self) -> Result<String> {
        Ok(format!("tcp:{}", self.0.local_addr()?))
    }

    /// Waits for the connection of QEMU. Reads and writes of the line have the timeout `limit`.
    ///
    /// # Errors
    /// If QEMU ends or does not connect in time.
    pub(super) fn accept(&self, emulator: &mut Emulator, limit: Duration) -> Result<TcpStream> {
        let end = Instant::now() + limit;
        loop {
            match self.0.accept() {
                Ok((line, _)) => return Ok(timed(line, limit)?),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => (),
                Err(error) => return Err(error).context("the line to the controller"),
            }
            if let Some(status) = emulator.status()? {
                bail!("QEMU ended before it connected, with {status}");
            }
            if Instant::now() >= end {
                bail!("QEMU did not connect within {} s", limit.as_secs());
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
