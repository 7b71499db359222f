/* A rig and what its cameras see: generated, the same every time. */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>

#include "stereo_selfcal.h"

/* Both cameras of the rig: pinholes. */
extern const selfcal_camera_t scene_camera;

/* Where the right camera is: turned and shifted from its place. */
void scene_rig(selfcal_extrinsics_t *rig);

/* A new pair of `count` matches: 0.3 px of noise, one in five wrong. */
void scene_matches(const selfcal_extrinsics_t *rig, selfcal_correspondence_t *matches, size_t count);

#endif
