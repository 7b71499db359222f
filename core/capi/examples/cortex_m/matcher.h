/* Stands for the FPGA: frames in the format of core/src/link/FORMAT.md. */
#ifndef MATCHER_H
#define MATCHER_H

#include "stereo_selfcal.h"

#define MATCHER_FRAME_BYTES(count) (36 + 16 * (count))

/* Writes a frame of pixels in 1/256 px, none negative; `frame` has MATCHER_FRAME_BYTES(count). */
void matcher_frame(uint8_t *frame, uint32_t sequence, const uint16_t size_px[2],
                   const selfcal_correspondence_t *matches, uint16_t count);

#endif
