//! The picture of the README: a knocked pair before and after calibration.

use anyhow::{Context, Result, anyhow};
use images::pictures::before_and_after;

use super::comparison::{Attempt, Scores, comparison};
use super::scene::PicturedScene;

/// Turn of the left camera in the README, degrees.
pub const KNOCKED: f64 = 1.0;

/// A knocked pair, before and after calibration.
#[derive(Debug, Clone)]
pub struct Knocked {
    /// Two rows of left image, right image and disparities, JPEG.
    pub jpeg: Vec<u8>,
    /// Scores before and after.
    pub scores: [Scores; 2],
}

/// The motorcycle, whose left camera is turned up by so many degrees.
///
/// # Errors
/// As [`comparison`], or if one of the rectifications has nothing to show.
pub fn knocked(degrees: f64) -> Result<Knocked> {
    let mut all = comparison(&PicturedScene::shipped("motorcycle_sift", degrees)?)?.into_iter();
    let outcome = |attempt: Option<Attempt>| {
        let attempt = attempt.context("an attempt is missing")?;
        attempt.outcome.map_err(|why| anyhow!("{}: {why}", attempt.name))
    };
    let (before, first) = outcome(all.next())?;
    let (after, last) = outcome(all.next_back())?;
    Ok(Knocked { jpeg: before_and_after([&before, &after])?, scores: [first, last] })
}
