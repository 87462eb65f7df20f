#!/usr/bin/env bash
# Install what the tests of pages, profiles and tokens need: Chromium, Java with Maven (which fetches veraPDF), SoftHSM.
set -euo pipefail
missing=()
command -v chromium >/dev/null || missing+=(chromium)
command -v java >/dev/null || missing+=(default-jre-headless)
command -v mvn >/dev/null || missing+=(maven)
command -v softhsm2-util >/dev/null || missing+=(softhsm2)
[ ${#missing[@]} -gt 0 ] || exit 0
if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
  printf 'test-all: missing are %s. Fix: sudo apt-get install %s\n' "${missing[*]}" "${missing[*]}" >&2
  exit 2
fi
printf 'test-all: installing %s\n' "${missing[*]}" >&2
export DEBIAN_FRONTEND=noninteractive
# Another installation, such as a system's own updates, may hold the lock for a while.
wait=(-o DPkg::Lock::Timeout=300)
apt-get "${wait[@]}" update -qq >/dev/null
apt-get "${wait[@]}" install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
