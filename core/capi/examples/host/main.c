/* Calibrates a recorded rig, pair by pair, and compares the estimate with the set's reference.
 *
 *     calibrate host-tests/data/opencv_chess_sift
 */
#include <stdio.h>
#include <string.h>

#include "dataset.h"
#include "steps.h"
#include "stereo_selfcal.h"

static selfcal_t cal;

static void print_verdict(const selfcal_verdict_t *verdict)
{
    printf("rows_px %.3f\n", verdict->rows_px);
    printf("depth_px %.3f\n", verdict->depth_px);
    printf("coverage %.2f\n", verdict->coverage);
    printf("may_arm %s\n", verdict->may_arm ? "yes" : "no");
    printf("should_apply %s\n", verdict->should_apply ? "yes" : "no");
}

/* Applies the estimate and prints the input of a rectifier. */
static bool apply(void)
{
    selfcal_calibration_t applied;
    selfcal_rectified_camera_t camera;
    selfcal_homographies_t homographies;
    if (!done(selfcal_apply(&cal, &applied), "apply") ||
        !done(selfcal_choose_camera(&cal, SELFCAL_SOURCE_IN_USE, 0, &camera), "camera") ||
        !done(selfcal_homographies(&cal, SELFCAL_SOURCE_IN_USE, &camera, &homographies),
              "homographies"))
        return false;
    printf("generation %u\n", (unsigned)applied.generation);
    print_numbers("rectified_focal_px", &camera.focal_px, 1);
    print_numbers("H_l", homographies.left, 9);
    print_numbers("H_r", homographies.right, 9);
    return true;
}

static bool calibrate(const char *set)
{
    selfcal_factory_t factory;
    struct rig reference;
    if (!dataset_read_meta(set, &factory, &reference) ||
        !done(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &factory), "start"))
        return false;

    static selfcal_correspondence_t matches[SELFCAL_CAPACITY];
    selfcal_verdict_t verdict;
    unsigned accepted = 0;
    for (unsigned pairs = 0;; pairs++) {
        size_t count;
        switch (dataset_read_pair(set, (int)pairs, matches, SELFCAL_CAPACITY, &count)) {
        case DATASET_ERROR:
            return false;
        case DATASET_END:
            if (pairs == 0) {
                fprintf(stderr, "error: no pairs/0000.csv in %s\n", set);
                return false;
            }
            if (!print_estimate(&cal, pairs, accepted, &reference))
                return false;
            if (!done(selfcal_verdict(&cal, &verdict), "verdict"))
                return false;
            print_verdict(&verdict);
            return apply();
        case DATASET_PAIR:
            break;
        }
        /* A refused match is not a failure, and a refused pair is not one either. */
        selfcal_outcome_t outcome = {0};
        selfcal_error_t error = selfcal_take_pair(&cal, matches, count, &outcome);
        accepted += print_pair(error, &outcome, pairs, count);
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
                "the verdict. The result of each pair goes to the standard error.\n",
                argv[0]);
        return argc == 2 ? 0 : 2;
    }
    return calibrate(argv[1]) ? 0 : 1;
}
