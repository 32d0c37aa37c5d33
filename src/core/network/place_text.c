/* Places of sources and detectors as text: "plane:12.5:shear". */
#include "base/base.h"
#include "base/text.h"

#include <math.h>
#include <sonopack/network.h>
#include <stdio.h>
#include <string.h>

static const char *wall_of(bool source) { return source ? "bottom" : "top"; }

static sp_status wrong(const char *text, bool source, sp_error *err) {
    return sp_fail(
        err, SP_EINVAL,
        "%.60s: must be %s, part:X0:X1 with X0 below X1, plane:Y or grain:I, optionally followed by :normal or "
        ":shear",
        text, wall_of(source));
}

/* A length on the command line. */
static bool read_length(const char *word, double *out) { return sp_word_number(word, out) && *out >= 0 && *out <= 1e9; }

/* Whether the words name a place; a component has been taken off. */
static bool read_words(int count, char *const *word, bool source, sp_place *at) {
    int64_t grain;
    if (count == 0 || (count == 1 && strcmp(word[0], wall_of(source)) == 0))
        return true;
    if (count == 2 && strcmp(word[0], "grain") == 0) {
        at->kind = SP_PLACE_GRAIN;
        const bool good = sp_word_integer(word[1], &grain) && grain >= 0 && grain <= INT32_MAX;
        at->grain = good ? (int32_t)grain : 0;
        return good;
    }
    if (count == 2 && strcmp(word[0], "plane") == 0) {
        at->kind = SP_PLACE_PLANE;
        return read_length(word[1], &at->height);
    }
    at->kind = SP_PLACE_PART;
    return count == 3 && strcmp(word[0], "part") == 0 && read_length(word[1], &at->from) &&
           read_length(word[2], &at->to) && at->from < at->to;
}

sp_status sp_place_read(const char *text, bool source, sp_place *out, bool *component, sp_error *err) {
    char copy[200], *word[4] = {NULL}, *rest = copy;
    sp_place at = sp_place_wall();
    int count = 0;
    if (strlen(text) >= sizeof copy)
        return wrong(text, source, err);
    strcpy(copy, text);
    while (rest && count < 4)
        word[count++] = strsep(&rest, ":");
    at.shear = strcmp(word[count - 1], "shear") == 0;
    const bool given = at.shear || strcmp(word[count - 1], "normal") == 0;
    if (rest || !read_words(count - given, word, source, &at))
        return wrong(text, source, err);
    if (component)
        *component = given;
    *out = at;
    return SP_OK;
}

char *sp_place_text(const sp_place *at, bool source, char text[SP_PLACE_TEXT]) {
    const char *component = at->shear ? "shear" : "normal";
    char one[SP_NUMBER_TEXT], two[SP_NUMBER_TEXT];
    switch (at->kind) {
    case SP_PLACE_WALL: snprintf(text, SP_PLACE_TEXT, "%s:%s", wall_of(source), component); break;
    case SP_PLACE_GRAIN: snprintf(text, SP_PLACE_TEXT, "grain:%d:%s", at->grain, component); break;
    case SP_PLACE_PLANE:
        snprintf(text, SP_PLACE_TEXT, "plane:%s:%s", sp_number_text(at->height, one), component);
        break;
    case SP_PLACE_PART:
        snprintf(text, SP_PLACE_TEXT, "part:%s:%s:%s", sp_number_text(at->from, one), sp_number_text(at->to, two),
                 component);
        break;
    }
    return text;
}
