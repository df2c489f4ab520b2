/* What the board alone takes. */
#include "board.h"

int program(void)
{
    ticks_begin();
    say(ticks() ? "" : "\n");
    return 0;
}
