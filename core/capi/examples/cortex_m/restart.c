#include "restart.h"

#include <math.h>

#include "check.h"
#include "matcher.h"
#include "scene.h"
#include "stack.h"

#define MATCHES 200
/* Bytes of one transfer of a driver. */
#define PIECE 100

static selfcal_link_t wire;

/* Stands for flash. */
static uint8_t factory[SELFCAL_FACTORY_BYTES], snapshot[SELFCAL_SNAPSHOT_BYTES];

static void check_power_loss(selfcal_t *cal)
{
    selfcal_calibration_t before;
    selfcal_calibration_t after;
    selfcal_factory_t made;
    selfcal_state_t state;

    CHECK(selfcal_apply(cal, &before) == SELFCAL_OK);
    CHECK(selfcal_factory_to_record(&scene_factory, factory) == SELFCAL_OK);
    stack_paint();
    CHECK(selfcal_snapshot(cal, snapshot) == SELFCAL_OK);
    const unsigned snapshot_stack = stack_used();

    CHECK(selfcal_factory_from_record(&made, factory, sizeof factory - 1) == SELFCAL_ERROR_RECORD_DAMAGED);
    CHECK(selfcal_factory_from_record(&made, factory, sizeof factory) == SELFCAL_OK);
    CHECK(selfcal_init(cal, sizeof *cal, SELFCAL_HEADER, NULL, &made) == SELFCAL_OK);
    CHECK(selfcal_restore(cal, snapshot, sizeof snapshot - 1) == SELFCAL_ERROR_RECORD_DAMAGED);
    stack_paint();
    CHECK(selfcal_restore(cal, snapshot, sizeof snapshot) == SELFCAL_OK);
    printf("records: factory %u bytes, snapshot %u; stack, bytes: snapshot %u, restore %u\n",
           (unsigned)sizeof factory, (unsigned)sizeof snapshot, snapshot_stack, (unsigned)stack_used());

    CHECK(selfcal_in_use(cal, &after) == SELFCAL_OK);
    for (int i = 0; i < 3; i++) /* `t` is the same to rounding */
        CHECK(fabsf(after.extrinsics.translation[i] - before.extrinsics.translation[i]) < 1e-6f);
    CHECK(selfcal_state(cal, &state) == SELFCAL_OK && state == SELFCAL_STATE_SUSPECT);
}

/* Feeds a frame in pieces; returns whether it was whole. */
static bool receive(selfcal_t *cal, const uint8_t *bytes, size_t length, uint32_t *stack)
{
    bool whole = false;
    while (length > 0) {
        size_t used;
        selfcal_frame_t frame;
        stack_paint();
        CHECK(selfcal_link_feed(&wire, cal, bytes, length < PIECE ? length : PIECE, &used,
                                &frame) == SELFCAL_OK);
        if (stack_used() > *stack)
            *stack = stack_used();
        whole = whole || (frame.whole && frame.taken == MATCHES);
        bytes += used;
        length -= used;
    }
    return whole;
}

static void check_link(selfcal_t *cal, const selfcal_extrinsics_t *rig)
{
    static selfcal_correspondence_t matches[MATCHES];
    static uint8_t frame[MATCHER_FRAME_BYTES(MATCHES)];
    selfcal_link_counters_t counters;
    selfcal_proposal_t proposal;
    uint32_t stack = 0;

    CHECK(selfcal_link_note_overrun(&wire) == SELFCAL_ERROR_NOT_INITIALISED);
    CHECK(selfcal_link_init(&wire, sizeof wire) == SELFCAL_OK);
    scene_matches(rig, matches, MATCHES);
    CHECK(matcher_frame(frame, 0, scene_factory.left.size_px, matches, MATCHES) == sizeof frame);
    frame[500] ^= 1;
    CHECK(!receive(cal, frame, sizeof frame, &stack));
    frame[500] ^= 1;
    CHECK(receive(cal, frame, sizeof frame, &stack));
    CHECK(selfcal_solve_pair(cal, NULL) == SELFCAL_OK);
    CHECK(selfcal_proposal(cal, &proposal) == SELFCAL_OK);
    CHECK(selfcal_link_counters(&wire, &counters) == SELFCAL_OK);
    CHECK(counters.good == 1 && counters.bad_crc == 1);
    CHECK(proposal.state == SELFCAL_STATE_LOCKED);
    printf("link: %u bytes, stack of feed %u; %s after one frame, %u pairs fused\n",
           (unsigned)sizeof wire, (unsigned)stack, selfcal_string(proposal.state),
           (unsigned)proposal.pairs);
}

void check_restart(selfcal_t *cal, const selfcal_extrinsics_t *rig)
{
    check_power_loss(cal);
    check_link(cal, rig);
}
