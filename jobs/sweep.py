#!/usr/bin/python3
"""Statistics, picture and report of a campaign: study.png, statistics.json, report.md."""

import csv
import json

from study_picture import COLOURS, DARK, BadInput, Quantity, np, plt, read_json, run, style

EXAMPLES = """examples:
  mpirun -n 2 build/stylet sweep input/campaigns/figure09.yaml
  jobs/sweep.py out/sweep-figure09
"""
CONFIDENCE = 0.95


class Campaign:
    """Rows of results.csv, averaged over the shifts of each point."""

    def __init__(self, folder):
        self.plan = read_json(folder / "plan.json", "stylet sweep")
        try:
            with open(folder / "results.csv", newline="", encoding="utf-8") as file:
                self.rows = list(csv.DictReader(file))
        except OSError as error:
            raise BadInput(f"{folder}/results.csv: cannot be read: {error}") from None
        self.outputs = [Quantity(path) for path in self.plan["outputs"]]
        self.variables = self.plan["variables"]
        n_points = len(self.plan["points"])
        samples = [[[] for _ in self.outputs] for _ in range(n_points)]
        self.values = [None] * n_points
        for row in self.rows:
            point = int(row["point"])
            self.values[point] = [row[v["column"]] for v in self.variables]
            if row["status"] != "done":
                continue
            for k, output in enumerate(self.outputs):
                samples[point][k].append(output.factor * float(row[output.path]))
        whole = len(self.outputs) * [np.nan]
        # A point of which a shift failed has another average than its neighbours: left out.
        complete = [len(s[0]) == self.plan["shifts"] for s in samples]
        self.mean = np.array([[np.mean(k) for k in s] if ok else whole
                              for s, ok in zip(samples, complete)])
        self.spread = np.array([[np.std(k, ddof=1) if len(k) > 1 else 0.0 for k in s] if ok
                                else whole for s, ok in zip(samples, complete)])
        self.jitter = [float(np.sqrt(np.nanmean(self.spread[:, k] ** 2)))
                       for k in range(len(self.outputs))]
        self.incomplete = n_points - sum(complete)

    def column(self, index):
        """Numbers of a variable by point, or None where they are words."""
        try:
            return np.array([float(v[index]) if v else np.nan for v in self.values])
        except ValueError:
            return None

    def words(self, index):
        return [v[index] if v else "" for v in self.values]


def curve(axes, campaign, points, variable, k, colour, label=None):
    x = campaign.column(variable)
    if x is None:
        names = campaign.words(variable)
        axes.bar([names[p] for p in points], campaign.mean[points, k], color=colour, label=label)
        return
    points = sorted(points, key=lambda p: x[p])
    y, e = campaign.mean[points, k], campaign.spread[points, k]
    axes.plot(x[points], y, "o-", color=colour, markersize=4, label=label)
    if np.any(e > 0):
        axes.fill_between(x[points], y - e, y + e, color=colour, alpha=0.2, linewidth=0)
    if campaign.variables[variable]["scale"] == "log":
        axes.set_xscale("log")


def draw_grid(campaign):
    """A curve for each value of all variables but the one that changes most."""
    distinct = [len(set(campaign.words(i))) for i in range(len(campaign.variables))]
    numeric = [i for i in range(len(distinct)) if campaign.column(i) is not None] or [0]
    along = max(numeric, key=lambda i: distinct[i])
    others = [i for i in range(len(distinct)) if i != along and distinct[i] > 1]
    groups = {}
    for p, values in enumerate(campaign.values):
        if values:
            groups.setdefault(tuple(values[i] for i in others), []).append(p)
    n = len(campaign.outputs)
    figure, all_axes = plt.subplots(1, n, figsize=(5.2 * n, 3.8), squeeze=False)
    for k, (axes, output) in enumerate(zip(all_axes[0], campaign.outputs)):
        for number, (key, points) in enumerate(groups.items()):
            label = ", ".join(f"{campaign.variables[i]['name']} {value}"
                              for i, value in zip(others, key))
            curve(axes, campaign, points, along, k, COLOURS[number % len(COLOURS)], label or None)
        axes.set_xlabel(campaign.variables[along]["column"].replace("_", " "))
        axes.set_ylabel(output.label)
        axes.set_ylim(bottom=0)
        style(axes)
        if others and k == 0:
            axes.legend(fontsize=8, frameon=False)
    lines = []
    statistics = []
    for key, points in groups.items():
        y = campaign.mean[points, 0]
        x = campaign.column(along)
        if np.all(np.isnan(y)):
            continue
        low = points[int(np.nanargmin(y))]
        name = ", ".join(f"{campaign.variables[i]['name']} {v}" for i, v in zip(others, key))
        at = f" at {x[low]:g}" if x is not None else ""
        lines.append(f"{name + ': ' if name else ''}{campaign.outputs[0].label} "
                     f"{np.nanmin(y):.3g}{at} to {np.nanmax(y):.3g}")
        statistics.append({"at": dict(zip([campaign.variables[i]["name"] for i in others], key)),
                           "x": None if x is None else x[points].tolist(), "y": y.tolist()})
    return figure, {"curves": statistics}, lines


