//! Arbitrary bits as storage, configuration and arguments.

use std::mem::MaybeUninit;
use std::ptr;

use proptest::prelude::*;
use stereo_selfcal_capi::selfcal_error_t::*;
use stereo_selfcal_capi::*;

use crate::misuse::every_function;
use crate::rig::{Cal, Observed, defaults, factory, get, recorded};

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
        let mut cal = Cal::new();
        bytes(&mut cal)[at] ^= flip;
        prop_assert_eq!(get!(cal, selfcal_state), Err(SELFCAL_ERROR_NOT_INITIALISED));
        bytes(&mut cal)[at] ^= flip;
        prop_assert_eq!(get!(cal, selfcal_in_use).map(|used| used.generation), Ok(0));
    }

    #[test]
    fn arguments_of_arbitrary_bits_are_taken_or_refused_whole(
        bits in prop::collection::vec(any::<u8>(), 256), numbers in any::<[u32; 2]>(),
    ) {
        let mut cal = Cal::new();
        let before = Observed::of(&mut cal);
        let factory: selfcal_factory_t = of_bits(&bits);
        let match_: selfcal_correspondence_t = of_bits(&bits);
        let config: selfcal_config_t = of_bits(&bits);
        let [source, alpha] = numbers;
        let alpha = f32::from_bits(alpha);
        // SAFETY: live objects.
        let codes = unsafe {
            [
                selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, ptr::null(), &factory),
                selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, &config, &factory),
                selfcal_choose_camera(cal.ptr(), source, alpha, MaybeUninit::uninit().as_mut_ptr()),
            ]
        };
        if !codes[..2].contains(&SELFCAL_OK) {
            prop_assert_eq!(Observed::of(&mut cal), before);
        }
        // SAFETY: live objects.
        let code = unsafe { selfcal_push(cal.ptr(), &match_, ptr::null_mut()) };
        let batch = get!(cal, selfcal_batch).unwrap();
        prop_assert_eq!((batch.offered, batch.held == 1), (1, code == SELFCAL_OK));
    }

    #[test]
    fn a_configuration_with_a_wrong_byte_is_refused_or_within_its_limits(
        at in 0..size_of::<selfcal_config_t>(), flip in 1..=u8::MAX,
    ) {
        let mut config = defaults();
        // SAFETY: any bits are a configuration.
        unsafe { *(&raw mut config).cast::<u8>().add(at) ^= flip };
        let mut cal = Cal::zeroed();
        // SAFETY: live objects.
        let code = unsafe {
            selfcal_init(cal.ptr(), SELFCAL_STORAGE_SIZE, SELFCAL_HEADER, &config, &factory(&recorded()))
        };
        prop_assert!([SELFCAL_OK, SELFCAL_ERROR_CONFIG].contains(&code), "{:?}", code);
        prop_assert_eq!(get!(cal, selfcal_state).is_ok(), code == SELFCAL_OK);
    }
}

#[test]
fn a_wrong_bit_in_a_length_is_detected_where_an_access_would_leave_the_storage() {
    let mut cal = Cal::new();
    let mut found = 0;
    for at in 12..SELFCAL_STORAGE_SIZE {
        // The lengths of an empty batch and scene are 0.
        if bytes(&mut cal)[at] != 0 {
            continue;
        }
        bytes(&mut cal)[at] = 0x80;
        if get!(cal, selfcal_state) == Err(SELFCAL_ERROR_NOT_INITIALISED) {
            for (name, code) in every_function(cal.ptr()) {
                assert_eq!(code, SELFCAL_ERROR_NOT_INITIALISED, "{name}");
            }
            found += 1;
        }
        bytes(&mut cal)[at] = 0;
    }
    assert_eq!(found, 2, "high byte of the length of the batch, length of the scene");
    assert_eq!(get!(cal, selfcal_in_use).map(|used| used.generation), Ok(0));
}

/// A size as the documents write it: with a comma after the thousands.
fn stated(size: usize) -> String {
    if size < 1000 { size.to_string() } else { format!("{},{:03}", size / 1000, size % 1000) }
}

#[test]
fn the_documents_state_the_sizes_of_the_storage() {
    assert_eq!(SELFCAL_CAPACITY, 256, "the documents state the sizes of the default capacity");
    let calibrator = stated(size_of::<selfcal_t>());
    let both = format!("{calibrator}, {}", stated(size_of::<selfcal_link_t>()));
    let usage = include_str!("../../examples/readme/usage.c");
    assert!(
        usage.contains(&format!("/* 256 matches a pair: {calibrator} bytes */")),
        "{calibrator}"
    );
    assert!(include_str!("../../README.md").contains(&format!("| {both}, 4,096 |")), "{both}");
    let evidence = include_str!("../../../../host-tests/evidence/tables/by-tests.md");
    let row = format!("| `selfcal_t` of 256 matches, `selfcal_link_t` | {both} bytes |");
    assert!(evidence.contains(&row), "{row}");
}
