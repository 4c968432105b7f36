#!/usr/bin/python3
"""Picture and report of a convergence study: study.png, report.md."""

from study_picture import COLOURS, DARK, Quantity, np, plt, read_json, run, style

EXAMPLES = """examples:
  mpirun -n 2 build/stylet converge input/prostate.yaml
  jobs/converge.py out/converge-prostate
"""


def cells_in(level):
    """The word for the cells of this level's mesh, and their number."""
    word = "tetrahedra" if "n_tetrahedra" in level else "triangles"
    return word, level["n_" + word]


def place(name, level):
    return 1e3 * level["step"] if name == "step" else cells_in(level)[1]


def draw(study, quantities):
    names = [n for n in ("mesh", "step", "joint") if len(study["quantities"][quantities[0].path]
                                                          .get(n, {"levels": []})["levels"]) > 1]
    rows = min(len(quantities), 3)
    figure, all_axes = plt.subplots(rows, len(names), squeeze=False,
                                    figsize=(4.0 * len(names), 2.8 * rows))
    for row, quantity in enumerate(quantities[:rows]):
        for axes, name in zip(all_axes[row], names):
            entry = study["quantities"][quantity.path][name]
            x = np.array([place(name, level) for level in entry["levels"]], dtype=float)
            y = quantity.factor * np.array([level["value"] for level in entry["levels"]])
            u = quantity.factor * np.array([level["uncertainty"] for level in entry["levels"]])
            axes.errorbar(x, y, yerr=u, fmt="o-", color=COLOURS[0], markersize=4, capsize=3)
            if not entry["remark"]:
                axes.axhline(quantity.factor * entry["limit"], color=COLOURS[1], linewidth=1)
                axes.set_title(f"order {entry['order']:.2f}", fontsize=9, color=DARK)
            else:
                axes.set_title(entry["remark"], fontsize=8, color=COLOURS[1])
            axes.set_xscale("log")
            if name == "step":
                axes.invert_xaxis()
            axes.set_xlabel("time step (ms)" if name == "step" else cells_in(entry["levels"][0])[0]
                            + (", step halved with it" if name == "joint" else ""))
            if axes is all_axes[row][0]:
                axes.set_ylabel(quantity.label)
            style(axes)
    figure.tight_layout()
    return figure


def report(study, quantities):
    lines = ["# Convergence", ""]
    for quantity in quantities:
        cells, _ = cells_in(study["quantities"][quantity.path]["mesh"]["levels"][0])
        lines += [f"## {quantity.path}", "", f"| refined | {cells} | step (ms) | {quantity.label} "
                  "| uncertainty | order | limit |", "|---|---|---|---|---|---|---|"]
        for name in ("mesh", "step", "joint"):
            entry = study["quantities"][quantity.path].get(name)
            if not entry or len(entry["levels"]) < 2:
                continue
            for level in entry["levels"]:
                last = level is entry["levels"][-1]
                told = last and not entry["remark"]
                lines.append(
                    f"| {name} | {cells_in(level)[1]} | {1e3 * level['step']:.4g} | "
                    f"{quantity.factor * level['value']:.4f} | "
                    f"{quantity.factor * level['uncertainty']:.2g} | "
                    f"{entry['order'] if told else float('nan'):.2f} | "
                    f"{quantity.factor * entry['limit'] if told else float('nan'):.4f} |"
                    .replace("nan", ""))
            if entry["remark"]:
                lines.append(f"| {name} | {entry['remark']} | | | | | |")
        lines.append("")
    lines += ["Uncertainty: Grid Convergence Index, safety factor 1.25 where the order is sensible, "
              "else 3.", "", "![](study.png)", ""]
    return "\n".join(lines)


def main(folder, quiet):
    study = read_json(folder / "convergence.json", "stylet converge")
    quantities = [Quantity(path) for path in study["quantities"]]
    draw(study, quantities).savefig(folder / "study.png", dpi=110)
    (folder / "report.md").write_text(report(study, quantities), encoding="utf-8")
    if not quiet:
        print(f"picture and report in {folder}: study.png, report.md")


if __name__ == "__main__":
    run(main, ("study.png", "report.md"), __doc__, EXAMPLES)
