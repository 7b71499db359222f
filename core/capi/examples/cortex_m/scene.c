#include "scene.h"

#include <math.h>
#include <stdbool.h>

#define WIDTH 1280
#define HEIGHT 800
#define FOCAL 900.0f
#define NOISE_PX 0.3f

#define CAMERA                                       \
    {                                                \
        .focal_px = {FOCAL, FOCAL},                  \
        .principal_px = {WIDTH / 2, HEIGHT / 2},     \
        .size_px = {WIDTH, HEIGHT},                  \
        .lens = SELFCAL_LENS_PINHOLE,                \
    }

const selfcal_factory_t scene_factory = {.left = CAMERA, .right = CAMERA};

void scene_rig(selfcal_extrinsics_t *rig)
{
    /* Roll of 0.02 rad, then pitch of -0.015 rad. */
    const float c = cosf(0.02f), s = sinf(0.02f), p = cosf(-0.015f), q = sinf(-0.015f);
    *rig = (selfcal_extrinsics_t){
        .rotation = {c, -s, 0, p * s, p * c, -q, q * s, q * c, p},
        .translation = {-0.9996f, 0.02f, -0.02f},
    };
}

/* Uniform from 0 to 1: the upper bits of a linear congruential generator. */
static float uniform(void)
{
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / 16777216.0f;
}

static float noise(void)
{
    /* The sum of three uniform numbers: close to Gaussian, standard deviation 1/2. */
    return 2 * NOISE_PX * (uniform() + uniform() + uniform() - 1.5f);
}

static bool in_image(const float px[2])
{
    return px[0] >= 0 && px[0] < WIDTH && px[1] >= 0 && px[1] < HEIGHT;
}

static bool see(const selfcal_extrinsics_t *rig, selfcal_correspondence_t *match)
{
    /* 3 to 60 baselines away, uniform in inverse depth. */
    const float depth = 1 / (1 / 60.0f + uniform() * (1 / 3.0f - 1 / 60.0f));
    const float u = uniform() * WIDTH, v = uniform() * HEIGHT;
    const float p[3] = {(u - WIDTH / 2) / FOCAL * depth, (v - HEIGHT / 2) / FOCAL * depth, depth};
    float r[3];
    for (int i = 0; i < 3; i++) {
        const float *row = rig->rotation + 3 * i;
        r[i] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + rig->translation[i];
    }
    *match = (selfcal_correspondence_t){
        .left_px = {u + noise(), v + noise()},
        .right_px = {FOCAL * r[0] / r[2] + WIDTH / 2 + noise(),
                     FOCAL * r[1] / r[2] + HEIGHT / 2 + noise()},
        .score = 1,
    };
    return in_image(match->left_px) && in_image(match->right_px);
}

void scene_matches(const selfcal_extrinsics_t *rig, selfcal_correspondence_t *matches, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        while (!see(rig, &matches[i])) {
        }
        if (i % 5 == 0) {
            matches[i].right_px[0] = uniform() * (WIDTH - 1);
            matches[i].right_px[1] = uniform() * (HEIGHT - 1);
        }
    }
}
