/* Input: "u_left v_left u_right v_right" a line, px; any other line ends a stereo pair. */
#include <stdio.h>
#include "stereo_selfcal.h"
static selfcal_t cal; /* 256 matches a pair: 11,040 bytes */
static bool ok(selfcal_error_t error)
{
    if (error != SELFCAL_OK) fprintf(stderr, "%s\n", selfcal_string(error));
    return error == SELFCAL_OK;
}
static void take_pair(void) /* a pair that is not fused is normal: continue with the next one */
{
    selfcal_verdict_t verdict;
    ok(selfcal_solve_pair(&cal, NULL));
    if (ok(selfcal_verdict(&cal, &verdict)))
        printf("%s, rows %.1f px, depth %.1f px: %s\n", selfcal_string(verdict.state),
               verdict.rows_px, verdict.depth_px, verdict.may_arm ? "may arm" : "must not arm");
}
int main(void)
{
    selfcal_camera_t camera = {{1400, 1400}, {959.5f, 599.5f}, {1920, 1200}, SELFCAL_LENS_PINHOLE, {0}};
    /* A guess, side by side. With .extrinsics, of a calibration, the estimate keeps their yaw. */
    selfcal_factory_t factory = {.left = camera, .right = camera};
    selfcal_correspondence_t m = {.score = 1};
    selfcal_calibration_t found; /* extrinsics and their cameras */
    if (!ok(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &factory))) return 1;
    for (char s[128]; fgets(s, sizeof s, stdin) != NULL;)
        if (sscanf(s, "%f%f%f%f", &m.left_px[0], &m.left_px[1], &m.right_px[0], &m.right_px[1]) < 4)
            take_pair();
        else ok(selfcal_push(&cal, &m, NULL)); /* a refused match is normal too */
    take_pair(); /* the last one, if no line ended it */
    if (!ok(selfcal_apply(&cal, &found))) return 1;
    for (int i = 0; i < 3; i++) printf("%s%.4f", i ? " " : "t = ", found.extrinsics.translation[i]);
    puts("");
}
