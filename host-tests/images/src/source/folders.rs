//! Images of a folder, or of a pattern with `*`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

/// Endings of images.
const ENDINGS: [&str; 10] =
    ["png", "jpg", "jpeg", "pgm", "ppm", "pnm", "tif", "tiff", "bmp", "webp"];

/// Whether the ending belongs to an image.
pub(super) fn is_image(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    ENDINGS.contains(&ending.as_str())
}

/// The images of a folder or of a pattern, in the order of their names, or a single image. An error without images.
pub(super) fn images(place: &Path) -> Result<Vec<PathBuf>> {
    let name = place.display();
    let mut found: Vec<PathBuf> = if place.is_dir() {
        let entries = std::fs::read_dir(place).with_context(|| format!("cannot list {name}"))?;
        entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?
    } else if place.is_file() {
        vec![place.to_path_buf()]
    } else {
        let pattern = place.to_str().context("the pattern is not valid text")?;
        glob::glob(pattern)?.collect::<Result<_, _>>()?
    };
    found.retain(|path| is_image(path));
    found.sort();
    ensure!(!found.is_empty(), "no images (PNG, JPEG, PGM, TIFF, BMP, WebP) in {name}");
    Ok(found)
}
