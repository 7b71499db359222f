/* Calibrates a recorded rig, pair by pair, and compares the estimate with the set's reference.
 *
 *     calibrate host-tests/data/opencv_chess_sift
 */
#include <stdio.h>
#include <string.h>

#include "dataset.h"
#include "reference.h"
#include "stereo_selfcal.h"

static selfcal_t cal;

static bool done(selfcal_error_t error, const char *what)
{
    if (error != SELFCAL_OK)
        fprintf(stderr, "error: %s: %s (%d)\n", what, selfcal_error_string(error), (int)error);
    return error == SELFCAL_OK;
}

/* Solves and fuses what is in the batch; false if it was not taken in, which is no failure. */
static bool take_pair(int index, size_t count)
{
    selfcal_fused_t fused;
    selfcal_report_t report;
    selfcal_error_t error = selfcal_solve_pair(&cal);
    if (error == SELFCAL_OK)
        error = selfcal_fuse(&cal, &fused);
    fprintf(stderr, "pair %2d, %3zu matches: ", index, count);
    if (selfcal_report(&cal, &report) == SELFCAL_OK)
        fprintf(stderr, "%6.3f > %5.3f px, ", report.rms_px_before, report.rms_px_after);
    fprintf(stderr, "%s\n", error ? selfcal_error_string(error) : selfcal_fused_string(fused));
    return error == SELFCAL_OK;
}

static void print_numbers(const char *name, const float *numbers, int count)
{
    printf("%s", name);
    for (int i = 0; i < count; i++)
        printf(" %.9g", numbers[i]);
    printf("\n");
}

static void print_health(const selfcal_health_t *health)
{
    printf("row_offset_in_use_px %.3f\n", health->in_use_px);
    printf("row_offset_proposed_px %.3f\n", health->proposed_px);
    printf("coverage %.2f\n", health->coverage);
    printf("band %s\n", selfcal_band_string(health->band));
    printf("arming %s\n", selfcal_arming_string(health->arming));
}

static bool print_estimate(int pairs, int accepted, const struct rig *reference)
{
    selfcal_proposal_t proposal;
    if (!done(selfcal_proposal(&cal, &proposal), "estimate"))
        return false;
    printf("pairs %d\n", pairs);
    printf("accepted %d\n", accepted);
    printf("state %s\n", selfcal_state_string(proposal.state));
    print_numbers("R", proposal.extrinsics.rotation, 9);
    print_numbers("t", proposal.extrinsics.translation, 3);
    print_numbers("sd_rotation", &proposal.sd.rotation_rad, 1);
    print_numbers("sd_translation", &proposal.sd.translation_rad, 1);
    printf("e_t %.9f\n", baseline_error(&proposal.extrinsics, reference));
    printf("e_theta %.9f\n", rotation_error(&proposal.extrinsics, reference));
    return true;
}

/* Puts the estimate into use and asks for what a rectifier loads. */
static bool apply(void)
{
    uint32_t generation;
    selfcal_rectified_camera_t camera;
    selfcal_homographies_t homographies;
    if (!done(selfcal_apply(&cal, NULL), "apply") ||
        !done(selfcal_generation(&cal, &generation), "generation") ||
        !done(selfcal_choose_camera(&cal, SELFCAL_SOURCE_IN_USE, 0, &camera), "camera") ||
        !done(selfcal_homographies(&cal, SELFCAL_SOURCE_IN_USE, &camera, &homographies),
              "homographies"))
        return false;
    printf("generation %u\n", (unsigned)generation);
    print_numbers("rectified_focal_px", &camera.focal_px, 1);
    print_numbers("H_l", homographies.left, 9);
    print_numbers("H_r", homographies.right, 9);
    return true;
}

static bool calibrate(const char *set)
{
    selfcal_camera_t left, right;
    struct rig reference;
    if (!dataset_read_meta(set, &left, &right, &reference) ||
        !done(selfcal_init(&cal, sizeof cal, NULL), "start") ||
        !done(selfcal_set_cameras(&cal, &left, &right), "cameras"))
        return false;

    static selfcal_correspondence_t matches[SELFCAL_CAPACITY];
    selfcal_health_t health;
    bool has_health = false;
    int accepted = 0;
    for (int pairs = 0;; pairs++) {
        size_t count;
        switch (dataset_read_pair(set, pairs, matches, SELFCAL_CAPACITY, &count)) {
        case DATASET_ERROR:
            return false;
        case DATASET_END:
            if (pairs == 0) {
                fprintf(stderr, "error: no pairs/0000.csv in %s\n", set);
                return false;
            }
            if (!print_estimate(pairs, accepted, &reference))
                return false;
            if (has_health)
                print_health(&health);
            return apply();
        case DATASET_PAIR:
            break;
        }
        /* Matches that are refused are counted, and no reason to stop. */
        if (!done(selfcal_push_array(&cal, matches, count, NULL), "matches"))
            return false;
        accepted += take_pair(pairs, count);
        has_health = selfcal_health(&cal, &health) == SELFCAL_OK;
        if (!done(selfcal_clear_pair(&cal), "clear"))
            return false;
    }
}

int main(int argc, char **argv)
{
    if (argc != 2 || strcmp(argv[1], "--help") == 0) {
        fprintf(argc == 2 ? stdout : stderr,
                "usage: %s SET\n\n"
                "Calibrates a stereo rig from recorded correspondences. SET is a folder with\n"
                "meta.json and pairs/NNNN.csv, such as host-tests/data/opencv_chess_sift.\n"
                "Prints the estimate, its errors against the reference of the set, rad, and\n"
                "the health; what becomes of each pair goes to the standard error.\n",
                argv[0]);
        return argc == 2 ? 0 : 2;
    }
    return calibrate(argv[1]) ? 0 : 1;
}
