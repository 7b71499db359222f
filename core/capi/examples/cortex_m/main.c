/* Firmware of a Cortex-M4F that calibrates a generated rig, and checks that the library refuses misuse.
 * Returns 1 if a check fails. */
#include <math.h>
#include <stdio.h>

#include "check.h"
#include "restart.h"
#include "scene.h"
#include "stack.h"
#include "stereo_selfcal.h"

#define PAIRS 8
#define MATCHES 200

static selfcal_t cal;
int failures;

static void check_refused_start(void)
{
    selfcal_factory_t blind = scene_factory;
    selfcal_config_t config = {.max_passes = 1};
    selfcal_calibration_t in_use;

    CHECK(selfcal_in_use(&cal, &in_use) == SELFCAL_ERROR_NOT_INITIALISED);
    CHECK(selfcal_init(NULL, sizeof cal, SELFCAL_HEADER, NULL, &scene_factory) == SELFCAL_ERROR_NULL);
    CHECK(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, NULL) == SELFCAL_ERROR_NULL);
    CHECK(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER + 1, NULL, &scene_factory) == SELFCAL_ERROR_HEADER);
    CHECK(selfcal_init(&cal, 1000, SELFCAL_HEADER, NULL, &scene_factory) == SELFCAL_ERROR_STORAGE_SIZE);
    CHECK(selfcal_init((selfcal_t *)((char *)&cal + 1), sizeof cal, SELFCAL_HEADER, NULL, &scene_factory) ==
          SELFCAL_ERROR_ALIGNMENT);
    CHECK(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, &config, &scene_factory) == SELFCAL_ERROR_CONFIG);
    printf("refused: %s\n", selfcal_argument_string(&config, NULL));
    blind.right.focal_px[1] = NAN;
    CHECK(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &blind) == SELFCAL_ERROR_FACTORY);
    printf("refused: %s\n", selfcal_argument_string(NULL, &blind));

    stack_paint();
    CHECK(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &scene_factory) == SELFCAL_OK);
    printf("stack of selfcal_init: %u bytes\n", (unsigned)stack_used());
    CHECK(selfcal_in_use(&cal, &in_use) == SELFCAL_OK && in_use.generation == 0);
}

static void check_misuse(void)
{
    selfcal_correspondence_t match = {.left_px = {NAN, 0}, .score = 1};
    selfcal_batch_t batch;

    CHECK(selfcal_push(&cal, &match, NULL) == SELFCAL_ERROR_NOT_FINITE);
    CHECK(selfcal_apply(&cal, NULL) == SELFCAL_ERROR_NO_ESTIMATE);
    CHECK(selfcal_solve_pair(&cal, NULL) == SELFCAL_ERROR_TOO_FEW);
    CHECK(selfcal_batch(&cal, &batch) == SELFCAL_OK);
    CHECK(batch.held == 0 && batch.refused == 1);
}

/* Largest stack of each call of a pair, bytes. */
static struct {
    uint32_t push, solve, details;
} stack;

static void note_stack(uint32_t *most)
{
    const uint32_t used = stack_used();
    if (used > *most)
        *most = used;
}

/* Solves and fuses one pair pass by pass, as a loop with a deadline does. */
static void take_pair(const selfcal_extrinsics_t *rig, selfcal_details_t *details)
{
    static selfcal_correspondence_t matches[MATCHES];
    selfcal_pushed_counts_t counts;
    selfcal_outcome_t outcome = {0};
    bool ended = false;

    scene_matches(rig, matches, MATCHES);
    stack_paint();
    CHECK(selfcal_push_array(&cal, matches, MATCHES, &counts) == SELFCAL_OK);
    note_stack(&stack.push);
    CHECK(counts.kept == MATCHES && counts.refused == 0);
    stack_paint();
    while (!ended && selfcal_advance_pair(&cal, &ended, &outcome) == SELFCAL_OK) {
    }
    note_stack(&stack.solve);
    CHECK(ended && outcome.fused == SELFCAL_FUSED_ADDED && outcome.has_pair);
    stack_paint();
    CHECK(selfcal_details(&cal, details) == SELFCAL_OK);
    note_stack(&stack.details);
}

