#!/usr/bin/env bash
# ./render.sh [FILE.rib] [options]   builds Kinora where needed and renders FILE (else scenes/cornell.rib).
# Options are those of `build/kinora render --help`. Messages and progress go to the terminal; the program says at the end
# where each picture is.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
"$root/tools/setup" kinora

# the gallery scene when the command line begins with no file and names none later
names_file=
if [[ ${1:-} == - || ( -n ${1:-} && ${1:-} != -* ) ]]; then names_file=1; fi
for argument in "$@"; do
  case $argument in *.rib | *.rib.gz | -h | --help | --version) names_file=1 ;; esac
done
if [[ -z $names_file ]]; then set -- "$root/scenes/cornell.rib" "$@"; fi
exec "$root/build/kinora" render "$@"
