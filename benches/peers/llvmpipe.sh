#!/bin/sh
# Runs our raster bench and a peer's renderer of the same scene in turn, and prints one CSV row for each
# run. Both use two threads; each run is a process of its own.
#
#   benches/peers/llvmpipe.sh PEER.py RASTER [ROUNDS [FRAMES]] > raster.csv
#
# PEER.py  draws the scene with Mesa's llvmpipe: called as `python3 PEER.py FRAMES`, it reads
#          LP_NUM_THREADS and CULL from its environment and prints `median=… ms min=… ms`. It needs
#          python3 with numpy and moderngl, and a Mesa with EGL.
# RASTER   our bench: the file that `cargo bench --bench raster --no-run` names.
set -eu
if [ $# -lt 2 ] || [ $# -gt 4 ]; then
    sed -n '2,10s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
peer=$1 raster=$2 rounds=${3:-5} frames=${4:-15}

# number NAME: what stands after NAME in the output of a run.
number() {
    sed -n "s/.*[ ]$1[ =]\([0-9][0-9.]*\).*/\1/p" | head -n 1
}

row() {
    median=$(printf '%s\n' "$4" | number median)
    least=$(printf '%s\n' "$4" | number "$5")
    if [ -z "$median" ] || [ -z "$least" ]; then
        echo "llvmpipe.sh: no times in what $2 printed: $4" >&2
        exit 1
    fi
    echo "$1,$2,$3,2,$frames,$median,$least"
}

echo "round,renderer,back_face_culling,threads,frames,wall_ms_median,wall_ms_least"
round=1
while [ "$round" -le "$rounds" ]; do
    out=$(LP_NUM_THREADS=2 CULL=1 python3 "$peer" "$frames")
    row "$round" llvmpipe yes "$out" min
    out=$(RAYON_NUM_THREADS=2 "$raster" --frames "$frames" 2>&1)
    row "$round" foveasim yes "$out" least
    out=$(LP_NUM_THREADS=2 python3 "$peer" "$frames")
    row "$round" llvmpipe no "$out" min
    out=$(RAYON_NUM_THREADS=2 "$raster" --frames "$frames" --both-faces 2>&1)
    row "$round" foveasim no "$out" least
    round=$((round + 1))
done
