#!/bin/sh
# Usage: PYTHON=... driver.sh DIR. The contract of pk/run.h, on the models run_*.so there.
set -u
dir=$1
tmp=$dir/driver.tmp
mkdir -p "$tmp"
failed=0
check() { # check TEXT COMMAND...
    text=$1
    shift
    if "$@"; then count=$((count + 1)); else echo "driver: FAILED: $text"; failed=1; fi
}
count=0
layer() { # layer MODEL <SETTINGS
    LD_PRELOAD=${PRELOAD:-} ASAN_OPTIONS=detect_leaks=0 "$PYTHON" tests/runtime/run.py "$dir/$1.so"
}
run() { # run MODEL SETTINGS; leaves code, out.csv, err
    printf '%b' "$2" | layer "$1" >"$tmp/out.csv" 2>"$tmp/err"
    code=$?
}

run run_pendulum "method rk4\nuntil 1\nevery 0.3\nstep 0.07\nreport $tmp/r.json\n"
check "exit 0" [ $code -eq 0 ]
check "header" [ "$(head -1 "$tmp/out.csv")" = "t,x,x',energy" ]
check "rows at 0, .3, .6, .9 and 1" [ "$(cut -d, -f1 "$tmp/out.csv" | tr '\n' ' ')" = \
    "t 0 0.3 0.6 0.8999999999999999 1 " ]
check "steps are those asked for: 14 and a shorter one" grep -q '"steps": 15' "$tmp/r.json"
check "report is JSON" python3 -c "import json; d = json.load(open('$tmp/r.json'))['drifts']
assert d[0]['name'] == 'energy' and 1e-9 < d[0]['max'] < 1e-5"

run run_pendulum "method verlet\nuntil 1\nevery 0\nstep 0.25\nstart q 0 0x1p-1\nparam 0 2.5\n"
check "each step is a row" [ "$(wc -l <"$tmp/out.csv")" -eq 6 ]
check "hexadecimal start" [ "$(sed -n 2p "$tmp/out.csv" | cut -d, -f2)" = 0.5 ]

for method in dop853 dopri5 gsl_rk8pd gsl_msadams gauss3; do
    run run_pendulum "method $method\nuntil 2\nrtol 1e-12\nstep 0.01\nevery 0.5\n"
    check "$method: last row exactly at until" [ "$(tail -1 "$tmp/out.csv" | cut -d, -f1)" = 2 ]
    check "$method: five rows" [ "$(wc -l <"$tmp/out.csv")" -eq 6 ]
done
run run_pendulum "method dop853\nuntil 2\nevery 0.01\nrows dense\nrtol 1e-6\nreport $tmp/r.json\n"
check "dense rows" [ "$(wc -l <"$tmp/out.csv")" -eq 202 ]
check "dense rows take few steps" [ "$(sed -n 's/.*"steps": \([0-9]*\).*/\1/p' "$tmp/r.json")" -lt 20 ]

run run_oscillator "method exponential\nuntil 1000\nevery 250\nreport $tmp/r.json\n"
check "exact steps are as long as rows are apart" grep -q '"steps": 4,' "$tmp/r.json"
check "and exact" python3 -c "
from math import cos, sin
t, q = map(float, open('$tmp/out.csv').read().split()[-1].split(',')[:2])
assert t == 1000 and 0 < abs(q - (.7 * cos(t) + .2 * sin(t))) < 1e-15"
python3 -c "
import struct
open('$tmp/members', 'wb').write(struct.pack('2d', 1, 4))"
run run_oscillator "method exponential\nuntil 100\nensemble $tmp/members\nmembers 2\ncolumn param 0\n"
check "exact in ensembles" python3 -c "
from math import cos, sin
for row in open('$tmp/out.csv').read().split()[1:]:
    k, t, q = map(float, row.split(',')[:3])
    assert abs(q - (.7 * cos(k * t) + .2 / k * sin(k * t))) < 1e-15 and t == 100"
run run_pendulum "method exponential\nuntil 1\n"
check "and of linear systems alone" grep -q 'exponential needs a system that is linear' "$tmp/err"

