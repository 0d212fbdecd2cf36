#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
#
# Resolves the package lists of pyproject.toml for every Python and platform at once, and pins each
# package with its hashes. What is pinned already stays, unless `--upgrade` is given.
set -eu

uv=$(command -v .venv/bin/uv || command -v uv || true)
if [ -z "$uv" ]; then
    .venv/bin/python -m venv build/uv
    build/uv/bin/python -m pip --disable-pip-version-check install --quiet uv
    uv=build/uv/bin/uv
fi

compile() { # compile LOCK ARGUMENT... : the package list on stdin or among the arguments
    lock=$1
    shift
    if [ -e "$lock" ]; then cp "$lock" "build/$lock"; fi
    "$uv" pip compile --quiet --universal --generate-hashes --python-version 3.10 --no-annotate \
        --no-emit-index-url --no-emit-find-links --custom-compile-command 'make lock' \
        --override build/overrides.in --output-file "build/$lock" "$@"
    {
        echo '# SPDX-License-Identifier: Apache-2.0'
        grep -v SPDX-License-Identifier "build/$lock"
    } >"build/$lock.tagged"
    mv "build/$lock.tagged" "$lock"
    rm "build/$lock"
    echo "$lock: $(grep -c == "$lock") pins"
}

# Cosmic Ray's pages of HTML, which nobody asks for, want a package that has no wheel.
mkdir -p build/requirements
echo "yattag ; python_version < '3'" >build/overrides.in

compile requirements/package.lock pyproject.toml --extra test --extra report "$@"

# The synthesis tools, that for mutants and the pages' generator, each alone, at versions that agree
# with the lock above.
for group in synth mutate docs; do
    .venv/bin/python - "$group" <<'EOF' >"build/$group.in"
import sys
try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib
with open("pyproject.toml", "rb") as file:
    print(*tomllib.load(file)["project"]["optional-dependencies"][sys.argv[1]], sep="\n")
EOF
    # The pages' generator shares no environment with the package.
    case $group in docs) constraints= ;; *) constraints='--constraints requirements/package.lock' ;; esac
    # shellcheck disable=SC2086 # two words or none
    compile "requirements/$group.lock" "build/$group.in" $constraints "$@"
done
