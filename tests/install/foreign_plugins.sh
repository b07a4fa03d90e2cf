#!/usr/bin/env bash
# foreign_plugins.sh SOURCE BUILD: installs BUILD, moves the installed tree, builds examples/plugins and tests/install/broken
# against it with nothing of SOURCE on the include path, renders with them and checks them with the installed kit.
# Proves: the package is complete and can be moved; a user's bxdf and integrator change the picture; a library of another
# plug-in interface, one without the symbol and one that throws give a message and a picture, not a crash; without the library of
# picture files there is a message and an exit code. Misses: other compilers, other distributions.
set -euo pipefail
source_dir=$1 build_dir=$2
work=$(mktemp -d "${TMPDIR:-/tmp}/kinora_install.XXXXXX")
trap 'rm -rf "$work"' EXIT
unset KINORA_PLUGIN_PATH

fail() { echo "FAILED: $*" >&2; exit 1; }
says() { grep -qF -- "$2" "$1" || { cat "$1" >&2; fail "$1 does not say: $2"; }; }
is_silent_about() { ! grep -qF -- "$2" "$1" || { cat "$1" >&2; fail "$1 says: $2"; }; }
# run EXPECTED_CODE LOG COMMAND...: standard error goes to LOG
run() {
  local expected=$1 log=$2 code=0
  shift 2
  "$@" >"$log.out" 2>"$log" || code=$?
  [[ $code == "$expected" ]] || { cat "$log.out" "$log" >&2; fail "exit code $code, expected $expected: $*"; }
}

cmake --install "$build_dir" --prefix "$work/first" >"$work/install.log" || fail "cmake --install"
mv "$work/first" "$work/moved here"
tree="$work/moved here"
for part in bin/kinora bin/kinora-check-plugin bin/kinora-procedural include/kinora/ri.h include/kinora/plugin.h include/kinora/testing/bxdf_checks.h \
  lib/libkinora-testing.a lib/kinora/libkinora_base.so lib/kinora/libkinora_image.so lib/kinora/libkinora_pictures.so lib/kinora/plugins lib/cmake/Kinora/KinoraConfig.cmake share/kinora/scenes/cornell.rib \
  share/kinora/docs/plugins.md; do
  [[ -e $tree/$part ]] || fail "$part is not installed"
done
kinora="$tree/bin/kinora"

# the sources are copied, so that no path leads back into the tree
cp -r "$source_dir/examples/plugins" "$work/examples"
cp -r "$source_dir/tests/install/broken" "$work/broken"
cp -r "$source_dir/tests/install/kit_user" "$work/kit_user"
for project in examples broken kit_user; do
  cmake -S "$work/$project" -B "$work/build_$project" -G Ninja -DCMAKE_PREFIX_PATH="$tree" >"$work/cmake.log" 2>&1 ||
    { cat "$work/cmake.log" >&2; fail "configuring $project"; }
  cmake --build "$work/build_$project" >"$work/build.log" 2>&1 || { cat "$work/build.log" >&2; fail "building $project"; }
done
for example in Retroreflector AmbientOcclusion FireflyClamp Posterize SoftSpot Tent Pfm Panorama Ripple Puff Thickness; do
  lines=$(wc -l <"$source_dir/examples/plugins/$example.cpp")
  ((lines < 150)) || fail "$example.cpp has $lines lines: an example stays under 150"
done
lines=$(wc -l <"$source_dir/examples/plugins/Haze.cpp")
((lines <= 200)) || fail "Haze.cpp has $lines lines: a path tracer through media takes 200"

scene() {  # scene INTEGRATOR BXDF
  cat <<RIB
Hider "raytrace" "int maxsamples" [4] "int minsamples" [4]
Integrator "$1" "integrator"
Display "picture.exr" "openexr" "rgba"
Format 64 48 1
Projection "perspective" "fov" [40]
Translate 0 0 4
WorldBegin
AttributeBegin
ConcatTransform [2 0 0 0  0 2 0 0  0 0 1 0  0 0 -4 1]
Attribute "visibility" "int camera" [0]
Light "PxrRectLight" "key" "float intensity" [5]
AttributeEnd
AttributeBegin
Bxdf "$2" "material"
Sphere 1 -1 1 360
AttributeEnd
WorldEnd
RIB
}
cd "$work"
scene PxrPathTracer PxrDiffuse >stock.rib
run 0 stock.log "$kinora" stock.rib -o stock.exr --progress none

