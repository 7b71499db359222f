#include "matcher.h"

size_t matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                     const selfcal_correspondence_t *matches, uint16_t count)
{
    selfcal_encoder_t encoder;
    selfcal_frame_header_t header = {
        .sequence = sequence,
        .size_px = {size_px[0], size_px[1]},
        .fraction_bits = 8,
        .pyramid_ratio = 64, /* no pyramid */
    };
    uint8_t *at = frame;

    /* The header contains the number of matches, so the matches that can be encoded are counted first. */
    for (uint16_t i = 0; i < count; i++)
        if (selfcal_frame_check(&header, &matches[i]) == SELFCAL_OK)
            header.count++;
    if (selfcal_frame_begin(&encoder, sizeof encoder, &header, at) != SELFCAL_OK)
        return 0;
    at += SELFCAL_FRAME_HEADER_BYTES;
    for (uint16_t i = 0; i < count; i++)
        if (selfcal_frame_match(&encoder, &matches[i], at) == SELFCAL_OK)
            at += SELFCAL_FRAME_MATCH_BYTES;
    if (selfcal_frame_end(&encoder, at) != SELFCAL_OK)
        return 0;
    return (size_t)(at - frame) + SELFCAL_FRAME_END_BYTES;
}
