/* Recorded correspondences: a folder with meta.json and pairs/NNNN.csv. */
#ifndef DATASET_H
#define DATASET_H

#include <stdbool.h>
#include <stddef.h>

#include "stereo_selfcal.h"

/* R row by row, t of unit length: p_r = R p_l + t. */
struct rig {
    double rotation[9];
    double translation[3];
};

/* Reads the cameras of a set, as a factory calibration whose extrinsics are a guess, and its reference extrinsics.
 * Returns false, after a message, if this fails. */
bool dataset_read_meta(const char *set, selfcal_factory_t *factory, struct rig *reference);

enum dataset_pair { DATASET_PAIR, DATASET_END, DATASET_ERROR };

/* Reads pair number `index`, from 0, with at most `room` matches. Returns DATASET_END if the set has no such pair.
 * Prints a message before it returns DATASET_ERROR. */
enum dataset_pair dataset_read_pair(const char *set, int index, selfcal_correspondence_t *matches,
                                    size_t room, size_t *count);

#endif
