/* Runs the task of task.c on a stack of its own, as an RTOS does: the task uses the process stack, interrupts use the
 * main stack. Prints the number of bytes used of the stack of the task. Returns 1 if a check fails. */
#include <stdint.h>
#include <stdio.h>

#include "check.h"
#include "matcher.h"
#include "scene.h"
#include "task.h"

#define PAIRS 8
#define MATCHES 200
#define PAINT 0xA5A5A5A5A5A5A5A5u
#define BYTES_PER_INTERRUPT 16

/* The core's timer, at 25 MHz. */
#define SYST_CSR (*(volatile uint32_t *)0xE000E010)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018)
#define TICKS_PER_INTERRUPT 500

int failures;

static uint64_t task_stack[TASK_STACK_BYTES / 8];
static task_result_t result;

/* Frames of the matcher, sent by the interrupt. */
static uint8_t frames[PAIRS][MATCHER_FRAME_BYTES(MATCHES)];
static volatile uint32_t sent;

/* Stands for a UART with a FIFO: each interrupt queues up to 16 bytes, or none unless the queue has room for 16. */
void systick(void)
{
    if (task_room() < BYTES_PER_INTERRUPT)
        return;
    for (int i = 0; i < BYTES_PER_INTERRUPT && sent < sizeof frames; i++) {
        task_queue(frames[sent / sizeof frames[0]][sent % sizeof frames[0]]);
        sent++;
    }
}

static void task(void)
{
    task_run(&scene_factory, PAIRS, &result);
}

/* Calls a function on the process stack. */
__attribute__((naked)) static void run_on(uint64_t *top, void (*function)(void))
{
    (void)top, (void)function;
    __asm volatile("push {r4, lr}\n"
                   "msr psp, r0\n"
                   "mrs r3, control\n orr r3, r3, #2\n msr control, r3\n isb\n"
                   "blx r1\n"
                   "mrs r3, control\n bic r3, r3, #2\n msr control, r3\n isb\n"
                   "pop {r4, pc}\n");
}

static uint32_t stack_used(void)
{
    size_t untouched = 0;
    while (untouched < TASK_STACK_BYTES / 8 && task_stack[untouched] == PAINT)
        untouched++;
    return (uint32_t)(TASK_STACK_BYTES - 8 * untouched);
}

int main(void)
{
    static selfcal_correspondence_t matches[MATCHES];
    selfcal_extrinsics_t rig;

    scene_rig(&rig);
    for (uint32_t i = 0; i < PAIRS; i++) {
        scene_matches(&rig, matches, MATCHES);
        CHECK(matcher_frame(frames[i], i, scene_factory.left.size_px, matches, MATCHES) == sizeof frames[i]);
    }
    for (size_t i = 0; i < TASK_STACK_BYTES / 8; i++)
        task_stack[i] = PAINT;
    SYST_RVR = TICKS_PER_INTERRUPT - 1;
    SYST_CVR = 0;
    SYST_CSR = 7; /* on, with its interrupt, from the core's clock */
    run_on(task_stack + TASK_STACK_BYTES / 8, task);
    SYST_CSR = 0;

    const uint32_t used = stack_used();
    printf("task: %u frames, %u fused, %u applied\n", (unsigned)result.frames, (unsigned)result.fused,
           (unsigned)result.applied);
    printf("stack of the task: %u of %u bytes used\n", (unsigned)used, (unsigned)TASK_STACK_BYTES);
    CHECK(result.error == SELFCAL_OK && result.frames == PAIRS && result.fused == PAIRS);
    CHECK(result.applied > 0);
    CHECK(sent == sizeof frames);
    CHECK(used > 0 && used <= TASK_STACK_BYTES / 4 * 3);
    for (int i = 0; i < 9; i++) {
        const float off = result.in_use.extrinsics.rotation[i] - rig.rotation[i];
        CHECK(off < 0.002f && -off < 0.002f);
    }
    printf(failures == 0 ? "all checks passed\n" : "%d failed checks\n", failures);
    return failures != 0;
}