static float largest_difference(const float *a, const float *b, int count)
{
    float largest = 0;
    for (int i = 0; i < count; i++)
        largest = fmaxf(largest, fabsf(a[i] - b[i]));
    return largest;
}

static void check_estimate(const selfcal_extrinsics_t *rig)
{
    selfcal_proposal_t proposal;
    selfcal_calibration_t applied, in_use;
    selfcal_rectified_camera_t camera;
    selfcal_homographies_t homographies;

    CHECK(selfcal_proposal(&cal, &proposal) == SELFCAL_OK);
    CHECK(proposal.state == SELFCAL_STATE_LOCKED);
    const float e_r = largest_difference(proposal.extrinsics.rotation, rig->rotation, 9);
    const float e_t = largest_difference(proposal.extrinsics.translation, rig->translation, 3);
    printf("%s after %u pairs, error %.5f in R, %.5f in t; reported sd %.5f, %.5f rad\n",
           selfcal_string(proposal.state), (unsigned)proposal.pairs, e_r, e_t,
           proposal.sd.rotation_rad, proposal.sd.translation_rad);
    CHECK(e_r < 4 * proposal.sd.rotation_rad && e_r < 0.002f);
    CHECK(e_t < 4 * proposal.sd.translation_rad && e_t < 0.003f);

    CHECK(selfcal_apply(&cal, &applied) == SELFCAL_OK);
    CHECK(selfcal_in_use(&cal, &in_use) == SELFCAL_OK);
    CHECK(largest_difference(applied.extrinsics.rotation, in_use.extrinsics.rotation, 9) == 0);
    CHECK(largest_difference(in_use.right.focal_px, scene_factory.right.focal_px, 2) == 0);
    CHECK(in_use.generation == 1);
    CHECK(selfcal_choose_camera(&cal, SELFCAL_SOURCE_IN_USE, 0, &camera) == SELFCAL_OK);
    CHECK(selfcal_homographies(&cal, SELFCAL_SOURCE_IN_USE, &camera, &homographies) == SELFCAL_OK);
    CHECK(selfcal_undo(&cal, NULL) == SELFCAL_OK);
    CHECK(selfcal_undo(&cal, NULL) == SELFCAL_ERROR_NOTHING_TO_UNDO);
}

int main(void)
{
    selfcal_requirements_t needs;
    selfcal_extrinsics_t rig;
    selfcal_details_t details = {0};
    selfcal_verdict_t verdict = {0};

    CHECK(selfcal_requirements(&needs) == SELFCAL_OK);
    CHECK(needs.capacity == SELFCAL_CAPACITY && needs.size <= sizeof cal);
    printf("storage for %u matches: %u bytes, of which %u are used\n", (unsigned)needs.capacity,
           (unsigned)sizeof cal, (unsigned)needs.size);
    check_refused_start();
    check_misuse();

    scene_rig(&rig);
    for (int i = 0; i < PAIRS; i++)
        take_pair(&rig, &details);
    printf("stack, bytes: push %u, solve %u, details %u\n", (unsigned)stack.push,
           (unsigned)stack.solve, (unsigned)stack.details);
    CHECK(selfcal_verdict(&cal, &verdict) == SELFCAL_OK);
    printf("rows %.3f px, depth %.3f px, coverage %.2f; may arm: %s\n", verdict.rows_px,
           verdict.depth_px, verdict.coverage, verdict.may_arm ? "yes" : "no");
    CHECK(verdict.should_apply && verdict.rows_px > 1 && details.proposed_px < 0.6f);
    CHECK(!verdict.may_arm && (verdict.reasons & SELFCAL_REASON_ROWS) != 0);
    check_estimate(&rig);
    check_restart(&cal, &rig);

    printf(failures == 0 ? "all checks passed\n" : "%d failed checks\n", failures);
    return failures != 0;
}