def draw_one_at_a_time(campaign):
    n = len(campaign.variables)
    base = campaign.values[0]
    members = [[p for p, v in enumerate(campaign.values)
                if v and all(v[j] == base[j] for j in range(n) if j != i)] for i in range(n)]
    figure, all_axes = plt.subplots(1, n + 1, figsize=(3.4 * (n + 1), 3.6), squeeze=False)
    swings = []
    for i, axes in enumerate(all_axes[0][:n]):
        curve(axes, campaign, members[i], i, 0, COLOURS[0])
        axes.set_xlabel(campaign.variables[i]["column"].replace("_", " "))
        axes.set_ylim(bottom=0)
        style(axes)
        y = campaign.mean[members[i], 0]
        swings.append((campaign.variables[i]["name"], float(np.nanmin(y)), float(np.nanmax(y))))
    all_axes[0][0].set_ylabel(campaign.outputs[0].label)
    tornado = sorted(swings, key=lambda s: s[2] - s[1])
    axes = all_axes[0][n]
    middle = campaign.mean[0, 0]
    for row, (name, low, high) in enumerate(tornado):
        axes.barh(row, high - low, left=low, color=COLOURS[0])
    axes.axvline(middle, color=DARK, linewidth=1)
    axes.set_yticks(range(n), [name for name, _, _ in tornado])
    axes.set_xlabel(campaign.outputs[0].label)
    style(axes)
    lines = [f"{name}: {low:.3g} to {high:.3g} {campaign.outputs[0].unit}"
             for name, low, high in reversed(tornado)]
    return figure, {"base": middle, "tornado": [
        {"variable": name, "low": low, "high": high} for name, low, high in reversed(tornado)]}, lines


def unit_cube(campaign):
    """Points as shares of the ranges, as they were drawn."""
    columns = []
    for i, variable in enumerate(campaign.variables):
        x = campaign.column(i)
        low, high = (float(variable[end].split()[0]) for end in ("from", "to"))
        low_high = np.array([low, high])
        if len(variable["from"].split()) > 1 and variable["from"].split()[1:] != variable["to"].split()[1:]:
            raise BadInput(f"variable '{variable['name']}': give from and to in the same unit")
        if variable["scale"] == "log":
            x, low_high = np.log(x), np.log(low_high)
        columns.append((x - low_high[0]) / (low_high[1] - low_high[0]))
    return np.column_stack(columns)


def bootstrap(statistic, n, repeats=1000):
    """Percentile interval of a statistic of resampled row numbers."""
    random = np.random.default_rng(1)
    draws = np.array([statistic(random.integers(0, n, n)) for _ in range(repeats)])
    half = (1 - CONFIDENCE) / 2
    return np.quantile(draws, [half, 1 - half], axis=0)


def bars(names, groups, title):
    figure, axes = plt.subplots(figsize=(1.6 + 1.1 * len(names), 3.8))
    width = 0.8 / len(groups)
    for g, (label, value, low, high) in enumerate(groups):
        at = np.arange(len(names)) + (g - (len(groups) - 1) / 2) * width
        axes.bar(at, value, width, color=COLOURS[g], label=label)
        axes.errorbar(at, value, yerr=[np.maximum(value - low, 0), np.maximum(high - value, 0)],
                      fmt="none", ecolor=DARK, capsize=3, linewidth=1)
    axes.set_xticks(range(len(names)), [n.replace("_", "\n") for n in names], fontsize=8)
    axes.set_ylabel(title)
    axes.legend(fontsize=8, frameon=False)
    style(axes)
    return figure


