/* Stands for the matcher: the library's encoder makes frames in the format of core/src/link/FORMAT.md. */
#ifndef MATCHER_H
#define MATCHER_H

#include <stddef.h>

#include "stereo_selfcal.h"

#define MATCHER_FRAME_BYTES(count) \
    (SELFCAL_FRAME_HEADER_BYTES + SELFCAL_FRAME_MATCH_BYTES * (count) + SELFCAL_FRAME_END_BYTES)

/* Writes a frame of the matches that can be encoded, in steps of 1/256 px. Returns its length, bytes, or 0 after an
 * error. `frame` has room for MATCHER_FRAME_BYTES(count) bytes. */
size_t matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                     const selfcal_correspondence_t *matches, uint16_t count);

#endif
