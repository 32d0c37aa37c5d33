/* Lists of frequencies as options give them. */
#include "base/base.h"
#include "cli/cli.h"

#include <string.h>

static sp_status one_number(const char *text, size_t length, double *out, sp_error *err) {
    char word[64];
    if (length >= sizeof word)
        return sp_fail(err, SP_EINVAL, "--at %.60s: must be W1,W2,... or LOW:HIGH:N", text);
    memcpy(word, text, length);
    word[length] = '\0';
    return cli_number("--at", word, 1e-12, 1e9, out, err);
}

static sp_status parse_list(const char *text, int32_t most, int32_t *n, double *omega, sp_error *err) {
    sp_status status = SP_OK;
    for (*n = 0; status == SP_OK; text++) {
        const size_t length = strcspn(text, ",");
        if (*n == most)
            return sp_fail(err, SP_EINVAL, "--at: more than %d frequencies", most);
        status = one_number(text, length, &omega[(*n)++], err);
        text += length;
        if (*text == '\0')
            break;
    }
    return status;
}

static sp_status parse_range(const char *text, int32_t most, int32_t *n, double *omega, sp_error *err) {
    const char *one = strchr(text, ':'), *two = strchr(one + 1, ':');
    double low, high;
    int64_t count;
    if (!two)
        return sp_fail(err, SP_EINVAL, "--at %.60s: must be W1,W2,... or LOW:HIGH:N", text);
    sp_status status = one_number(text, (size_t)(one - text), &low, err);
    if (status == SP_OK)
        status = one_number(one + 1, (size_t)(two - one - 1), &high, err);
    if (status == SP_OK)
        status = cli_integer("--at: N", two + 1, 2, most, &count, err);
    if (status == SP_OK && !(low < high))
        status = sp_fail(err, SP_EINVAL, "--at %.60s: LOW must be below HIGH", text);
    if (status != SP_OK)
        return status;
    *n = (int32_t)count;
    for (int32_t l = 0; l < *n; l++)
        omega[l] = l < *n - 1 ? low + (high - low) * l / (*n - 1) : high;
    return SP_OK;
}

sp_status cli_frequencies(const char *text, int32_t most, int32_t *n, double *omega, sp_error *err) {
    return strchr(text, ':') ? parse_range(text, most, n, omega, err) : parse_list(text, most, n, omega, err);
}
