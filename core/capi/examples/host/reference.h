/* Errors of an estimate against a reference. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "dataset.h"

/* Angle between the two baselines, rad. */
double baseline_error(const selfcal_extrinsics_t *estimate, const struct rig *reference);

/* Distance of the two rotation vectors, rad, for rotations of less than half a turn. */
double rotation_error(const selfcal_extrinsics_t *estimate, const struct rig *reference);

#endif