def draw_morris(campaign):
    """Morris 1991; mu* of Campolongo et al. 2007: mean size of the effects over whole ranges."""
    d = len(campaign.variables)
    x, y = unit_cube(campaign), campaign.mean[:, 0]
    effects = []
    for first in range(0, len(y), d + 1):
        if np.any(np.isnan(y[first:first + d + 1])):
            continue
        row = np.empty(d)
        for p in range(first, first + d):
            j = int(np.argmax(np.abs(x[p + 1] - x[p])))
            row[j] = (y[p + 1] - y[p]) / (x[p + 1, j] - x[p, j])
        effects.append(row)
    if len(effects) < 2:
        raise BadInput("fewer than two whole trajectories: nothing to estimate")
    effects = np.array(effects)
    size, sigma = np.abs(effects).mean(0), effects.std(0, ddof=1)
    size_range = bootstrap(lambda i: np.abs(effects[i]).mean(0), len(effects))
    sigma_range = bootstrap(lambda i: effects[i].std(0, ddof=1), len(effects))
    names = [v["name"] for v in campaign.variables]
    figure = bars(names, [("mu* (mean size of effect)", size, *size_range),
                          ("sigma (interaction, curvature)", sigma, *sigma_range)],
                  campaign.outputs[0].label)
    order = np.argsort(-size)
    lines = [f"{names[j]}: mu* {size[j]:.3g} [{size_range[0][j]:.3g}, {size_range[1][j]:.3g}], "
             f"sigma {sigma[j]:.3g}, mean {effects[:, j].mean():+.3g} {campaign.outputs[0].unit}"
             for j in order]
    return figure, {"trajectories": len(effects), "variables": names, "mu": effects.mean(0).tolist(),
                    "mu_star": size.tolist(), "mu_star_interval": size_range.T.tolist(),
                    "sigma": sigma.tolist(), "sigma_interval": sigma_range.T.tolist()}, lines


def sobol_indices(points, values, rows):
    """First order by Mauntz and Kucherenko's estimator, which is the better one for small indices,
    and total order by Jansen's; both by OpenTURNS, with bootstrap intervals."""
    try:
        import openturns as ot
    except ImportError as error:
        raise BadInput(f"Sobol indices need python3-openturns: {error}") from None
    arguments = ot.Sample(points.tolist()), ot.Sample(values.reshape(-1, 1).tolist()), rows
    ot.RandomGenerator.SetSeed(1)

    def prepared(kind):
        algorithm = kind(*arguments)
        algorithm.setUseAsymptoticDistribution(False)
        algorithm.setConfidenceLevel(CONFIDENCE)
        return algorithm

    def with_interval(index, interval):
        return np.array([np.array(index), np.array(interval.getLowerBound()),
                         np.array(interval.getUpperBound())])

    first = prepared(ot.MauntzKucherenkoSensitivityAlgorithm)
    total = prepared(ot.JansenSensitivityAlgorithm)
    return (with_interval(first.getFirstOrderIndices(), first.getFirstOrderIndicesInterval()),
            with_interval(total.getTotalOrderIndices(), total.getTotalOrderIndicesInterval()))


def draw_sobol(campaign):
    d, n = len(campaign.variables), campaign.plan["samples"]
    x, y = unit_cube(campaign), campaign.mean[:, 0]
    blocks = y.reshape(d + 2, n)
    whole = ~np.any(np.isnan(blocks), axis=0)
    kept = int(whole.sum())
    if kept < 2:
        raise BadInput("fewer than two whole rows: nothing to estimate")
    points = x.reshape(d + 2, n, d)[:, whole].reshape(-1, d)
    first, total = sobol_indices(points, blocks[:, whole].ravel(), kept)
    names = [v["name"] for v in campaign.variables]
    figure = bars(names, [("first order", *first), ("total", *total)],
                  f"share of the variance of\n{campaign.outputs[0].label}")
    both = blocks[:2, whole]
    lines = [f"mean {both.mean():.3g}, standard deviation {both.std(ddof=1):.3g} "
             f"{campaign.outputs[0].unit} over {both.size} points"]
    lines += [f"{names[j]}: first {first[0, j]:.2f} [{first[1, j]:.2f}, {first[2, j]:.2f}], "
              f"total {total[0, j]:.2f} [{total[1, j]:.2f}, {total[2, j]:.2f}]"
              for j in np.argsort(-total[0])]
    return figure, {"rows": kept, "variables": names, "mean": float(both.mean()),
                    "standard_deviation": float(both.std(ddof=1)),
                    "first": first[0].tolist(), "first_interval": first[1:].T.tolist(),
                    "total": total[0].tolist(), "total_interval": total[1:].T.tolist()}, lines


