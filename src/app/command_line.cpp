#include "stylet/app/command_line.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/units.hpp"

#include <vector>

namespace stylet {

const char* const examples = R"(  stylet run input/prostate.yaml
  mpirun -n 2 stylet run input/prostate.yaml --output out/deeper --force \
      --set needles.0.motion.0.position="2.85 cm"
  stylet run input/prostate.yaml --set time.until=implanted --set mesh.refine=1
  stylet run input/prostate.yaml --set output.checkpoint.steps=100
  stylet run input/prostate.yaml --resume
  stylet inspect out/prostate/checkpoints/00000100.h5
  stylet check input/prostate.yaml
  stylet check scene.yaml --set 'tissue.regions."lobe.left".youngs_modulus=80 kPa'
  stylet modes 6 input/prostate.yaml
  stylet stability input/prostate.yaml --set tissue.damping.stiffness_factor=null \
      --set tissue.damping.mass_factor="200 1/s"
  mpirun -n 2 stylet converge input/prostate.yaml --store
  stylet run input/prostate.yaml --accuracy "0.2 mm"
  stylet tradeoff input/prostate.yaml --set time.step="5 ms"
  stylet plan input/prostate.yaml --depth-range "10 mm"
  mpirun -n 2 stylet sweep input/campaigns/figure09.yaml
  stylet view input/prostate.yaml
  stylet schema
  stylet run input/prostate.yaml -- -ksp_monitor -pc_type gamg)";

const char* const remarks =
    "Items of lists are counted from 0; names with dots stand in double quotes; KEY=null takes a "
    "key "
    "away.\n"
    "PETSc options stand after -- and only tune or show solvers: -ksp_*, -pc_*, -ts_monitor, "
    "-log_view.";

const char* const exit_codes =
    "0 done, 2 bad scene or mesh, 3 numerical failure, 4 input/output, 1 anything else.";

namespace {

std::string footer() {
  return std::string("\nExamples:\n") + examples + "\n\n" + remarks + "\nExit codes: " + exit_codes;
}

/// The value of an option in SI.
double in_unit(const std::string& option, const std::string& text, const std::string& unit) {
  try {
    return to_si(text, unit);
  } catch (const InputError& error) {
    throw InputError(option + ": " + error.what());
  }
}

/// Lives while it declares; what is called at parsing refers to `asked` only.
class Verbs {
 public:
  Verbs(CLI::App& app, Asked& asked) : app_(app), asked_(asked) {}

  void declare() {
    app_.name("stylet");
    app_.footer(footer());
    app_.require_subcommand(1);
    app_.set_version_flag("--version", std::string("stylet ") + STYLET_VERSION);
    run();
    check();
    inspect();
    modes();
    stability();
    converge();
    tradeoff();
    plan();
    sweep();
    view();
    CLI::App* schema =
        app_.add_subcommand("schema", "all keys of a scene: type, unit, range, default");
    schema->add_flag("--markdown", asked_.markdown, "as a table for the README");
  }

 private:
  void takes_scene(CLI::App* verb) {
    verb->add_option("scene", asked_.scene.file, "scene file (YAML)")->required();
    verb->add_option("--set", asked_.scene.overrides,
                     "key=value of the scene, may be repeated; keys as in `stylet schema`")
        ->allow_extra_args(false);
    verb->footer(footer());
  }

  static void writes(CLI::App* verb, auto& options, const std::string& folder) {
    verb->add_option("--output", options.output, "folder of the results (default: " + folder + ")");
    verb->add_flag("--force", options.force, "replace the results that an earlier one left there");
    verb->add_flag("--quiet", options.quiet, "print errors only");
  }

  static void resumes(CLI::App* verb, StudyOptions& options) {
    verb->add_flag("--resume", options.resume,
                   "go on with a study that was stopped: run what is missing");
  }

  static void runs_many(CLI::App* verb, StudyOptions& options, const std::string& folder) {
    writes(verb, options, folder);
    resumes(verb, options);
    verb->add_option("--ranks-per-run", options.ranks_per_run,
                     "ranks that share one run; the others take other runs")
        ->capture_default_str();
    verb->add_flag("!--no-picture", options.picture, "leave the picture and the report out");
    verb->footer(footer());
  }

  void run() {
    CLI::App* verb = app_.add_subcommand("run", "simulate a scene");
    takes_scene(verb);
    writes(verb, asked_.run, "out/<scene>");
    verb->add_flag("--resume", asked_.run.resume,
                   "go on from the newest checkpoint in the folder, on any number of ranks")
        ->excludes("--force");
    verb->add_option_function<std::string>(
        "--until",
        [&until = asked_.run.until](const std::string& text) {
          until = in_unit("--until", text, "s");
        },
        "run a part: end at that time of the scene, such as '0.5 s', with a checkpoint");
    verb->add_option_function<std::string>(
        "--accuracy",
        [&accuracy = asked_.accuracy](const std::string& text) {
          (void)in_unit("--accuracy", text, "m");
          accuracy = text;
        },
        "wanted for the placement error, such as '0.2 mm': takes the cheapest mesh and step that "
        "the stored convergence study says reach it");
  }

  void check() {
    takes_scene(app_.add_subcommand("check", "validate a scene and its mesh, run nothing"));
  }

  void inspect() {
    CLI::App* verb = app_.add_subcommand("inspect", "say what a checkpoint of a run holds");
    verb->add_option("checkpoint", asked_.checkpoint, "file in checkpoints/ of a run")->required();
    verb->add_option("--snapshot", asked_.snapshot,
                     "a new folder for what it holds as a snapshot, for ParaView");
    verb->footer(footer());
  }

