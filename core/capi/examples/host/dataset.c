#include "dataset.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_ROOM 16384
#define PATH_ROOM 4096

/* Reads the `count` numbers after a key; skips brackets and commas. */
static bool numbers(const char *text, const char *key, double *to, size_t count)
{
    const char *at = strstr(text, key);
    if (at == NULL)
        return false;
    at += strlen(key);
    for (size_t i = 0; i < count; i++) {
        at += strspn(at, " \t\r\n:[],");
        char *end;
        to[i] = strtod(at, &end);
        if (end == at)
            return false;
        at = end;
    }
    return true;
}

static bool camera(const char *text, const char *k_key, const char *dist_key, selfcal_camera_t *to)
{
    double k[9], dist[5], width, height;
    if (!numbers(text, k_key, k, 9) || !numbers(text, dist_key, dist, 5) ||
        !numbers(text, "\"width\"", &width, 1) || !numbers(text, "\"height\"", &height, 1))
        return false;
    if (!(width >= 1 && width <= 65535 && height >= 1 && height <= 65535))
        return false;
    *to = (selfcal_camera_t){
        .focal_px = {(float)k[0], (float)k[4]},
        .principal_px = {(float)k[2], (float)k[5]},
        .size_px = {(uint16_t)width, (uint16_t)height},
        .lens = SELFCAL_LENS_RADIAL_TANGENTIAL,
    };
    for (size_t i = 0; i < 5; i++)
        to->distortion[i] = (float)dist[i];
    return true;
}

bool dataset_read_meta(const char *set, selfcal_factory_t *factory, struct rig *reference)
{
    char path[PATH_ROOM], text[TEXT_ROOM];
    snprintf(path, sizeof path, "%s/meta.json", set);
    FILE *file = fopen(path, "r");
    if (file == NULL) {
        fprintf(stderr, "error: %s is not a data set: cannot read %s: %s\n", set, path,
                strerror(errno));
        return false;
    }
    size_t length = fread(text, 1, sizeof text - 1, file);
    text[length] = '\0';
    fclose(file);
    if (strstr(text, "\"lens\"") != NULL) {
        fprintf(stderr, "error: %s: this example reads sets without \"lens\" only\n", path);
        return false;
    }
    *factory = (selfcal_factory_t){0}; /* cameras side by side, a guess */
    if (!camera(text, "\"K_l\"", "\"dist_l\"", &factory->left) ||
        !camera(text, "\"K_r\"", "\"dist_r\"", &factory->right) ||
        !numbers(text, "\"R\"", reference->rotation, 9) ||
        !numbers(text, "\"t\"", reference->translation, 3)) {
        fprintf(stderr, "error: %s lacks cameras or reference\n", path);
        return false;
    }
    return true;
}

enum dataset_pair dataset_read_pair(const char *set, int index, selfcal_correspondence_t *matches,
                                    size_t room, size_t *count)
{
    char path[PATH_ROOM], line[256];
    snprintf(path, sizeof path, "%s/pairs/%04d.csv", set, index);
    FILE *file = fopen(path, "r");
    if (file == NULL)
        return DATASET_END;
    enum dataset_pair read = DATASET_PAIR;
    int number = 1;
    if (fgets(line, sizeof line, file) == NULL || strncmp(line, "ul,vl,ur,vr,score", 17) != 0) {
        fprintf(stderr, "error: %s does not begin with ul,vl,ur,vr,score\n", path);
        read = DATASET_ERROR;
    }
    for (*count = 0; read == DATASET_PAIR && fgets(line, sizeof line, file) != NULL; ++*count) {
        double ul, vl, ur, vr, score;
        number++;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf", &ul, &vl, &ur, &vr, &score) != 5) {
            fprintf(stderr, "error: %s, line %d: not five numbers\n", path, number);
            read = DATASET_ERROR;
        } else if (*count == room) {
            fprintf(stderr, "error: %s: more than %zu matches\n", path, room);
            read = DATASET_ERROR;
        } else {
            matches[*count] = (selfcal_correspondence_t){
                .left_px = {(float)ul, (float)vl},
                .right_px = {(float)ur, (float)vr},
                .score = (float)score,
            };
        }
    }
    fclose(file);
    return read;
}
