/* Stands for the FPGA: its frames, as core/src/link/FORMAT.md has them. */
#ifndef MATCHER_H
#define MATCHER_H

#include "stereo_selfcal.h"

#define MATCHER_FRAME_BYTES(count) (36 + 16 * (count))

/* A frame of pixels in 1/256 px, none of which may be negative; `frame` has room for it. */
void matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                   const selfcal_correspondence_t *matches, uint16_t count);

#endif
