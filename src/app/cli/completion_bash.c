/* Completions for bash. */
#include "cli/completion.h"

#include <stdio.h>
#include <string.h>

static const char head[] = "# bash completion for sonopack, as `sonopack completion bash' prints it.\n\n";

static const char tail[] =
    "_sonopack_files() { # endings, word\n"
    "    local ending\n"
    "    compopt -o filenames 2>/dev/null\n"
    "    mapfile -t COMPREPLY < <({ compgen -d -- \"$2\"; for ending in $1; do compgen -f -X \"!*.$ending\" -- \"$2\"; "
    "done; } | sort -u)\n"
    "    ((${#COMPREPLY[@]})) || mapfile -t COMPREPLY < <(compgen -f -- \"$2\")\n"
    "}\n\n"
    "_sonopack() {\n"
    "    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}\n"
    "    local before=${COMP_WORDS[COMP_CWORD > 2 ? COMP_CWORD - 2 : 0]} words\n"
    "    COMPREPLY=()\n"
    "    if ((COMP_CWORD == 1)); then\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"$_sonopack_commands --help --version\" -- \"$current\")\n"
    "        return\n"
    "    fi\n"
    "    if [ \"$command\" = help ]; then\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"$_sonopack_commands scene $_sonopack_keys\" -- \"$current\")\n"
    "        return\n"
    "    fi\n"
    "    # bash takes = for a word of its own: --set packing.kind = CURRENT, or --set packing.kind =\n"
    "    [ \"$current\" = = ] && current='' before=$previous previous='='\n"
    "    if [ \"$previous\" = = ] && [[ $before == *.* ]]; then\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"$(_sonopack_values \"$before\")\" -- \"$current\")\n"
    "        return\n"
    "    fi\n"
    "    [ \"$previous\" = = ] && previous=$before\n"
    "    case $(_sonopack_argument \"$command\" \"$previous\") in\n"
    "    words:*)\n"
    "        words=$(_sonopack_argument \"$command\" \"$previous\")\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"${words#words:}\" -- \"$current\")\n"
    "        return\n"
    "        ;;\n"
    "    key)\n"
    "        compopt -o nospace 2>/dev/null\n"
    "        if [[ $current == *=* ]]; then\n"
    "            mapfile -t COMPREPLY < <(compgen -P \"${current%%=*}=\" -W \"$(_sonopack_values \"${current%%=*}\")\" "
    "-- "
    "\"${current#*=}\")\n"
    "        else\n"
    "            mapfile -t COMPREPLY < <(compgen -S = -W \"$_sonopack_keys\" -- \"$current\")\n"
    "        fi\n"
    "        return\n"
    "        ;;\n"
    "    file)\n"
    "        _sonopack_files '' \"$current\"\n"
    "        return\n"
    "        ;;\n"
    "    folder)\n"
    "        compopt -o filenames 2>/dev/null\n"
    "        mapfile -t COMPREPLY < <(compgen -d -- \"$current\")\n"
    "        return\n"
    "        ;;\n"
    "    value) return ;;\n"
    "    esac\n"
    "    if [[ $current == -* ]]; then\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"$(_sonopack_options \"$command\")\" -- \"$current\")\n"
    "        return\n"
    "    fi\n"
    "    words=$(_sonopack_first \"$command\")\n"
    "    if [ -n \"$words\" ] && { ((COMP_CWORD == 2)) || [ \"$command\" = bench ]; }; then\n"
    "        mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
    "        return\n"
    "    fi\n"
    "    _sonopack_files \"$(_sonopack_endings \"$command\")\" \"$current\"\n"
    "}\n\n"
    "complete -F _sonopack sonopack\n";

/* ---- the tables, as functions of the shell ---------------------------------------------------------------------- */

static void open_table(sp_text *t, const char *name, const char *arguments) {
    sp_text_add(t, "%s() { # %s\n    case $1 in\n", name, arguments);
}

static void close_table(sp_text *t) { sp_text_add(t, "    esac\n}\n\n"); }

static void put_options(sp_text *t, const cli_syntax *s) {
    for (int k = 0; cli_option_at(s, k); k++)
        if (cli_option_at(s, k)->name)
            sp_text_add(t, "--%s ", cli_option_at(s, k)->name);
    for (int k = 0; cli_option_at(s, k); k++)
        if (cli_option_at(s, k)->alias)
            sp_text_add(t, "--%s ", cli_option_at(s, k)->alias);
}

static void put_argument(sp_text *t, const char *command, const cli_option *o) {
    static const char *const names[] = {[COMPLETION_VALUE] = "value",
                                        [COMPLETION_FILE] = "file",
                                        [COMPLETION_FOLDER] = "folder",
                                        [COMPLETION_KEY] = "key"};
    const completion_kind kind = completion_of(o);
    if (kind == COMPLETION_NONE)
        return;
    sp_text_add(t, "    %s\\ --%s", command, o->name);
    if (o->alias)
        sp_text_add(t, " | %s\\ --%s", command, o->alias);
    if (o->letter)
        sp_text_add(t, " | %s\\ -%c", command, o->letter);
    sp_text_add(t, ") echo '%s", kind == COMPLETION_WORDS ? "words:" : names[kind]);
    for (int k = 0; kind == COMPLETION_WORDS && completion_word(o, k); k++)
        sp_text_add(t, "%s%s", k > 0 ? " " : "", completion_word(o, k));
    sp_text_add(t, "' ;;\n");
}

static void put_first(sp_text *t, const cli_syntax *s) {
    for (int k = 0; s->kinds && s->kinds[k]; k++)
        sp_text_add(t, "%s ", s->kinds[k]);
    for (int k = 0; s->file_word && s->file_word(k); k++)
        sp_text_add(t, "%s ", s->file_word(k));
}

static void put_tables(sp_text *t) {
    const cli_command_row *row;
    const cli_syntax *s = NULL;
    open_table(t, "_sonopack_options", "command");
    for (int k = 0; (row = completion_command(k, &s)); k++) {
        sp_text_add(t, "    %s) echo '", row->name);
        put_options(t, s);
        sp_text_add(t, "--help --usage --version' ;;\n");
    }
    close_table(t);
    sp_text_add(t, "_sonopack_argument() { # command, option\n    case $1\\ $2 in\n");
    for (int k = 0; (row = completion_command(k, &s)); k++)
        for (int i = 0; cli_option_at(s, i); i++)
            if (cli_option_at(s, i)->name)
                put_argument(t, row->name, cli_option_at(s, i));
    close_table(t);
    open_table(t, "_sonopack_first", "command");
    for (int k = 0; (row = completion_command(k, &s)); k++) {
        if (!s->kinds && !s->file_word)
            continue;
        sp_text_add(t, "    %s) echo '", row->name);
        put_first(t, s);
        sp_text_add(t, "' ;;\n");
    }
    close_table(t);
    open_table(t, "_sonopack_endings", "command");
    for (int k = 0; (row = completion_command(k, &s)); k++)
        if (completion_endings(s) && completion_endings(s)[0])
            sp_text_add(t, "    %s) echo '%s' ;;\n", row->name, completion_endings(s));
    close_table(t);
}

static void put_keys(sp_text *t) {
    sp_text_add(t, "_sonopack_keys='");
    for (int k = 0; sp_scene_key(k); k++)
        sp_text_add(t, "%s%s", k > 0 ? " " : "", sp_scene_key(k));
    sp_text_add(t, "'\n\n");
    open_table(t, "_sonopack_values", "key");
    for (int k = 0; sp_scene_key(k); k++) {
        if (!completion_value(sp_scene_key(k), 0))
            continue;
        sp_text_add(t, "    %s) echo '", sp_scene_key(k));
        for (int i = 0; completion_value(sp_scene_key(k), i); i++)
            sp_text_add(t, "%s%s", i > 0 ? " " : "", completion_value(sp_scene_key(k), i));
        sp_text_add(t, "' ;;\n");
    }
    close_table(t);
}

void completion_bash(sp_text *t) {
    sp_text_add(t, "%s_sonopack_commands='", head);
    for (const cli_command_row *row = cli_commands; row->name; row++)
        sp_text_add(t, "%s%s", row > cli_commands ? " " : "", row->name);
    sp_text_add(t, "'\n");
    put_keys(t);
    put_tables(t);
    sp_text_add(t, "%s", tail);
}
