/* The option --damping: reads the law of the dashpots, and names it in a table. */
#include "cli/dashpots.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

sp_status cli_damping_read(const char *text, double low, double high, sp_damping *out, sp_error *err) {
    sp_damping law = {.ratio = 1};
    sp_status status;
    if (!strchr(text, ':'))
        status = cli_number("--damping", text, low, high, &law.value, err);
    else
        status =
            sp_damping_read(text, &law, err) == SP_OK
                ? SP_OK
                : sp_fail(err, SP_EINVAL, "--damping %.60s: must be " CLI_DAMPING ", with numbers of 0 or more", text);
    if (status == SP_OK && law.value < low)
        status = sp_fail(err, SP_EINVAL, "--damping %.60s: the coefficient must be above 0", text);
    if (status == SP_OK)
        *out = law;
    return status;
}

void cli_damping_comment(cli_writer *w, const sp_damping *law) {
    char normal[SP_NUMBER_TEXT], tangential[SP_NUMBER_TEXT];
    if (law->kind == SP_DAMPING_ZETA) {
        cli_value(w, "damping", law->value);
        return;
    }
    cli_comment(w, "damping = %s:%s:%s", law->kind == SP_DAMPING_MASS ? "mass" : "gamma",
                sp_number_text(law->value, normal), sp_number_text(law->ratio * law->value, tangential));
}
