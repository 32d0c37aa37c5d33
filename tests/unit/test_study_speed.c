#include "ensemble/speed.h"
#include "numeric/random.h"
#include "test.h"

enum { N = 20, TRIALS = 800 };

/* Arrivals at heights near 8 and 25 with the speed 0.3: heights scatter, sources do, and the way on top of it. Joint
 * ones share the source's scatter, and every fifth lacks one of the marks. */
static void make_up(sp_random *r, bool joint, double distance[2][N], double time[2][N]) {
    for (int k = 0; k < N; k++) {
        double source = 0;
        for (int g = 0; g < 2; g++) {
            const double height = (g ? 25 : 8) + (joint ? 0 : 0.4 * sp_random_normal(r));
            if (g == 0 || !joint)
                source = 5 - 3 * log1p(-sp_random_uniform(r)); /* skewed */
            distance[g][k] = height;
            time[g][k] = source + height / 0.3 + sp_random_normal(r);
        }
        if (joint && k % 5 == 4)
            time[k % 2][k] = NAN;
    }
}

/* 95% to four standard deviations of so many trials, and half a percent for skewed samples. */
TEST(coverage_of_the_speed) {
    const uint64_t seed = 12;
    print_message("seed %llu\n", (unsigned long long)seed);
    for (int joint = 0; joint < 2; joint++) {
        sp_random r = sp_random_make(seed, 99);
        double distance[2][N], time[2][N], width = 0;
        int held = 0;
        for (int k = 0; k < TRIALS; k++) {
            make_up(&r, joint, distance, time);
            const sp_arrivals near = {N, distance[0], time[0]}, far = {N, distance[1], time[1]};
            sp_interval i;
            assert_ok(sp_speed_interval(&near, &far, joint, 0.95, &i, &err));
            held += i.low <= 0.3 && 0.3 <= i.high;
            width += (i.high - i.low) / TRIALS;
        }
        print_message("%s: %.1f%%, mean width %.4f\n", joint ? "joint" : "independent", 100.0 * held / TRIALS, width);
        assert_close(100.0 * held / TRIALS, 95, 400 * sqrt(0.95 * 0.05 / TRIALS) + 0.5);
        /* c dt/t: of independent ends the variances 9 + 1 of N each; of joint ones those of the ways, 1 of the 18 that
         * have a mark, and the sources' 9 of the four packings that lack one */
        const double flight = 17 / 0.3, change = joint ? sqrt(2.0 / 18 + 4 * 9 / (18.0 * 18)) : sqrt(2 * 10.0 / N);
        assert_relative(width, 2 * 2.09 * 0.3 * change / flight, 0.2);
    }
}

TEST(where_there_is_no_speed) {
    const double distance[2][2] = {{8, 8}, {25, 25}}, time[3][2] = {{30, 32}, {90, 91}, {NAN, NAN}};
    const sp_arrivals near = {2, distance[0], time[0]}, far = {2, distance[1], time[1]},
                      one = {1, distance[1], time[1]}, never = {2, distance[1], time[2]};
    const struct {
        const sp_arrivals *near, *far;
        bool speed;
    } all[] = {{&near, &far, true}, {&far, &near, false}, {&near, &one, false}, {&near, &never, false}};
    for (int k = 0; k < 4; k++)
        for (int joint = 0; joint < 2; joint++) {
            if (joint && all[k].near->n != all[k].far->n)
                continue;
            sp_interval i = {0, 0};
            assert_ok(sp_speed_interval(all[k].near, all[k].far, joint, 0.95, &i, &err));
            assert_true(all[k].speed ? i.low < i.high : isnan(i.low) && isnan(i.high));
        }
}

RUN_TESTS(NULL, NULL)
