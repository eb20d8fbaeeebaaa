#!/bin/sh
# All speeds that a change of this package may move, in one go: benchmarks/all_idle.sh [BEFORE] | tee speeds.txt
#
# BEFORE is a checkout of an older state, measured in turn with this one. By estimate it takes 8 minutes on
# two idle cores, with BEFORE 20, and a few more where scenes are not in the model cache yet. QUICK=1 does little
# of each, to see that all of it runs. Needs the package's Python as PYTHON (by default .venv/bin/python here).
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
python=${PYTHON:-$here/.venv/bin/python}
before=${1:-}
[ -z "$before" ] || before=$(cd "$before" && pwd)
if [ -n "${QUICK:-}" ]; then
  trials=4 many=2 scenes=1 rounds=1 repeats=1 steps=6 predictors=oracle,antipodal records=100
else
  trials=180 many=180 scenes=50 rounds=3 repeats=10 steps=10 records="1000 10000 100000"
  predictors=htc-grasp,htc-grasp-1000,htc-grasp-no-ea,htc-grasp-no-ca,gg-cnn,gg-cnn2,gr-convnet,gr-convnet-16,antipodal,centroid,random,oracle
fi
# As an installed package has it: byte code is written once. Folders and caches of the trees stay as they are.
unset PYTHONDONTWRITEBYTECODE
PYTHONPYCACHEPREFIX=$(mktemp -d)
export PYTHONPYCACHEPREFIX
trap 'rm -rf "$PYTHONPYCACHEPREFIX"' EXIT
cd "$here/benchmarks"

part() { # TITLE TREE SCRIPT ARGUMENTS…: a script of this checkout with the package of a tree
  printf '\n## %s (%s, load %s)\n' "$1" "$2" "$(cut -d' ' -f1 /proc/loadavg)"
  PYTHONPATH=$2 "$python" "$here/benchmarks/$3" $4 || echo "failed: $3 $4 with $2"
}

date
for tree in $before "$here"; do
  part "180 trials, trials a second, phases" "$tree" wall_time.py "--trials $trials"
done
part "Physics of the busy time" "$here" physics_share.py "--trials $((trials < 18 ? trials : 18))"
for workers in 1 2; do
  part "First trial recorded, $workers workers" "$here" start_up.py \
    "$before $here --workers $workers --repeats $repeats"
done
part "Scenes of training data" "$here" synth.py \
  "--scenes $scenes --rounds $rounds --workers 2 ${before:+--before $before}"
part "Training" "$here" training.py "htc-grasp gr-convnet --steps $steps"
part "12 predictors on the same trials" "$here" bench_table.py \
  "$before $here --trials $many --predictors $predictors"
part "Latency of networks" "$here" latency.py \
  "--repeats $repeats --predictor htc-grasp --predictor gr-convnet --predictor tf-grasp"
part "Workers, Ray, large runs" "$here" scaling.py "--trials $((trials < 120 ? trials : 120)) --records $records"
date
