/* Keys: the key at fault in an error, and the tables that say which values a key may have. */
#include "test.h"

#include "packing/prepare.h"
#include "scene/field.h"

#include "base/base.h"

/* ---- the key at fault ------------------------------------------------------------------------------------------- */

/* The value is refused, in a scene and in --set, with the key that it was given for. */
static void assert_refused(const sp_field *f, const char *value) {
    char override[160], text[200], *overrides[] = {override};
    sp_scene s;
    sp_error err = {0};
    snprintf(override, sizeof override, "%s=%s", f->key, value);
    const bool path = f->type == SP_FIELD_FILE || f->type == SP_FIELD_PATH; /* of which --set takes any text */
    sp_status status = sp_field_is_tapped(f) ? sp_scene_read_tapped(NULL, path ? 0 : 1, overrides, &s, &err)
                                             : sp_scene_read(NULL, path ? 0 : 1, overrides, &s, &err);
    if (path && status == SP_OK)
        sp_scene_free(&s);
    else if (status != SP_EINVAL || strcmp(err.key, f->key) != 0)
        fail_msg("--set %s: key \"%s\", %s", override, err.key, err.text);
    const char *name = sp_field_name(f), *inner = strchr(name, '.');
    const int group = (int)strcspn(f->key, ".");
    if (inner)
        snprintf(text, sizeof text, "%.*s = { %.*s = { %s = %s; }; };", group, f->key, (int)(inner - name), name,
                 inner + 1, value);
    else
        snprintf(text, sizeof text, "%.*s = { %s = %s; };", group, f->key, name, value);
    err = (sp_error){0};
    if (sp_scene_parse(text, "s.cfg", 0, NULL, &s, &err) != SP_EINVAL || strcmp(err.key, f->key) != 0)
        fail_msg("%s: key \"%s\", %s", text, err.key, err.text);
}

static void assert_number_refused(const sp_field *f, double value) {
    char text[64];
    const bool list = f->type == SP_FIELD_REALS, integer = f->type == SP_FIELD_INT || f->type == SP_FIELD_INT64;
    if (integer && fabs(value) < 1e18)
        snprintf(text, sizeof text, "%.0f", value);
    else
        snprintf(text, sizeof text, "%s%.17g%s", list ? "(" : "", value, list ? ")" : "");
    assert_refused(f, text);
}

TEST(every_key_refuses_what_is_out_of_range) {
    for (const sp_field *f = sp_fields; f < sp_fields + SP_FIELDS; f++) {
        const sp_key *range = sp_field_limits(f);
        if (!range) {
            assert_false(sp_field_is_number(f));
            assert_refused(f, f->type == SP_FIELD_BOOL ? "3" : "3.5");
            continue;
        }
        assert_string_equal(range->name, f->key);
        assert_int_equal(range->type, f->type);
        const bool integer = f->type == SP_FIELD_INT || f->type == SP_FIELD_INT64;
        assert_number_refused(f, integer ? range->low - 1 : range->low - fmax(1e-3 * fabs(range->low), 1e-20));
        assert_number_refused(f, integer ? fmin(range->high + 1, 1e19) : 1.001 * range->high);
        if (integer)
            assert_refused(f, "1.5");
    }
}

/* What a spec refuses names the same key as what the scene refuses. */
TEST(specs_name_the_key) {
    for (const sp_key *key = sp_pack_keys; key->name; key++) {
        sp_pack_spec s = sp_pack_spec_default();
        sp_error err = {0};
        char *place = (char *)&s + key->offset;
        const double wrong = 2 * key->high, numbers[] = {wrong, wrong};
        const double *list = numbers;
        const int32_t narrow = (int32_t)fmin(wrong + 7, 2e9), two = 2;
        const int64_t wide = (int64_t)fmin(wrong, 0x1p62);
        if (key->type == SP_KEY_BOOL || (key->type == SP_KEY_INT64 && key->high > 0x1p62))
            continue; /* takes every value of its type */
        if (key->type == SP_KEY_REAL)
            memcpy(place, &wrong, sizeof wrong);
        else if (key->type == SP_KEY_INT64)
            memcpy(place, &wide, sizeof wide);
        else if (key->type != SP_KEY_REALS)
            memcpy(place, &narrow, sizeof narrow);
        if (key->type == SP_KEY_REALS) {
            memcpy(place, &list, sizeof list);
            memcpy((char *)&s + key->count, &two, sizeof two);
        }
        assert_int_equal(sp_pack_spec_check(&s, &err), SP_EINVAL);
        assert_string_equal(err.key, key->name);
    }
}