turn() { # turn COLUMN: of the last row, once round behind .25, where it began
    python3 -c "
x = float(open('$tmp/out.csv').read().split()[-1].split(',')[$1])
assert abs(x - .25 - 6.283185307179586) < 1e-10, x"
}
round=0x1.921fb54442d18p+2
run run_turning "method gauss\nuntil $round\nevery 1\nrtol 1e-13\n"
check "states follow the rates" [ "$(head -1 "$tmp/out.csv")" = "t,x,x',\"y,1'\",energy" ]
check "once round, by dense rows" turn 3
run run_turning "method gauss4\nuntil $round\nstep 0.01\nshow v 1\nstart v 1 10.25\n"
check "where they are told to start" [ "$(sed -n 2p "$tmp/out.csv")" = "0,10.25" ]
run run_turning "method verlet\nuntil $round\nstep 1e-4\nevery 1\n"
check "by a splitting method" [ $code -eq 0 ]
for bad in "start v 2 2\n" "show v 2\n" "start x 0 1\n" "show z 0\n"; do
    run run_turning "method rk4\nuntil 1\nstep 0.1\n$bad"
    check "no such state: $bad" [ $code -eq 2 ]
done
python3 -c "
import struct
open('$tmp/members', 'wb').write(struct.pack('4d', .25, .5, 1.25, .5))"
run run_turning "method rk4\nuntil $round\nstep 0.001\nensemble $tmp/members\nmembers 2\ncolumn v 1\ncolumn q 0\n"
check "members have their own" [ "$(head -1 "$tmp/out.csv")" = "member,t,x,x',\"y,1'\",energy" ]
check "which go on from where they start" python3 -c "
rows = [list(map(float, x.split(','))) for x in open('$tmp/out.csv').read().split()[1:]]
assert [abs(r[4] - 6.283185307179586 - s) < 1e-9 for r, s in zip(rows, (.25, 1.25))] == [True] * 2"

run run_pair "method gauss\nuntil 10\nevery 1\nrtol 1e-12\npart 1 method verlet\npart 1 step 1e-3\nreport $tmp/r.json\n"
check "blocks apart" [ $code -eq 0 ]
check "rows of the whole" [ "$(head -1 "$tmp/out.csv")" = "t,x,\"y,1\",x',\"y,1'\",energy" ]
check "each by its own method" python3 -c "
import json
from math import cos
r, row = json.load(open('$tmp/r.json')), open('$tmp/out.csv').read().split()[-1].split(',')
a, b = r['parts']
assert (a['method'], b['method'], b['step'], b['steps']) == ('gauss', 'verlet', 1e-3, 10000), r
assert a['steps'] < 30 and r['steps'] == a['steps'] + b['steps'] and a['rtol'] == 1e-12
assert 1e-6 < abs(float(row[2]) - .5 * cos(200)) < 1e-2
assert 1e-7 < r['drifts'][0]['max'] < 1e-3"
run run_pendulum "method gauss\nuntil 10\nevery 1\nrtol 1e-12\nrows land\n"
alone=$(tail -1 "$tmp/out.csv" | cut -d, -f2)
run run_pair "method gauss\nuntil 10\nevery 1\nrtol 1e-3\npart 0 rtol 1e-12\npart 1 method exponential\nparam 1 100\n"
check "the same as alone, to the bit" [ "$(tail -1 "$tmp/out.csv" | cut -d, -f2)" = "$alone" ]
check "exact steps, by the whole's parameter" python3 -c "
from math import cos
assert abs(float(open('$tmp/out.csv').read().split()[-1].split(',')[2]) - .5 * cos(100)) < 1e-15"
run run_pendulum "method rk4\nuntil 1\nevery 0.3\nstep 0.07\n"
alone=$(tail -1 "$tmp/out.csv" | cut -d, -f2)
run run_pair "method rk4\nuntil 1\nevery 0.3\nstep 0.07\n"
check "steps divide the last interval as alone" [ "$(tail -1 "$tmp/out.csv" | cut -d, -f2)" = "$alone" ]
check "the last interval is shorter" [ "$(cut -d, -f1 "$tmp/out.csv" | tr '\n' ' ')" = \
    "t 0 0.3 0.6 0.8999999999999999 1 " ]
