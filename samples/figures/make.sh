#!/bin/sh
# Figures 6 to 12 of the paper that these samples follow (docs/figures.md says what each shows): each scheme is rendered
# once, the rest is `eyebox mix`. Prints the numbers that go with the figures and puts them on one sheet.
#
#   samples/figures/make.sh [FOLDER]      FOLDER/figures.png; the folder is figures-out if not said
#
# EYEBOX                the program (target/release/eyebox)
# PASSES                passes of each scheme (64)
# ALONE                 limit for each way of tracing the direct scheme alone, figures 10 and 11 (--time 60s)
# FOV, RESOLUTION       of the eye (36 degrees, 480x240): wide, since the eye adapts to the street and not to the display
# MORE                  further options of every rendering, such as --polarisation off
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

render() { # scheme, file, options
    scheme=$1 file=$2
    shift 2
    # shellcheck disable=SC2086
    "$eyebox" render "$here/../hud-$scheme/hud.optics.toml" -o "$out/$file.exr" --resolution "$resolution" \
        --set "eye.fov_deg=$fov" --seed 1 --format json $more "$@" > "$out/$file.json"
}
mix() { # from, to, options
    from=$1 to=$2
    shift 2
    "$eyebox" mix "$out/$from.exr" -o "$out/$to.exr" "$@" > "$out/$to.txt"
}
# The value that `measure` finds for a frame: adaptation, luminance of the middle of white, leak over threshold.
measured() { "$eyebox" measure "$out/$1.exr" > "$out/$1.measure"; }
adaptation() { sed -n 's/^adaptation luminance, arithmetic: \([0-9.e+-]*\).*/\1/p' "$out/$1.measure"; }
white() { sed -n 's/^white luminance.*rows from the top left: \([0-9. ]*\).*/\1/p' "$out/$1.measure" | awk '{ print $5 }'; }
leak() { sed -n 's/^leak over threshold: \([0-9.e+-]*\) .*(\([a-z]*\):.*/\1 \2/p' "$out/$1.measure"; }
number() { sed -n "s/^ *\"$2\": *\([0-9.e+-]*\),*\$/\1/p" "$out/$1.json" | head -n 1; }

# Once per scheme -----------------------------------------------------------------------------------------------------
render diffuse diffuse --samples "$passes"
render direct direct --samples "$passes"

# 6: the display with a diffuser alone, at two contrasts of its slide -------------------------------------------------
mix diffuse fig06a --gain sky=0 --contrast inf
mix diffuse fig06b --gain sky=0 --contrast 300
measured fig06b
level=$(white fig06b)
mean_of_white=$(sed -n 's/^white luminance, mean of 9 points: \([0-9.e+-]*\) .*/\1/p' "$out/fig06b.measure")
awk "BEGIN { printf \"6   white: middle %.0f cd/m2, %.2f of the mean of 9 points; two contrasts from one rendering\\n\", $level, $level / $mean_of_white }"

# 7, 8, 9: before the panorama by day and by night, with the LEDs turned up and down ------------------------------------
high=$(awk "BEGIN { print 10000 / $level }")
low=$(awk "BEGIN { print 1600 / $level }")
mix diffuse fig07 --gain "led=$high"
mix diffuse fig08 --gain "led=$high" --gain "sky=$night"
mix diffuse fig09 --gain "led=$low" --gain "sky=$night"
mix diffuse fig09s --gain "sky=$night" --solve leak=hidden
mix diffuse sky --gain led=0
measured sky
measured fig07
measured fig08
measured fig09
share=$(awk "BEGIN { print $(adaptation fig06b) / $level }")
compare() { # figure, name, level, gain of the sky, the paper's adaptation
    awk "BEGIN {
        own = $4 * $(adaptation sky) + $share * $3; got = $(adaptation "$2")
        printf \"%-3s adapted to %.1f cd/m2; sky + lit share %.4f x %d: %.1f (%+.2f %%); the paper %d\n\", \
            \"$1\", got, $share, $3, own, 100 * (got / own - 1), $5 }"
}
compare 7 fig07 10000 1 2140
compare 8 fig08 10000 "$night" 234
compare 9 fig09 1600 "$night" 142
for name in fig08 fig09; do echo "    $name: leak over threshold $(leak $name)"; done
awk 'BEGIN { printf "    with the adaptation that the paper has: %.2f and %.2f\n", 10000 / 300 / 0.0556 / 234, 1600 / 300 / 0.0556 / 142 }'
sed -n 's/^--solve/9   --solve/p; s/^leak:/    leak:/p' "$out/fig09s.txt" | sed 's/: \(hidden\|visible\)$//'

# 10, 11: the direct scheme by one way of tracing alone -----------------------------------------------------------------
# shellcheck disable=SC2086
render direct fig10 --estimator backward --set sky.scale_cd_m2=0 $alone
# shellcheck disable=SC2086
render direct fig11 --estimator forward --set sky.scale_cd_m2=0 $alone
awk "BEGIN {
    b = $(number fig10 relative_error); f = $(number fig11 relative_error)
    tb = $(number fig10 seconds); tf = $(number fig11 seconds)
    printf \"10  rays from the eye: noise %.3g of the picture after %.0f s\n11  light from the lamps: %.3g after %.0f s\n\", b, tb, f, tf
    printf \"    at equal time its variance is %.0f times less\n\", b * b * tb / (f * f * tf) }"

# The mean over the picture, with what is known of its error: the same light, whoever traces it.
mean() { sed -n 's/^adaptation luminance, arithmetic: \([^(]*\).*/\1/p' "$out/$1.measure"; }

# 12: all together before the panorama by day ---------------------------------------------------------------------------
mix direct led --gain sky=0
measured led
measured fig10
measured fig11
echo "    mean over the picture by the plan $(mean led)"
echo "    by rays from the eye $(mean fig10)"
echo "    by light from the lamps $(mean fig11)"
mix direct fig12 --gain "led=$(awk "BEGIN { print 10000 / $(white led) }")"
measured fig12
echo "12  adapted to $(adaptation fig12) cd/m2; the paper 2940"

"$eyebox" view --columns 3 -o "$out/figures.png" \
    "$out/fig06a.exr" "$out/fig06b.exr" "$out/fig07.exr" "$out/fig08.exr" "$out/fig09.exr" "$out/fig09s.exr" \
    "$out/fig10.exr" "$out/fig11.exr" "$out/fig12.exr" \
    --caption "6a diffuser: contrast infinite" --caption "6b diffuser: contrast 300:1" \
    --caption "7 by day: 10000 cd/m2" --caption "8 by night: 10000 cd/m2 - the leak is visible" \
    --caption "9 by night: 1600 cd/m2 - the leak is hidden" --caption "9 by night: the level that mix --solve finds" \
    --caption "10 direct scheme: rays from the eye" --caption "11 direct scheme: light from the lamps" \
    --caption "12 direct scheme by day: 10000 cd/m2"
