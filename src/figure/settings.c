#include "figure/settings.h"

#include "figure/markup.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct setting {
    char key[48], value[64]; /* the key without its group: both kinds of comments have the same */
} setting;

/* Where the search for the next setting goes on. */
typedef struct place {
    int comment;
    const char *rest; /* of a line with several; NULL: begin the comment */
} place;

/* "group.key = value" alone, or one of the parts of "pressure = ..., grains = ...". */
static bool read_setting(const char *line, bool several, setting *out, const char **rest) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789_";
    const char *key = line + strspn(line, " \t");
    const bool parts = several || strncmp(key, "pressure = ", 11) == 0;
    size_t length = strspn(key, letters);
    *rest = NULL;
    if (!parts && key[length] != '.')
        return false;
    if (!parts) {
        key += length + 1;
        length = strspn(key, letters);
    }
    if (length == 0 || length >= sizeof out->key || strncmp(key + length, " = ", 3) != 0)
        return false;
    const char *value = key + length + 3, *comma = parts ? strstr(value, ", ") : NULL;
    const size_t size = comma ? (size_t)(comma - value) : strlen(value);
    snprintf(out->key, sizeof out->key, "%.*s", (int)length, key);
    snprintf(out->value, sizeof out->value, "%.*s", (int)(size < 64 ? size : 63), value);
    *rest = comma ? comma + 2 : NULL;
    return true;
}

static bool next_setting(const sp_table *t, place *at, setting *out) {
    while (at->comment < t->comments) {
        const bool several = at->rest != NULL;
        const char *line = several ? at->rest : t->comment[at->comment];
        const bool found = read_setting(line, several, out, &at->rest);
        if (!at->rest)
            at->comment++;
        if (found)
            return true;
    }
    return false;
}

static bool find_setting(const sp_table *t, const char *key, setting *out) {
    place at = {0};
    while (next_setting(t, &at, out))
        if (strcmp(out->key, key) == 0)
            return true;
    return false;
}

/* All tables have it, and not all the same. */
static bool tells_apart(int tables, const sp_plot_table *table, const setting *s) {
    bool differs = false;
    for (int j = 0; j < tables; j++) {
        setting other;
        if (!find_setting(table[j].table, s->key, &other))
            return false;
        differs = differs || strcmp(other.value, s->value) != 0;
    }
    return differs;
}

static void add_part(const setting *s, char out[SETTINGS_LABEL]) {
    static const char *const symbols[][2] = {{"pressure", "|p|"}, {"friction", "|\xce\xbc|"}, {"grains", "|N|"}};
    char name[96], value[128], *end;
    sp_figure_text_escape(name, sizeof name, s->key, 24);
    for (size_t k = 0; k < sizeof symbols / sizeof *symbols; k++)
        if (strcmp(s->key, symbols[k][0]) == 0)
            snprintf(name, sizeof name, "%s", symbols[k][1]);
    const double number = strtod(s->value, &end);
    if (end > s->value && *end == '\0' && isfinite(number))
        sp_figure_text_number(value, sizeof value, number, 9);
    else
        sp_figure_text_escape(value, sizeof value, s->value, 16);
    const size_t used = strlen(out);
    snprintf(out + used, SETTINGS_LABEL - used, "%s%s = %s", used > 0 ? ", " : "", name, value);
}

static void label_of(int tables, const sp_plot_table *table, int j, char out[SETTINGS_LABEL]) {
    enum { KEYS_MOST = 8 };
    char named[KEYS_MOST][48];
    int keys = 0;
    place at = {0};
    setting one, here;
    out[0] = '\0';
    /* in the order of the first table, so that all labels have the same */
    while (keys < KEYS_MOST && next_setting(table[0].table, &at, &one)) {
        bool again = false;
        for (int k = 0; k < keys; k++)
            again = again || strcmp(named[k], one.key) == 0;
        if (again || !tells_apart(tables, table, &one))
            continue;
        snprintf(named[keys++], sizeof named[0], "%s", one.key);
        if (find_setting(table[j].table, one.key, &here))
            add_part(&here, out);
    }
}

void sp_settings_label(int tables, const sp_plot_table *table, int j, int most, char out[SETTINGS_LABEL]) {
    char own[SETTINGS_LABEL], other[SETTINGS_LABEL];
    label_of(tables, table, j, own);
    bool alone = own[0] != '\0';
    for (int k = 0; k < tables && alone; k++)
        for (int l = 0; l < k && alone; l++) {
            label_of(tables, table, k, own);
            label_of(tables, table, l, other);
            alone = strcmp(own, other) != 0;
        }
    out[0] = '\0';
    if (alone)
        label_of(tables, table, j, out);
    else if (table[j].label)
        sp_figure_text_escape(out, SETTINGS_LABEL, table[j].label, most);
}

void sp_settings_interval(const sp_table *t, char *out, size_t size) {
    static const char words[] = "interval at level ";
    double level = NAN;
    for (int c = 0; c < t->comments && !isfinite(level); c++) {
        const char *at = strstr(t->comment[c], words);
        char *end = NULL;
        const double value = at ? strtod(at + strlen(words), &end) : NAN;
        if (value > 0 && value < 1)
            level = value;
    }
    char percent[40];
    if (isfinite(level)) {
        sp_figure_text_number(percent, sizeof percent, 100 * level, 4);
        snprintf(out, size, "%s%% interval", percent);
    } else
        snprintf(out, size, "interval");
}
