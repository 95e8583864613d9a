#!/bin/sh
# Figures 6 to 12 of the paper that these samples follow (docs/figures.md says what each shows): each scheme is rendered
# once, the rest is `eyebox mix`. Prints the numbers that go with the figures, checks what has to hold for them, and puts
# them on one sheet. Exit code 1: something does not hold; each such line begins with FAILED.
#
#   samples/figures/make.sh [FOLDER]      FOLDER/figures.png; the folder is figures-out if not said
#
# EYEBOX                the program (target/release/eyebox)
# PASSES                passes of each scheme (64)
# ALONE                 limit of each rendering of the direct scheme by one way of tracing, figures 10 to 12 (--time 60s)
# FOV, RESOLUTION       of the eye (36 degrees, 480x240): wide, since the eye adapts to the street and not to the display
# MORE                  further options of every rendering, such as --polarisation off
# KEEP=1                take renderings that are in the folder instead of making them again
set -eu

here=$(cd "$(dirname "$0")" && pwd)
eyebox=${EYEBOX:-$here/../../target/release/eyebox}
passes=${PASSES:-64}
alone=${ALONE:---time 60s}
fov=${FOV:-36}
resolution=${RESOLUTION:-480x240}
more=${MORE:-}
out=${1:-figures-out}
mkdir -p "$out"

# The panorama by night is the one by day, dimmed: its darkest pixel has 292 cd/m² by day and 34 by night.
night=$(awk 'BEGIN { print 34 / 292 }')
# Of what the eye of figures 10 to 12 sees, a twelfth of its width: the display is four by two such blocks.
block=$((${resolution%x*} / 12))
failed=0

ok() { echo "    ok: $1"; }
fail() { echo "FAILED: $1"; failed=1; }
check() { # what has to hold, in words and for awk
    if awk "BEGIN { exit !($2) }"; then ok "$1"; else fail "$1"; fi
}
# CPU seconds of all that was run so far. `times` in a subshell would tell that of the subshell.
cpu() {
    times > "$out/times"
    cpu=$(awk 'NR == 2 { gsub(/[ms]/, " "); print 60 * ($1 + $3) + $2 + $4 }' "$out/times")
}
render() { # scheme, file, seed, options
    scheme=$1 file=$2 seed=$3
    shift 3
    if [ -n "${KEEP:-}" ] && [ -s "$out/$file.exr" ] && [ -s "$out/$file.json" ]; then return; fi
    cpu
    before=$cpu
    # shellcheck disable=SC2086
    "$eyebox" render "$here/../hud-$scheme/hud.optics.toml" -o "$out/$file.exr" --resolution "$resolution" \
        --set "eye.fov_deg=$fov" --seed "$seed" --format json $more "$@" > "$out/$file.json"
    cpu
    awk "BEGIN { print $cpu - $before }" > "$out/$file.cpu"
}
mix() { # from, to, options
    from=$1 to=$2
    shift 2
    "$eyebox" mix "$out/$from.exr" -o "$out/$to.exr" "$@" > "$out/$to.txt"
}
differ() { # file of the result, frames and options
    result=$1
    shift
    "$eyebox" diff "$@" > "$out/$result.diff"
}
# The value that `measure` finds for a frame: adaptation, luminance of the middle of white, leak over threshold.
measured() { "$eyebox" measure "$out/$1.exr" > "$out/$1.measure"; }
adaptation() { sed -n 's/^adaptation luminance, arithmetic: \([0-9.e+-]*\).*/\1/p' "$out/$1.measure"; }
white() { sed -n 's/^white luminance.*rows from the top left: \([0-9. ]*\).*/\1/p' "$out/$1.measure" | awk '{ print $5 }'; }
leak() { sed -n 's/^leak over threshold: \([0-9.e+-]*\) .*(\([a-z]*\):.*/\1 \2/p' "$out/$1.measure"; }
number() { sed -n "s/^ *\"$2\": *\([0-9.e+-]*\),*\$/\1/p" "$out/$1.json" | head -n 1; }
paths() { # of one way of tracing, from the ledgers of a rendering
    awk "/\"ledgers\"/ { all = 1 } all && /\"$2\"/ { own = 1 } own && /\"paths\"/ { gsub(/[^0-9]/, \"\"); print; exit }" \
        "$out/$1.json"
}

