#!/usr/bin/env bash
# Proves that tools/check_floors accepts includes that go down and names each kind of violation by file and line.
set -euo pipefail
check=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work"/src/{base,scene,film,rib,render,elsewhere} "$work"/include/kinora/simd "$work"/plugins/bxdf/{A,B,shared} \
  "$work"/plugins/light/C
touch "$work"/src/{base/low.h,scene/scene.h,film/film.h,rib/reader.h,render/high.h,elsewhere/x.h} \
  "$work"/include/kinora/plugin.h "$work"/include/kinora/simd/wide.h "$work"/plugins/bxdf/{A/own.h,shared/lobe.h}

printf '#include <vector>\n#include <fmt/format.h>\n#include "base/low.h"\n#include "scene/scene.h"\n' >"$work/src/film/good.cpp"
printf '#include <kinora/plugin.h>\n#include "own.h"\n#include "plugins/bxdf/shared/lobe.h"\n#include <cmath>\n' >"$work/plugins/bxdf/A/A.cpp"
"$check" "$work" >"$work/out" || { cat "$work/out"; echo "a good tree is refused"; exit 1; }

# refused FILE LINE INCLUDE: the include, at that line of the file, is found
refused() {
  mkdir -p "$(dirname "$work/$1")"
  { for ((i = 1; i < $2; ++i)); do echo; done; printf '#include %s\n' "$3"; } >"$work/$1"
  if "$check" "$work" >"$work/out"; then echo "$1 includes $3 unnoticed"; exit 1; fi
  grep -qF "$1:$2: " "$work/out" || { cat "$work/out"; echo "$1:$2 is not named"; exit 1; }
  rm "$work/$1"
}
refused src/base/up.cpp 1 '"film/film.h"'
refused src/film/sideways.cpp 3 '"rib/reader.h"'
refused src/scene/up.h 2 '"render/high.h"'
refused src/film/unknown.cpp 1 '"elsewhere/x.h"'
refused include/kinora/leak.h 1 '"base/low.h"'
refused include/kinora/simd/up.h 1 '<kinora/plugin.h>'
refused plugins/bxdf/A/inside.cpp 1 '"base/low.h"'
refused plugins/bxdf/B/other.cpp 1 '"plugins/bxdf/A/own.h"'
refused plugins/light/C/C.cpp 1 '"plugins/bxdf/shared/lobe.h"'
refused plugins/bxdf/shared/shared_lobe.h 1 '"plugins/bxdf/A/own.h"'
refused src/film/missing.cpp 1 '<kinora/nowhere.h>'
