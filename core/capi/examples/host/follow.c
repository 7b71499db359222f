/* Calibrates from the bytes of a matcher, as a firmware does: restores the snapshot of the last run,
 * and writes a new one at the end.
 *
 *     follow host-tests/data/opencv_chess_sift stream.scmf memory
 */
#include <stdio.h>
#include <string.h>

#include "dataset.h"
#include "steps.h"
#include "stereo_selfcal.h"

/* Bytes of one interrupt of a driver. */
#define PIECE 200

static selfcal_t cal;
static selfcal_link_t wire;

/* The record that was read, or is to be written. A file stands for flash. A flash driver would keep the previous record
 * until the new one is written; this example overwrites it. */
static uint8_t record[SELFCAL_SNAPSHOT_BYTES];

static size_t read_memory(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL)
        return 0;
    size_t length = fread(record, 1, sizeof record, file);
    fclose(file);
    return length;
}

static bool write_memory(const char *path)
{
    FILE *file = fopen(path, "wb");
    bool written = file != NULL && fwrite(record, 1, sizeof record, file) == sizeof record;
    if (file != NULL && fclose(file) != 0)
        written = false;
    if (!written)
        fprintf(stderr, "error: cannot write %s\n", path);
    return written;
}

static bool start(const char *set, const char *memory, struct rig *reference)
{
    selfcal_factory_t factory;
    if (!dataset_read_meta(set, &factory, reference) ||
        !done(selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &factory), "start") ||
        !done(selfcal_link_init(&wire, sizeof wire), "link"))
        return false;
    size_t length = read_memory(memory);
    if (length > 0) {
        /* A refused record is not a failure: the calibrator starts from the factory extrinsics. */
        selfcal_error_t error = selfcal_restore(&cal, record, length);
        fprintf(stderr, "memory: %s\n", error ? selfcal_string(error) : "restored");
    }
    return true;
}

/* Feeds one piece; returns the number of pairs fused. */
static unsigned feed(const uint8_t *bytes, size_t length)
{
    unsigned accepted = 0;
    size_t used;
    do {
        selfcal_frame_t frame;
        selfcal_error_t error = selfcal_link_feed(&wire, &cal, bytes, length, &used, &frame);
        bytes += used;
        length -= used;
        if (error != SELFCAL_OK)
            fprintf(stderr, "link: %s\n", selfcal_string(error));
        if (frame.whole) {
            selfcal_outcome_t outcome = {0};
            error = selfcal_solve_pair(&cal, &outcome);
            accepted += print_pair(error, &outcome, (unsigned)frame.sequence, frame.taken);
        }
    } while (used > 0 && length > 0);
    return accepted;
}

static bool follow(const char *set, const char *stream, const char *memory)
{
    struct rig reference;
    if (!start(set, memory, &reference))
        return false;
    FILE *driver = fopen(stream, "rb");
    if (driver == NULL) {
        fprintf(stderr, "error: cannot read %s\n", stream);
        return false;
    }
    uint8_t piece[PIECE];
    unsigned accepted = 0;
    for (size_t length; (length = fread(piece, 1, sizeof piece, driver)) > 0;)
        accepted += feed(piece, length);
    fclose(driver);

    selfcal_link_counters_t counters;
    if (!done(selfcal_link_counters(&wire, &counters), "counters") ||
        !print_estimate(&cal, counters.good, accepted, &reference) ||
        !done(selfcal_snapshot(&cal, record), "snapshot"))
        return false;
    printf("missing %u\n", (unsigned)counters.gaps);
    printf("record_bytes %zu\n", sizeof record);
    return write_memory(memory);
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        bool asked = argc == 2 && strcmp(argv[1], "--help") == 0;
        fprintf(asked ? stdout : stderr,
                "usage: %s SET STREAM MEMORY\n\n"
                "Calibrates a stereo rig from the bytes of a matcher. SET is a folder with the\n"
                "meta.json of the rig, STREAM a file of frames (cargo selfcal record), MEMORY a\n"
                "file that stands for flash: the snapshot is restored from it, if it exists,\n"
                "and written to it.\n",
                argv[0]);
        return asked ? 0 : 2;
    }
    return follow(argv[1], argv[2], argv[3]) ? 0 : 1;
}