# Half a period from a right angle to the next, 2 K(1/sqrt 2): in each row the energy is 0.
run run_pair "method gauss\nuntil 14.832597418410976\nevery 3.7081493546027438\nrtol 1e-12\nparam 0 1
start q 0 1.5707963267948966\nstart v 0 0\nstart q 1 0\nreport $tmp/r.json\n"
check "an energy that rows see at turning points alone has a scale" python3 -c "
import json
d = json.load(open('$tmp/r.json'))['drifts'][0]
assert d['scale'] > 1 and d['max'] < 1e-11, d"
run run_pair "method gauss\nuntil 10\nevery 5\nh_min 2\npart 0 method rk4\npart 0 step 0.1\nreport $tmp/r.json\n"
check "one fails: exit 4" [ $code -eq 4 ]
check "with its reason" grep -q 'run: part 2 (x): the step size fell .* the whole is at t = 0$' "$tmp/err"
check "and its status" grep -q '"status": "PK_STEP_UNDERFLOW"' "$tmp/r.json"
for bad in "diagnose all" "rows dense" "every 0" "part 2 step 1" "part 1 method what" "part 0 step x" \
    "part 0" "part 1 method rk4"; do
    run run_pair "method gauss\nuntil 1\n$bad\n"
    check "not of blocks apart: $bad" [ $code -eq 2 ]
    check "which is said" [ -s "$tmp/err" ]
done

run run_broken "method dop853\nuntil 3\nevery 0.1\nreport $tmp/r.json\n"
check "numerics fail: exit 4" [ $code -eq 4 ]
check "rows up to the last valid time" [ "$(tail -1 "$tmp/out.csv" | cut -d, -f1)" = 1.2000000000000002 ]
check "reason on standard error" grep -q 'no longer finite; last valid time 1.2' "$tmp/err"
check "report names it" grep -q '"status": "PK_NOT_FINITE"' "$tmp/r.json"
check "an energy that is not conserved has no drift" grep -q '"drifts": \[\]' "$tmp/r.json"

for bad in "method nosuch\n" "method rk4\nuntil x\n" "param 9 1\n" "start q 7 1\n" "bogus 1\n" \
    "method rk4\n" "until 1\n" "method rk4\nuntil 1\n" "method dop853\nuntil 1\nevery 0\n" "param 0\n"; do
    run run_pendulum "$bad"
    check "usage error for $bad" [ $code -eq 2 ]
    check "and says why" [ -s "$tmp/err" ]
done
for bad in "show q 1\n" "show observed 0\n" "show\n" "show what 0\n" "at 0\n"; do
    run run_pendulum "$bad"
    check "what is not there cannot be in a row: $bad" [ $code -eq 2 ]
done
run run_pendulum "method rk4\nuntil 1\nevery 0.5\nstep 0.1\nshow v 0\nshow energy\nshow v 0\n"
check "columns as asked for" [ "$(sed -n 1p "$tmp/out.csv")" = "t,x',energy,x'" ]
check "and their rows" [ "$(wc -l <"$tmp/out.csv")" -eq 4 ]
check "a column is the same wherever it stands" [ "$(cut -d, -f2 "$tmp/out.csv")" = "$(cut -d, -f4 "$tmp/out.csv")" ]
run run_pendulum "column q 0\ncolumn q 7\n"
check "a column that is not there: exit 2" [ $code -eq 2 ]
run run_pendulum "method rk4\nuntil 1\nstep .1\nparam 0 -1\n"
check "parameter out of bounds: exit 2" [ $code -eq 2 ]
run run_pendulum "method dop853\nuntil 1\nrtol 0\natol 0\n"
check "no tolerance: exit 2" [ $code -eq 2 ]

