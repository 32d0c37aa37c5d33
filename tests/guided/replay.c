/* Runs a target without libFuzzer: on every file of its corpus, and on inputs that are damaged at random.
 *
 * usage: TARGET CORPUS [CASES [SEED]] */
#include "guided.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 1 << 16 };

static uint64_t state;
static uint64_t draw(uint64_t below) { /* Marsaglia's xorshift */
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state % below;
}

static const char *const hostile[] = {
    "nan",   "-1",     "1e308", "99999999999999999999", "2147483648", "", "\xff\xfe", "%s%n", "====", "\t", "\n",
    "0x1p3", "1e-320", "\""};

/* One damage: a bit, a hostile word, or a range that is cut out or repeated. Returns the new size. */
static size_t damage(uint8_t *data, size_t size) {
    const size_t at = (size_t)draw(size + 1), span = (size_t)draw(1 + (size - at < 64 ? size - at : 64));
    const char *word = hostile[draw(sizeof hostile / sizeof *hostile)];
    const size_t length = strlen(word);
    switch (draw(4)) {
    case 0:
        if (at < size)
            data[at] ^= (uint8_t)(1u << draw(8));
        return size;
    case 1:
        if (size - span + length >= MOST)
            return size;
        memmove(data + at + length, data + at + span, size - at - span);
        memcpy(data + at, word, length);
        return size - span + length;
    case 2: memmove(data + at, data + at + span, size - at - span); return size - span;
    default:
        if (size + span >= MOST)
            return size;
        memmove(data + at + span, data + at, size - at);
        return size + span;
    }
}

static size_t read_input(const char *folder, const char *name, uint8_t *data) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    must(file != NULL);
    const size_t size = fread(data, 1, MOST - 1, file);
    must(feof(file));
    fclose(file);
    return size;
}

/* The input is copied to memory of its exact size, so that valgrind and the sanitizers see what reads beyond it. */
static void run(const uint8_t *data, size_t size) {
    uint8_t *exact = malloc(size > 0 ? size : 1);
    must(exact != NULL);
    memcpy(exact, data, size);
    must(LLVMFuzzerTestOneInput(exact, size) == 0);
    free(exact);
}

static int64_t replay(const char *folder, const char *name, int64_t cases) {
    static uint8_t data[MOST], copy[MOST];
    const size_t size = read_input(folder, name, data);
    run(data, size);
    for (int64_t k = 0; k < cases; k++) {
        size_t now = size;
        memcpy(copy, data, size);
        for (uint64_t times = 1 + draw(4); times > 0; times--)
            now = damage(copy, now);
        run(copy, now);
    }
    return cases + 1;
}

int main(int count, char **words) {
    must(count >= 2);
    const int64_t cases = count > 2 ? atoll(words[2]) : 0;
    state = count > 3 ? strtoull(words[3], NULL, 10) : 20050201;
    struct dirent **entry;
    const int files = scandir(words[1], &entry, NULL, alphasort);
    int64_t done = 0, used = 0;
    must(files > 2 && state != 0);
    LLVMFuzzerInitialize(&count, &words);
    for (int k = 0; k < files; k++)
        if (entry[k]->d_name[0] != '.') {
            done += replay(words[1], entry[k]->d_name, cases / (files - 2));
            used++;
        }
    for (int k = 0; k < files; k++)
        free(entry[k]);
    free(entry);
    printf("%lld inputs of the corpus, %lld in all\n", (long long)used, (long long)done);
    return used > 0 ? 0 : 1;
}