TEST(unknown_keys_are_the_ones_at_fault) {
    sp_scene s;
    sp_error err = {0};
    char *override[] = {(char[]){"packing.widht=3"}};
    assert_int_equal(sp_scene_read(NULL, 1, override, &s, &err), SP_EINVAL);
    assert_string_equal(err.key, "packing.widht");
    assert_int_equal(sp_scene_parse("packin = { width = 3; };", "s.cfg", 0, NULL, &s, &err), SP_EINVAL);
    assert_string_equal(err.key, "packin");
    assert_int_equal(sp_scene_parse("packing = ;", "s.cfg", 0, NULL, &s, &err), SP_EINVAL);
    assert_string_equal(err.key, ""); /* an error of syntax has no key, and takes none from an error before */
}

/* ---- the table of a packing ------------------------------------------------------------------------------------- */

static size_t size_of(const sp_key *key) {
    switch (key->type) {
    case SP_KEY_REAL: return sizeof(double);
    case SP_KEY_INT64: return sizeof(int64_t);
    case SP_KEY_BOOL: return sizeof(bool);
    case SP_KEY_REALS: return sizeof(double *);
    default: return sizeof(int32_t);
    }
}

/* Every byte of sp_pack_spec but padding belongs to one key: a new member that the table lacks would be missing from
 * the check and from the identity of a saved state. */
TEST(every_member_has_a_key) {
    static sp_pack_spec spec;
    unsigned char covered[sizeof spec] = {0}, members[sizeof spec];
    memset(&spec, 0xff, sizeof spec);
#if defined(__GNUC__) && __GNUC__ >= 11 && !defined(__clang__)
    __builtin_clear_padding(&spec);
#endif
    memcpy(members, &spec, sizeof spec);
    for (const sp_key *key = sp_pack_keys; key->name; key++) {
        for (size_t k = 0; k < size_of(key); k++)
            covered[key->offset + k]++;
        for (size_t k = 0; k < sizeof(int32_t) && key->type == SP_KEY_REALS; k++)
            covered[key->count + k]++;
    }
#if defined(__GNUC__) && __GNUC__ >= 11 && !defined(__clang__)
    for (size_t k = 0; k < sizeof spec; k++)
        if (covered[k] != (members[k] != 0))
            fail_msg("byte %zu of sp_pack_spec: %d keys, %s", k, covered[k], members[k] ? "a member" : "padding");
#endif
}

typedef struct saved {
    unsigned char *state;
    size_t size;
} saved;

static sp_status keep(const void *state, size_t size, void *user, sp_error *err) {
    saved *s = user;
    s->state = malloc(size);
    assert_non_null(s->state);
    memcpy(s->state, state, size);
    s->size = size;
    return sp_fail(err, SP_EINTERRUPTED, "one is enough");
}

/* Another value of one key, whether it is allowed or not. */
static void change(sp_pack_spec *s, const sp_key *key) {
    static const double list[] = {0.5};
    static const double *const values = list;
    const int32_t one = 1;
    unsigned char *place = (unsigned char *)s + key->offset;
    double real;
    if (key->type == SP_KEY_REAL) {
        memcpy(&real, place, sizeof real);
        real = real > 0 ? 1.01 * real : 0.05;
        memcpy(place, &real, sizeof real);
    } else if (key->type == SP_KEY_REALS) {
        memcpy(place, &values, sizeof values);
        memcpy((char *)s + key->count, &one, sizeof one);
    } else {
        *place ^= 1;
    }
}

/* A saved state is that of one spec only: it must not go on with any key changed. */
TEST(every_key_decides_whose_state_it_is) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 40;
    spec.width = 8;
    saved kept = {0};
    const sp_pack_hooks hooks = {.user = &kept, .save = keep};
    sp_packing p = sp_packing_none();
    assert_int_equal(sp_packing_make_with(&spec, &hooks, &p, NULL), SP_EINTERRUPTED);
    assert_ok(sp_pack_state_check(&spec, kept.state, kept.size, NULL, &err));
    for (const sp_key *key = sp_pack_keys; key->name; key++) {
        sp_pack_spec other = spec;
        change(&other, key);
        if (sp_pack_state_check(&other, kept.state, kept.size, NULL, NULL) != SP_EFORMAT)
            fail_msg("a state goes on with another %s", key->name);
    }
    free(kept.state);
}

RUN_TESTS(NULL, NULL)
