/* What clang's analyzer cannot know of functions in other files, told to it by tests/lint, which puts this header in
 * front of every source: sp_fail and its like return the status that they were given, and argp_error does not return.
 * Without this it follows hundreds of paths on which a failure is SP_OK. */
#ifndef LINT_MODEL_H
#define LINT_MODEL_H

#include <argp.h>
#include <base/base.h>

#define sp_fail(err, status, ...)          ((sp_fail)(err, status, __VA_ARGS__), (sp_status)(status))
#define sp_fail_key(err, status, key, ...) ((sp_fail_key)(err, status, key, __VA_ARGS__), (sp_status)(status))
#define sp_fail_memory(err, bytes)         ((sp_fail_memory)(err, bytes), SP_ENOMEM)
#define argp_error(...)                    (argp_error(__VA_ARGS__), __builtin_unreachable())

#endif
