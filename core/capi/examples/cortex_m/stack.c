#include "stack.h"

#define PAINT 0xA5C3F00Du
/* Words painted below the stack of these functions. */
#define PAINTED_WORDS 8192
/* Stack that stack_paint and stack_used themselves may use, words. */
#define OWN_WORDS 16

static volatile uint32_t *painted_to;

__attribute__((noinline)) void stack_paint(void)
{
    painted_to = (uint32_t *)__builtin_frame_address(0) - OWN_WORDS;
    for (int i = 1; i <= PAINTED_WORDS; i++)
        painted_to[-i] = PAINT;
}

__attribute__((noinline)) uint32_t stack_used(void)
{
    int untouched = PAINTED_WORDS;
    while (untouched > 0 && painted_to[-untouched] == PAINT)
        untouched--;
    return (uint32_t)sizeof(uint32_t) * (OWN_WORDS + (uint32_t)untouched);
}
