#include "reference.h"

#include <math.h>

static double norm(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double baseline_error(const selfcal_extrinsics_t *estimate, const struct rig *reference)
{
    const float *a = estimate->translation;
    const double *b = reference->translation;
    const double cross[3] = {
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    };
    return atan2(norm(cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

/* Returns axis times angle. Uses atan2, because an arc cosine would lose small angles. */
static void rotation_vector(const double r[9], double w[3])
{
    const double axis[3] = {r[7] - r[5], r[2] - r[6], r[3] - r[1]};
    const double twice_sine = norm(axis);
    const double angle = atan2(twice_sine, r[0] + r[4] + r[8] - 1);
    for (int i = 0; i < 3; i++)
        w[i] = twice_sine > 0 ? axis[i] * (angle / twice_sine) : 0;
}

double rotation_error(const selfcal_extrinsics_t *estimate, const struct rig *reference)
{
    double r[9], a[3], b[3];
    for (int i = 0; i < 9; i++)
        r[i] = estimate->rotation[i];
    rotation_vector(r, a);
    rotation_vector(reference->rotation, b);
    const double apart[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return norm(apart);
}