def draw_scatter(campaign):
    """Rank correlations with bootstrap intervals."""
    y = campaign.mean[:, 0]
    valid = ~np.isnan(y)
    n = len(campaign.variables)
    figure, all_axes = plt.subplots(1, n, figsize=(3.2 * n, 3.4), squeeze=False, sharey=True)
    lines, statistics = [], []

    def ranks(a):
        return np.argsort(np.argsort(a)).astype(float)

    for i, axes in enumerate(all_axes[0]):
        x = campaign.column(i)
        axes.plot(x, y, ".", color=COLOURS[0])
        axes.set_xlabel(campaign.variables[i]["column"].replace("_", " "))
        if campaign.variables[i]["scale"] == "log":
            axes.set_xscale("log")
        style(axes)
        a, b = x[valid], y[valid]
        rho = np.corrcoef(ranks(a), ranks(b))[0, 1]
        low, high = bootstrap(lambda s: np.corrcoef(ranks(a[s]), ranks(b[s]))[0, 1], len(a))
        name = campaign.variables[i]["name"]
        lines.append(f"{name}: rank correlation {rho:+.2f} [{low:+.2f}, {high:+.2f}]")
        statistics.append({"variable": name, "rank_correlation": rho, "interval": [low, high]})
    all_axes[0][0].set_ylabel(campaign.outputs[0].label)
    low, high = bootstrap(lambda s: y[valid][s].mean(), int(valid.sum()))
    lines.insert(0, f"mean {y[valid].mean():.3g} [{low:.3g}, {high:.3g}], standard deviation "
                    f"{y[valid].std(ddof=1):.3g} {campaign.outputs[0].unit}")
    return figure, {"correlations": statistics, "mean": float(y[valid].mean()),
                    "mean_interval": [low, high]}, lines


DRAWINGS = {"grid": draw_grid, "one_at_a_time": draw_one_at_a_time, "morris": draw_morris,
            "sobol": draw_sobol, "random": draw_scatter, "latin_hypercube": draw_scatter}


def main(folder, quiet):
    campaign = Campaign(folder)
    figure, statistics, lines = DRAWINGS[campaign.plan["design"]](campaign)
    title = campaign.plan["title"]
    if title:
        figure.suptitle(title, color=DARK)
    figure.tight_layout()
    figure.savefig(folder / "study.png", dpi=110)
    if campaign.plan["shifts"] > 1:
        lines.append(f"jitter over the shifts of a point: {campaign.jitter[0]:.2g} "
                     f"{campaign.outputs[0].unit} (standard deviation; bands in the picture)")
    if campaign.incomplete:
        lines.append(f"{campaign.incomplete} of {len(campaign.values)} points failed and are left out")
    statistics |= {"output": campaign.outputs[0].path, "unit": campaign.outputs[0].unit,
                   "confidence": CONFIDENCE, "jitter": campaign.jitter[0],
                   "points": len(campaign.values), "incomplete": campaign.incomplete}
    (folder / "statistics.json").write_text(json.dumps(statistics, indent=1) + "\n")
    report = [f"# {title or 'Campaign'}", "", f"Design {campaign.plan['design']}, "
              f"{campaign.plan['runs']} runs; intervals are at {100 * CONFIDENCE:g} %.", ""]
    report += [f"- {line}" for line in lines] + ["", "![](study.png)", ""]
    (folder / "report.md").write_text("\n".join(report))
    if not quiet:
        print("\n".join(lines))
        print(f"picture and report in {folder}: study.png, statistics.json, report.md")


if __name__ == "__main__":
    run(main, ("study.png", "statistics.json", "report.md"), __doc__, EXAMPLES)
