/* Functions that both examples use. */
#ifndef STEPS_H
#define STEPS_H

#include "dataset.h"

/* Returns whether a call succeeded; prints the error if it did not. */
bool done(selfcal_error_t error, const char *what);

/* Prints the result of a pair of `count` matches; returns whether it was fused. A refused pair is not a failure. */
bool print_pair(selfcal_error_t error, const selfcal_outcome_t *outcome, unsigned number, size_t count);

void print_numbers(const char *name, const float *numbers, int count);

/* Prints the estimate after `pairs` pairs, and its errors against the reference; returns false without an estimate. */
bool print_estimate(const selfcal_t *cal, unsigned pairs, unsigned accepted,
                    const struct rig *reference);

#endif
