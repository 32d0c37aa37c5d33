/* Tells tables apart by the settings in their metadata. */
#include "figure/settings.h"

#include "figure/markup.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* The key of a scene without its group: "friction" of "packing.friction" and of a list "pressure = ..., friction = ..."
 * or "dimension = ..., friction = ..."; NULL for other metadata. */
static const char *scene_key(const sp_table *t, int k) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789_";
    int first = k;
    while (first > 0 && t->value[first - 1].comment == t->value[k].comment)
        first--;
    const char *key = t->value[k].key, *point = key + strspn(key, letters);
    const bool list = strcmp(t->value[first].key, "pressure") == 0 ||
                      (strcmp(t->value[first].key, "dimension") == 0 && first + 1 < t->values &&
                       t->value[first + 1].comment == t->value[first].comment);
    if (!list && *point != '.')
        return NULL;
    key = list ? key : point + 1;
    return *key && key[strspn(key, letters)] == '\0' ? key : NULL;
}

static const sp_table_value *find_setting(const sp_table *t, const char *key) {
    for (int k = 0; k < t->values; k++) {
        const char *own = scene_key(t, k);
        if (own && strcmp(own, key) == 0)
            return &t->value[k];
    }
    return NULL;
}

/* All tables have the key, and not all the same value. */
static bool differs(int tables, const sp_plot_table *table, const char *key) {
    const sp_table_value *first = find_setting(table[0].table, key);
    bool differ = false;
    for (int j = 1; j < tables; j++) {
        const sp_table_value *other = find_setting(table[j].table, key);
        if (!other)
            return false;
        differ = differ || strcmp(other->text, first->text) != 0;
    }
    return differ;
}

static void add_part(const char *key, const sp_table_value *v, char out[SETTINGS_LABEL]) {
    static const char *const symbols[][3] = {{"pressure", "|p|", " |E|*"},
                                             {"friction", "|\xce\xbc|", ""},
                                             {"grains", "|N|", ""},
                                             {"width", "width", " |d|"},
                                             {"dimension", "dimension", ""}};
    char name[96], value[128];
    const char *unit = "";
    sp_figure_text_escape(name, sizeof name, key, 24);
    for (size_t k = 0; k < sizeof symbols / sizeof *symbols; k++)
        if (strcmp(key, symbols[k][0]) == 0) {
            snprintf(name, sizeof name, "%s", symbols[k][1]);
            unit = v->kind != SP_COLUMN_TEXT ? symbols[k][2] : "";
        }
    if (v->kind != SP_COLUMN_TEXT && isfinite(v->number))
        sp_figure_text_number(value, sizeof value, v->number, 9);
    else
        sp_figure_text_escape(value, sizeof value, v->text, 16);
    const size_t used = strlen(out);
    snprintf(out + used, SETTINGS_LABEL - used, "%s%s = %s%s", used > 0 ? ", " : "", name, value, unit);
}

static void label_of(int tables, const sp_plot_table *table, int j, char out[SETTINGS_LABEL]) {
    enum { KEYS_MOST = 8 };
    const sp_table *first = table[0].table; /* its order is that of all labels */
    int keys = 0;
    out[0] = '\0';
    for (int k = 0; k < first->values && keys < KEYS_MOST; k++) {
        const char *key = scene_key(first, k);
        if (!key || find_setting(first, key) != &first->value[k] || !differs(tables, table, key))
            continue;
        keys++;
        add_part(key, find_setting(table[j].table, key), out);
    }
}

void sp_settings_label(int tables, const sp_plot_table *table, int j, int most, char out[SETTINGS_LABEL]) {
    char own[SETTINGS_LABEL], other[SETTINGS_LABEL];
    if (table[j].named) {
        sp_figure_text_escape(out, SETTINGS_LABEL, table[j].label ? table[j].label : "", most > 40 ? most : 40);
        return;
    }
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

int sp_settings_dimension(int tables, const sp_plot_table *table) {
    int common = 0;
    for (int j = 0; j < tables; j++) {
        double dim = 0;
        if (!sp_table_get_number(table[j].table, "dimension", &dim))
            sp_table_get_number(table[j].table, "packing.dimension", &dim);
        if ((dim != 1 && dim != 2 && dim != 3) || (common && dim != common))
            return 0;
        common = (int)dim;
    }
    return common;
}

void sp_settings_interval(const sp_table *t, char *out, size_t size) {
    double level = NAN;
    char percent[40];
    if (sp_table_get_number(t, "interval_level", &level) && level > 0 && level < 1) {
        sp_figure_text_number(percent, sizeof percent, 100 * level, 4);
        snprintf(out, size, "%s%% interval", percent);
    } else
        snprintf(out, size, "interval");
}
