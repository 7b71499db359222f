//! Joins the tracked matches of two frames by their track numbers.
//!
//! Each frame is joined to the same earlier frame, so that the rig can move far enough for
//! [`Calibrator::push_tracks`](crate::Calibrator::push_tracks). Once more than half of the tracks of the earlier
//! frame are lost, a newer frame replaces it. A track is looked up by the remainder of its number modulo the capacity,
//! without search or sorting. The tracks that the last frame shares with the earlier frame come first in the list.

use super::motion::MotionFit;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;

/// Matches of an earlier frame and of the last frame, joined by their tracks; at most `N`.
///
/// For each frame call [`Tracks::begin`], then [`Tracks::push`] for each match, then [`Tracks::end`];
/// [`Tracking`](crate::link::Tracking) does this for the frames of a matcher. A push takes constant time.
///
/// RAM: 66 bytes per track in `f32`, plus 72 bytes. [`Calibrator::push_tracks`](crate::Calibrator::push_tracks) reads up
/// to 256 tracks.
#[derive(Debug, Clone)]
pub struct Tracks<T: Scalar, const N: usize> {
    /// Rays of each track in the earlier frame, and in the last frame that has the track.
    quads: [[RayPair<T>; 2]; N],
    /// Track number of each entry of `quads`.
    ids: [u16; N],
    /// Index of a track in `quads` and `ids`, by the remainder of its number; stale if another track is at that index.
    places: [u16; N],
    /// Number of tracks in `quads` and `ids`.
    held: u16,
    /// Number of these tracks that the present frame has, too. They come first in `quads` and `ids`.
    seen: u16,
    /// Rays and tracks of the present frame.
    present: [RayPair<T>; N],
    present_ids: [u16; N],
    count: u16,
    /// Whether the present frame has ended.
    has_ended: bool,
    /// Motion of the rig between the two frames, between two steps of its fit.
    fit: MotionFit<T>,
}