# Once per scheme -----------------------------------------------------------------------------------------------------
render diffuse diffuse 1 --samples "$passes"
render direct direct 1 --samples "$passes"
# What the predictions are made from: the sky alone and the LEDs alone, rendered by themselves with other random numbers.
fewer=$(((passes + 3) / 4))
render diffuse sky-of-diffuse 2 --samples "$fewer" --set led.flux_lm=0
render diffuse led-of-diffuse 3 --samples "$fewer" --set sky.scale_cd_m2=0
render diffuse no-reflection 8 --samples 2 --set 'coating.ar={ ideal = { R = 0, T = 1 } }'
render direct sky-of-direct 4 --samples "$fewer" --set led.flux_lm=0

# 6: the display with a diffuser alone, at two contrasts of its slide -------------------------------------------------
mix diffuse fig06a --gain sky=0 --contrast inf
mix diffuse fig06b --gain sky=0 --contrast 300
mix diffuse fig06w --gain sky=0 --contrast 1
mix diffuse fig06c2 --gain sky=0 --contrast 2
mix diffuse fig06c4 --gain sky=0 --contrast 4
mix diffuse fig06c43 --gain sky=0 --contrast 1.3333333333333333
mix no-reflection plain06a --gain sky=0 --contrast inf
mix no-reflection plain06b --gain sky=0 --contrast 300
mix no-reflection plain06w --gain sky=0 --contrast 1
measured fig06b
level=$(white fig06b)
mean_of_white=$(sed -n 's/^white luminance, mean of 9 points: \([0-9.e+-]*\) .*/\1/p' "$out/fig06b.measure")
# The leak is the open slide's picture over the contrast: it has its brightest spot where white has.
spot=$(sed -n 's/^leak spot: \([0-9.e+-]*\) .*(at \([0-9.+-]*\)°, \([0-9.+-]*\)°.*/\1 \2 \3/p' "$out/fig06b.measure")
# shellcheck disable=SC2086
set -- $spot
off=$(awk "BEGIN { print sqrt(($2) ^ 2 + ($3) ^ 2) }")
peak=$(awk "BEGIN { print 300 * $1 / $mean_of_white }")
awk "BEGIN { printf \"6   white: middle %.0f cd/m2; brightest patch %.2f of the mean of 9 points, %.2f degrees from the axis\\n\", \
    $level, $peak, $off }"
weights=$(awk 'BEGIN { printf "%.17g,%.17g", 1 - 1 / 300, 1 / 300 }')
of_peak() { sed -n 's/^(default): .* \([0-9.e+-]*\) of the peak.*/\1/p; s/^(default): equal/0/p' "$out/$1.diff"; }
relation="b = a (1 - 1/300) + white/300 in every pixel and layer to 1e-6 of the peak, without reflections at the lenses"
if differ fig06 "$out/plain06b.exr" "$out/plain06a.exr" "$out/plain06w.exr" --weights "$weights" --within 1e-6; then
    ok "$relation: $(of_peak fig06)"
else
    fail "$relation: see $out/fig06.diff"
fi
# With them some light crosses the slide up to four times: a polynomial of fourth degree in 1/C, known at C = inf, 1, 2, 4, 4/3.
differ fig06x "$out/fig06b.exr" "$out/fig06a.exr" "$out/fig06w.exr" --weights "$weights" --within 1e-6 || true
weights=$(awk 'BEGIN {
    n = split("0 1 0.5 0.25 0.75", at, " ")
    for (i = 1; i <= n; i++) {
        weight = 1
        for (j = 1; j <= n; j++) if (j != i) weight *= (1 / 300 - at[j]) / (at[i] - at[j])
        printf "%s%.17g", (i > 1 ? "," : ""), weight
    } }')
# Judged for the picture: `secondary`, a thousand millionth of it, is rounded at its share that crosses often.
differ fig06c "$out/fig06b.exr" "$out/fig06a.exr" "$out/fig06w.exr" "$out/fig06c2.exr" "$out/fig06c4.exr" \
    "$out/fig06c43.exr" --weights "$weights" --within 1e-6 || true
relation="with them the same from five contrasts, for light that crosses the slide again"
if grep -q '^(default): \(the same\|equal\)' "$out/fig06c.diff"; then
    ok "$relation: $(of_peak fig06c); from two: $(of_peak fig06x)"
else
    fail "$relation: see $out/fig06c.diff"
fi
check "a bright spot on the LED's chief ray: within half a degree of the axis, over the mean" "$off < 0.5 && $peak > 1"

