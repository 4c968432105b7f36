#!/usr/bin/python3
"""Work-precision diagram and report of a trade-off study: study.png, report.md."""

from study_picture import COLOURS, DARK, plt, read_json, run, style

EXAMPLES = """examples:
  build/stylet tradeoff input/prostate.yaml
  jobs/tradeoff.py out/tradeoff-prostate
"""
MARKERS = "osD^v<>PX*h"


def name_of(run):
    kernel = run.get("kernel", 1)
    return run["way"] if kernel == 1 else f"{run['way']}, kernel {kernel:.3g}"


def draw(study):
    figure, axes = plt.subplots(figsize=(8.2, 5.0))
    runs = [r | {"way": name_of(r)} for r in study["runs"]
            if "failure" not in r and r["way"] != "reference"]
    names = list(dict.fromkeys(r["way"] for r in runs))
    for number, name in enumerate(names):
        own = [r for r in runs if r["way"] == name]
        colour = COLOURS[number % len(COLOURS)]
        for refine in sorted({r["refine"] for r in own}):
            level = sorted((r for r in own if r["refine"] == refine), key=lambda r: r["seconds"])
            axes.plot([r["seconds"] for r in level], [1e3 * r["error"] for r in level], "-",
                      marker=MARKERS[number % len(MARKERS)], color=colour, markersize=5, linewidth=0.8,
                      alpha=0.8, label=name if refine == own[0]["refine"] else None)
    front = sorted((r for r in runs if r["on_front"]), key=lambda r: r["seconds"])
    axes.step([r["seconds"] for r in front], [1e3 * r["safe_error"] for r in front], where="post",
              color=DARK, linewidth=1.6, label="front")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("wall time (s)")
    axes.set_ylabel(f"error of the placement error (mm), against {1e3 * study['reference']:.3f} mm")
    style(axes)
    axes.legend(fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.tight_layout()
    return figure


def report(study):
    lines = ["# Speed against accuracy", "", f"Reference: {1e3 * study['reference']:.4f} mm.", "",
             "| way | mesh.refine | step (ms) | placement error (mm) | error (mm) | of all finer (mm) | time (s) | front |",
             "|---|---|---|---|---|---|---|---|"]
    for r in study["runs"]:
        start = f"| {name_of(r)} | {r['refine']} | {1e3 * r['step']:.4g} | "
        if "failure" in r:
            lines.append(start + f"{r['failure']} | | | | |")
        else:
            lines.append(start + f"{1e3 * r['placement_error']:.4f} | {1e3 * r['error']:.4f} | "
                         f"{1e3 * r['safe_error']:.4f} | "
                         f"{r['seconds']:.3g} | {'yes' if r['on_front'] else ''} |")
    return "\n".join(lines + [""] + [f"- {line}" for line in study["advice"]]
                     + ["", "![](study.png)", ""])


def main(folder, quiet):
    study = read_json(folder / "tradeoff.json", "stylet tradeoff")
    draw(study).savefig(folder / "study.png", dpi=110)
    (folder / "report.md").write_text(report(study), encoding="utf-8")
    if not quiet:
        print(f"picture and report in {folder}: study.png, report.md")


if __name__ == "__main__":
    run(main, ("study.png", "report.md"), __doc__, EXAMPLES)
