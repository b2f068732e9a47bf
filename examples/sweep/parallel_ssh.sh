#!/bin/bash
# Flies a packed sweep on several machines by GNU parallel over ssh, and merges the results.
#
#   sinew sweep robots/quad/quad.toml --seeds 1..1000 --pack sweep
#   parallel_ssh.sh sweep /var/tmp/sweep 20 all.jsonl alice@node0 alice@node1
#
# Arguments: folder of --pack, the place of its copy on each machine, number of parts, the merged file, machines. A part
# whose machine fails is flown again on another one; parts that a machine has already are not flown there again.
# PARALLEL_SSH: another command than ssh, with its options.
set -eu
folder=$1 there=$2 parts=$3 merged=$4
shift 4
read -ra ssh <<<"${PARALLEL_SSH:-ssh}"
export PARALLEL_SSH="${ssh[*]}"
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

for host in "$@"; do
  tar -C "$folder" -cf - . | "${ssh[@]}" "$host" "mkdir -p '$there/results' && tar -C '$there' -xf -"
done
# Exit code 1: some runs were not good, which is a result.
logins=$(IFS=, && echo "$*")
seq "$parts" | parallel --will-cite --sshlogin "$logins" --jobs 1 --retries 3 \
  "'$there/run' --jobs \$(nproc) --shard {}/$parts --results '$there/results/{}.jsonl' || test \$? -eq 1"
for host in "$@"; do
  mkdir "$results/$host"
  "${ssh[@]}" "$host" "tar -C '$there/results' -cf - ." | tar -C "$results/$host" -xf -
done
"$folder/run" merge "$results"/*/*.jsonl --into "$merged" || test $? -eq 1
