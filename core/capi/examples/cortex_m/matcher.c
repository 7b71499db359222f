#include "matcher.h"

#include <math.h>

#define FRACTION_BITS 8

static uint32_t crc;

static uint8_t *put(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) {
        const uint8_t byte = (uint8_t)(value >> 8 * i);
        *at++ = byte;
        crc ^= byte;
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return at;
}

/* The CRC goes out as the complement of the register, which it does not change. */
static uint8_t *put_crc(uint8_t *at)
{
    const uint32_t held = crc;
    at = put(at, ~held, 4);
    crc = held;
    return at;
}

static uint8_t *put_pixel(uint8_t *at, const float px[2])
{
    at = put(at, (uint32_t)lroundf(ldexpf(px[0], FRACTION_BITS)), 3);
    return put(at, (uint32_t)lroundf(ldexpf(px[1], FRACTION_BITS)), 3);
}

void matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                   const selfcal_correspondence_t *matches, uint16_t count)
{
    crc = 0xffffffffu;
    frame = put(frame, 0x464d4353, 4); /* "SCMF" */
    frame = put(frame, 1, 1);          /* version */
    frame = put(frame, 0, 1);          /* flags */
    frame = put(frame, FRACTION_BITS, 1);
    frame = put(frame, 64, 1); /* no pyramid */
    frame = put(frame, sequence, 4);
    frame = put(frame, count, 2);
    frame = put(frame, 0, 2); /* grid step of the wire */
    frame = put(frame, 0, 8); /* no clock */
    frame = put(frame, size_px[0], 2);
    frame = put(frame, size_px[1], 2);
    frame = put_crc(frame);
    for (uint16_t i = 0; i < count; i++) {
        frame = put_pixel(frame, matches[i].left_px);
        frame = put_pixel(frame, matches[i].right_px);
        frame = put(frame, (uint32_t)lroundf(65535 * matches[i].score), 2);
        frame = put(frame, 0, 2); /* level, reserved */
    }
    put_crc(frame);
}