  void modes() {
    CLI::App* verb =
        app_.add_subcommand("modes", "smallest natural frequencies of a scene's tissue");
    verb->add_option("n", asked_.n_modes, "how many")->required();
    takes_scene(verb);
  }

  void stability() {
    CLI::App* verb = app_.add_subcommand(
        "stability", "measure which time steps are stable during a scene's insertion");
    takes_scene(verb);
    writes(verb, asked_.stability, "out/stability-<scene>");
    verb->add_option("--samples", asked_.stability.samples,
                     "moments of the insertion, evenly spaced")
        ->capture_default_str();
  }

  void converge() {
    ConvergeOptions& levels = asked_.converge;
    CLI::App* verb = app_.add_subcommand(
        "converge",
        "refine mesh and time step: orders, limits and uncertainty of a scene's numbers");
    takes_scene(verb);
    runs_many(verb, levels.study, "out/converge-<scene>");
    verb->add_option("--mesh-levels", levels.mesh_levels, "the scene's mesh and finer ones")
        ->capture_default_str();
    verb->add_option("--step-levels", levels.step_levels, "the scene's time step and halved ones")
        ->capture_default_str();
    verb->add_flag(
        "--store", levels.store,
        "keep the result as <scene>.accuracy.json, for the uncertainties that run prints");
  }

  void tradeoff() {
    TradeoffOptions& trade = asked_.tradeoff;
    CLI::App* verb = app_.add_subcommand(
        "tradeoff", "measure speed against accuracy: methods, meshes and steps of a scene");
    takes_scene(verb);
    runs_many(verb, trade.study, "out/tradeoff-<scene>");
    verb->add_option("--mesh-levels", trade.mesh_levels,
                     "the scene's mesh and finer ones; the reference is one finer still")
        ->capture_default_str();
    verb->add_option("--step-levels", trade.step_levels, "the scene's time step and longer ones")
        ->capture_default_str();
    verb->add_option("--repeats", trade.repeats, "of a run, for its median time")
        ->capture_default_str();
  }

  void plan() {
    PlanOptions& plans = asked_.plan;
    CLI::App* verb = app_.add_subcommand(
        "plan", "find the heights and stops of the needles that bring the seeds to their targets");
    takes_scene(verb);
    writes(verb, plans.study, "out/plan-<scene>");
    resumes(verb, plans.study);
    const auto length = [&](const char* name, double& value, const char* doc) {
      verb->add_option_function<std::string>(
          name, [name, &value](const std::string& text) { value = in_unit(name, text, "m"); }, doc);
    };
    length("--depth-range", plans.depth_range,
           "how far a stop may be from the scene's, such as '10 mm' (default: 15 mm)");
    length("--height-range", plans.height_range,
           "how far a height may be from the scene's; '0 mm' keeps it (default: 5 mm)");
    length("--tolerance", plans.tolerance,
           "placement error that is good enough (default: 0.05 mm)");
    verb->add_option_function<std::vector<std::string>>(
            "--speed-range",
            [&plans](const std::vector<std::string>& speeds) {
              plans.speeds = {in_unit("--speed-range", speeds[0], "m/s"),
                              in_unit("--speed-range", speeds[1], "m/s")};
            },
            "also choose the speed of insertion, between two such as '1 cm/s' '10 cm/s'")
        ->expected(2);
    verb->add_option("--most-runs", plans.most_runs, "for one needle")->capture_default_str();
  }

  void sweep() {
    SweepOptions& campaign = asked_.sweep;
    CLI::App* verb = app_.add_subcommand("sweep", "run a campaign: a scene with some keys varied");
    verb->add_option("campaign", asked_.scene.file, "campaign file (YAML)")->required();
    verb->add_option("--set", asked_.scene.overrides, "key=value of the scene, for all runs")
        ->allow_extra_args(false);
    runs_many(verb, campaign.study, "out/sweep-<campaign>");
    verb->add_option_function<std::string>(
        "--part", [&campaign](const std::string& text) { campaign.part = parse_part(text); },
        "K/N: run every N-th run, from the K-th on, into part-K in the folder; N of these make the "
        "campaign");
    verb->add_flag("--join", campaign.join,
                   "take over what parts in the folder have run, then run what is missing");
  }

  void view() {
    ViewArguments& options = asked_.view;
    CLI::App* verb = app_.add_subcommand(
        "view", "a window: the needle in your hand, the tissue as ultrasound shows it");
    takes_scene(verb);
    verb->add_option("--script", options.script,
                     "file of orders to the hand; draws without a display (input/README.md)");
    verb->add_option("--frames", options.frames, "folder of the script's pictures")
        ->capture_default_str();
    verb->add_option("--record", options.record,
                     "recordings go to RECORD-1, RECORD-2, ... (default: out/view-<scene>)");
    verb->add_flag("!--no-record", options.records, "record nothing");
    verb->add_option(
        "--plan", options.plan,
        "scene whose needles are drawn over the tissue, such as a plan's planned.yaml");
    verb->add_option("--size", options.size, "of window or pictures, in pixels")
        ->capture_default_str();
    verb->add_option("--letters", options.letters, "size of letters and marks, such as 1.5")
        ->capture_default_str()
        ->check(CLI::Range(0.5, 4.0));
    verb->add_option("--seconds", options.seconds,
                     "close the window by itself and print how fast it was")
        ->check(CLI::NonNegativeNumber);
  }

  CLI::App& app_;
  Asked& asked_;
};

}  // namespace

void declare(CLI::App& app, Asked& asked) {
  app.description(
      "stylet simulates how a needle deforms and cuts soft tissue and where its seeds end up.");
  Verbs(app, asked).declare();
}

}  // namespace stylet
