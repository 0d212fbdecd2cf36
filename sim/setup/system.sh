#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# The system packages that the project needs and this machine lacks, on Debian and its relatives.
#   system.sh check PYTHON     one line on stdout if this user must do something about them first
#   system.sh install PYTHON   installs what is missing
set -eu

action=$1
python=$(sh sim/setup/python.sh "$2" 2>&1) || {
    echo "$python"
    exit 2
}

if [ "${TOOLCHAIN:-wheel}" = native ] && [ "${SIMULATES:-yes}" = yes ] && ! verilator --version 2>/dev/null |
    awk '{ ok = $2 >= 5.036 } END { exit !ok }'; then
    echo "TOOLCHAIN=native needs Verilator 5.036 or newer on PATH and finds" \
        "$(verilator --version 2>/dev/null || echo none)"
    exit 2
fi

missing=
need() { # need COMMAND PACKAGE
    command -v "$1" >/dev/null 2>&1 || missing="$missing $2"
}
need g++ g++
need make make
need ccache ccache
need iverilog iverilog
need ngspice ngspice
need mbpoll mbpoll
# A browser for the test of the scope. Elsewhere than on Debian it is no package of apt-get's.
if [ "${BROWSES:-no}" = yes ] && grep -qx ID=debian /etc/os-release 2>/dev/null; then
    need chromium chromium
    need chromedriver chromium-driver
fi
version=$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
# A bare Debian has the venv module without ensurepip. The package's name carries the version, but
# for the distribution's own Python.
if ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
    own=$(readlink -f /usr/bin/python3 2>/dev/null || true)
    if [ "${own##*/}" = "$version" ]; then
        missing="$missing python3-venv"
    else
        missing="$missing $version-venv"
    fi
fi
# A simulator loads Python as a shared library, for cocotb; Debian's interpreter does without it.
if ! "$python" -c '
import ctypes, os, sysconfig
directory, version = sysconfig.get_config_vars("LIBDIR", "py_version_short")
ctypes.CDLL(os.path.join(directory, f"libpython{version}.so.1.0"))' 2>/dev/null; then
    case $("$python" -c 'import sys; print(sys.base_prefix)') in
    /usr) missing="$missing lib$version" ;;
    *)
        echo "$python was built without its shared library lib$version.so, which cocotb needs:" \
            "name another with make PYTHON=/path/to/python3"
        exit 2
        ;;
    esac
fi
missing=${missing# }
if [ -z "$missing" ]; then exit 0; fi

command="apt-get install -y --no-install-recommends $missing"
as_root=none
if ! command -v apt-get >/dev/null 2>&1; then
    command=
elif [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1 && sudo -n true >/dev/null 2>&1; then
    as_root='sudo -n'
fi

if [ "$action" = check ]; then
    if [ -z "$command" ]; then
        echo "missing on this system, and there is no apt-get to install it: $missing"
    elif [ "$as_root" = none ]; then
        echo "system packages are missing that only root may install:" \
            "type \`sudo apt-get install -y $missing\` first"
    fi
    exit 0
fi

if [ "$as_root" = none ]; then exit 2; fi
echo "installing system packages: $missing"
apt_get() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o Acquire::Retries=5 \
        -o DPkg::Lock::Timeout=300 "$@" </dev/null
}
# A foreign package source that fails need not stop us: the installation decides.
apt_get update || echo "apt-get update failed; trying with the package lists at hand" >&2
# shellcheck disable=SC2086 # a list of words
apt_get install -y --no-install-recommends $missing