# the two examples, by --plugin-path
scene PxrPathTracer Retroreflector >retro.rib
run 0 retro.log "$kinora" retro.rib -o retro.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about retro.log PLUGIN-
run 1 diff.log "$kinora" diff stock.exr retro.exr
scene AmbientOcclusion PxrDiffuse >occlusion.rib
run 0 occlusion.log "$kinora" occlusion.rib -o occlusion.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about occlusion.log PLUGIN-
run 1 diff.log "$kinora" diff stock.exr occlusion.exr
for width in 1 4; do
  for name in retro occlusion; do
    run 0 width.log "$kinora" $name.rib -o width.exr --width $width --progress none --plugin-path "$work/build_examples"
    run 0 diff.log "$kinora" diff $name.exr width.exr
  done
done
# two stages with records between them; what its picture is like is judged in tests/probes
scene OneConnection PxrDiffuse >connection.rib
run 0 connection.log "$kinora" connection.rib -o connection.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about connection.log PLUGIN-
run 0 width.log "$kinora" connection.rib -o width.exr --width 1 --progress none --plugin-path "$work/build_examples"
run 0 diff.log "$kinora" diff connection.exr width.exr
# its own way through media; what its picture is like is judged in tests/probes
scene Haze PxrVolume >haze.rib
run 0 haze.log "$kinora" haze.rib -o haze.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about haze.log PLUGIN-
run 0 width.log "$kinora" haze.rib -o width.exr --width 1 --progress none --plugin-path "$work/build_examples"
run 0 diff.log "$kinora" diff haze.exr width.exr
# chords of the unit sphere are 4/3 long on average, wherever they begin
scene Thickness PxrDiffuse | sed 's/\[4\]/[64]/g; s/^Integrator.*/& "float scale" [0.75]/; s/^Format/CropWindow 0.42 0.58 0.42 0.58\n&/' >thickness.rib
run 0 thickness.log "$kinora" thickness.rib -o thickness.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about thickness.log PLUGIN-
run 0 diff.log "$kinora" diff thickness.exr thickness.exr
awk '/^means/ { exit !($2 > 0.98 && $2 < 1.02) }' diff.log.out || fail "thickness of a sphere: $(grep means diff.log.out)"
# with a ball of half the radius inside, of one set with it: a quarter of the chords cross it, 2/3 long on average, which
# leaves 7/8; the mean is that of three colours and an alpha of 1
sed 's/"float scale" \[0.75\]/& "string traceSet" ["pair"]/; s/^\( *\)\(Sphere .*\)/Attribute "grouping" "string membership" ["pair"]\n\2\nSphere 0.5 -0.5 0.5 360/' thickness.rib >pair.rib
run 0 pair.log "$kinora" pair.rib -o pair.exr --progress none --plugin-path "$work/build_examples" --strict
is_silent_about pair.log RENDER-TRACE-SET
run 0 diff.log "$kinora" diff pair.exr pair.exr
awk '/^means/ { exit !($2 > 0.895 && $2 < 0.917) }' diff.log.out || fail "thickness of a hollow ball: $(grep means diff.log.out)"
run 0 list.log "$kinora" plugins retroreflector --plugin-path "$work/build_examples"
says list.log.out sharpness

# one plug-in of each further kind: it is found, it changes the picture and every width
# gives the same picture
kind() {  # kind NAME SED_SCRIPT EXPECTED_DIFF
  sed "$2" stock.rib >"$1.rib"
  run 0 "$1.log" "$kinora" "$1.rib" -o "$1.exr" --progress none --plugin-path "$work/build_examples" --strict
  is_silent_about "$1.log" PLUGIN-
  is_silent_about "$1.log" FILM-FILTER
  run "$3" diff.log "$kinora" diff stock.exr "$1.exr"
  run 0 width.log "$kinora" "$1.rib" -o width.exr --width 1 --progress none --plugin-path "$work/build_examples"
  run 0 diff.log "$kinora" diff "$1.exr" width.exr
}
kind clamp 's/^WorldBegin/SampleFilter "FireflyClamp" "f" "float limit" [0.2]\n&/' 1
kind poster 's/^WorldBegin/DisplayFilter "Posterize" "f" "int levels" [3]\n&/' 1
kind spot 's/^Light /LightFilter "SoftSpot" "f" "float radius" [0.5]\n&/' 1
kind tent 's/^Format/PixelFilter "Tent" 4 4\n&/' 1
kind panorama 's/^Projection.*/Projection "Panorama" "float heightAngle" [60]/' 1
kind ripple 's/^Bxdf/Displace "Ripple" "d" "float height" [0.3]\n&/' 1
sed 's/^Display .*/Display "picture.pfm" "Pfm" "rgba"/' stock.rib >pfm.rib
run 0 pfm.log "$kinora" pfm.rib --progress none --plugin-path "$work/build_examples" --strict
[[ $(head -c 2 picture.pfm) == PF && $(stat -c %s picture.pfm) == $((64 * 48 * 12 + 14)) ]] || fail "picture.pfm is no float map"
run 0 list.log "$kinora" plugins puff --plugin-path "$work/build_examples"
says list.log.out density

