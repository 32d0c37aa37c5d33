/* Writes the input script of LAMMPS: our contact law, our piston, our protocol. */
#include "base/base.h"
#include "base/file.h"
#include "foreign/engine.h"

#include <sonopack/version.h>
#include <stdio.h>
#include <sys/stat.h>

const char *const sp_engine_names[SP_ENGINE_FILES] = {"gas.data",   "in.pack",     "scene.cfg",     "printed.txt",
                                                      "log.lammps", "grains.dump", "contacts.dump", "result.txt"};

sp_status sp_engine_path(const char *folder, sp_engine_file file, char *out, sp_error *err) {
    const int length = snprintf(out, SP_PATH_MAX, "%s/%s", folder, sp_engine_names[file]);
    return length > 0 && length < SP_PATH_MAX
               ? SP_OK
               : sp_fail(err, SP_EINVAL, "the name of the folder has %d bytes, must have fewer", length);
}

sp_status sp_engine_look(const char *folder, sp_engine_file file, char *out, sp_error *err) {
    struct stat info;
    sp_status status = sp_engine_path(folder, file, out, err);
    if (status == SP_OK && stat(out, &info) == 0 && !S_ISREG(info.st_mode))
        return sp_fail(err, SP_EFORMAT, "%s: must be a regular file", out);
    return status;
}

/* "name = value" as LAMMPS' variable. */
static void set(sp_text *t, const char *name, double value) {
    sp_text_add(t, "variable    %-10s equal ", name);
    sp_text_number(t, value);
    sp_text_add(t, "\n");
}

static void add_numbers(sp_text *t, const sp_engine_deck *d) {
    set(t, "p", d->pressure);
    set(t, "step", d->step);
    set(t, "calm", d->calm);
    set(t, "rest", d->rest);
    set(t, "drag", d->drag);
    set(t, "piston", d->piston_mass);
    sp_text_add(t, "variable    most       equal %lld\n\n", (long long)d->steps);
}

static void add_box(sp_text *t, const sp_engine_deck *d) {
    const bool flat = d->dim == 2;
    sp_text_add(t,
                "units       lj\n"
                "dimension   %d\n"
                "boundary    %s\n"
                "# columns as high as the box: each rank has its share of the grains before and after compaction\n"
                "processors  %s\n"
                "newton      off\n"
                "atom_style  sphere\n"
                "comm_modify vel yes\n"
                "read_data   %s\n"
                "group       grain type 1\n"
                "group       piston type 2\n"
                "neighbor    ",
                d->dim, flat ? "p f p" : "p p f", flat ? "* 1 1" : "* * 1", sp_engine_names[SP_ENGINE_GAS]);
    sp_text_number(t, d->skin);
    sp_text_add(t, " bin\nneigh_modify delay 0 every 1 check yes exclude group piston all\n\n");
}

/* ---- contact law ------------------------------------------------------------------------------------------------ */

/* Springs with Coulomb's law, and normal viscosity. */
static void add_springs(sp_text *t, const sp_engine_deck *d, double factor) {
    sp_text_add(t, "hertz ");
    sp_text_number(t, factor * d->kn);
    sp_text_add(t, " ");
    sp_text_number(t, d->restitution);
    if (!(d->friction > 0)) {
        sp_text_add(t, " tangential linear_nohistory 0 0 damping tsuji limit_damping");
        return;
    }
    sp_text_add(t, " tangential mindlin/force ");
    sp_text_number(t, factor * d->kt);
    sp_text_add(t, " ");
    sp_text_number(t, d->free_viscosity ? 0 : d->tangential_damping);
    sp_text_add(t, " ");
    sp_text_number(t, d->friction);
    sp_text_add(t, " damping tsuji limit_damping");
}

/* Tangential viscosity alone, of springs without weight. */
static void add_viscosity(sp_text *t, const sp_engine_deck *d, double factor) {
    sp_text_add(t, "hertz ");
    sp_text_number(t, factor * d->weak_kn);
    sp_text_add(t, " ");
    sp_text_number(t, d->weak_restitution);
    sp_text_add(t, " tangential linear_nohistory ");
    sp_text_number(t, d->weak_damping);
    sp_text_add(t, " 1e15 damping tsuji");
}

