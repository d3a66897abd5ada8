#!/bin/sh
# Both pages of rivals in one run, docs/results/performance.md and docs/results/own-elements.md. Python packages go into a virtual
# environment in target/rivals/venv, made where there is none. Arguments go to both scripts:
#
#     benches/rivals/all.sh
#     benches/rivals/all.sh --rounds 1 --docs target/rivals/trial
set -eu
cd "$(dirname "$0")/../.."
venv=target/rivals/venv
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --requirement benches/rivals/requirements.txt
"$venv/bin/python" benches/rivals/run.py "$@"
"$venv/bin/python" benches/rivals/own_elements.py "$@"
