/* Depth of the stack, measured by painting. */
#ifndef STACK_H
#define STACK_H

#include <stdint.h>

/* Paints 32 KiB of unused stack below the caller. */
void stack_paint(void);

/* Returns the number of bytes of stack below the caller used since stack_paint, at most about 32 KiB. */
uint32_t stack_used(void);

#endif
