#!/usr/bin/env bash
# ./test.sh   installs what is missing, builds everything and runs every test. The last line is "N passed, N failed".
# Scenes of others for the tests that read real files are looked for in ../shared/scenes; without them those are skipped.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
start=$SECONDS
tools/setup
built=$SECONDS
log=build/test.log
status=0
ctest --test-dir build -j2 --output-on-failure "$@" 2>&1 | tee "$log" || status=$?
# ctest closes with: "98% tests passed, 2 tests failed out of 117"
failed=$(sed -nE 's/^.*tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1/p' "$log" | tail -n 1)
total=$(sed -nE 's/^.*tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\2/p' "$log" | tail -n 1)
skipped=$(grep -cE '\*\*\*Skipped|\*\*\*Not Run \(Disabled\)' "$log" || true)
if [[ -z $total || $total -eq 0 ]]; then
  echo "no test was run" >&2
  failed=1 total=1
fi
echo "Built in $((built - start)) s, tested in $((SECONDS - built)) s; $skipped skipped."
echo "$((total - failed - skipped)) passed, $failed failed"
((failed == 0 && status == 0))
