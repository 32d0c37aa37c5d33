#ifndef SP_TEST_H
#define SP_TEST_H
/* cmocka with asserts for doubles (its own cast to float) and for statuses. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
/* after the above: cmocka needs them */
#include <cmocka.h>

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
/* The call (which takes &err) fails with this status and a reason that contains the text. */
#define assert_fails(call, expected, text_part)                                                                        \
    do {                                                                                                               \
        sp_error err = {0};                                                                                            \
        sp_status st_ = (call);                                                                                        \
        if (st_ != (expected) || !strstr(err.text, text_part))                                                         \
            fail_msg("%s: %s \"%s\", expected %s \"%s\"", #call, sp_status_name(st_), err.text,                        \
                     sp_status_name(expected), text_part);                                                             \
    } while (0)
#endif