impl<T: Scalar, const N: usize> Tracks<T, N> {
    /// Returns the tracks before the first frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            quads: [[RayPair::ZERO; 2]; N],
            ids: [0; N],
            places: [0; N],
            held: 0,
            seen: 0,
            present: [RayPair::ZERO; N],
            present_ids: [0; N],
            count: 0,
            has_ended: false,
            fit: MotionFit::START,
        }
    }

    /// Begins a frame. A previous frame that has not ended is dropped. A previous frame that has ended and has tracks
    /// becomes the earlier frame if there is no earlier frame, or if it shares fewer than half of the tracks of the
    /// present one.
    pub fn begin(&mut self) {
        let is_lost = self.seen < self.held.div_ceil(2) || self.held == 0;
        if self.has_ended && self.count > 0 && is_lost {
            self.renew();
        }
        (self.seen, self.count, self.has_ended) = (0, 0, false);
        self.fit = MotionFit::START;
    }

    /// Adds a match of the frame, and joins it to the match of the same track in the earlier frame. If the frame itself
    /// becomes the earlier frame, it keeps only its first `N` matches with a track. If several tracks have the same
    /// remainder modulo `N`, it keeps the first of them.
    ///
    /// * `track`: number of the track, the same in each frame; 0 for a match without a track.
    /// * `rays`: rays of the match by [`Cameras::rays`](crate::Cameras::rays), with the factory cameras.
    pub fn push(&mut self, track: u16, rays: &RayPair<T>) {
        if track != 0 {
            let _ = self.join(track, rays);
            let _ = self.note(track, rays);
        }
    }

    /// Ends the frame, and thereby confirms its matches.
    pub fn end(&mut self) {
        self.has_ended = true;
    }

    /// Returns the matches that the earlier frame and the last frame share; empty until the last frame has ended.
    pub fn quads(&self) -> &[[RayPair<T>; 2]] {
        let seen = if self.has_ended { self.seen } else { 0 };
        self.quads.get(..seen.into()).unwrap_or_default()
    }

    /// Returns the fit of the motion between the two frames, and the matches that they share.
    pub(crate) fn fit(&mut self) -> (&mut MotionFit<T>, &[[RayPair<T>; 2]]) {
        let seen = if self.has_ended { self.seen } else { 0 };
        (&mut self.fit, self.quads.get(..seen.into()).unwrap_or_default())
    }

    /// Forgets the earlier frame. The last frame takes its place when the next frame begins, if it has ended and has
    /// tracks.
    pub fn restart(&mut self) {
        (self.held, self.seen) = (0, 0);
        self.fit = MotionFit::START;
    }

    /// Returns the remainder of a track number modulo `N`; `None` if `N` is 0.
    fn remainder(track: u16) -> Option<usize> {
        usize::from(track).checked_rem(N)
    }

    /// Adds a match to the present frame.
    fn note(&mut self, track: u16, rays: &RayPair<T>) -> Option<()> {
        *self.present_ids.get_mut(usize::from(self.count))? = track;
        *self.present.get_mut(usize::from(self.count))? = *rays;
        self.count = self.count.checked_add(1)?;
        Some(())
    }

    /// Makes the present frame the earlier frame.
    fn renew(&mut self) {
        self.held = 0;
        for at in 0..self.count {
            let _ = self.keep(at.into());
        }
    }

    /// Keeps a match of the present frame, unless a match with the same remainder is kept already.
    fn keep(&mut self, at: usize) -> Option<()> {
        let (track, rays) = (*self.present_ids.get(at)?, *self.present.get(at)?);
        let remainder = Self::remainder(track);
        let place = self.places.get_mut(remainder?)?;
        let ids = self.ids.get(..self.held.into())?;
        if ids.get(usize::from(*place)).is_some_and(|held| Self::remainder(*held) == remainder) {
            return None;
        }
        *place = self.held;
        *self.ids.get_mut(usize::from(self.held))? = track;
        *self.quads.get_mut(usize::from(self.held))? = [rays; 2];
        self.held = self.held.checked_add(1)?;
        Some(())
    }

    /// Joins a match to the match of the same track in the earlier frame.
    fn join(&mut self, track: u16, rays: &RayPair<T>) -> Option<()> {
        let own = *self.places.get(Self::remainder(track)?)?;
        let (place, seen) = (usize::from(own), usize::from(self.seen));
        let is_held = own < self.held && *self.ids.get(place)? == track;
        // A track that has been seen already occurs twice in this frame.
        if !is_held || place < seen {
            return None;
        }
        // The track changes places with the first unseen track, which may be this track itself.
        let [before, _] = *self.quads.get(place)?;
        let (other, of_other) = (*self.ids.get(seen)?, *self.quads.get(seen)?);
        (*self.ids.get_mut(place)?, *self.quads.get_mut(place)?) = (other, of_other);
        (*self.ids.get_mut(seen)?, *self.quads.get_mut(seen)?) = (track, [before, *rays]);
        *self.places.get_mut(Self::remainder(other)?)? = own;
        *self.places.get_mut(Self::remainder(track)?)? = self.seen;
        self.seen = self.seen.checked_add(1)?;
        Some(())
    }
}