# 7, 8, 9: before the panorama by day and by night, with the LEDs turned up and down ------------------------------------
high=$(awk "BEGIN { print 10000 / $level }")
low=$(awk "BEGIN { print 1600 / $level }")
mix diffuse fig07 --gain "led=$high"
mix diffuse fig08 --gain "led=$high" --gain "sky=$night"
mix diffuse fig09 --gain "led=$low" --gain "sky=$night"
mix diffuse fig09s --gain "sky=$night" --solve leak=hidden
for name in sky-of-diffuse led-of-diffuse fig07 fig08 fig09; do measured "$name"; done
share=$(awk "BEGIN { print $(adaptation led-of-diffuse) / $(white led-of-diffuse) }")
compare() { # figure, name, level, gain of the sky, mean of the sky, lit share, the paper's adaptation
    got=$(adaptation "$2")
    own=$(awk "BEGIN { print $4 * $5 + $6 * $3 }")
    awk "BEGIN { printf \"%-3s adapted to %.1f cd/m2; sky %.1f + lit share %.4f x %d = %.1f (%+.2f %%); the paper %d\\n\", \
        \"$1\", $got, $4 * $5, $6, $3, $own, 100 * ($got / $own - 1), $7 }"
    check "adaptation as predicted within 1 %" "$got < 1.01 * $own && $got > 0.99 * $own"
}
compare 7 fig07 10000 1 "$(adaptation sky-of-diffuse)" "$share" 2140
compare 8 fig08 10000 "$night" "$(adaptation sky-of-diffuse)" "$share" 234
compare 9 fig09 1600 "$night" "$(adaptation sky-of-diffuse)" "$share" 142
factor() { awk "BEGIN { printf \"%.2f\", $1 / 300 / 0.0556 / $2 }"; } # level, adaptation: picture white over C, over threshold
echo "    8: (level/C) / (0.0556 x adaptation) = $(factor 10000 "$(adaptation fig08)"); brightest patch of the leak: $(leak fig08)"
echo "    9: (level/C) / (0.0556 x adaptation) = $(factor 1600 "$(adaptation fig09)"); brightest patch of the leak: $(leak fig09)"
case "$(leak fig08) $(leak fig09)" in
    *visible*hidden) ok "lowering the LEDs turns a visible leak into a hidden one" ;;
    *) fail "lowering the LEDs turns a visible leak into a hidden one" ;;
esac
paper="$(factor 10000 234) and $(factor 1600 142)"
if [ "$paper" = "2.56 and 0.68" ]; then ok "with the paper's adaptation: $paper"; else fail "with the paper's adaptation: $paper"; fi
sed -n 's/^--solve/9   --solve/p; s/^leak:/    leak:/p' "$out/fig09s.txt" | sed 's/: \(hidden\|visible\)$//'

# 10, 11: the direct scheme by one way of tracing alone; the eye's rays are aimed at nothing, as the paper's ---------------
# shellcheck disable=SC2086
render direct fig10 5 --estimator backward --unguided --set sky.scale_cd_m2=0 $alone
# shellcheck disable=SC2086
render direct fig11 6 --estimator forward --set sky.scale_cd_m2=0 $alone
# Paths that are aimed at nothing: of so many from the lamps and as many from the eye, how many find the other end.
from_lamps=0 from_eye=0 tried=0
hits() { # pattern of the table's rows, options
    pattern=$1
    shift
    "$eyebox" rays "$here/../hud-direct/hud.optics.toml" --set "eye.fov_deg=$fov" --set sky.scale_cd_m2=0 --seed "$seed" "$@" |
        awk "/$pattern/ { sum += \$3 } END { print sum + 0 }"
}
seed=0
while [ $seed -lt 48 ]; do
    seed=$((seed + 1)) tried=$((tried + 16384))
    from_lamps=$((from_lamps + $(hits 'arrived in the pupil' --from lamp)))
    from_eye=$((from_eye + $(hits 'met the lamp' --from eye)))
done
# Pupil of 4 mm, nine dies of 0.2 x 0.2 mm; the view as an area of the plane at distance 1, since that is what pixels share.
formula=$(awk "BEGIN { a = atan2(0, -1) / 360 * $fov; a = sin(a) / cos(a); b = a * ${resolution#*x} / ${resolution%x*}
    print atan2(0, -1) * 2 ^ 2 * 4 * a * b / (9 * 0.2 ^ 2 * atan2(0, -1)) }")
awk "BEGIN { printf \"10, 11: A_pupil Omega_cam / (N A_led pi) = %.2f; of %d paths each, aimed at nothing, %d from the lamps arrive, %d from the eye: %.2f +- %.2f\\n\", \
    $formula, $tried, $from_lamps, $from_eye, $from_lamps / $from_eye, $from_lamps / $from_eye * sqrt(1 / $from_lamps + 1 / $from_eye) }"
