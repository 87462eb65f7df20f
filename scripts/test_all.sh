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
# Another installation, such as a system's own updates, may hold apt's locks; only dpkg's are waited for by an option.
for ((try = 1; ; try++)); do
  apt-get update -qq >/dev/null && break
  ((try < 60)) || exit 100
  sleep 5
done
apt-get -o DPkg::Lock::Timeout=300 install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
