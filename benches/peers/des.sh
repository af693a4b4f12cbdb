#!/bin/sh
# Runs the M/M/1 chain of our pipeline bench and of a peer in turn, and prints one CSV row for each run. One
# thread, a million events; each run is a process of its own.
#
#   benches/peers/des.sh PEER PIPELINE [ROUNDS] > des.csv
#
# PEER      a program that runs a producer, a queue, a server and a sink (mean times 1 and 0.8) as desru and as a bare
#           loop over a binary heap: called as `PEER JOBS REPETITIONS`, it prints one line for each with
#           its name and `… Mevents/s wall`. A job is two events.
# PIPELINE  our bench: the file that `cargo bench --bench pipeline --no-run` names. Its chains with all that
#           happens recorded are measured too.
set -eu
if [ $# -lt 2 ] || [ $# -gt 3 ]; then
    sed -n '2,12s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
peer=$1 pipeline=$2 rounds=${3:-5}

row() {
    if [ -z "$4" ]; then
        echo "des.sh: no rate in what $2 printed" >&2
        exit 1
    fi
    echo "$1,$2,$3,$4"
}

# peer_rate TEXT NAME: millions of events a second, wall clock.
peer_rate() {
    printf '%s\n' "$1" | sed -n "s/.*$2.*-> \([0-9.]*\) Mevents\/s wall.*/\1/p" | head -n 1
}

# our_rate NAME: the median that criterion prints.
our_rate() {
    "$pipeline" --bench --warm-up-time 0.5 --measurement-time 2 --sample-size 10 "^pipeline/$1\$" 2>/dev/null |
        sed -n 's/.*thrpt: *\[[0-9.]* [A-Za-z/]* \([0-9.]*\) Melem\/s.*/\1/p' | head -n 1
}

echo "round,engine,chain,million_events_per_s"
round=1
while [ "$round" -le "$rounds" ]; do
    out=$("$peer" 500000 5)
    row "$round" desru mm1 "$(peer_rate "$out" desru)"
    row "$round" foveasim mm1 "$(our_rate mm1_events)"
    row "$round" heap-loop mm1 "$(peer_rate "$out" 'BinaryHeap loop')"
    row "$round" foveasim recorded-vsync "$(our_rate recorded_events_vsync)"
    row "$round" foveasim recorded-xr "$(our_rate recorded_events_xr)"
    round=$((round + 1))
done
