#!/usr/bin/env bash
# Install what the tests of pages, profiles and tokens need: Chromium, Java with Maven (which fetches veraPDF), SoftHSM.
set -euo pipefail
missing=()
command -v chromium >/dev/null || missing+=(chromium)
command -v java >/dev/null || missing+=(default-jre-headless)
command -v mvn >/dev/null || missing+=(maven)
command -v softhsm2-util >/dev/null || missing+=(softhsm2)
[ ${#missing[@]} = 0 ] || bash "$(dirname "$0")/packages.sh" test-all "${missing[@]}"
