#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# environment.sh PYTHON LOCK...: brings .venv up to what the locks say, then installs the project.
# Run at the root of the repository. .venv/.unfinished stands from the first moment to the last, so
# that an interrupted run is started afresh instead of trusted: pip takes a half-copied package for
# an installed one. At the end .venv/.ready holds the path of the tree.
set -eu

python=$(sh sim/setup/python.sh "$1")
shift
locks=$*
unfinished=.venv/.unfinished

# A tree that was moved or copied holds an environment that points to the old place.
if [ -e "$unfinished" ] || ! .venv/bin/python -c '
import os, sys
sys.exit(sys.version_info < (3, 10) or not os.path.samefile(sys.prefix, ".venv"))' 2>/dev/null ||
    ! grep -qF "$(pwd -P)/.venv" .venv/bin/activate 2>/dev/null; then
    rm -rf .venv
fi
mkdir -p .venv
: >"$unfinished"
rm -f .venv/.ready

if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    echo "making .venv with $("$python" --version)"
    "$python" -m venv .venv
fi

pip_install() {
    .venv/bin/python -m pip --disable-pip-version-check --no-input install --quiet \
        --retries 5 --timeout 60 "$@" </dev/null
}

# The locks are complete: what they leave out of a package's wishes isn't wanted.
# pip retries a connection, but gives up a download that breaks off in the middle.
echo "installing the packages of $locks"
attempt=1
# shellcheck disable=SC2086,SC2046 # lists of words
until pip_install --require-hashes --no-deps --only-binary :all: $(printf -- '-r %s ' $locks); do
    if [ "$attempt" -ge 3 ]; then exit 1; fi
    echo "attempt $attempt failed, trying again" >&2
    sleep $((attempt * 5))
    attempt=$((attempt + 1))
done

# Nothing may come from the network here: all dependencies and the build back end are in the lock.
pip_install --no-index --no-deps --no-build-isolation -e .

# In the C locale, Python reads no path with an umlaut from there. One from the file's folder has none.
for path in .venv/lib/python*/site-packages/__editable__.wavehaptics-*.pth; do
    printf '%s\n' ../../../../sim ../../../../tools >"$path"
done

sh sim/setup/verilator.sh
pwd -P >.venv/.ready
rm "$unfinished"
