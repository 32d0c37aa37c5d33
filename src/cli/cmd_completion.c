/* sonopack completion: prints a short script for a shell, which asks `sonopack completion --words ...' for the words at
 * every key. They come from the tables that the commands are parsed with, so that they cannot be out of date. */
#include "base/base.h"
#include "cli/cli.h"
#include "scene/field.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const char *const shells[] = {"bash", "zsh", "fish", NULL};
static const char *const scripts[] = {
    "# bash completion for sonopack, as `sonopack completion bash' prints it.\n"
    "_sonopack() {\n"
    "    local line word ending program=${COMP_WORDS[0]/#\\~/$HOME} current=${COMP_WORDS[COMP_CWORD]}\n"
    "    [ \"$current\" = = ] && current=''\n"
    "    COMPREPLY=()\n"
    "    while IFS= read -r line; do\n"
    "        word=${line%%$'\\t'*}\n"
    "        case $word in\n"
    "        :*) ;;\n"
    "        *) [[ $word == \"$current\"* ]] || continue ;;\n"
    "        esac\n"
    "        case $word in\n"
    "        :folders) compopt -o filenames; mapfile -t COMPREPLY < <(compgen -d -- \"$current\") ;;\n"
    "        :files*)\n"
    "            compopt -o filenames\n"
    "            mapfile -t COMPREPLY < <({ compgen -d -- \"$current\"; for ending in ${word#:files}; do\n"
    "                compgen -f -X \"!*.$ending\" -- \"$current\"; done; } | sort -u)\n"
    "            ((${#COMPREPLY[@]})) || mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n"
    "            ;;\n"
    "        *) [ \"${word%=}\" = \"$word\" ] || compopt -o nospace; COMPREPLY+=(\"$word\") ;;\n"
    "        esac\n"
    "    done < <(\"$program\" completion --words \"${COMP_WORDS[@]:1:COMP_CWORD}\" 2>/dev/null)\n"
    "}\n"
    "complete -F _sonopack sonopack\n",
    "#compdef sonopack\n"
    "# zsh completion for sonopack, as `sonopack completion zsh' prints it.\n"
    "_sonopack() {\n"
    "    local -a found\n"
    "    local line\n"
    "    for line in \"${(@f)$(${~words[1]} completion --words \"${(@)words[2,CURRENT]}\" 2>/dev/null)}\"; do\n"
    "        case $line in\n"
    "        :folders) _files -/ ;;\n"
    "        ':files '*) _files -g \"*.(${${line#:files }// /|})(-.)\" ;;\n"
    "        :files) _files ;;\n"
    "        *=$'\\t'*) compadd -S '' -- ${line%%$'\\t'*} ;;\n"
    "        ?*) found+=(\"${${line%%$'\\t'*}//:/\\\\:}:${line#*$'\\t'}\") ;;\n"
    "        esac\n"
    "    done\n"
    "    (($#found)) && _describe word found\n"
    "}\n"
    "if ((${+functions[compdef]})) && [[ $zsh_eval_context[-1] != loadautofunc ]]; then\n"
    "    compdef _sonopack sonopack\n"
    "else\n"
    "    _sonopack \"$@\"\n"
    "fi\n",
    "# fish completion for sonopack, as `sonopack completion fish' prints it.\n"
    "function __sonopack_words\n"
    "    set -l words (commandline -opc)\n"
    "    set -l current (commandline -ct)\n"
    "    for line in ($words[1] completion --words $words[2..-1] \"$current\" 2>/dev/null)\n"
    "        switch $line\n"
    "            case ':folders'\n"
    "                __fish_complete_directories \"$current\"\n"
    "            case ':files'\n"
    "                __fish_complete_path \"$current\"\n"
    "            case ':files *'\n"
    "                for ending in (string split ' ' -- $line)[2..-1]\n"
    "                    __fish_complete_suffix .$ending\n"
    "                end\n"
    "            case '*'\n"
    "                echo $line\n"
    "        end\n"
    "    end\n"
    "end\n"
    "complete -c sonopack -e\n"
    "complete -c sonopack -f -a '(__sonopack_words)'\n"};

