/* What LAMMPS says of itself: version, progress, and why it failed. */
#include "base/base.h"
#include "base/file.h"
#include "foreign/engine.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PART = 65536 };

/* Up to PART bytes from the beginning of a file, or from its end. Empty if it cannot be read. */
static void read_part(const char *folder, sp_engine_file file, bool end, char text[PART + 1]) {
    char path[SP_PATH_MAX];
    size_t got = 0;
    FILE *f = sp_engine_look(folder, file, path, NULL) == SP_OK ? fopen(path, "re") : NULL;
    if (f && end && fseek(f, 0, SEEK_END) == 0) {
        const long size = ftell(f);
        fseek(f, size > PART ? size - PART : 0, SEEK_SET);
    }
    if (f) {
        got = fread(text, 1, PART, f);
        fclose(f);
    }
    for (size_t k = 0; k < got; k++)
        text[k] = text[k] ? text[k] : ' ';
    text[got] = '\0';
}

static void copy_line(const char *from, const char *stop, char out[SP_ENGINE_TEXT]) {
    const size_t length = strcspn(from, stop);
    snprintf(out, SP_ENGINE_TEXT, "%.*s", (int)(length < SP_ENGINE_TEXT ? length : SP_ENGINE_TEXT - 1), from);
    for (char *c = out; *c; c++)
        *c = (unsigned char)*c < ' ' ? ' ' : *c;
}

/* "LAMMPS (29 Sep 2021 - Update 2)" */
static void find_version(const char *text, char out[SP_ENGINE_TEXT]) {
    const char *at = strstr(text, "LAMMPS (");
    if (at)
        copy_line(at + strlen("LAMMPS ("), ")\n", out);
}

static void find_fault(const char *text, char out[SP_ENGINE_TEXT]) {
    const char *at = strncmp(text, "ERROR", 5) == 0 ? text : strstr(text, "\nERROR");
    if (at)
        copy_line(at + (*at == '\n'), "\n", out);
}

/* The last line that is three numbers and nothing else, and has its end. */
static void find_row(char *text, sp_engine_log *out) {
    for (char *end = strrchr(text, '\n'); end; end = strrchr(text, '\n')) {
        *end = '\0';
        const char *line = strrchr(text, '\n');
        double row[3];
        int used = 0;
        line = line ? line + 1 : text;
        if (sscanf(line, "%lf %lf %lf %n", &row[0], &row[1], &row[2], &used) == 3 && line[used] == '\0' &&
            row[0] >= 0 && row[0] < 9e18) {
            out->steps = (int64_t)row[0];
            out->acceleration = row[1];
            out->height = row[2];
            return;
        }
    }
}

void sp_engine_read_log(const char *folder, sp_engine_log *out) {
    char *text = sp_alloc(PART + 1, 1);
    *out = (sp_engine_log){.steps = -1, .acceleration = NAN, .height = NAN};
    if (!text)
        return;
    read_part(folder, SP_ENGINE_LOG, false, text);
    find_version(text, out->version);
    if (!out->version[0]) {
        read_part(folder, SP_ENGINE_WORDS, false, text);
        find_version(text, out->version);
    }
    read_part(folder, SP_ENGINE_WORDS, true, text);
    find_fault(text, out->fault);
    read_part(folder, SP_ENGINE_LOG, true, text);
    if (!out->fault[0])
        find_fault(text, out->fault);
    find_row(text, out);
    sp_free(text);
}

int sp_engine_date(const char *version) {
    static const char months[] = "JanFebMarAprMayJunJulAugSepOctNovDec";
    int day, year;
    char month[4];
    if (sscanf(version, "%2d %3s %4d", &day, month, &year) != 3 || strlen(month) != 3)
        return 0;
    const char *at = strstr(months, month);
    if (!at || (at - months) % 3 != 0)
        return 0;
    return 10000 * year + 100 * (int)((at - months) / 3 + 1) + day;
}
