#ifndef SP_CLI_COMPLETION_H
#define SP_CLI_COMPLETION_H
/* What the completions of all shells are made of. */

#include "base/text.h"
#include "cli/cli.h"

/* Each writes the completions for one shell. */
void completion_bash(sp_text *t);
void completion_zsh(sp_text *t);
void completion_fish(sp_text *t);

/* Command k whose syntax is known, with it; NULL after the last. `help' has none, and is not among them. */
const cli_command_row *completion_command(int k, const cli_syntax **syntax);

/* What completes the argument of an option. */
typedef enum completion_kind {
    COMPLETION_NONE = 0, /* a flag */
    COMPLETION_VALUE,    /* a number or a text of the user's own */
    COMPLETION_WORDS,
    COMPLETION_FILE,
    COMPLETION_FOLDER,
    COMPLETION_KEY /* KEY=VALUE */
} completion_kind;
completion_kind completion_of(const cli_option *o);
/* Word k that an option takes; NULL after the last. Valid until the next call. */
const char *completion_word(const cli_option *o, int k);
/* Endings of the files that a command reads, separated by blanks; "": any file; NULL: none. */
const char *completion_endings(const cli_syntax *s);
/* Word k of a value of a scene key, as --set takes it; NULL after the last. */
const char *completion_value(const char *key, int k);

/* The first clause of a help text, at most 60 bytes, without quotes, brackets and colons, which shells would read. */
const char *completion_help(const char *text, char buf[64]);

#endif
