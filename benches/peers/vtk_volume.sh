#!/bin/sh
# Runs our volume bench and VTK's CPU ray caster on the same volume, transfer function, steps, light and moving
# camera in turn, and prints one CSV row for each run. Both use two threads; each run is a process of its own.
#
#   benches/peers/vtk_volume.sh PEER.py VOLUME [ROUNDS [FRAMES]] > volume-peer.csv
#
# PEER.py  draws 36 Gaussians in 256 x 256 x 256 voxels with vtkFixedPointVolumeRayCastMapper at 1024 x 1024: called as
#          `python3 PEER.py fixed uint16 THREADS FRAMES`, it prints `median … ms wall, … ms cpu`. It needs numpy
#          and vtk, and a folder of its own that can be written. PYTHON names another interpreter.
# VOLUME   our bench: the file that `cargo bench --bench volume --no-run` names.
set -eu
if [ $# -lt 2 ] || [ $# -gt 4 ]; then
    sed -n '2,12s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
peer=$1 volume=$2 rounds=${3:-5} frames=${4:-9} python=${PYTHON:-python3}

row() {
    if [ -z "$3" ] || [ -z "$4" ]; then
        echo "vtk_volume.sh: no times in what $2 printed" >&2
        exit 1
    fi
    echo "$1,$2,2,$frames,$3,$4"
}

# ours FLAG: the median time of a frame [ms].
ours() {
    RAYON_NUM_THREADS=2 "$volume" --frames "$frames" --only blobs --ways drawn "$@" | tail -n 1 | cut -d , -f 7
}

echo "round,renderer,threads,frames,wall_ms_median,cpu_ms_median"
round=1
while [ "$round" -le "$rounds" ]; do
    out=$("$python" "$peer" fixed uint16 2 "$frames" 2>/dev/null)
    wall=$(printf '%s\n' "$out" | sed -n 's/.*median \([0-9.]*\) ms wall.*/\1/p')
    cpu=$(printf '%s\n' "$out" | sed -n 's/.*wall, \([0-9.]*\) ms cpu.*/\1/p')
    row "$round" vtk "$wall" "$cpu"
    row "$round" foveasim "$(ours)" "$(ours --cpu-time)"
    round=$((round + 1))
done
