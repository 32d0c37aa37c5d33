#ifndef SONOPACK_SCENE_H
#define SONOPACK_SCENE_H
/* A scene: what the user describes and wants, checked. Files in libconfig syntax; one field table gives name, unit,
 * range, default and meaning to the parser, to `sonopack help scene` and to the stored copy. */

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

/* Bits of sp_scene.want. */
enum {
    SP_WANT_CTOF = 1,      /* first front of each sample, hence c_tof */
    SP_WANT_STATICS = 2,   /* Table I */
    SP_WANT_MODULI = 4,    /* Table II */
    SP_WANT_SIGNAL = 8,    /* the signal itself is stored */
    SP_WANT_PROBES = 16,   /* Tables IV and V; Table II is made with them */
    SP_WANT_PLANES = 32,   /* fronts at horizontal planes inside of each sample */
    SP_WANT_SCALING = 64,  /* the fronts of SP_WANT_CTOF, as a table over distance: no part of its own */
    SP_WANT_SPECTRUM = 128 /* every frequency of each sample's network, hence the density of states */
};

/* One swept key: study runs every combination of the values of all sweeps. */
typedef struct sp_sweep {
    char key[64];
    int count;
    double *values;  /* numbers, words as the codes of their enum, booleans as 0 and 1, or lists one after the other */
    int32_t *begin;  /* of lists: list k is values[begin[k]] .. values[begin[k + 1] - 1]; NULL: a value each */
    bool overridden; /* an override gave the key a value too, which no sample of the study would have */
} sp_sweep;

enum { SP_SWEEPS_MAX = 8, SP_FROM_MAX = 1024, SP_PLANES_MAX = 32 };

typedef struct sp_scene {
    sp_pack_spec pack;
    double height; /* packing.height: aimed-at height [d], from which sp_scene_resolve finds pack.grains; 0: none */
    sp_network_options network;
    sp_signal_options signal; /* until = 0: the window of sp_signal_window() */
    int32_t samples;          /* study.samples: seeds pack.seed .. pack.seed + samples - 1 a combination */
    unsigned want;            /* study.want */
    int32_t planes;           /* signal.planes: heights of planes above the bottom wall [d], ascending */
    double plane[SP_PLANES_MAX];
    int sweeps;
    sp_sweep sweep[SP_SWEEPS_MAX]; /* those of study.sweep, then keys that were given lists or ranges */
    bool dimension_given;          /* else packing.dimension is that of a swept packing.kind */
    double *diameters;             /* of a list, where this scene owns it: pack.diameters points there */
    double *history;               /* likewise */
    sp_tapped_spec tapped;         /* no packing, and no sample of a study, depends on it */
    double *masses, *radii;        /* of lists, where this scene owns them: column.mass and column.radius point there */
    char from[SP_FROM_MAX]; /* packing.file, from the current folder; "": none. Whoever makes packings of it reads it */
} sp_scene;

SP_API sp_scene sp_scene_default(void);
SP_API void sp_scene_free(sp_scene *s);

/* Reads a scene file, then applies overrides "key=value" (as --set gives them), then checks every value and the
 * combination (sp_pack_spec_check). path may be NULL (defaults and overrides only).
 * Errors name file, line, key, value and range; unknown keys are errors with the nearest known name.
 * SP_EINVAL for every wrong scene, a missing or unreadable file included. */
SP_API sp_status sp_scene_read(const char *path, int overrides, char *const *override, sp_scene *out, sp_error *err);
/* The same for the tapped column: the column is checked (sp_tapped_check), and no packing. */
SP_API sp_status sp_scene_read_tapped(const char *path, int overrides, char *const *override, sp_scene *out,
                                      sp_error *err);
/* sp_scene_read from text; name stands for the file in messages. */
SP_API sp_status sp_scene_parse(const char *text, const char *name, int overrides, char *const *override, sp_scene *out,
                                sp_error *err);
/* SP_EINVAL if an override is hidden by a sweep of the same key: for what makes all samples of a scene. One packing
 * (`sonopack pack') takes the override and no sweep. */
SP_API sp_status sp_scene_check_sweeps(const sp_scene *s, sp_error *err);
/* Puts the number of grains that packing.height asks for into the pack spec, and 0 into the height: what one sample is
 * made of. Of a study's samples sp_study_scene does so. */
SP_API sp_status sp_scene_resolve(sp_scene *s, sp_error *err);
/* Sets one numeric key (used by sweeps), checked against its range. Of packing.grains and packing.height the one that
 * is set last decides. */
SP_API sp_status sp_scene_set(sp_scene *s, const char *key, double value, sp_error *err);
/* A numeric key's value; NAN for an unknown key. */
SP_API double sp_scene_get(const sp_scene *s, const char *key);
/* Value k of a sweep, checked against the key's range. Lists stay the sweep's, which must outlive the scene. Of
 * packing.grains and packing.height the one that is set last decides. */
SP_API sp_status sp_scene_set_swept(sp_scene *s, const sp_sweep *sweep, int k, sp_error *err);
/* Value k of a sweep for readers: numbers at full precision, words without quotes, lists in [], true and false; cut
 * where size is too small. Returns buf, empty where there is no such key or value. */
SP_API const char *sp_sweep_text(const sp_sweep *sweep, int k, char *buf, size_t size);

/* Every key of group ("packing", "network", "signal", "study", "column", or NULL for all but "column", of which no
 * sample is made) with its value at full precision, in the syntax of a scene file: reading it back gives the same
 * values bit for bit. Caller frees. NULL: no memory. */
SP_API char *sp_scene_text(const sp_scene *s, const char *group);
/* The field table as text for `sonopack help scene`. Caller frees. */
SP_API char *sp_scene_help(void);

#ifdef __cplusplus
}
#endif
#endif