static void add_law(sp_text *t, const sp_engine_deck *d) {
    sp_text_add(
        t,
        "# Hertz's and Mindlin's forces with E* = 1: spring, `restitution' that sets the damping, tangential spring,\n"
        "# viscosity and friction. A wall is rigid and flat: twice as stiff.\n");
    sp_text_add(t, "variable    law       string \"");
    add_springs(t, d, 1);
    sp_text_add(t, "\"\nvariable    wall      string \"");
    add_springs(t, d, 2);
    sp_text_add(t, "\"\n");
    if (!d->free_viscosity) {
        sp_text_add(t, "pair_style  granular\npair_coeff  * * ${law}\n\n");
        return;
    }
    sp_text_add(
        t, "# Coulomb's law limits the springs, not the viscous forces: these come from contacts of their own, whose\n"
           "# springs are 1e8 times weaker and whose friction is endless.\n"
           "variable    law_v     string \"");
    add_viscosity(t, d, 1);
    sp_text_add(t, "\"\nvariable    wall_v    string \"");
    add_viscosity(t, d, 2);
    sp_text_add(t, "\"\npair_style  hybrid/overlay granular granular\n"
                   "pair_coeff  * * granular 1 ${law_v}\n"
                   "pair_coeff  * * granular 2 ${law}\n\n");
}

/* ---- walls ------------------------------------------------------------------------------------------------------ */

static void add_walls(sp_text *t, const sp_engine_deck *d) {
    const char up = d->dim == 2 ? 'y' : 'z', *const move = d->dim == 2 ? "NULL v_top NULL" : "NULL NULL v_top";
    const char *const plane = d->dim == 2 ? "0 0 0 0 -1 0" : "0 0 0 0 0 -1";
    const int column = d->dim == 2 ? 3 : 4;
    const bool twice = d->free_viscosity;
    sp_text_add(t,
                "# An atom, which touches nothing, has the mass of the upper wall: the wall is where the atom is. The "
                "load pushes\n"
                "# it down and the grains push it up.\n"
                "variable    top equal xcm(piston,%c)\n"
                "region      above plane %s side in move %s units box\n"
                "fix         floor grain wall/gran granular ${wall} %cplane 0 NULL contacts\n"
                "fix         roof grain wall/gran/region granular ${wall} region above contacts\n"
                "compute     roof grain reduce sum f_roof[%d]\n",
                up, plane, move, up, column);
    if (twice)
        sp_text_add(t,
                    "fix         floor_v grain wall/gran granular ${wall_v} %cplane 0 NULL\n"
                    "fix         roof_v grain wall/gran/region granular ${wall_v} region above contacts\n"
                    "compute     roof_v grain reduce sum f_roof_v[%d]\n",
                    up, column);
    sp_text_add(t,
                "variable    load equal v_p*lx%s\n"
                "variable    push equal -v_load-c_roof%s\n"
                "fix         push piston addforce %s\n"
                "fix         move_grains grain nve/sphere\n"
                "fix         move_piston piston nve\n%s\n",
                d->dim == 2 ? "" : "*ly", twice ? "-c_roof_v" : "", d->dim == 2 ? "0 v_push 0" : "0 0 v_push",
                d->dim == 2 ? "fix         flat all enforce2d\n" : "");
}

/* ---- runs ------------------------------------------------------------------------------------------------------- */

/* Largest acceleration, angular ones times R included. A piston on its way down is not at rest, however heavy it is. */
static void add_measures(sp_text *t, const sp_engine_deck *d) {
    const bool turns = d->friction > 0;
    if (turns)
        sp_text_add(t, "compute     spin all property/atom radius tqx tqy tqz\n");
    sp_text_add(t, "variable    a atom sqrt(fx^2+fy^2+fz^2)/mass\n"
                   "compute     a all reduce max v_a\n");
    if (turns)
        sp_text_add(t, "variable    turn atom 2.5*sqrt(c_spin[2]^2+c_spin[3]^2+c_spin[4]^2)/(mass*c_spin[1])\n"
                       "compute     turn grain reduce max v_turn\n");
    sp_text_add(t,
                "variable    largest equal c_a%s\n"
                "variable    moving equal v_largest+(abs(v_push)>0.5*v_load)\n"
                "thermo      1000\n"
                "thermo_style custom step v_largest v_top\n"
                "thermo_modify lost error norm no flush yes format float %%.10g\n\n",
                turns ? "+c_turn" : "");
}

