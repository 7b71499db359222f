#include "steps.h"

#include <stdio.h>

#include "reference.h"

bool done(selfcal_error_t error, const char *what)
{
    if (error != SELFCAL_OK)
        fprintf(stderr, "error: %s: %s (%d)\n", what, selfcal_string(error), (int)error);
    return error == SELFCAL_OK;
}

bool print_pair(selfcal_error_t error, const selfcal_outcome_t *outcome, unsigned number, size_t count)
{
    fprintf(stderr, "pair %2u, %3zu matches: ", number, count);
    if (outcome->has_pair)
        fprintf(stderr, "%6.3f > %5.3f px, ", outcome->pair.rms_px_before, outcome->pair.rms_px_after);
    fprintf(stderr, "%s\n", selfcal_string(error ? error : outcome->fused));
    return error == SELFCAL_OK;
}

void print_numbers(const char *name, const float *numbers, int count)
{
    printf("%s", name);
    for (int i = 0; i < count; i++)
        printf(" %.9g", numbers[i]);
    printf("\n");
}

bool print_estimate(const selfcal_t *cal, unsigned pairs, unsigned accepted,
                    const struct rig *reference)
{
    selfcal_proposal_t proposal;
    if (!done(selfcal_proposal(cal, &proposal), "estimate"))
        return false;
    printf("pairs %u\n", pairs);
    printf("accepted %u\n", accepted);
    printf("behind_the_estimate %u\n", (unsigned)proposal.pairs);
    printf("state %s\n", selfcal_string(proposal.state));
    print_numbers("R", proposal.extrinsics.rotation, 9);
    print_numbers("t", proposal.extrinsics.translation, 3);
    print_numbers("sd_rotation", &proposal.sd.rotation_rad, 1);
    print_numbers("sd_translation", &proposal.sd.translation_rad, 1);
    printf("e_t %.9f\n", baseline_error(&proposal.extrinsics, reference));
    printf("e_theta %.9f\n", rotation_error(&proposal.extrinsics, reference));
    return true;
}
