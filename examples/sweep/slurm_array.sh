#!/bin/bash
# Flies a packed sweep as a Slurm array job, a part of the sweep in each task. All nodes see both folders.
#
#   sinew sweep robots/quad/quad.toml --seeds 1..1000 --pack /shared/sweep
#   sbatch --array=0-9 slurm_array.sh /shared/sweep /shared/results 10
#   /shared/sweep/run merge /shared/results/*.jsonl --into all.jsonl          once the job has ended
#
# Arguments: folder of --pack, folder of results, number of parts. The number of parts is no matter of the job: parts that
# failed are submitted again with, say, --array=3,7. A task whose node is lost is queued again by Slurm; either goes on
# where its file of results ends.
#SBATCH --requeue
#SBATCH --open-mode=append
set -eu
folder=$1 results=$2 parts=$3
part=$((SLURM_ARRAY_TASK_ID + 1))
mkdir -p "$results"
code=0
"$folder/run" --shard "$part/$parts" --results "$results/$part.jsonl" --jobs "${SLURM_CPUS_PER_TASK:-1}" || code=$?
((code == 1)) || exit "$code" # 1: some runs were not good, which is a result
