#!/usr/bin/env bash
# Runs the campaigns of the paper's figures and puts pictures and a comparison into out/figures.
# usage: jobs/figures.sh [--ranks N] [CAMPAIGN...]   (default: 2 ranks, all of input/campaigns)
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"

ranks=2
if [ "${1-}" = --ranks ]; then
  ranks=$2
  shift 2
fi
cd "$root"
[ -x build/stylet ] || { echo "figures.sh: no build/stylet; bash jobs/start.sh builds it" >&2; exit 2; }
names=("$@")
if [ ${#names[@]} -eq 0 ]; then
  for file in input/campaigns/*.yaml; do names+=("$(basename "$file" .yaml)"); done
fi
"$root/jobs/install.sh" --studies
mkdir -p out/figures
for name in "${names[@]}"; do
  say "campaign $name"
  on_ranks "$ranks" build/stylet sweep "input/campaigns/$name.yaml" --output "out/figures/$name" --force
  [ ! -f "out/figures/$name/study.png" ] || cp "out/figures/$name/study.png" "out/figures/$name.png"
done
/usr/bin/python3 -B jobs/figures.py out/figures
