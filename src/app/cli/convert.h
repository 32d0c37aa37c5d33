#ifndef SP_CLI_CONVERT_H
#define SP_CLI_CONVERT_H
/* What cmd_convert and its reading of other programs' files share. */
#include "cli/convert_out.h"

#include <sonopack/study/import.h>

#define CONVERT_FORMS "auto|lammps-data|lammps-dump|liggghts|yade|mercury|xyz|csv|photoelastic"

typedef struct convert_arguments {
    cli_common common;
    const char *grains, *contacts; /* the two tables; NULL: none */
    const char *in, *out;          /* packing files as given; NULL: none */
    /* of other programs' files */
    int from; /* an sp_form */
    const char *walls, *columns, *types;
    int64_t frame;
    double length_unit, force_unit, mass_unit, kn, kt_ratio, thickness;
    bool rest;
    convert_out to;
    const char *ending; /* the form of OUT; NULL: unknown */
} convert_arguments;

/* Reads --material. Without d= its diameter is 0: that of the file. */
sp_status convert_set_material(void *arguments, const char *text, sp_error *err);
/* Whether IN is a file of another program: --from says so, or its content. */
sp_status convert_is_foreign(const convert_arguments *a, bool *foreign, sp_error *err);
/* Refuses options of other programs' files where IN is none. */
sp_status convert_refuse_options(const convert_arguments *a, const cli_syntax *syntax, sp_error *err);
/* Takes IN and OUT from the command line. `contacts` stays as it was given. */
sp_status convert_take_files(convert_arguments *a, sp_error *err);
/* Gives a packing of ours the material of --material, if that is given. */
sp_status convert_give_material(const convert_arguments *a, sp_packing *p, sp_error *err);
/* Reads IN, and prints what there is to say about it. */
sp_status convert_import(const convert_arguments *a, const cli_syntax *syntax, sp_packing *p, sp_error *err);

#endif
