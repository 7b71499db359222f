#include "task.h"

/* Size of the queue, a power of two. Only the interrupt writes to the queue, and only the task reads from it. */
#define QUEUE_BYTES 4096u

static volatile uint8_t queue[QUEUE_BYTES];
static volatile uint32_t queued, taken;

/* Static, so that neither is on the stack. */
static selfcal_t cal;
static selfcal_link_t wire;

size_t task_room(void)
{
    return QUEUE_BYTES - (queued - taken);
}

void task_queue(uint8_t byte)
{
    if (task_room() == 0)
        return;
    queue[queued % QUEUE_BYTES] = byte;
    queued++; /* after the byte is written: the task reads up to here */
}

/* Waits for bytes, and takes at most `room` of them. With FreeRTOS use xStreamBufferReceive. */
static size_t take(uint8_t *to, size_t room)
{
    size_t count = 0;

    /* An interrupt between the test and `wfi` does not wake the task, but the next interrupt does. */
    while (queued == taken)
        __asm volatile("wfi");
    while (count < room && queued != taken) {
        to[count++] = queue[taken % QUEUE_BYTES];
        taken++;
    }
    return count;
}

static void take_pair(task_result_t *result)
{
    selfcal_error_t error = SELFCAL_OK;
    bool ended = false;

    result->frames++;
    /* Pass by pass: tasks of this priority may run in between. */
    while (!ended && error == SELFCAL_OK)
        error = selfcal_advance_pair(&cal, &ended, NULL);
    if (error == SELFCAL_OK) /* a pair that is not fused is normal */
        result->fused++;
    if (selfcal_apply(&cal, &result->in_use) == SELFCAL_OK) /* refused until the estimate is locked */
        result->applied++;
}

static selfcal_error_t start(const selfcal_factory_t *factory, selfcal_calibration_t *in_use)
{
    selfcal_error_t error = selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, factory);

    if (error == SELFCAL_OK)
        error = selfcal_link_init(&wire, sizeof wire);
    if (error == SELFCAL_OK)
        error = selfcal_in_use(&cal, in_use); /* for the rectifier, from the first image on */
    return error;
}

void task_run(const selfcal_factory_t *factory, uint32_t frames, task_result_t *result)
{
    uint8_t bytes[64];

    *result = (task_result_t){0};
    result->error = start(factory, &result->in_use);
    while (result->error == SELFCAL_OK && result->frames < frames) {
        const uint8_t *at = bytes;
        size_t left = take(bytes, sizeof bytes);
        while (left > 0 && result->error == SELFCAL_OK) {
            selfcal_frame_t frame;
            size_t used;
            result->error = selfcal_link_feed(&wire, &cal, at, left, &used, &frame);
            at += used;
            left -= used;
            if (frame.whole)
                take_pair(result);
        }
    }
}