# by the folder of the installed tree, and by the environment
cp "$work/build_examples/Retroreflector.so" "$tree/lib/kinora/plugins/"
run 0 folder.log "$kinora" retro.rib -o folder.exr --progress none --strict
run 0 diff.log "$kinora" diff retro.exr folder.exr
rm "$tree/lib/kinora/plugins/Retroreflector.so"
run 4 none.log "$kinora" retro.rib -o none.exr --progress none --strict
run 0 environment.log env KINORA_PLUGIN_PATH="$work/build_examples" "$kinora" retro.rib -o environment.exr --progress none --strict
run 0 diff.log "$kinora" diff retro.exr environment.exr

# the installed kit, as a program and as a library
run 0 kit.log "$tree/bin/kinora-check-plugin" "$work/build_examples/Retroreflector.so"
for example in FireflyClamp Posterize SoftSpot Tent Puff; do
  run 0 kit.log "$tree/bin/kinora-check-plugin" "$work/build_examples/$example.so"
done
run 0 kit_user.log "$work/build_kit_user/kit_user"

# a shared object of Procedural "DynamicLoad", built as its author does and run by the installed program
cc -shared -fPIC -Wall -Werror -I "$tree/include" "$source_dir/examples/procedurals/menger.c" -o menger.so
cat >sponge.rib <<'RIB'
Format 32 24 1
Projection "perspective" "fov" [40]
Translate 0 0 5
WorldBegin
Light "PxrDomeLight" "dome"
Procedural "DynamicLoad" ["menger" "1 -1 1 -1 1 -1 1  1 1 1 1 0 1 1 1 1  1 0 1 0 0 0 1 0 1  1 1 1 1 0 1 1 1 1"] [-1 1 -1 1 -1 1]
WorldEnd
RIB
run 0 sponge.log "$kinora" sponge.rib -o sponge.exr --progress none --spp 1 --allow-exec --strict
run 0 none.log "$kinora" sponge.rib -o none.exr --progress none --spp 1
grep -q ASSET-PROGRAM-REFUSED none.log || fail "an object that is not run is not named"
run 1 diff.log "$kinora" diff sponge.exr none.exr

# broken libraries: a message that names the library, a picture, code 0; with --strict code 4
for broken in WrongAbi NoSymbol; do
  scene PxrPathTracer $broken >$broken.rib
  run 0 $broken.log "$kinora" $broken.rib -o $broken.exr --progress none --plugin-path "$work/build_broken"
  says $broken.log PLUGIN-LOAD
  says $broken.log $broken.so
  [[ -s $broken.exr ]] || fail "no picture beside $broken"
  run 4 $broken.strict.log "$kinora" $broken.rib --progress none --plugin-path "$work/build_broken" --strict
done
says WrongAbi.log "interface"
says NoSymbol.log kinoraPlugins
scene Throws PxrDiffuse >Throws.rib
run 0 Throws.log "$kinora" Throws.rib -o Throws.exr --progress none --plugin-path "$work/build_broken"
says Throws.log Throws
says Throws.log PLUGIN-CREATE
run 0 diff.log "$kinora" diff stock.exr Throws.exr  # the path tracer stands in
run 4 Throws.strict.log "$kinora" Throws.rib --progress none --plugin-path "$work/build_broken" --strict
# without the library of picture files: what needs none goes on, all else has one message and its exit code
library="$tree/lib/kinora/libkinora_pictures.so"
run 0 png.log "$kinora" stock.rib -o stock.png --progress none
sed 's/^Bxdf .*/Pattern "PxrTexture" "picture" "string filename" ["stock.png"]\n&/; s/^Sphere/Bxdf "PxrDiffuse" "textured" "reference color diffuseColor" ["picture:resultRGB"]\n&/' \
  stock.rib >textured.rib
run 0 textured.log "$kinora" textured.rib -o textured.exr --progress none
mv "$library" "$library.away"
run 0 version.log "$kinora" --version
run 0 without.log "$kinora" stock.rib -o without.exr --progress none
for arguments in "textured.rib -o none.exr" "info stock.png" "diff stock.png stock.png" "maketex stock.png stock.tx"; do
  # shellcheck disable=SC2086
  run 8 library.log "$kinora" $arguments
  says library.log APP-LIBRARY
  says library.log libkinora_pictures.so
done
run 6 library.log "$kinora" stock.rib -o none.png --progress none
says library.log libkinora_pictures.so
echo "no library" >"$library"
run 8 library.log "$kinora" info stock.png
says library.log APP-LIBRARY
mv "$library.away" "$library"
run 0 diff.log "$kinora" diff stock.exr without.exr
[[ $(ldd "$kinora" | wc -l) -lt 40 ]] || fail "the program starts with $(ldd "$kinora" | wc -l) shared libraries"

echo "install: all passed"
