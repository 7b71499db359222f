/* Depth of the stack, measured by painting. */
#ifndef STACK_H
#define STACK_H

#include <stdint.h>

/* Paints the unused stack. */
void stack_paint(void);

/* Bytes of stack below the caller used since stack_paint, at most 32 KiB. */
uint32_t stack_used(void);

#endif
