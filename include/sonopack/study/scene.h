#ifndef SONOPACK_SCENE_H
#define SONOPACK_SCENE_H
/* A scene is the user's description of packings, signals and studies: a file in the syntax of libconfig. One table of
 * keys serves the parser, `sonopack help scene`, and the copy of the scene in each result. */

#include <sonopack/packing.h>
#include <sonopack/signal.h>
#include <sonopack/status.h>
#include <sonopack/tapped/tapped.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Bits of sp_scene.want: the parts of a sample's results. */
enum {
    SP_WANT_CTOF = 1,      /* first front, from which c_tof follows */
    SP_WANT_STATICS = 2,   /* Table I */
    SP_WANT_MODULI = 4,    /* Table II */
    SP_WANT_SIGNAL = 8,    /* the signal itself */
    SP_WANT_PROBES = 16,   /* Tables IV and V; needs Table II */
    SP_WANT_PLANES = 32,   /* fronts at horizontal planes inside the packing */
    SP_WANT_SCALING = 64,  /* the fronts of SP_WANT_CTOF as a table over distance; no part of its own */
    SP_WANT_SPECTRUM = 128 /* every frequency of the network, from which the density of states follows */
};

/* A swept key. A study makes every combination of the values of all sweeps. */
typedef struct sp_sweep {
    char key[64];
    int count;
    double *values;  /* numbers; codes of words; 0 and 1 for booleans; or lists, one after the other */
    int32_t *begin;  /* list k is values[begin[k]] .. values[begin[k + 1] - 1]; NULL unless the values are lists */
    bool overridden; /* --set gave the key a single value, which no sample of the study would have */
} sp_sweep;

enum { SP_SWEEPS_MAX = 8, SP_FROM_MAX = 1024, SP_PLANES_MAX = 32, SP_LISTS_MAX = 24 };

typedef struct sp_scene {
    sp_pack_spec pack;
    double height;        /* packing.height [d], from which sp_scene_resolve finds pack.grains; 0: not given */
    sp_material material; /* the group material; young = 0: not known. No sample depends on it */
    sp_network_options network;
    sp_signal_options signal; /* until = 0 stands for sp_signal_window() */
    int32_t samples;          /* study.samples: each combination has the seeds pack.seed .. pack.seed + samples - 1 */
    unsigned want;            /* study.want: bits SP_WANT_ */
    int32_t planes;           /* how many planes */
    double plane[SP_PLANES_MAX]; /* signal.planes: their heights above the bottom wall [d], ascending */
    int sweeps;
    sp_sweep sweep[SP_SWEEPS_MAX]; /* first those of study.sweep, then keys that were given a list or a range */
    bool dimension_given;          /* if not, and packing.kind is swept, each kind has its own dimension */
    double *owned[SP_LISTS_MAX];   /* lists of numbers that belong to this scene, by the order of their keys. pack and
                                      tapped point to them. NULL: not owned */
    sp_tapped_spec tapped;         /* the group column: the tapped column, which has nothing to do with packings */
    char from[SP_FROM_MAX];        /* packing.file, relative to the current folder; "": none. The caller reads it */
} sp_scene;

SP_API sp_scene sp_scene_default(void);
SP_API void sp_scene_free(sp_scene *s);

/* Reads a scene file, applies the overrides "key=value" (those of --set), and checks all values and their combination
 * (sp_pack_spec_check). With path = NULL there are only defaults and overrides.
 *
 * Returns SP_EINVAL for every wrong scene, and for a file that is missing or cannot be read. The reason names file,
 * line, key, value and range; err->key is the key at fault. For an unknown key the reason suggests the most similar
 * one. */
SP_API sp_status sp_scene_read(const char *path, int overrides, char *const *override, sp_scene *out, sp_error *err);
/* The same for the tapped column: checks the group column (sp_tapped_check), and no packing. */
SP_API sp_status sp_scene_read_tapped(const char *path, int overrides, char *const *override, sp_scene *out,
                                      sp_error *err);
/* sp_scene_read from a text. name is what messages call the file. */
SP_API sp_status sp_scene_parse(const char *text, const char *name, int overrides, char *const *override, sp_scene *out,
                                sp_error *err);
/* SP_EINVAL if a sweep hides an override of the same key. To be called before a study is run; a single packing ignores
 * sweeps, and uses the override. */
SP_API sp_status sp_scene_check_sweeps(const sp_scene *s, sp_error *err);
/* Replaces packing.height by the number of grains that it stands for, as a single packing needs it. sp_study_scene does
 * this for the samples of a study. */
SP_API sp_status sp_scene_resolve(sp_scene *s, sp_error *err);
/* Sets a numeric key, checked against its range. Of packing.grains and packing.height, the one set last counts. */
SP_API sp_status sp_scene_set(sp_scene *s, const char *key, double value, sp_error *err);
/* Value of a numeric key; NAN for an unknown key. */
SP_API double sp_scene_get(const sp_scene *s, const char *key);
/* Sets a swept key to value k of its sweep, checked against its range. A list remains owned by the sweep, which must
 * outlive the scene. Of packing.grains and packing.height, the one set last counts. */
SP_API sp_status sp_scene_set_swept(sp_scene *s, const sp_sweep *sweep, int k, sp_error *err);
/* Writes value k of a sweep for readers: numbers with all their digits, words without quotes, lists in []. Truncates to
 * size. Returns buf, which is empty if there is no such key or value. */
SP_API const char *sp_sweep_text(const sp_sweep *sweep, int k, char *buf, size_t size);

/* All keys of a group ("packing", "material", "network", "signal", "study" or "column") as the text of a scene file;
 * with NULL all groups but "column", on which no sample depends, and "material" only if it is known. Reading the text
 * gives the same values, bit for bit. The caller frees it with sp_free. NULL: no memory. */
SP_API char *sp_scene_text(const sp_scene *s, const char *group);
/* The table of keys as text, for `sonopack help scene`. The caller frees it with sp_free. */
SP_API char *sp_scene_help(void);
/* Meaning, unit, range, default, source and an example of one key, "packing.friction", or of all keys of a name,
 * "friction", or group, "packing.types"; "" if there is none. The caller frees it with sp_free. NULL: no memory. */
SP_API char *sp_scene_help_key(const char *word);
/* The name of key k = 0, 1, ... of scenes, as "packing.kind"; NULL after the last. */
SP_API const char *sp_scene_key(int k);

#ifdef __cplusplus
}
#endif
#endif
