/* Completions for fish. */
#include "cli/completion.h"

#include <string.h>

static const char head[] =
    "# fish completion for sonopack, as `sonopack completion fish' prints it.\n\n"
    "complete -c sonopack -e\n"
    "complete -c sonopack -f\n"
    "complete -c sonopack -n __fish_use_subcommand -l help -d 'explain the commands'\n"
    "complete -c sonopack -n __fish_use_subcommand -l version -d 'print the version'\n\n"
    "function __sonopack_needs_kind -a command # whether the next word is the first after the command\n"
    "    set -l words (string match -v -- '-*' (commandline -opc))\n"
    "    test (count $words) -eq 2; and test \"$words[2]\" = $command\n"
    "end\n\n";

/* "KEY=" of all keys, and "KEY=WORD" of those with words. */
static void put_keys(sp_text *t) {
    sp_text_add(t, "function __sonopack_keys\n");
    for (int k = 0; sp_scene_key(k); k++) {
        sp_text_add(t, "    echo %s=\n", sp_scene_key(k));
        for (int i = 0; completion_value(sp_scene_key(k), i); i++)
            sp_text_add(t, "    echo %s=%s\n", sp_scene_key(k), completion_value(sp_scene_key(k), i));
    }
    sp_text_add(t, "end\n\n");
}

static void put_option(sp_text *t, const char *command, const cli_option *o, const char *name) {
    const completion_kind kind = completion_of(o);
    char help[64];
    sp_text_add(t, "complete -c sonopack -n '__fish_seen_subcommand_from %s' -l %s", command, name);
    if (o->letter && name == o->name)
        sp_text_add(t, " -s %c", o->letter);
    if (kind == COMPLETION_WORDS) {
        sp_text_add(t, " -x -a '");
        for (int k = 0; completion_word(o, k); k++)
            sp_text_add(t, "%s%s", k > 0 ? " " : "", completion_word(o, k));
        sp_text_add(t, "'");
    } else if (kind != COMPLETION_NONE) {
        sp_text_add(t, "%s",
                    kind == COMPLETION_FILE     ? " -r -F"
                    : kind == COMPLETION_FOLDER ? " -x -a '(__fish_complete_directories)'"
                    : kind == COMPLETION_KEY    ? " -x -a '(__sonopack_keys)'"
                                                : " -x");
    }
    sp_text_add(t, " -d '%s'\n", completion_help(o->help, help));
}

/* The words of the first argument, or files of the right endings. */
static void put_files(sp_text *t, const char *command, const cli_syntax *s) {
    const char *endings = completion_endings(s);
    static const char seen[] = "__fish_seen_subcommand_from";
    char ending[16];
    for (int k = 0; s->kinds && s->kinds[k]; k++)
        sp_text_add(t, "complete -c sonopack -n '__sonopack_needs_kind %s' -a %s\n", command, s->kinds[k]);
    for (int k = 0; s->file_word && s->file_word(k); k++)
        sp_text_add(t, "complete -c sonopack -n '__fish_seen_subcommand_from %s' -a %s\n", command, s->file_word(k));
    if (!endings || s->file_word)
        return;
    if (!endings[0])
        sp_text_add(t, "complete -c sonopack -n '%s %s; and not __sonopack_needs_kind %s' -F\n", seen, command,
                    s->kinds ? command : "-");
    for (; *endings; endings += strspn(endings, " ")) {
        const size_t n = strcspn(endings, " ");
        memcpy(ending, endings, n);
        ending[n] = '\0';
        sp_text_add(t,
                    "complete -c sonopack -n '%s %s; and not __sonopack_needs_kind %s' -a '(__fish_complete_suffix "
                    ".%s)'\n",
                    seen, command, s->kinds ? command : "-", ending);
        endings += n;
    }
}

static void put_command(sp_text *t, const cli_command_row *row, const cli_syntax *s) {
    const cli_option *o;
    char help[64];
    sp_text_add(t, "complete -c sonopack -n __fish_use_subcommand -a %s -d '%s'\n", row->name,
                completion_help(row->meaning, help));
    for (int k = 0; (o = cli_option_at(s, k)); k++) {
        if (o->name)
            put_option(t, row->name, o, o->name);
        if (o->alias)
            put_option(t, row->name, o, o->alias);
    }
    sp_text_add(t, "complete -c sonopack -n '__fish_seen_subcommand_from %s' -s h -l help -d 'print the help'\n",
                row->name);
    put_files(t, row->name, s);
}

void completion_fish(sp_text *t) {
    const cli_command_row *row;
    const cli_syntax *s = NULL;
    sp_text_add(t, "%s", head);
    put_keys(t);
    for (int k = 0; (row = completion_command(k, &s)); k++)
        put_command(t, row, s);
    sp_text_add(t, "complete -c sonopack -n __fish_use_subcommand -a help -d 'explain a command or a key of scenes'\n");
    for (row = cli_commands; row->name; row++)
        sp_text_add(t, "complete -c sonopack -n '__fish_seen_subcommand_from help' -a %s\n", row->name);
    for (int k = 0; sp_scene_key(k); k++)
        sp_text_add(t, "complete -c sonopack -n '__fish_seen_subcommand_from help' -a %s\n", sp_scene_key(k));
}
