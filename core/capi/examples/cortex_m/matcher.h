/* Stands for the matcher: frames in the format of core/src/link/FORMAT.md, by the library's encoder. */
#ifndef MATCHER_H
#define MATCHER_H

#include <stddef.h>

#include "stereo_selfcal.h"

#define MATCHER_FRAME_BYTES(count) \
    (SELFCAL_FRAME_HEADER_BYTES + SELFCAL_FRAME_MATCH_BYTES * (count) + SELFCAL_FRAME_END_BYTES)

/* Writes a frame of the matches that fit the format, in 1/256 px. Its length, 0 after an error; `frame` has
 * MATCHER_FRAME_BYTES(count). */
size_t matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                     const selfcal_correspondence_t *matches, uint16_t count);

#endif
