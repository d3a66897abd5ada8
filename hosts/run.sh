#!/usr/bin/env bash
# Runs the tests of the hosts: hosts/run.sh [scikit-fem] [dolfinx], without arguments all of them. Makes a virtual environment for each
# under the target directory and installs the Python module into it,
# from the file DIFFUSE_CONTACT_WHEEL if there is one. dolfinx needs Debian's packages: see dolfinx/README.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

environments=${CARGO_TARGET_DIR:-target}/hosts
[[ $# -gt 0 ]] || set -- scikit-fem dolfinx
for host in "$@"; do
    case $host in
        scikit-fem) python=${PYTHON:-python3} options=() packages=("scikit-fem>=10") ;;
        dolfinx) python=/usr/bin/python3 options=(--system-site-packages) packages=() ;;
        *) printf 'hosts/run.sh: there is no host "%s", only scikit-fem and dolfinx\n' "$host" >&2 && exit 2 ;;
    esac
    if [[ $host == dolfinx ]] &&
        ! { "$python" -c 'import dolfinx, petsc4py, mpi4py, ensurepip' && command -v mpirun; } >/dev/null 2>&1; then
        printf 'hosts/run.sh: dolfinx needs %s of Debian\n' \
            "python3-dolfinx, python3-petsc4py, python3-mpi4py, openmpi-bin and python3-venv" >&2 && exit 2
    fi
    environment=$environments/$host
    "$python" -m venv --clear "${options[@]}" "$environment"
    "$environment/bin/pip" install --quiet "${DIFFUSE_CONTACT_WHEEL:-./python}" "pytest>=8" "${packages[@]}"
    "$environment/bin/python" -m pytest -p no:cacheprovider "hosts/$host"
done
