/* Completions for zsh. */
#include "cli/completion.h"

static const char head[] = "#compdef sonopack\n"
                           "# zsh completion for sonopack, as `sonopack completion zsh' prints it.\n\n";

/* Keys of scenes after --set, and after = the words of their values. */
static const char tail[] = "_sonopack_set() {\n"
                           "    if compset -P '*='; then\n"
                           "        compadd -- $(_sonopack_values ${IPREFIX%=})\n"
                           "    else\n"
                           "        compadd -S = -- $_sonopack_keys\n"
                           "    fi\n"
                           "}\n\n"
                           "_sonopack() {\n"
                           "    local -a commands\n"
                           "    commands=($_sonopack_commands)\n"
                           "    if ((CURRENT == 2)); then\n"
                           "        _describe 'command' commands\n"
                           "        _arguments '--help[explain the commands]' '--version[print the version]'\n"
                           "        return\n"
                           "    fi\n"
                           "    local command=$words[2]\n"
                           "    shift words\n"
                           "    ((CURRENT--))\n"
                           "    if [[ $command == help ]]; then\n"
                           "        compadd -- ${_sonopack_commands%%:*} scene $_sonopack_keys\n"
                           "    elif ((${+functions[_sonopack_$command]})); then\n"
                           "        _sonopack_$command\n"
                           "    fi\n"
                           "}\n\n"
                           "if ((${+functions[compdef]})) && [[ $zsh_eval_context[-1] != loadautofunc ]]; then\n"
                           "    compdef _sonopack sonopack\n"
                           "else\n"
                           "    _sonopack \"$@\"\n"
                           "fi\n";

/* ":ARGUMENT:ACTION" of an option. */
static void put_action(sp_text *t, const cli_option *o) {
    const completion_kind kind = completion_of(o);
    char help[64];
    if (kind == COMPLETION_NONE)
        return;
    sp_text_add(t, ":%s:", completion_help(o->argument, help));
    if (kind == COMPLETION_WORDS) {
        sp_text_add(t, "(");
        for (int k = 0; completion_word(o, k); k++)
            sp_text_add(t, "%s%s", k > 0 ? " " : "", completion_word(o, k));
        sp_text_add(t, ")");
    } else {
        sp_text_add(t, "%s",
                    kind == COMPLETION_FILE     ? "_files"
                    : kind == COMPLETION_FOLDER ? "_files -/"
                    : kind == COMPLETION_KEY    ? "_sonopack_set"
                                                : " ");
    }
}

static void put_option(sp_text *t, const cli_option *o, const char *name) {
    char help[64];
    sp_text_add(t, " \\\n        '*--%s%s[%s]", name, o->argument ? "=" : "", completion_help(o->help, help));
    put_action(t, o);
    sp_text_add(t, "'");
    if (!o->letter || name != o->name)
        return;
    sp_text_add(t, " \\\n        '*-%c%s[%s]", o->letter, o->argument ? "+" : "", completion_help(o->help, help));
    put_action(t, o);
    sp_text_add(t, "'");
}

/* The words of the first argument, or files of the right endings. */
static void put_files(sp_text *t, const cli_syntax *s) {
    const char *endings = completion_endings(s);
    if (s->kinds || s->file_word) {
        sp_text_add(t, " \\\n        '%s:%s:(", s->file_word ? "*" : "1", s->file_word ? "case" : s->kind_name);
        for (int k = 0; s->kinds && s->kinds[k]; k++)
            sp_text_add(t, "%s%s", k > 0 ? " " : "", s->kinds[k]);
        for (int k = 0; s->file_word && s->file_word(k); k++)
            sp_text_add(t, "%s%s", k > 0 ? " " : "", s->file_word(k));
        sp_text_add(t, ")'");
    }
    if (!endings || s->file_word)
        return;
    sp_text_add(t, " \\\n        '*:%s:_files", s->file_name);
    if (endings[0]) {
        sp_text_add(t, " -g \"*.(");
        for (; *endings; endings++)
            sp_text_add(t, "%c", *endings == ' ' ? '|' : *endings);
        sp_text_add(t, ")(-.)\"");
    }
    sp_text_add(t, "'");
}

static void put_command(sp_text *t, const cli_command_row *row, const cli_syntax *s) {
    const cli_option *o;
    sp_text_add(t, "_sonopack_%s() {\n    _arguments -s -S", row->name);
    for (int k = 0; (o = cli_option_at(s, k)); k++) {
        if (o->name)
            put_option(t, o, o->name);
        if (o->alias)
            put_option(t, o, o->alias);
    }
    sp_text_add(t, " \\\n        '(-)'{-h,--help}'[print the help]' '(-)--usage[print the options in short]'"
                   " '(-)'{-V,--version}'[print the version]'");
    put_files(t, s);
    sp_text_add(t, "\n}\n\n");
}

static void put_keys(sp_text *t) {
    sp_text_add(t, "typeset -ga _sonopack_keys\n_sonopack_keys=(");
    for (int k = 0; sp_scene_key(k); k++)
        sp_text_add(t, "%s%s", k > 0 ? " " : "", sp_scene_key(k));
    sp_text_add(t, ")\n\n_sonopack_values() {\n    case $1 in\n");
    for (int k = 0; sp_scene_key(k); k++) {
        if (!completion_value(sp_scene_key(k), 0))
            continue;
        sp_text_add(t, "    *%s) print -l --", sp_scene_key(k));
        for (int i = 0; completion_value(sp_scene_key(k), i); i++)
            sp_text_add(t, " %s", completion_value(sp_scene_key(k), i));
        sp_text_add(t, " ;;\n");
    }
    sp_text_add(t, "    esac\n}\n\n");
}

void completion_zsh(sp_text *t) {
    const cli_command_row *row;
    const cli_syntax *s = NULL;
    char help[64];
    sp_text_add(t, "%stypeset -ga _sonopack_commands\n_sonopack_commands=(\n", head);
    for (row = cli_commands; row->name; row++)
        sp_text_add(t, "    '%s:%s'\n", row->name, completion_help(row->meaning, help));
    sp_text_add(t, ")\n\n");
    put_keys(t);
    for (int k = 0; (row = completion_command(k, &s)); k++)
        put_command(t, row, s);
    sp_text_add(t, "%s", tail);
}