# Intervals: no drift of the count by round-off of t, none below it.
run run_pendulum "method verlet\nuntil 12345.6\nevery 0.1\nstep 0.1\nreport $tmp/r.json\n"
check "rows of a step each" grep -q '"steps": 123456,' "$tmp/r.json"
check "and 0 and header" [ "$(wc -l <"$tmp/out.csv")" -eq 123458 ]
run run_pendulum "method verlet\nuntil 1\nevery 5\nstep 7\n"
check "every and step beyond until: two rows" [ "$(cut -d, -f1 "$tmp/out.csv" | tr '\n' ' ')" = "t 0 1 " ]
for tiny in "method dop853\nuntil 1\nevery 1e-300\n" "method rk4\nuntil 1\nstep 1e-300\n" \
    "method rk4\nuntil 1e9\nevery 1\nstep 1e-9\n"; do
    run run_pendulum "$tiny"
    check "below round-off: exit 2 for $tiny" [ $code -eq 2 ]
    check "and no row" [ "$(wc -l <"$tmp/out.csv")" -eq 0 ]
done

# An ensemble in batches (RUN_BATCH_BYTES is room for 64 members here): each member as it runs alone.
python3 -c "
import array
members = [(0.01 * i, 1 + 0.001 * i) for i in range(150)]
array.array('d', sum(members, ())).tofile(open('$tmp/members', 'wb'))
for i, (q, g) in enumerate(members, 1):
    print(f'start q 0 {q.hex()}\\\\nparam 0 {g.hex()}\\\\n')" >"$tmp/alone"
same="method rk4\nuntil 1\nevery 0.4\nstep 0.05\n"
run run_pendulum "${same}ensemble $tmp/members\nmembers 150\ncolumn q 0\ncolumn param 0\nreport $tmp/r.json\n"
check "an ensemble: exit 0" [ $code -eq 0 ]
cp "$tmp/out.csv" "$tmp/members.csv"
check "its rows, member after member" [ "$(cut -d, -f1 "$tmp/members.csv" | uniq -c | awk '{print $1}' | sort -u | tr '\n' ' ')" = "1 4 " ]
check "150 members" [ "$(tail -1 "$tmp/members.csv" | cut -d, -f1,2)" = 150,1 ]
check "all done" grep -q '"done": 150' "$tmp/r.json"
for i in 1 2 63 64 65 128 129 150; do
    run run_pendulum "$same$(sed -n "${i}p" "$tmp/alone")"
    tail -n +2 "$tmp/out.csv" >"$tmp/one.csv"
    grep "^$i," "$tmp/members.csv" | cut -d, -f2- >"$tmp/of_many.csv"
    check "member $i as alone" cmp -s "$tmp/one.csv" "$tmp/of_many.csv"
done

# The motion is finite, its energy not: rows, a word, exit 4.
run run_pendulum "method verlet\nuntil 1\nstep 0.1\nevery 0.5\nstart v 0 1e200\nreport $tmp/r.json\n"
check "energy not finite: exit 4" [ $code -eq 4 ]
check "rows all the same" [ "$(wc -l <"$tmp/out.csv")" -eq 4 ]
check "said with its time" grep -q 'energy is not finite in 3 of 3 rows, first at t = 0' "$tmp/err"
check "and in the report" grep -q '"not_finite": "energy"' "$tmp/r.json"

printf 'method rk4\nuntil 10\nstep 1e-3\nevery 0\n' | layer run_pendulum >/dev/full 2>"$tmp/err"
check "disk full: exit 2" [ $? -eq 2 ]
check "disk full is said" grep -q 'cannot write' "$tmp/err"

printf 'method rk4\nuntil 1e7\nstep 1e-3\nevery 1\nprogress 1\nreport '"$tmp"'/r.json\n' >"$tmp/long"
LD_PRELOAD=${PRELOAD:-} ASAN_OPTIONS=detect_leaks=0 "$PYTHON" tests/runtime/run.py \
    "$dir/run_pendulum.so" <"$tmp/long" >"$tmp/out.csv" 2>"$tmp/err" &
pid=$!
sleep 1.5
kill -TERM $pid # sh has the background ignore SIGINT
wait $pid
check "interrupted: exit 130" [ $? -eq 130 ]
check "rows were flushed" [ "$(wc -l <"$tmp/out.csv")" -gt 10 ]
check "whole last line" [ "$(tail -1 "$tmp/out.csv" | tr -cd , | wc -c)" -eq 3 ]
check "progress was shown" grep -q '^progress ' "$tmp/err"
check "not too often" [ "$(grep -c '^progress ' "$tmp/err")" -le 16 ]
echo "driver: $count checks passed"
exit $failed
