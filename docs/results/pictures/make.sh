#!/usr/bin/env bash
# Makes report.png and shape.png beside it (they are not kept): the report of a plate on a cylinder with both elements, as a browser shows it.
# Needs Rust and Chromium. Usage: docs/results/pictures/make.sh [PROGRAM], from anywhere; PROGRAM is built if it is not given.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."

program=${1:-}
if [[ -z $program ]]; then
    cargo build --release -p diffuse-contact-solver
    program=${CARGO_TARGET_DIR:-target}/release/diffuse-contact-solve
fi
runs=$(mktemp -d)
trap 'rm -rf "$runs"' EXIT

deck=examples/plate_cylinder.toml
"$program" solve "$deck" --out "$runs/diffuse"
sed 's/^contact = .*/contact = "node-to-facet"/' "$deck" >"$runs/classic.toml"
"$program" solve "$runs/classic.toml" --out "$runs/classic"
"$program" report "$runs/diffuse" "$runs/classic" -o "$runs/both.html"

# The scenes alone.
sed 's|^<main>|&<style>.two, h1 { display: none }</style>|' "$runs/both.html" >"$runs/scenes.html"

# A picture of a page: name, page, height.
shoot() {
    chromium --headless --no-sandbox --disable-gpu --enable-unsafe-swiftshader --no-first-run \
        --disable-background-networking --disable-component-update --disable-sync --hide-scrollbars \
        --user-data-dir="$runs/profile" --window-size="1240,$3" --virtual-time-budget=30000 \
        --force-device-scale-factor=0.8 --screenshot="docs/results/pictures/$1" "file://$runs/$2" 2>/dev/null
}
shoot report.png both.html 1080
shoot shape.png scenes.html 1390
