/* Generates a rig and matches of its cameras; each run gives the same ones. */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>

#include "stereo_selfcal.h"

/* Factory calibration: both cameras of the rig, without distortion, and a guess of the extrinsics, side by side. */
extern const selfcal_factory_t scene_factory;

/* Extrinsics of the rig, rotated and shifted from side by side. */
void scene_rig(selfcal_extrinsics_t *rig);

/* Generates a pair of `count` matches with 0.3 px of noise; one in five is an outlier. */
void scene_matches(const selfcal_extrinsics_t *rig, selfcal_correspondence_t *matches, size_t count);

#endif
