#!/usr/bin/env bash
# Prepare a virtual environment from a locked list of requirements, on a machine
# that may have nothing but python3, make and git.
set -euo pipefail
venv=${1:-.venv}
lock=${2:-requirements.lock}
python=${PYTHON:-python3}
# The package itself goes where it is run and where its documentation is made.
case $lock in requirements.lock | requirements-docs.lock) package=yes ;; *) package= ;; esac

say() { printf '%s\n' "$*" >&2; }

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
  say "setup: $("$python" --version) found; Python 3.11 or newer expected. Fix: PYTHON=python3.11 make setup"
  exit 2
}

# What the Python packages need from the system: WeasyPrint loads Pango and the HarfBuzz subsetter.
missing=()
has_library() { "$python" -c "import ctypes; ctypes.CDLL('$1')" 2>/dev/null; }
has_library libpangoft2-1.0.so.0 || missing+=(libpangoft2-1.0-0)
has_library libharfbuzz-subset.so.0 || missing+=(libharfbuzz-subset0)
if ! command -v uv >/dev/null && ! "$python" -m pip --version >/dev/null 2>&1; then
  missing+=(python3-pip)
fi
[ ${#missing[@]} = 0 ] || bash "$(dirname "$0")/packages.sh" setup "${missing[@]}"

say "setup: preparing $venv (about half a minute the first time)"
rm -rf "$venv"
if command -v uv >/dev/null; then
  uv venv -q --python "$python" "$venv"
  uv pip install -q --python "$venv/bin/python" --compile-bytecode --require-hashes -r "$lock"
  [ -z "$package" ] || uv pip install -q --python "$venv/bin/python" --no-build-isolation --no-deps -e .
else
  # --without-pip: Debian ships venv's bootstrap of pip apart, and pip can serve another environment from outside.
  "$python" -m venv --without-pip "$venv"
  pip=("$python" -m pip --python "$venv/bin/python" --quiet --disable-pip-version-check)
  "${pip[@]}" install --no-compile --require-hashes -r "$lock"
  [ -z "$package" ] || "${pip[@]}" install --no-build-isolation --no-deps -e .
fi

# The rig is compiled once, so that no command waits for it; it also runs, more slowly, where it cannot be compiled.
if [ "$lock" = requirements.lock ]; then
  say "setup: compiling the rig (about half a minute, once)"
  "$venv/bin/python" -c 'from metrology.rig import engines
for name in engines.PROGRAMS: engines.loaded(name)' 2>/dev/null || say "setup: the rig was not compiled; it runs without"
fi