check "the formula says how much rarer the eye's paths find a lamp, within 3 sigma" \
    "(log($from_lamps / $from_eye / $formula)) ^ 2 < 9 * (1 / $from_lamps + 1 / $from_eye)"
aimed=$(sed -n 's/.*measured by \([0-9]*\) of \([0-9]*\) paths from the lamps.*/\1 \/ \2/p' "$out/fig11.json" | head -n 1)
awk "BEGIN {
    b = $(number fig10 relative_error) ^ 2; f = $(number fig11 relative_error) ^ 2
    nb = $(paths fig10 backward); nf = $(paths fig11 forward); tb = $(cat "$out/fig10.cpu"); tf = $(cat "$out/fig11.cpu")
    printf \"10  rays from the eye: noise %.3g of the light after %.0f s of CPU, %.3g paths\n\", sqrt(b), tb, nb
    printf \"11  light from the lamps: noise %.3g after %.0f s of CPU, %.3g paths, %.2f of those that are aimed arrive\n\", \
        sqrt(f), tf, nf, $aimed
    path = ($aimed) / ($from_eye / $tried); rate = nf / tf / (nb / tb)
    print path * rate, b * tb / (f * tf), path, b * nb / (f * nf), rate > \"$out/noise.txt\"
}"
read -r predicted found path found_path rate < "$out/noise.txt"
awk "BEGIN {
    printf \"    variance at equal paths: %.0f times less, predicted %.0f (formula %.2f x aim %.0f)\n\", $found_path, $path, $formula, $path / $formula
    printf \"    at equal CPU time (%.2f times the paths): %.0f times less, predicted %.0f; noise %.1f, predicted %.1f\n\", \
        $rate, $found, $predicted, sqrt($found), sqrt($predicted) }"
check "noise at equal CPU time as predicted within a factor of 2" "$found < 4 * $predicted && $found > $predicted / 4"
same="10 and 11 are the same picture: 3 sigma, blocks of $block pixels"
if differ fig10 "$out/fig10.exr" "$out/fig11.exr" --blocks "$block"; then ok "$same"; else fail "$same: see $out/fig10.diff"; fi

# 12: all together before the panorama by day ---------------------------------------------------------------------------
mix direct led --gain sky=0
for name in led sky-of-direct fig10 fig11; do measured "$name"; done
# The mean over the picture, with what is known of its error: the same light, whoever traces it.
mean() { sed -n 's/^adaptation luminance, arithmetic: \([^(]*\).*/\1/p' "$out/$1.measure"; }
echo "12  the LEDs' mean over the picture as planned $(mean led)"
echo "    by rays from the eye $(mean fig10)"
echo "    by light from the lamps $(mean fig11)"
mix direct fig12 --gain "led=$(awk "BEGIN { print 10000 / $(white led) }")"
measured fig12
share=$(awk "BEGIN { print $(adaptation fig11) / $(white fig11) }")
compare 12 fig12 10000 1 "$(adaptation sky-of-direct)" "$share" 2940
# shellcheck disable=SC2086
render direct brute 7 --estimator backward $alone
mix direct wrong --gain led=1.5
same="as planned it is the picture by rays from the eye alone: 3 sigma, blocks of $block pixels"
if differ fig12 "$out/brute.exr" "$out/direct.exr" --sigma 3 --blocks "$block"; then ok "$same"; else fail "$same: see $out/fig12.diff"; fi
if differ wrong "$out/brute.exr" "$out/wrong.exr" --sigma 3 --blocks "$block"; then
    fail "the same with half as much light again from the LEDs is told from it"
else
    ok "the same with half as much light again from the LEDs is told from it"
fi

"$eyebox" view --columns 3 -o "$out/figures.png" \
    "$out/fig06a.exr" "$out/fig06b.exr" "$out/fig07.exr" "$out/fig08.exr" "$out/fig09.exr" "$out/fig09s.exr" \
    "$out/fig10.exr" "$out/fig11.exr" "$out/fig12.exr" \
    --caption "6a diffuser: contrast infinite" --caption "6b diffuser: contrast 300:1" \
    --caption "7 by day: 10000 cd/m2" --caption "8 by night: 10000 cd/m2 - the leak is visible" \
    --caption "9 by night: 1600 cd/m2 - the leak is hidden" --caption "9 by night: the level that mix --solve finds" \
    --caption "10 direct scheme: rays from the eye" --caption "11 direct scheme: light from the lamps" \
    --caption "12 direct scheme by day: 10000 cd/m2"
echo "$out/figures.png"
exit $failed
