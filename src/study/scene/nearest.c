/* Finds the known word that is most like an unknown one. */
#include "scene/field.h"

#include <limits.h>
#include <string.h>

enum { LETTERS = 64 };

static int smaller(int a, int b) { return a < b ? a : b; }

int sp_edit_distance(const char *a, const char *b) {
    const int na = (int)strnlen(a, LETTERS - 1), nb = (int)strnlen(b, LETTERS - 1);
    int row[3][LETTERS]; /* distances between prefixes: this row of the table, and the two before */
    for (int j = 0; j <= nb; j++)
        row[0][j] = j;
    for (int i = 1; i <= na; i++) {
        int *now = row[i % 3];
        const int *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= nb; j++) {
            int change = last[j - 1] + (a[i - 1] != b[j - 1]);
            now[j] = smaller(change, 1 + smaller(last[j], now[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = smaller(now[j], before[j - 2] + 1);
        }
    }
    return row[na % 3][nb];
}

bool sp_is_near(const char *word, int distance) {
    const int length = (int)strnlen(word, LETTERS);
    return distance < length && distance <= (length < 6 ? 2 : length / 3);
}

const char *sp_nearest_word(const char *word, int count, const char *const *words) {
    const char *nearest = NULL;
    for (int k = 0, least = INT_MAX; k < count; k++) {
        const int distance = sp_edit_distance(word, words[k]);
        if (distance < least && sp_is_near(word, distance)) {
            least = distance;
            nearest = words[k];
        }
    }
    return nearest;
}
