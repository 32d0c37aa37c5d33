/* Saves the state of a compression beside its packing. */
#include "cli/pack_state.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static sp_status find_state(pack_state *s, const sp_pack_spec *spec, sp_error *err) {
    struct stat info;
    if (stat(s->path, &info) != 0)
        return SP_OK;
    char *data = NULL;
    size_t size = 0;
    int64_t steps = 0;
    sp_error reason = {0};
    sp_status status = S_ISREG(info.st_mode) ? sp_file_read(s->path, &data, &size, err) : SP_OK;
    if (status != SP_OK)
        return status;
    if (!data || !sp_pack_is_state(data, size)) {
        sp_free(data);
        return sp_fail(err, SP_EINVAL,
                       "%s: the state of the compression belongs in this file, which is something else and is not "
                       "replaced: choose another name for -o",
                       s->path);
    }
    if (sp_pack_state_check(spec, data, size, &steps, &reason) == SP_OK) {
        cli_note(s->common, "continues from step %lld, saved in %s", (long long)steps, s->path);
        s->found = data;
        s->found_size = size;
        s->kept = true;
        return SP_OK;
    }
    cli_note(s->common, "%s is not used: %s", s->path, reason.text);
    sp_free(data);
    return SP_OK;
}

sp_status pack_state_open(const cli_common *common, const sp_pack_spec *spec, double every, pack_state *out,
                          sp_error *err) {
    pack_state s = {.common = common, .every = every, .written_at = sp_clock_wall()};
    struct stat info;
    if (stat(common->output, &info) != 0 || S_ISREG(info.st_mode)) { /* not for a device or a pipe */
        const int length = snprintf(s.path, sizeof s.path, "%s.state", common->output);
        if (length < 0 || (size_t)length >= sizeof s.path)
            return sp_fail(err, SP_EINVAL, "-o: the file name has %d bytes, must have fewer than %d", length - 6,
                           SP_PATH_MAX - 6);
    }
    sp_status status = s.path[0] ? find_state(&s, spec, err) : SP_OK;
    if (status == SP_OK)
        *out = s;
    return status;
}

static sp_status write_now(pack_state *s, const void *state, size_t size, sp_error *err) {
    sp_status status = sp_file_write(s->path, state, size, err);
    s->written_at = sp_clock_wall();
    s->due = false;
    s->kept = s->kept || status == SP_OK;
    s->last_size = 0;
    return status;
}

sp_status pack_state_update(pack_state *s, const void *state, size_t size, sp_error *err) {
    if (!s->path[0])
        return SP_OK;
    if (s->due || sp_clock_wall() - s->written_at >= s->every)
        return write_now(s, state, size, err);
    if (size > s->last_capacity) {
        sp_free(s->last);
        s->last_capacity = size + size / 4;
        s->last = sp_alloc(s->last_capacity, 1);
        if (!s->last) {
            s->last_capacity = s->last_size = 0;
            return sp_fail_memory(err, size);
        }
    }
    memcpy(s->last, state, size);
    s->last_size = size;
    return SP_OK;
}

bool pack_state_is_safe(const pack_state *s) { return !s->path[0] || s->kept || s->last_size > 0; }

sp_status pack_state_flush(pack_state *s, sp_error *err) {
    return s->last_size > 0 ? write_now(s, s->last, s->last_size, err) : SP_OK;
}

void pack_state_remove(pack_state *s) {
    if (s->path[0])
        unlink(s->path);
}

void pack_state_free(pack_state *s) {
    sp_free(s->found);
    sp_free(s->last);
    *s = (pack_state){0};
}
