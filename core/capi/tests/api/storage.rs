//! Arbitrary bits as storage, configuration and arguments.

use std::mem::MaybeUninit;
use std::ptr;

use proptest::prelude::*;
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::misuse::every_function;
use crate::rig::{Cal, Observed, get};

fn bytes(cal: &mut Cal) -> &mut [u8] {
    // SAFETY: live storage, and every byte is initialised.
    unsafe { std::slice::from_raw_parts_mut(cal.ptr().cast(), SELFCAL_STORAGE_SIZE) }
}

/// A value of arbitrary bits.
fn of_bits<T: zerocopy::FromBytes>(bits: &[u8]) -> T {
    T::read_from_prefix(bits).unwrap().0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn storage_of_arbitrary_bits_is_refused_and_not_written(
        seed in prop::collection::vec(any::<u8>(), 64),
    ) {
        let mut cal = Cal::zeroed();
        bytes(&mut cal).iter_mut().zip(seed.iter().cycle()).for_each(|(to, from)| *to = *from);
        let before = bytes(&mut cal).to_vec();
        for (name, code) in every_function(cal.ptr()) {
            prop_assert_eq!(code, SELFCAL_ERROR_NOT_INITIALISED, "{}", name);
        }
        prop_assert!(before == bytes(&mut cal));
    }

    #[test]
    fn one_wrong_byte_in_the_magic_of_the_storage_is_detected(at in 0..12_usize, flip in 1..=u8::MAX) {
        let mut cal = Cal::new(None);
        bytes(&mut cal)[at] ^= flip;
        prop_assert_eq!(get!(cal, selfcal_generation), Err(SELFCAL_ERROR_NOT_INITIALISED));
        bytes(&mut cal)[at] ^= flip;
        prop_assert_eq!(get!(cal, selfcal_generation), Ok(0));
    }

    #[test]
    fn arguments_of_arbitrary_bits_are_taken_or_refused_whole(
        bits in prop::collection::vec(any::<u8>(), 96), numbers in any::<[u32; 2]>(),
    ) {
        let mut cal = Cal::new(None);
        let before = Observed::of(&mut cal);
        let camera: selfcal_camera_t = of_bits(&bits);
        let factory: selfcal_extrinsics_t = of_bits(&bits);
        let match_: selfcal_correspondence_t = of_bits(&bits);
        let config: selfcal_config_t = of_bits(&bits);
        let [source, alpha] = numbers;
        let alpha = f32::from_bits(alpha);
        // SAFETY: live objects.
        let codes = unsafe {
            [
                selfcal_set_cameras(cal.ptr(), &camera, &camera),
                selfcal_set_factory(cal.ptr(), &factory),
                selfcal_push(cal.ptr(), &match_, ptr::null_mut()),
                selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, &config),
                selfcal_choose_camera(cal.ptr(), source, alpha, MaybeUninit::uninit().as_mut_ptr()),
            ]
        };
        prop_assert_eq!(codes[3], SELFCAL_ERROR_CONFIG_NOT_INITIALISED);
        if !codes[..3].contains(&SELFCAL_OK) {
            prop_assert_eq!(Observed::of(&mut cal), before);
        }
    }

    #[test]
    fn a_configuration_with_a_wrong_byte_is_refused_or_within_its_limits(
        at in 0..size_of::<selfcal_config_t>(), flip in 1..=u8::MAX,
    ) {
        let mut config = crate::rig::config(selfcal_config_default);
        // SAFETY: any bits are a configuration.
        unsafe { *(&raw mut config).cast::<u8>().add(at) ^= flip };
        let mut cal = Cal::zeroed();
        // SAFETY: live objects.
        let code = unsafe { selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, &config) };
        // 1 and 2 are the presets.
        let other_preset = (at, flip) == (4, 1 ^ 2);
        let refused = code == SELFCAL_ERROR_CONFIG_NOT_INITIALISED;
        prop_assert!(at >= 8 || other_preset || refused, "{:?}", code);
        let begun = get!(cal, selfcal_generation) == Ok(0);
        prop_assert_eq!(begun, code == SELFCAL_OK);
    }
}

#[test]
fn a_wrong_bit_in_a_length_is_detected_where_an_access_would_leave_the_storage() {
    let mut cal = Cal::new(None);
    let mut found = 0;
    for at in 12..SELFCAL_STORAGE_SIZE {
        // The lengths of an empty batch and scene are 0.
        if bytes(&mut cal)[at] != 0 {
            continue;
        }
        bytes(&mut cal)[at] = 0x80;
        if get!(cal, selfcal_generation) == Err(SELFCAL_ERROR_NOT_INITIALISED) {
            for (name, code) in every_function(cal.ptr()) {
                assert_eq!(code, SELFCAL_ERROR_NOT_INITIALISED, "{name}");
            }
            found += 1;
        }
        bytes(&mut cal)[at] = 0;
    }
    assert_eq!(found, 3, "high byte of the length of the batch, lengths of the two scenes");
    assert_eq!(get!(cal, selfcal_generation), Ok(0));
}