/* The second run continues the first without a setup, in which wall/gran/region of 29 Sep 2021 forgets how the wall
 * moves. The drag acts on every third step, so that the largest acceleration is free of it on most of the steps that
 * look for rest. */
static void add_runs(sp_text *t, const sp_engine_deck *d) {
    sp_text_add(
        t,
        "variable    dragged equal 0\n"
        "variable    rate equal v_dragged*v_drag\n"
        "variable    drag_x atom -3*v_rate*mass*vx\n"
        "variable    drag_y atom -3*v_rate*mass*vy\n"
        "variable    drag_z atom -3*v_rate*mass*vz\n"
        "fix         drag grain addforce v_drag_x v_drag_y v_drag_z every 3\n"
        "variable    drag_p equal -v_rate*v_piston*vcm(piston,%c)\n"
        "fix         drag_p piston addforce %s\n"
        "variable    end equal v_moving/v_calm\n"
        "fix         end all halt 200 v_end < 1 error continue\n"
        "timestep    ${step}\n"
        "run         ${most}\n"
        "# The grains are calm: from here on with a global damping. What moves at the end comes to rest in sonopack.\n"
        "variable    dragged equal 1\n"
        "variable    end equal v_moving/v_rest\n"
        "run         ${most} pre no\n"
        "unfix       end\n\n",
        d->dim == 2 ? 'y' : 'z', d->dim == 2 ? "0 v_drag_p 0" : "0 0 v_drag_p");
}

/* Forces without their viscous parts, which dumps would contain. Of two laws, the numbers of the second follow the
 * twelve of the first. */
static void add_output(sp_text *t, const sp_engine_deck *d) {
    sp_text_add(t,
                "velocity    all set 0 0 0\n"
                "set         group grain omega 0 0 0\n"
                "compute     sp_id all property/local patom1 patom2\n"
                "compute     sp_contact all pair/local dist force %s\n"
                "dump        grains all custom 1 %s id type x y z radius mass f_floor[1] f_floor[2] f_floor[3] &\n"
                "            f_floor[4] f_floor[5] f_floor[6] f_floor[7] f_roof[1] f_roof[2] f_roof[3] f_roof[4] &\n"
                "            f_roof[5] f_roof[6] f_roof[7]\n"
                "dump        contacts all local 1 %s index c_sp_id[1] c_sp_id[2] c_sp_contact[1] c_sp_contact[2] &\n"
                "            c_sp_contact[3] c_sp_contact[4] c_sp_contact[5]\n"
                "dump_modify grains format float %%.17g sort id\n"
                "dump_modify contacts format float %%.17g\n"
                "run         0 post no\n"
                "undump      grains\n"
                "undump      contacts\n"
                "print       \"steps $(step) acceleration $(v_largest:%%.10g) top "
                "$(v_top:%%.17g)\" &\n"
                "            file %s screen no\n"
                "quit\n",
                d->free_viscosity ? "p13 p14 p15" : "p1 p2 p3", sp_engine_names[SP_ENGINE_GRAINS],
                sp_engine_names[SP_ENGINE_CONTACTS], sp_engine_names[SP_ENGINE_RESULT]);
}

void sp_engine_add_deck(sp_text *t, const sp_engine_deck *d) {
    sp_text_add(t,
                "# %d grains in %d dimensions, compressed by a piston: written by sonopack %s for LAMMPS of 29 Sep "
                "2021 or later\n"
                "# with its package GRANULAR. Lengths in mean diameters, density and E* of the grains 1.\n"
                "#   lmp -nocite -in %s          or      mpirun -n N lmp -nocite -in %s\n",
                d->grains, d->dim, sp_version(), sp_engine_names[SP_ENGINE_INPUT], sp_engine_names[SP_ENGINE_INPUT]);
    add_numbers(t, d);
    add_box(t, d);
    add_law(t, d);
    add_walls(t, d);
    add_measures(t, d);
    add_runs(t, d);
    add_output(t, d);
}