/* ---- words ------------------------------------------------------------------------------------------------------- */

/* What stands before each word that is offered: "--method=". The shell leaves out what does not begin like the word
 * that is being written. */
typedef struct offer {
    const char *before;
    int length;
} offer;
static const offer plain = {"", 0};

/* The first clause of a help text explains a word. */
static void put(const offer *o, const char *word, const char *end, const char *help) {
    const int clause = (int)strcspn(help, ";:(\v\n");
    printf("%.*s%s%s\t%.*s\n", o->length, o->before, word, end, clause < 60 ? clause : 60, help);
}

static void put_words(const offer *o, const char *const *words) {
    for (; words && *words; words++)
        put(o, *words, "", "");
}

/* The values of a key of scenes that are words. */
static void put_values(const offer *o, const char *key) {
    static const char *const truth[] = {"true", "false", NULL};
    const sp_field *f = sp_field_find(key);
    if (f && f->type == SP_FIELD_BOOL)
        put_words(o, truth);
    for (const sp_word *w = f && f->type == SP_FIELD_WORD ? f->words : NULL; w && w->word; w++)
        put(o, w->word, "", "");
}

static void put_keys(const offer *o, const char *end) {
    for (int k = 0; sp_scene_key(k); k++)
        put(o, sp_scene_key(k), end, sp_field_find(sp_scene_key(k))->meaning);
}

/* KEY, or after KEY= what it may be. current: what is written so far. */
static void put_setting(const offer *o, const char *current) {
    char key[64], before[128];
    const char *equals = strchr(current, '=');
    if (!equals) {
        put_keys(o, "=");
        return;
    }
    snprintf(key, sizeof key, "%.*s", (int)(equals - current), current);
    const int length = snprintf(before, sizeof before, "%.*s%s=", o->length, o->before, key);
    put_values(&(offer){before, length}, key);
}

static void put_argument(const offer *o, const cli_option *option, const char *current) {
    if (option->words)
        put_words(o, option->words);
    else if (option->key && sp_field_find(option->key)->words)
        put_values(o, option->key);
    else if (strcmp(option->argument, "KEY=VALUE") == 0)
        put_setting(o, current);
    else if (strcmp(option->argument, "DIR") == 0)
        puts(":folders");
    else if (strstr(option->argument, "FILE") || strcmp(option->argument, "TABLE") == 0)
        puts(":files");
}

/* ---- one command line -------------------------------------------------------------------------------------------- */

/* The option that a word names, up to `length'; NULL: none that has an argument. */
static const cli_option *option_of(const cli_syntax *s, const char *word, size_t length) {
    const cli_option *o;
    for (int k = 0; (o = cli_option_at(s, k)); k++)
        if (o->name && o->argument &&
            ((strncmp(word, "--", 2) == 0 && strlen(o->name) == length - 2 &&
              strncmp(o->name, word + 2, length - 2) == 0) ||
             (o->letter && length == 2 && word[0] == '-' && word[1] == o->letter)))
            return o;
    return NULL;
}

static void put_options(const offer *o, const cli_syntax *s) {
    static const char *const others[] = {"--help", "--usage", "--version", NULL};
    const cli_option *option;
    char name[64];
    for (int k = 0; (option = cli_option_at(s, k)); k++) {
        snprintf(name, sizeof name, "--%s", option->name ? option->name : "");
        if (option->name)
            put(o, name, "", option->help);
    }
    put_words(o, others);
}

/* Files by their endings; what is no scene and no packing may be any file. */
static void put_files(const cli_syntax *s) {
    const bool packing = s->file_name && strncmp(s->file_name, "packing", 7) == 0;
    const bool scene = s->file_name && strcmp(s->file_name, "scene") == 0;
    if (s->files_max > 0)
        printf(":files%s\n", scene                  ? " cfg"
                             : !packing             ? ""
                             : s->file_name[7] == 0 ? " h5 hdf5 txt"
                                                    : " h5 hdf5 txt tsv csv");
}

