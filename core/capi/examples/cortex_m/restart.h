/* Checks a loss of power, and then frames of the matcher. */
#ifndef RESTART_H
#define RESTART_H

#include "stereo_selfcal.h"

/* Checks both, with a calibrator that is locked on the rig. */
void check_restart(selfcal_t *cal, const selfcal_extrinsics_t *rig);

#endif
