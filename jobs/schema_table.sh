#!/usr/bin/env bash
# Renews the table of scene keys in input/README.md: schema_table.sh [PROGRAM], build/stylet by default.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
table=$(mktemp)
trap 'rm -f "$table"' EXIT
"${1:-$root/build/stylet}" schema --markdown >"$table"
sed -i -e '/^<!-- schema -->$/,/^<!-- \/schema -->$/{//!d}' -e "/^<!-- schema -->\$/r $table" \
  "$root/input/README.md"
