# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Every file that the programs write is read back by a program that is not ours: URDF and SVG by
# xmllint, JSON by jq, the printed configuration by the daemon itself.
. "$(dirname "$0")/check.sh"

for program in xmllint jq; do
    command -v $program >/dev/null || {
        echo "skipped: $program is not installed (tools/setup)"
        exit 77
    }
done
source=$data/../../..

xml() {
    xmllint --noout "$@" 2>"$work/xmllint" || {
        fail "not well-formed: $*"
        cat "$work/xmllint"
    }
}

# json FILE ROWS: so many JSON values, of which none is NaN or infinite (jq would make it 1e308)
json() {
    rows=$(jq -c . "$1" 2>"$work/jq" | wc -l)
    [ ! -s "$work/jq" ] && [ "$rows" -ge "$2" ] || {
        fail "no JSON, or not $2 values: $rows"
        cat "$work/jq"
        head -c 2000 "$1"
    }
    grep -qiE '[:,[] *-?(nan|inf)' "$1" && fail "a number that JSON has not: $1"
}

# ---- URDF ----

"$tool" chain nothing 2>"$work/err"
mechanisms=$(sed -n 's/.*there are //p' "$work/err" | tr -d ,)
[ "$(echo "$mechanisms" | wc -w)" -ge 13 ] || fail "the list of mechanisms: $mechanisms"
for name in $mechanisms; do
    for options in "" "-n 1" "-n 3 -s 18446744073709551615" "-n 4 -r 1e-300 -m 1e-9 -t 1e9 -c 0"; do
        # shellcheck disable=SC2086
        "$tool" chain "$name" $options >"$work/chain.urdf" 2>"$work/err" ||
            grep -q "must be" "$work/err" || fail "chain $name $options"
        [ ! -s "$work/chain.urdf" ] || xml "$work/chain.urdf"
    done
done
"$tool" chain helix --bodies 5 --curl 0.25 --seed 7 >"$work/chain.urdf"
# what its comment says writes the same file again
again=$(sed -n 's/<!-- totalforce \(.*\) -->/\1/p' "$work/chain.urdf")
# shellcheck disable=SC2086
"$tool" $again >"$work/again.urdf"
same "$work/chain.urdf" "$work/again.urdf" "the command in a chain's comment writes another file"
xml "$source"/config/robots/*.urdf "$source"/config/dds/*.xml "$data"/*.urdf

# ---- JSON ----

# names that JSON and XML have to quote
cat >"$work/odd.urdf" <<'EOF'
<robot name="a&lt;b&amp;c&quot;d\e">
  <link name="base"/>
  <link name="li&quot;nk\1&#xe9;">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <joint name="jo&quot;int\1 &lt;x&gt;" type="continuous">
    <parent link="base"/><child link="li&quot;nk\1&#xe9;"/><axis xyz="0 1 0"/>
  </joint>
</robot>
EOF
for file in "$data"/*.urdf "$source"/config/robots/*.urdf "$work/odd.urdf"; do
    "$tool" model --json --lock-massless-leaves "$file" >"$work/out" 2>"$work/err"
    json "$work/out" 1
done
status 0 "$tool" methods --json
json "$work/out" 10
cat >"$work/lines" <<'EOF'
{"id":"\"\\\u00e9\n","op":"forward_dynamics","q":[0],"v":[0],"tau":[1]}
{"op":"mass_matrix","q":{"jo\"int\\1 <x>":0.5}}
{"op":"forward_dynamics","q":{"jo\"in":1},"v":[0],"tau":[1]}
{"op":"forward_dynamics","q":[1e308],"v":[1e200],"tau":[1e308]}
not JSON
{"op":"operational_inertia","q":[0],"tips":["li\"nk\\1\u00e9"],"poses":true}
{"op":"kinematics","q":[0],"want":["poses","com","energy"]}
{"op":"task_torques","q":[0],"acceleration":{"li\"nk\\1\u00e9":[0,0,1,0,0,0]},"want":["lambda","spectrum"]}
EOF
"$tool" solve "$work/odd.urdf" <"$work/lines" >"$work/out" 2>"$work/err"
json "$work/out" 8
status 0 "$tool" chart --json --urdf "$work/odd.urdf" --budget-ms 1 --states 2 --rhs tau
json "$work/out" 5
status 0 "$tool" atlas --json --bodies 2 --points 2 --states 1 --methods aba,tfa
json "$work/out" 20

# ---- SVG ----

mkdir "$work/pictures"
status 0 "$tool" chart --urdf "$work/odd.urdf" --budget-ms 1 --states 2 --output "$work/pictures"
status 0 "$tool" chart --mechanisms random,massless --bodies 2,5 --budget-ms 1 --states 2 \
    --output "$work/pictures"
ls "$work"/pictures/*.svg >/dev/null || fail "no pictures"
xml "$work"/pictures/*.svg
for picture in $(find "$source/docs" -name '*.svg'); do
    xml "$picture"
done

# ---- YAML ----

for file in minimal full scenes; do
    status 0 "$bin/totalforced" --dump-config "$source/config/$file.yaml"
    # relative paths start at the file
    sed "s|urdf: \"\\([^/]\\)|urdf: \"$source/config/\\1|" "$work/out" >"$work/$file.yaml"
    status 0 "$bin/totalforced" --check "$work/$file.yaml"
    "$bin/totalforced" --dump-config "$work/$file.yaml" >"$work/again.yaml"
    same "$work/$file.yaml" "$work/again.yaml" "what is printed of $file.yaml prints otherwise"
done
finish
