/* Growing arrays and hashes. */
#include "test.h"

#include "base/base.h"

TEST(grows) {
    size_t capacity = 0;
    int64_t *x = NULL;
    for (size_t n = 0; n < 5000; n++) {
        int64_t *larger = sp_grow(x, n + 1, &capacity, sizeof *x);
        assert_non_null(larger);
        x = larger;
        assert_true(capacity > n && (uintptr_t)x % 64 == 0 && x[n] == 0 && x[capacity - 1] == 0);
        x[n] = (int64_t)n;
        for (size_t k = 0; k <= n; k += 100)
            assert_int_equal(x[k], k);
    }
    assert_true(capacity < 4 * 5000);
    sp_free(x);
}

/* Without memory, or for a size that overflows, the array stays as it was. */
TEST(keeps_the_array) {
    size_t capacity = 0;
    char *x = sp_grow(NULL, 10, &capacity, 1);
    const size_t before = capacity;
    strcpy(x, "kept");
    sp_alloc_fail_after(0);
    assert_null(sp_grow(x, before + 1, &capacity, 1));
    sp_alloc_fail_after(-1);
    assert_null(sp_grow(x, SIZE_MAX / 2, &capacity, 8));
    assert_true(capacity == before && strcmp(x, "kept") == 0);
    assert_ptr_equal(sp_grow(x, before, &capacity, 1), x);
    sp_free(x);
}

/* Test vectors of the authors' page (isthe.com/chongo/tech/comp/fnv). */
TEST(hashes) {
    assert_true(sp_hash64(SP_HASH64_BEGIN, "", 0) == 0xcbf29ce484222325u);
    assert_true(sp_hash64(SP_HASH64_BEGIN, "a", 1) == 0xaf63dc4c8601ec8cu);
    assert_true(sp_hash64(SP_HASH64_BEGIN, "foobar", 6) == 0x85944171f73967e8u);
    assert_true(sp_hash64(sp_hash64(SP_HASH64_BEGIN, "foo", 3), "bar", 3) == 0x85944171f73967e8u);
}

/* Every bit of the data counts, in the last, incomplete word too. */
TEST(hashes_words) {
    unsigned char data[21] = {0};
    const uint64_t zero = sp_hash64_words(SP_HASH64_BEGIN, data, sizeof data);
    for (size_t bit = 0; bit < 8 * sizeof data; bit++) {
        data[bit / 8] = (unsigned char)(1u << bit % 8);
        const uint64_t one = sp_hash64_words(SP_HASH64_BEGIN, data, sizeof data);
        assert_true(one != zero && (uint32_t)one != (uint32_t)zero);
        data[bit / 8] = 0;
    }
}

RUN_TESTS(NULL, NULL)
