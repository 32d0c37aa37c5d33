/* Names the frames of a movie. */
#include "cli/plot_frames.h"

#include "base/base.h"
#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 4, DIGITS_MOST = 9 };

/* Finds where the number goes and how many digits it has: at the only %d or %04d, else before the ending, after a dash.
 * rest: what follows the number. */
static sp_status find_place(const char *output, size_t *head, const char **rest, int *digits, sp_error *err) {
    const char *percent = strchr(output, '%'), *dot = strrchr(output, '.');
    char *end;
    *digits = DIGITS;
    if (!percent) {
        *head = dot ? (size_t)(dot - output) : strlen(output);
        *rest = output + *head;
        return SP_OK;
    }
    const long width = percent[1] == '0' ? strtol(percent + 1, &end, 10) : 0;
    if (percent[1] != '0')
        end = (char *)percent + 1;
    if (*end != 'd' || width < 0 || width > DIGITS_MOST || strchr(end, '%'))
        return sp_fail(err, SP_EINVAL,
                       "-o %s: frames are numbered at one %%d or %%04d in the name, or without one before "
                       "the ending",
                       output);
    *digits = width > 0 ? (int)width : 1;
    *head = (size_t)(percent - output);
    *rest = end + 1;
    return SP_OK;
}

sp_status plot_frame_path(const char *output, int64_t k, char path[SP_PATH_MAX], sp_error *err) {
    size_t head = 0;
    const char *rest = output;
    int digits = DIGITS;
    const sp_status status = find_place(output, &head, &rest, &digits, err);
    if (status != SP_OK)
        return status;
    const int length = snprintf(path, SP_PATH_MAX, "%.*s%s%0*lld%s", (int)head, output, strchr(output, '%') ? "" : "-",
                                digits, (long long)k + 1, rest);
    return length < SP_PATH_MAX
               ? SP_OK
               : sp_fail(err, SP_EINVAL, "-o: the name of a frame has %d bytes, must have fewer than %d", length,
                         SP_PATH_MAX);
}

sp_status plot_frame_paths(const char *output, int frames, char ***out, sp_error *err) {
    const size_t room = strlen(output) + 2 * DIGITS_MOST, table = (size_t)frames * sizeof(char *);
    char *memory = sp_alloc(1, table + (size_t)frames * room), path[SP_PATH_MAX];
    char **list = (char **)(void *)memory;
    sp_status status = memory ? SP_OK : sp_fail_memory(err, table + (size_t)frames * room);
    for (int k = 0; k < frames && status == SP_OK; k++) {
        status = plot_frame_path(output, k, path, err);
        list[k] = memory + table + (size_t)k * room;
        snprintf(list[k], room, "%s", path);
    }
    if (status == SP_OK)
        *out = list;
    else
        sp_free(memory);
    return status;
}

sp_status plot_frames_may_write(const cli_common *common, int64_t frames, sp_error *err) {
    char path[SP_PATH_MAX];
    sp_status status = SP_OK;
    for (int64_t k = 0; k < frames && status == SP_OK; k++) {
        status = plot_frame_path(common->output, k, path, err);
        if (status == SP_OK)
            status = cli_may_write(common, path, err);
    }
    return status;
}
