/* Reads and writes the places of sources and detectors. */
#include "cli/places.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

static const char *const kinds[] = {[SP_PLACE_WALL] = "", /* bottom or top */
                                    [SP_PLACE_PART] = "part",
                                    [SP_PLACE_GRAIN] = "grain",
                                    [SP_PLACE_PLANE] = "plane"};
static const int numbers[] = {[SP_PLACE_WALL] = 0, [SP_PLACE_PART] = 2, [SP_PLACE_GRAIN] = 1, [SP_PLACE_PLANE] = 1};
enum { KINDS = sizeof kinds / sizeof *kinds, WORDS_MAX = 4 };

static const char *wall_of(bool source) { return source ? "bottom" : "top"; }

const char *const cli_component_names[] = {"normal", "shear", NULL};

static bool read_component(const char *word, cli_component *out) {
    int shear;
    if (cli_choose("", word, cli_component_names, &shear, NULL) != SP_OK)
        return false;
    *out = shear ? COMPONENT_SHEAR : COMPONENT_NORMAL;
    return true;
}

static sp_status wrong_place(const cli_places *p, const char *option, const char *word, sp_error *err) {
    return sp_fail(err, SP_EINVAL,
                   "%s %.60s: must be %s, part:X0:X1, plane:Y or grain:I, optionally followed by :normal or :shear",
                   option, word, wall_of(p->sources));
}

static sp_status add(cli_places *p, sp_place at, cli_component component, sp_error *err) {
    if (p->n == CLI_PLACES_MAX)
        return sp_fail(err, SP_EINVAL, "more than %d %s", CLI_PLACES_MAX, p->sources ? "sources" : "detectors");
    p->at[p->n] = at;
    p->component[p->n++] = component;
    return SP_OK;
}

/* Reads the numbers that follow the kind of a place. */
static sp_status read_numbers(const char *option, char *const *word, sp_place *at, sp_error *err) {
    char what[60];
    int64_t grain = 0;
    snprintf(what, sizeof what, "%s %s:", option, kinds[at->kind]);
    if (at->kind == SP_PLACE_GRAIN) {
        sp_status status = cli_integer(what, word[0], 0, INT32_MAX, &grain, err);
        at->grain = (int32_t)grain;
        return status;
    }
    if (at->kind == SP_PLACE_PLANE)
        return cli_number(what, word[0], 0, 1e9, &at->height, err);
    sp_status status = cli_number(what, word[0], 0, 1e9, &at->from, err);
    if (status == SP_OK)
        status = cli_number(what, word[1], 0, 1e9, &at->to, err);
    if (status == SP_OK && !(at->from < at->to))
        status = sp_fail(err, SP_EINVAL, "%s%.30s:%.30s: must be an interval X0:X1 with X0 below X1", what, word[0],
                         word[1]);
    return status;
}

sp_status cli_places_add(cli_places *p, const char *option, const char *word, sp_error *err) {
    char copy[200], *words[WORDS_MAX] = {NULL}, *rest = copy;
    cli_component component = COMPONENT_DEFAULT;
    sp_place at = sp_place_wall();
    int count = 0;
    if (strlen(word) >= sizeof copy)
        return wrong_place(p, option, word, err);
    strcpy(copy, word);
    while (rest && count < WORDS_MAX)
        words[count++] = strsep(&rest, ":");
    if (rest)
        return wrong_place(p, option, word, err);
    if (read_component(words[count - 1], &component))
        count--;
    if (count == 0 || (count == 1 && strcmp(words[0], wall_of(p->sources)) == 0))
        return add(p, at, component, err);
    for (int k = SP_PLACE_PART; k < KINDS; k++)
        if (strcmp(words[0], kinds[k]) == 0 && count == 1 + numbers[k]) {
            at.kind = (sp_place_kind)k;
            sp_status status = read_numbers(option, words + 1, &at, err);
            return status == SP_OK ? add(p, at, component, err) : status;
        }
    return wrong_place(p, option, word, err);
}

sp_status cli_places_add_planes(cli_places *p, int64_t count, double height, sp_error *err) {
    sp_status status = SP_OK;
    for (int64_t k = 1; k <= count && status == SP_OK; k++)
        status = add(p, (sp_place){.kind = SP_PLACE_PLANE, .height = height * (double)k / (double)(count + 1)},
                     COMPONENT_DEFAULT, err);
    return status;
}

sp_status cli_places_set_component(cli_places *p, bool shear, sp_error *err) {
    sp_status status = p->n == 0 ? add(p, sp_place_wall(), COMPONENT_DEFAULT, err) : SP_OK;
    for (int32_t k = 0; k < p->n; k++)
        p->at[k].shear = p->component[k] == COMPONENT_DEFAULT ? shear : p->component[k] == COMPONENT_SHEAR;
    return status;
}

char *cli_place_text(const sp_place *at, bool source, char text[CLI_PLACE_TEXT]) {
    const char *component = at->shear ? "shear" : "normal";
    char one[SP_NUMBER_TEXT], two[SP_NUMBER_TEXT];
    switch (at->kind) {
    case SP_PLACE_WALL: snprintf(text, CLI_PLACE_TEXT, "%s:%s", wall_of(source), component); break;
    case SP_PLACE_PART:
        snprintf(text, CLI_PLACE_TEXT, "part:%s:%s:%s", sp_number_text(at->from, one), sp_number_text(at->to, two),
                 component);
        break;
    case SP_PLACE_GRAIN: snprintf(text, CLI_PLACE_TEXT, "grain:%d:%s", at->grain, component); break;
    case SP_PLACE_PLANE:
        snprintf(text, CLI_PLACE_TEXT, "plane:%s:%s", sp_number_text(at->height, one), component);
        break;
    }
    return text;
}
