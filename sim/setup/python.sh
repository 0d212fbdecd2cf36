#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Prints the interpreter to use: $1 (default: python3) or, unless another was asked for, the first
# of the versioned names that is new enough. Exit status 2 and one line on stderr if there is none.
set -eu

asked=${1:-python3}
candidates=$asked
if [ "$asked" = python3 ]; then
    candidates='python3 python3.13 python3.12 python3.11 python3.10 python3.14'
fi
for candidate in $candidates; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; then
        echo "$candidate"
        exit 0
    fi
done
found=$("$asked" -c 'import platform; print(platform.python_version())' 2>/dev/null || echo nothing)
echo "Python 3.10 or newer is needed and '$asked' is $found: install one, or name one with" \
    "make PYTHON=/path/to/python3" >&2
exit 2
