//! ROS 2 bags in SQLite, the default until Humble.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use rusqlite::limits::Limit;
use rusqlite::{Connection, OpenFlags};

use super::content::MOST_BYTES;
use super::parts::Parts;

/// Topics by their numbers: name and type.
type Topics = HashMap<i64, (String, String)>;

/// Hands out all messages in the order of recording, and the damaged parts.
///
/// # Errors
/// If the file cannot be opened, or has no tables of a bag.
pub(super) fn messages(file: &Path, out: &mut Parts<'_>) -> Result<ControlFlow<()>> {
    let bag = open(file)?;
    let topics = topics(&bag).map_err(|why| in_words(&why)).context("its topics")?;
    match each(&bag, &topics, out) {
        Ok(ControlFlow::Continue(())) => {}
        Ok(ControlFlow::Break(())) => return Ok(ControlFlow::Break(())),
        Err(why) => {
            return Ok(out.damaged(format!("the rest is lost: {:#}", in_words(&why))));
        }
    }
    // SQLite counts the entries of the index of times, if there is one.
    let stated = bag.query_one("SELECT count(*) FROM messages", [], |row| row.get::<_, i64>(0));
    Ok(match stated {
        Ok(stated) => out.stated(stated.unsigned_abs(), ""),
        Err(why) => out.damaged(in_words(&why).context("its index")),
    })
}

fn each(
    bag: &Connection,
    topics: &Topics,
    out: &mut Parts<'_>,
) -> rusqlite::Result<ControlFlow<()>> {
    // The order of recording needs no index, which may be damaged too.
    let mut all = bag.prepare("SELECT topic_id, data FROM messages ORDER BY rowid")?;
    let mut rows = all.query([])?;
    while let Some(row) = rows.next()? {
        let topic = row.get_ref(0)?.as_i64().ok().and_then(|id| topics.get(&id));
        let flow = match topic.zip(row.get_ref(1)?.as_blob().ok()) {
            Some(((topic, kind), bytes)) => out.message(topic, kind, bytes),
            None => out.damaged("a message of no known topic, or without content"),
        };
        if flow.is_break() {
            return Ok(flow);
        }
    }
    Ok(ControlFlow::Continue(()))
}

fn open(file: &Path) -> Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let bag = Connection::open_with_flags(file, flags).context("cannot open")?;
    let tables = bag
        .set_limit(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(MOST_BYTES)?)
        .and_then(|_| bag.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON"))
        // A view may compute without end, so both must be tables.
        .and_then(|()| {
            bag.query_one(
                "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages')",
                [],
                |row| row.get::<_, i64>(0),
            )
        })
        .map_err(|why| in_words(&why))?;
    ensure!(tables == 2, "is no ROS 2 bag: tables `topics` and `messages` are expected");
    Ok(bag)
}

fn topics(bag: &Connection) -> rusqlite::Result<Topics> {
    let mut all = bag.prepare("SELECT id, name, type FROM topics")?;
    all.query_map([], |row| Ok((row.get(0)?, (row.get(1)?, row.get(2)?))))?.collect()
}

/// An error of SQLite in words of a user.
fn in_words(why: &rusqlite::Error) -> anyhow::Error {
    use rusqlite::ErrorCode::{DatabaseCorrupt, NotADatabase, TooBig};
    match why.sqlite_error_code() {
        Some(DatabaseCorrupt | NotADatabase) => {
            anyhow::anyhow!("the file is damaged (`sqlite3 FILE .recover` saves what is left)")
        }
        Some(TooBig) => anyhow::anyhow!("a message states more than {MOST_BYTES} bytes"),
        Some(code) => anyhow::anyhow!("the file cannot be read ({code:?})"),
        None => anyhow::anyhow!("a value of another type than expected"),
    }
}
