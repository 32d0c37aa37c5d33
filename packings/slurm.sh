#!/bin/bash
# A study as a Slurm array: every task makes its share of the samples, all in one store.
#
#   sbatch packings/slurm.sh my.cfg store
#   sbatch --array=1-64 --time=12:00:00 packings/slurm.sh my.cfg store
#
# The store is a folder that all nodes share. Tasks may run in any order, at any time, and again: nothing that is in the
# store is made twice. The first command below waits for the array and writes the tables (--force replaces older ones);
# the second runs the same study as one MPI job:
#
#   sbatch --dependency=afterok:ARRAY_JOB_ID \
#     --wrap 'sonopack study my.cfg --store store --jobs 1 -o tables.tsv --force'
#   sbatch --ntasks=64 --wrap 'mpirun sonopack study my.cfg --store store -o tables.tsv --force'
#
# Adapt the lines marked with <--, or give these options to sbatch. docs/cluster.md says how to choose them.

#SBATCH --job-name=sonopack
#SBATCH --array=1-16             # <-- tasks
#SBATCH --cpus-per-task=1        # <-- samples in progress in a task at the same time
#SBATCH --mem-per-cpu=1G         # <-- enough for samples of 10 000 grains
#SBATCH --time=04:00:00          # <-- more than the longest sample takes; then the task is queued again and continues
#SBATCH --signal=B:USR1@120      # how the task is told, in seconds before
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=sonopack-%A_%a.log

if [ $# -ne 2 ]; then
    echo "usage: sbatch [OPTIONS] slurm.sh SCENE STORE, as in: sbatch --array=1-16 slurm.sh my.cfg store" >&2
    exit 2
fi
scene=$1 store=$2
sonopack=${SONOPACK:-sonopack}   # <-- the command, where it is not in PATH
most_restarts=50

# The task's shard from its place in the array: 0-15 and 1-31:2 are as good as 1-16. An array with holes, as of some
# tasks again (--array=3,7,8), is not cut into shards: its tasks take what is missing, one sample after the other.
id=${SLURM_ARRAY_TASK_ID:-1} first=${SLURM_ARRAY_TASK_MIN:-1} last=${SLURM_ARRAY_TASK_MAX:-1}
tasks=${SLURM_ARRAY_TASK_COUNT:-1} step=${SLURM_ARRAY_TASK_STEP:-1}
shard=()
if [ "$tasks" -gt 1 ] && [ $(((last - first) / step + 1)) -eq "$tasks" ]; then
    shard=(--shard "$(((id - first) / step + 1))/$tasks")
fi

# bash hears signals while it waits for a command in the background, and not for one in the foreground.
restart=no heard=no
stop() {
    heard=yes
    kill -TERM "$study" 2>/dev/null # finishes no sample, and loses none that is finished
}
trap 'restart=yes; stop' USR1 # the time is nearly over
trap stop TERM INT            # scancel

export OPENBLAS_NUM_THREADS=1
echo "$(date '+%F %T') $(hostname): sonopack study $scene --store $store ${shard[*]}"
"$sonopack" study "$scene" --store "$store" "${shard[@]}" --jobs "${SLURM_CPUS_PER_TASK:-1}" -v >/dev/null &
study=$!
while # a signal ends the wait, but not yet the study
    heard=no
    wait "$study"
    status=$?
    [ "$heard" = yes ]
do :; done
if [ "$restart" = yes ] && [ "$status" -ne 0 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "$most_restarts" ]; then
    scontrol requeue "${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}"
fi
exit "$status"
