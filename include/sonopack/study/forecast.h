#ifndef SONOPACK_FORECAST_H
#define SONOPACK_FORECAST_H
/* What a study will take before it is made: samples that are there and that are missing, and the cost of those. */

#include <sonopack/cost.h>
#include <sonopack/study/study.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { SP_FORECAST_PARTS = 9 };

/* Some of the work: packings first, then the parts of the results that are wanted. */
typedef struct sp_forecast_part {
    const char *what; /* NULL: not wanted */
    int64_t count;    /* samples */
    sp_cost cost;     /* of all of them; cpu and wall are those of one job */
    double bytes;     /* added to the store */
} sp_forecast_part;

typedef struct sp_forecast {
    int64_t samples, stored, failed; /* in the study; complete, or recorded as failed */
    int64_t looked;                  /* samples that were looked for; the others are taken to be like them */
    sp_forecast_part part[SP_FORECAST_PARTS];
    double longest; /* CPU time of the longest sample [s] */
} sp_forecast;

/* Looks for the samples of a study (sink NULL: there are none) and adds up what the missing ones take. `packed` tells
 * whether the packing of a sample is there already (NULL: none is). Looks for a part of very many samples only. Writes
 * nothing. SP_EINVAL for a combination that is no valid scene, SP_ENOMEM. */
SP_API sp_status sp_study_expect(const sp_scene *study, const sp_study_options *opt, const sp_study_sink *sink,
                                 bool (*packed)(void *user, const char *name), void *user, const sp_machine *machine,
                                 sp_forecast *out, sp_error *err);
/* CPU time [s] of a complete sample of a scene that is resolved (sp_scene_resolve). */
SP_API double sp_sample_expect(const sp_scene *scene, const sp_machine *machine);

#ifdef __cplusplus
}
#endif
#endif
