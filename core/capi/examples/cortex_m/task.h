/* The calibrator as a task of an RTOS such as FreeRTOS: an interrupt queues bytes, the task waits for them. */
#ifndef TASK_H
#define TASK_H

#include <stdbool.h>
#include <stddef.h>

#include "stereo_selfcal.h"

/* Stack of the task, bytes. task_main.c measures the used part, and fails above three quarters. The rest is for the
 * context that an RTOS saves (204 bytes with the floating point unit) and for the functions of the board. */
#define TASK_STACK_BYTES 12288

/* State of the task. Only the task writes it. */
typedef struct {
    uint32_t frames, fused, applied;
    selfcal_error_t error;        /* error that ended the task */
    selfcal_calibration_t in_use; /* for the rectifier: at first the factory calibration */
} task_result_t;

/* Returns the room in the queue, bytes. For the interrupt. */
size_t task_room(void);

/* Queues a byte if there is room. For the interrupt. With FreeRTOS use xStreamBufferSendFromISR. */
void task_queue(uint8_t byte);

/* The task: receives frames, solves pass by pass, fuses and applies. Ends after `frames` frames, or with an error. */
void task_run(const selfcal_factory_t *factory, uint32_t frames, task_result_t *result);

#endif
