/* What the completions of all shells are made of: the tables of the commands. */
#include "cli/completion.h"

#include "base/base.h"
#include "scene/field.h"

#include <stdio.h>
#include <string.h>

const cli_command_row *completion_command(int k, const cli_syntax **syntax) {
    for (const cli_command_row *row = cli_commands; row->name; row++) {
        if (!row->run || row->run == cmd_dispatch || k-- > 0)
            continue;
        *syntax = cli_syntax_of(row);
        return row;
    }
    return NULL;
}

/* ---- arguments of options --------------------------------------------------------------------------------------- */

/* Word k of "a|b|c", which is a list of words if it has no upper case and no digits; NULL if it is none. */
static const char *listed(const char *list, int k, char *buf, size_t size) {
    if (!list || !strchr(list, '|') || list[strspn(list, "abcdefghijklmnopqrstuvwxyz-|")] != '\0')
        return NULL;
    for (; k > 0 && list; k--) {
        list = strchr(list, '|');
        list = list ? list + 1 : NULL;
    }
    if (!list)
        return NULL;
    snprintf(buf, size, "%.*s", (int)strcspn(list, "|"), list);
    return buf;
}

static const char *key_word(const char *key, int k) {
    const sp_field *f = sp_field_find(key);
    if (!f || !f->words)
        return NULL;
    for (const sp_word *w = f->words; w->word; w++)
        if (k-- == 0)
            return w->word;
    return NULL;
}

const char *completion_word(const cli_option *o, int k) {
    static char word[32];
    if (o->words) {
        for (int i = 0; i <= k; i++)
            if (!o->words[i])
                return NULL;
        return o->words[k];
    }
    if (o->word)
        return o->word(k);
    return o->key && o->kind == CLI_PARSED ? key_word(o->key, k) : listed(o->argument, k, word, sizeof word);
}

completion_kind completion_of(const cli_option *o) {
    if (!o->argument)
        return COMPLETION_NONE;
    if (completion_word(o, 0))
        return COMPLETION_WORDS;
    if (strcmp(o->argument, "KEY=VALUE") == 0)
        return COMPLETION_KEY;
    if (strcmp(o->argument, "DIR") == 0)
        return COMPLETION_FOLDER;
    return strstr(o->argument, "FILE") || strstr(o->argument, "TSV") ? COMPLETION_FILE : COMPLETION_VALUE;
}

const char *completion_endings(const cli_syntax *s) {
    static const struct {
        const char *file, *endings;
    } all[] = {{"scene", "cfg"}, {"packing", "h5 hdf5 txt"}, {"packing or trace", "h5 hdf5 txt tsv csv"}};
    if (!s->file_name || s->files_max == 0)
        return NULL;
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (strcmp(s->file_name, all[k].file) == 0)
            return all[k].endings;
    return "";
}

const char *completion_value(const char *key, int k) {
    static const char *const truth[] = {"true", "false"};
    const sp_field *f = sp_field_find(key);
    if (f && f->type == SP_FIELD_BOOL)
        return k < 2 ? truth[k] : NULL;
    return f && f->type == SP_FIELD_WORD ? key_word(key, k) : NULL;
}

/* ---- texts ------------------------------------------------------------------------------------------------------ */

const char *completion_help(const char *text, char buf[64]) {
    size_t n = strcspn(text, ";:(\v\n"), used = 0;
    for (size_t i = 0; i < n && used < 60; i++)
        if (!strchr("'\"`[]\\$", text[i]))
            buf[used++] = text[i];
    if (used == 60) /* at a word */
        while (used > 0 && buf[used - 1] != ' ')
            used--;
    while (used > 0 && (buf[used - 1] == ' ' || buf[used - 1] == ','))
        used--;
    buf[used] = '\0';
    return buf;
}
