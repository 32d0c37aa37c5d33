/* sonopack completion: prints the completions for a shell. All words come from the tables that the commands are parsed
 * with, so that they cannot be out of date. */
#include "base/base.h"
#include "cli/completion.h"
#include "cli/output.h"

#include <string.h>
#include <sys/stat.h>

typedef struct arguments {
    cli_common common;
} arguments;

static const char *const shells[] = {"bash", "zsh", "fish", NULL};
static void (*const writers[])(sp_text *) = {completion_bash, completion_zsh, completion_fish};

static const cli_option options[] = {{0}};

static const cli_syntax syntax = {.usage = "SHELL",
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
static sp_status write_text(const cli_common *common, const sp_text *text, sp_error *err) {
    struct stat info;
    if (!common->output)
        return cli_print(text->data, err);
    if (stat(common->output, &info) == 0 && S_ISREG(info.st_mode))
        return sp_fail(err, SP_EINVAL, "%s: exists already: choose another name", common->output);
    return sp_text_save(common->output, text->data, text->size, err);
}

int cmd_completion(int argc, char **argv) {
    arguments a = {{0}};
    sp_text text = {0};
    sp_error err = {0};
    cli_parse(&syntax, argc, argv, &a);
    writers[a.common.kind](&text);
    sp_status status = text.failed ? sp_fail_memory(&err, 1 << 16) : write_text(&a.common, &text, &err);
    sp_text_free(&text);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
