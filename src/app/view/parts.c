/* Says in the page why a part of it is missing. */
#include "view/parts.h"

#include "base/base.h"

sp_status view_leave_out(view_json *j, const char *key, const view_part *part, bool needed, const sp_error *reason,
                         sp_error *err) {
    if (needed || reason->status == SP_ENOMEM)
        return sp_fail(err, reason->status, "%s", reason->text);
    if (part->report && part->report->missing)
        part->report->missing(part->report->user, reason->text);
    view_open(j, key, '{');
    view_text(j, "reason", reason->text);
    view_close(j, '}');
    return SP_OK;
}
