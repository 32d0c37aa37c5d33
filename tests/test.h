#ifndef SP_TEST_H
#define SP_TEST_H
/* cmocka with asserts for doubles (its own cast to float) and for statuses. */
#include <ctype.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
/* after the above: cmocka needs them */
#include <cmocka.h>

/* ---- tests ---------------------------------------------------------------------------------------------------- */

/* TEST(name) { ... } is a test of its program, which ends with RUN_TESTS(setup, teardown) of all of them, NULL for
 * none: in the order of the file. RUN_TESTS_WHERE: skipped where the condition is false. TEST_BETWEEN: with a setup and
 * a teardown of its own. */
static struct CMUnitTest test_all[100] __attribute__((unused));
static size_t test_count __attribute__((unused));
#define TEST_BETWEEN(name, setup, teardown)                                                                            \
    static void name(void **state);                                                                                    \
    __attribute__((constructor)) static void test_add_##name(void) {                                                   \
        test_all[test_count++] = (struct CMUnitTest){#name, name, setup, teardown, NULL};                              \
    }                                                                                                                  \
    static void name(__attribute__((unused)) void **state)
#define TEST(name) TEST_BETWEEN(name, NULL, NULL)
#define RUN_TESTS_WHERE(condition, setup, teardown)                                                                    \
    int main(void) {                                                                                                   \
        return (condition) ? _cmocka_run_group_tests("tests", test_all, test_count, setup, teardown) : 77;             \
    }
#define RUN_TESTS(setup, teardown) RUN_TESTS_WHERE(true, setup, teardown)

/* A variable that is freed where its block ends: FREED(sp_packing) p = ...; */
#define FREED(type) __attribute__((cleanup(type##_free))) type
/* The same of memory: RELEASED double *x = malloc(...); */
#define RELEASED __attribute__((cleanup(test_release)))
static inline void test_release(void *pointer) { free(*(void **)pointer); }

/* ---- asserts ----------------------------------------------------------------------------------------------------- */

#define assert_close(value, expected, tolerance)                                                                       \
    do {                                                                                                               \
        double v_ = (value), e_ = (expected), t_ = (tolerance);                                                        \
        if (!(fabs(v_ - e_) <= t_))                                                                                    \
            fail_msg("%s = %.17g, expected %.17g +- %g (off by %g)", #value, v_, e_, t_, v_ - e_);                     \
    } while (0)
#define assert_relative(value, expected, tolerance) assert_close(value, expected, (tolerance)*fabs(expected))
#define assert_ok(call)                                                                                                \
    do {                                                                                                               \
        sp_error err = {0};                                                                                            \
        sp_status st_ = (call);                                                                                        \
        if (st_ != SP_OK)                                                                                              \
            fail_msg("%s: %s (%s)", #call, err.text, sp_status_name(st_));                                             \
    } while (0)
/* ---- what a reason names ------------------------------------------------------------------------------------- */

static inline bool test_of_word(char c) { return c == '_' || isalnum((unsigned char)c); }

/* Whether the word found in a text stands there by itself: not "grain" of "grains", nor 5 of 0.5 or of 1e-5. */
static inline bool test_alone(const char *text, const char *at, size_t length) {
    const char before = at > text ? at[-1] : ' ', first = at[0], last = at[length - 1], after = at[length];
    const bool number = isdigit((unsigned char)first);
    if (test_of_word(first) && test_of_word(before))
        return false;
    if (number && (before == '-' || (before == '.' && at > text + 1 && isdigit((unsigned char)at[-2]))))
        return false;
    return !test_of_word(last) || !(test_of_word(after) || (after == '.' && isdigit((unsigned char)at[length + 1])));
}

static inline bool test_names_one(const char *text, const char *word, size_t length) {
    for (const char *at = text; *at; at++)
        if (strncmp(at, word, length) == 0 && test_alone(text, at, length))
            return true;
    return false;
}

/* Whether a text names all of the words, which blanks separate: keys, values, FILE:LINE. They are what tests ask of a
 * reason; how it is put is not theirs. */
static inline bool test_names(const char *text, const char *words) {
    const char *word = words + strspn(words, " ");
    while (*word) {
        const size_t length = strcspn(word, " ");
        if (!test_names_one(text, word, length))
            return false;
        word += length + strspn(word + length, " ");
    }
    return true;
}

/* The call (which takes &err) fails with this status and a reason that names the words. */
#define assert_fails(call, expected, words)                                                                            \
    do {                                                                                                               \
        sp_error err = {0};                                                                                            \
        sp_status st_ = (call);                                                                                        \
        if (st_ != (expected) || !*err.text || !test_names(err.text, words))                                           \
            fail_msg("%s: %s \"%s\", expected %s \"%s\"", #call, sp_status_name(st_), err.text,                        \
                     sp_status_name(expected), words);                                                                 \
    } while (0)
/* Every allocation of a call, which takes &err, fails once, the first one first: SP_ENOMEM until it succeeds, after
 * more than `least` of them. What follows is done after every try: it frees, and asserts that nothing is left where
 * `lacks`.
 */
#define EACH_ALLOCATION_FAILS(least, call, ...)                                                                        \
    do {                                                                                                               \
        int allocations_ = -1;                                                                                         \
        for (bool lacks = true; lacks;) {                                                                              \
            sp_error err = {0};                                                                                        \
            sp_alloc_fail_after(++allocations_);                                                                       \
            const sp_status st_ = (call);                                                                              \
            sp_alloc_fail_after(-1);                                                                                   \
            lacks = st_ != SP_OK;                                                                                      \
            if (lacks && st_ != SP_ENOMEM)                                                                             \
                fail_msg("%s: %s (%s)", #call, err.text, sp_status_name(st_));                                         \
            __VA_ARGS__;                                                                                               \
        }                                                                                                              \
        assert_true(allocations_ > (least));                                                                           \
    } while (0)
/* Sanitizers look for wrong reads and writes, and are five times as slow: tests that make many packings only to count
 * or for means are left out there, and of many like cases they take each n-th, while the others take all. */
#ifdef __SANITIZE_ADDRESS__
#define SKIP_SANITIZED()  skip()
#define SANITIZED_STEP(n) (n)
#else
#define SKIP_SANITIZED()  ((void)0)
#define SANITIZED_STEP(n) 1
#endif

#endif