/* The last of the words is the one that is being written. bash takes = for a word of its own. */
static void put_line(const cli_syntax *s, int count, char **word) {
    const char *current = word[count - 1], *equals = strchr(current, '=');
    if (strcmp(current, "=") == 0)
        current = "", count++;
    const bool split = count > 2 && strcmp(word[count - 2], "=") == 0;
    const char *before = split ? word[count - 3] : count > 1 ? word[count - 2] : "";
    const bool joined = !split && equals && strncmp(current, "--", 2) == 0;
    const cli_option *option =
        joined ? option_of(s, current, (size_t)(equals - current)) : option_of(s, before, strlen(before));
    const offer o = {current, joined ? (int)(equals + 1 - current) : 0};
    if (split && strncmp(before, "--", 2) != 0)
        put_values(&o, before);
    else if (option)
        put_argument(&o, option, joined ? equals + 1 : current);
    else if (current[0] == '-')
        put_options(&o, s);
    else if (s->kinds && count == 1)
        put_words(&o, s->kinds);
    else
        put_files(s);
}

static void put_commands(void) {
    for (const cli_command_row *row = cli_commands; row->name; row++)
        put(&plain, row->name, "", row->meaning);
}

/* The words after "sonopack". A command of the Python package knows its own, and any file may be meant. */
static int print_words(int count, char **word) {
    const cli_command_row *row = cli_commands;
    if (count <= 1) {
        put_commands();
        put_words(&plain, (const char *const[]){"--help", "--version", NULL});
        return CLI_OK;
    }
    while (row->name && strcmp(row->name, word[0]) != 0)
        row++;
    if (!row->name)
        return CLI_OK;
    if (!row->run) {
        put_commands();
        put_words(&plain, (const char *const[]){"scene", NULL});
        put_keys(&plain, "");
    } else if (row->syntax) {
        put_line(row->syntax, count - 1, word + 1);
    } else {
        char name[64], words[] = "--words", *arguments[] = {name, words, NULL};
        snprintf(name, sizeof name, "sonopack %s", row->name);
        if (word[count - 1][0] != '-')
            puts(":files");
        fflush(stdout);
        return cmd_dispatch(2, arguments);
    }
    return CLI_OK;
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

typedef struct arguments {
    cli_common common;
} arguments;

static const cli_option options[] = {{0}};

const cli_syntax cmd_completion_syntax = {.usage = "SHELL",
                                          .help = "Prints the completions of sonopack for bash, zsh or fish.\v"
                                                  "An installation has them already. For a build tree:\n"
                                                  "\n"
                                                  "  source <(build/release/sonopack completion bash)\n"
                                                  "  source <(build/release/sonopack completion zsh)\n"
                                                  "  build/release/sonopack completion fish | source",
                                          .options = options,
                                          .kinds = shells,
                                          .kind_name = "shell"};

/* Nothing in a file tells that it has completions, so none is replaced. */
static sp_status write_text(const cli_common *common, const char *text, sp_error *err) {
    struct stat info;
    if (!common->output)
        return cli_print(text, err);
    if (stat(common->output, &info) == 0 && S_ISREG(info.st_mode))
        return sp_fail(err, SP_EINVAL, "%s: exists already: choose another name", common->output);
    return sp_text_save(common->output, text, strlen(text), err);
}

int cmd_completion(int argc, char **argv) {
    arguments a = {{0}};
    sp_error err = {0};
    if (argc > 1 && strcmp(argv[1], "--words") == 0)
        return print_words(argc - 2, argv + 2);
    cli_parse(&cmd_completion_syntax, argc, argv, &a);
    return write_text(&a.common, scripts[a.common.kind], &err) == SP_OK ? CLI_OK : cli_fail(&err);
}