impl<T: Scalar, const N: usize> Default for Tracks<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;
    use std::vec::Vec;

    type Frame = Vec<(u16, u16)>;

    /// Returns rays that differ for each number.
    fn rays(of: u16) -> RayPair<f32> {
        let x = f32::from(of) / 8192.0;
        RayPair::try_new([x, 0.5], [x - 0.1, 0.5]).unwrap()
    }

    fn take<const N: usize>(tracks: &mut Tracks<f32, N>, frame: &[(u16, u16)]) {
        tracks.begin();
        for (track, of) in frame {
            tracks.push(*track, &rays(*of));
            assert!(tracks.quads().is_empty());
        }
        tracks.end();
    }

    /// Returns the bits of `x` of the left rays of each joined match, in the earlier and in the last frame, sorted.
    fn joined<const N: usize>(tracks: &Tracks<f32, N>) -> Vec<[u32; 2]> {
        let quads = tracks.quads().iter();
        let mut found: Vec<_> = quads.map(|quad| quad.map(|pair| pair.left.x.to_bits())).collect();
        found.sort_unstable();
        found
    }

    /// Returns the first match of each track; track 0 is left out.
    fn by_track(frame: &[(u16, u16)]) -> BTreeMap<u16, u16> {
        frame.iter().rev().filter(|(track, _)| *track != 0).copied().collect()
    }

    prop_compose! {
        fn frames()(frames in prop::collection::vec(
            prop::collection::vec((0..40_u16, any::<u16>()), 0..60), 2..6
        )) -> Vec<Frame> {
            frames
        }
    }

    proptest! {
        #[test]
        fn each_frame_is_joined_to_the_earlier_one_in_any_order(mut frames in frames()) {
            // Each frame contains all matches of the first frame, so it shares at least half of the tracks.
            let first = frames[0].clone();
            frames[1..].iter_mut().for_each(|frame| frame.splice(..0, first.clone()).for_each(drop));
            let mut tracks = Tracks::<f32, 64>::new();
            for (at, frame) in frames.iter().enumerate() {
                let mut frame = frame.clone();
                if at % 2 == 1 {
                    frame.reverse();
                }
                take(&mut tracks, &frame);
                let (before, after) = (by_track(&first), by_track(&frame));
                let both = before.iter().filter_map(|(track, of)| Some([*of, *after.get(track)?]));
                let mut expected: Vec<_> =
                    both.map(|pair| pair.map(|of| rays(of).left.x.to_bits())).collect();
                expected.sort_unstable();
                let none = at == 0 || before.is_empty();
                prop_assert_eq!(joined(&tracks), if none { Vec::new() } else { expected });
                if before.is_empty() {
                    break;
                }
            }
        }

        #[test]
        fn capacity_leaves_out_tracks_of_the_same_remainder_and_joins_no_other(
            one in prop::collection::vec(1..4096_u16, 0..40),
            two in prop::collection::vec(1..4096_u16, 0..40),
        ) {
            let [a, b] = [&one, &two].map(|ids| ids.iter().map(|id| (*id, *id)).collect::<Vec<_>>());
            let mut tracks = Tracks::<f32, 16>::new();
            take(&mut tracks, &a);
            take(&mut tracks, &b);
            let mut by_remainder = BTreeMap::new();
            by_remainder.extend(one.iter().take(16).rev().map(|id| (id % 16, *id)));
            let kept = by_remainder.values().filter(|id| two.contains(id)).count();
            prop_assert_eq!(tracks.quads().len(), if one.is_empty() { 0 } else { kept });
            prop_assert!(tracks.quads().iter().all(|[before, after]| before == after));
        }
    }

    #[test]
    fn a_frame_with_fewer_than_half_of_the_tracks_takes_their_place_and_one_without_tracks_does_not()
     {
        let mut tracks = Tracks::<f32, 8>::new();
        let mut after = |ids: &[u16]| {
            take(&mut tracks, &ids.iter().map(|id| (*id, *id)).collect::<Vec<_>>());
            tracks.quads().len()
        };
        assert_eq!([after(&[]), after(&[1, 2, 3, 4]), after(&[]), after(&[0, 0])], [0; 4]);
        assert_eq!([after(&[1, 2]), after(&[1, 9]), after(&[1, 2]), after(&[2])], [2, 1, 1, 0]);
        assert_eq!(after(&[2, 5]), 1);
        tracks.restart();
        assert!(tracks.quads().is_empty());
        take(&mut tracks, &[(5, 5), (6, 6)]);
        assert_eq!(tracks.quads().len(), 1);
    }

    #[test]
    fn a_frame_without_an_end_counts_for_nothing() {
        let mut tracks = Tracks::<f32, 8>::new();
        let broken = |tracks: &mut Tracks<f32, 8>| {
            tracks.begin();
            tracks.push(3, &rays(9));
            assert!(tracks.quads().is_empty());
        };
        broken(&mut tracks);
        take(&mut tracks, &[(3, 1), (4, 2)]);
        broken(&mut tracks);
        take(&mut tracks, &[(4, 5), (3, 6), (3, 7)]);
        assert_eq!(
            joined(&tracks),
            [[1, 6], [2, 5]].map(|of| of.map(|of| rays(of).left.x.to_bits()))
        );
        let mut none = Tracks::<f32, 0>::new();
        take(&mut none, &[(3, 1)]);
        take(&mut none, &[(3, 1)]);
        assert!(none.quads().is_empty());
    }
}
