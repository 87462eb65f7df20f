#!/usr/bin/env bash
# Install packages of Debian, or say how: packages.sh WHO PACKAGE…
set -euo pipefail
who=$1
shift
if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
  printf '%s: system packages are missing. Fix: sudo apt-get install %s\n' "$who" "$*" >&2
  exit 2
fi
printf '%s: installing %s\n' "$who" "$*" >&2
export DEBIAN_FRONTEND=noninteractive
# Another installation, such as a system's own updates, may hold apt's locks; only dpkg's are waited for by an option.
for ((try = 1; ; try++)); do
  apt-get update -qq >/dev/null && break
  ((try < 60)) || exit 100
  sleep 5
done
apt-get -o DPkg::Lock::Timeout=300 install -y -qq --no-install-recommends "$@" >/dev/null
