/* How deep the stack gets: painted, and looked at later. */
#ifndef STACK_H
#define STACK_H

#include <stdint.h>

/* Paints the unused stack. */
void stack_paint(void);

/* Bytes of stack that has been used below the caller since, 32 KiB at most. */
uint32_t stack_used(void);

#endif
