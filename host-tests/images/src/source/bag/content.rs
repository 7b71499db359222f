//! Bytes of a bag within bounds: a damaged length may ask for more memory than there is, and a damaged content may
//! decompress without end.

use std::borrow::Cow;
use std::io::Read;

use anyhow::{Context, Result, bail, ensure};

/// Largest record, chunk or message that is read, bytes: more than an uncompressed image of 8192 x 8192 px in colour.
pub(super) const MOST_BYTES: u64 = 256 << 20;

/// Reads bytes of a stated length. Memory grows with the bytes that are there, not with the length.
///
/// # Errors
/// If the length is out of range, or the file ends before.
pub(super) fn exactly(input: &mut impl Read, length: u64) -> Result<Vec<u8>> {
    ensure!(length <= MOST_BYTES, "a record states {length} bytes, so it is damaged");
    let mut bytes = Vec::new();
    input.take(length).read_to_end(&mut bytes).context("cannot be read")?;
    ensure!(bytes.len() as u64 == length, "cut short");
    Ok(bytes)
}

/// The content of a chunk.
///
/// * `compression`: its name in MCAP or in a bag of ROS 1.
/// * `length`: stated length of the content, bytes.
///
/// # Errors
/// If the compression is unknown, the compressed bytes are damaged, or the content has another length.
pub(super) fn inflated<'a>(
    compression: &str,
    bytes: &'a [u8],
    length: u64,
) -> Result<Cow<'a, [u8]>> {
    ensure!(length <= MOST_BYTES, "a chunk states {length} bytes, so it is damaged");
    // One byte more than stated shows a longer content.
    let whole = |decoder: &mut dyn Read| {
        let mut content = Vec::new();
        let read = decoder.take(length + 1).read_to_end(&mut content);
        read.ok().map(|_| content)
    };
    let content = match compression {
        "" | "none" => Some(Cow::Borrowed(bytes)),
        "lz4" => whole(&mut lz4_flex::frame::FrameDecoder::new(bytes)).map(Cow::Owned),
        "bz2" => whole(&mut bzip2::read::BzDecoder::new(bytes)).map(Cow::Owned),
        "zstd" => {
            let decoder = zstd::Decoder::with_buffer(bytes);
            decoder.ok().and_then(|mut decoder| whole(&mut decoder)).map(Cow::Owned)
        }
        other => bail!("a chunk of the unknown compression `{other}`"),
    };
    let content = content.with_context(|| format!("a chunk of damaged {compression}"))?;
    ensure!(
        content.len() as u64 == length,
        "a chunk has another length than it states, {length} bytes"
    );
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_beyond_the_file_takes_no_memory_and_is_named() {
        let why = |length| exactly(&mut &b"four"[..], length).unwrap_err().to_string();
        assert!(why(1 << 62).contains("states 4611686018427387904 bytes"));
        assert_eq!(why(MOST_BYTES), "cut short");
        assert_eq!(exactly(&mut &b"four"[..], 4).unwrap(), b"four");
    }

    #[test]
    fn a_content_longer_than_stated_ends_at_the_stated_length() {
        let zeros = vec![0; 64 << 20];
        let packed = zstd::encode_all(&zeros[..], 1).unwrap();
        let why = inflated("zstd", &packed, 1000).unwrap_err().to_string();
        assert!(why.contains("another length"), "{why}");
        assert_eq!(inflated("zstd", &packed, zeros.len() as u64).unwrap().len(), zeros.len());
        assert!(inflated("none", b"four", 5).is_err());
        let why = inflated("rar", b"four", 4).unwrap_err().to_string();
        assert!(why.contains("`rar`"), "{why}");
    }
}
