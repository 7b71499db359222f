/* Steps of both examples. */
#ifndef STEPS_H
#define STEPS_H

#include "dataset.h"

/* Whether a call succeeded; prints its error if not. */
bool done(selfcal_error_t error, const char *what);

/* Prints what became of a pair of `count` matches; whether it was fused. A refused pair is no failure. */
bool print_pair(selfcal_error_t error, const selfcal_outcome_t *outcome, unsigned number, size_t count);

void print_numbers(const char *name, const float *numbers, int count);

/* Prints the estimate after `pairs` pairs and its errors; false without an estimate. */
bool print_estimate(const selfcal_t *cal, unsigned pairs, unsigned accepted,
                    const struct rig *reference);

#endif
