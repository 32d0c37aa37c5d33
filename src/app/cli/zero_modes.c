/* Comments on zero modes, the same in all tables. */
#include "cli/modes.h"

void cli_zero_modes(cli_writer *w, const sp_zero_modes *z) {
    if (z->total >= 0)
        cli_comment(w, "zero_modes = %lld", (long long)z->total);
    cli_comment(w, "rattler_modes = %lld", (long long)z->rattlers);
    cli_comment(w, "free_spins = %lld", (long long)z->spins);
    cli_comment(w, "rigid_motions = %lld", (long long)z->rigid);
    if (z->total >= 0) {
        cli_comment(w, "mechanisms = %lld", (long long)z->mechanisms);
        cli_value(w, "zero_below", z->below);
    } else
        cli_comment(w, "mechanisms are not told apart from soft modes");
}
