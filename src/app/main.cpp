#include "stylet/app/verbs.hpp"
#include "stylet/base/errors.hpp"
#include "stylet/base/units.hpp"
#include "stylet/petsc/session.hpp"

#include <CLI/CLI.hpp>

#include <array>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace stylet;

constexpr const char* examples = R"(
Examples:
  stylet run input/prostate.yaml
  mpirun -n 2 stylet run input/prostate.yaml --output out/deeper --force \
      --set needles.0.motion.0.position="2.85 cm"
  stylet run input/prostate.yaml --set time.until=implanted --set mesh.refine=1
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
  stylet schema
  stylet run input/prostate.yaml -- -ksp_monitor -pc_type gamg

Items of lists are counted from 0; names with dots stand in double quotes; KEY=null takes a key away.
PETSc options stand after -- and only tune solvers: -ksp_*, -pc_*, -log_view.
Exit codes: 0 done, 2 bad scene or mesh, 3 numerical failure, 4 input/output, 1 anything else.)";

/// Everything after -- is PETSc's.
std::vector<std::string> split(std::span<char*> arguments, std::vector<char*>& for_petsc) {
  std::vector<std::string> own;
  bool ours = true;
  for_petsc.push_back(arguments[0]);
  for (char* argument : arguments.subspan(1)) {
    if (ours && std::string_view(argument) == "--") {
      ours = false;
    } else if (ours) {
      own.emplace_back(argument);
    } else {
      for_petsc.push_back(argument);
    }
  }
  return own;
}

/// What is wrong with PETSc's options; empty if nothing is. PETSc acts on some of its options when it
/// starts, and has some that change more than solvers, or read files.
std::string trouble_with(std::span<char* const> options) {
  constexpr std::array allowed{
      "-ksp_",        "-pc_", "-sub_", "-mg_",          "-mat_mumps_",
      "-eps_",        "-st_", "-log_", "-options_left", "-mat_superlu_dist_",
      "-mat_cholmod_"};
  // Which modes are computed is not for a solver to say.
  constexpr std::array other_modes{"-eps_target",    "-eps_largest",  "-eps_smallest", "-eps_nev",
                                   "-eps_all",       "-eps_interval", "-eps_harmonic", "-eps_gen",
                                   "-eps_hermitian", "-eps_non",      "-eps_pos",      "-st_shift"};
  const auto is_one_of = [](std::string_view option, std::span<const char* const> starts) {
    return std::ranges::any_of(starts,
                               [&](const char* start) { return option.starts_with(start); });
  };
  for (const std::string_view option : options) {
    const bool is_name = option.size() > 1 && option[0] == '-' && std::isalpha(option[1]) != 0;
    if (!is_name) continue;
    if (!is_one_of(option, allowed)) {
      return "PETSc option " + std::string(option) +
             " is not one of the solver options -ksp_*, -pc_*, -mg_*, -sub_*, -mat_mumps_*, "
             "-eps_*, "
             "-st_*, -log_*";
    }
    if (is_one_of(option, other_modes)) {
      return "PETSc option " + std::string(option) +
             " changes which modes are computed; solver options only change how";
    }
  }
  return {};
}

/// CLI11 would only say that a subcommand is missing.
void require_known_verb(const CLI::App& app, const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments[0].starts_with("-")) return;
  std::string verbs;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == arguments[0]) return;
    verbs += (verbs.empty() ? "" : ", ") + verb->get_name();
  }
  throw InputError("'" + arguments[0] + "' is no verb; allowed: " + verbs + "; see stylet --help");
}

/// The value of an option in SI.
double in_unit(const std::string& option, const std::string& text, const std::string& unit) {
  try {
    return to_si(text, unit);
  } catch (const InputError& error) {
    throw InputError(option + ": " + error.what());
  }
}

int program(std::vector<std::string> arguments, const std::string& bad_options) {
  CLI::App app{
      "stylet simulates how a needle deforms and cuts soft tissue and where its seeds end "
      "up."};
  app.name("stylet");
  app.footer(examples);
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("stylet ") + STYLET_VERSION);

  SceneArguments scene;
  RunOptions options;
  int n_modes = 0;
  bool markdown = false;
  const auto takes_scene = [&](CLI::App* verb) {
    verb->add_option("scene", scene.file, "scene file (YAML)")->required();
    verb->add_option("--set", scene.overrides,
                     "key=value of the scene, may be repeated; keys as in `stylet schema`")
        ->allow_extra_args(false);
    verb->footer(examples);
  };
  CLI::App* run = app.add_subcommand("run", "simulate a scene");
  takes_scene(run);
  run->add_option("--output", options.output, "folder of the results (default: out/<scene>)");
  std::string accuracy;
  run->add_option(
      "--accuracy", accuracy,
      "wanted for the placement error, such as '0.2 mm': takes the cheapest mesh and step "
      "that the stored convergence study says reach it");
  run->add_flag("--force", options.force, "overwrite the results of an earlier run");
  run->add_flag("--quiet", options.quiet, "print errors only");
  CLI::App* check = app.add_subcommand("check", "validate a scene and its mesh, run nothing");
  takes_scene(check);
  CLI::App* modes = app.add_subcommand("modes", "smallest natural frequencies of a scene's tissue");
  modes->add_option("n", n_modes, "how many")->required();
  takes_scene(modes);
  StabilityOptions study;
  CLI::App* stability = app.add_subcommand(
      "stability", "measure which time steps are stable during a scene's insertion");
  takes_scene(stability);
  stability->add_option("--samples", study.samples, "moments of the insertion, evenly spaced")
      ->capture_default_str();
  stability->add_option("--output", study.output,
                        "folder of the results (default: out/stability-<scene>)");
  stability->add_flag("--force", study.force, "overwrite the results of an earlier study");
  stability->add_flag("--quiet", study.quiet, "print errors only");
  StudyOptions many;
  const auto runs_many = [&](CLI::App* verb, const std::string& folder) {
    verb->add_option("--output", many.output, "folder of the results (default: " + folder + ")");
    verb->add_flag("--resume", many.resume,
                   "go on with a study that was stopped: run what is missing");
    verb->add_flag("--force", many.force, "replace the results of an earlier study");
    verb->add_option("--ranks-per-run", many.ranks_per_run,
                     "ranks that share one run; the others take other runs")
        ->capture_default_str();
    verb->add_flag("!--no-picture", many.picture, "leave the picture and the report out");
    verb->add_flag("--quiet", many.quiet, "print errors only");
    verb->footer(examples);
  };
  ConvergeOptions levels;
  CLI::App* converge = app.add_subcommand(
      "converge", "refine mesh and time step: orders, limits and uncertainty of a scene's numbers");
  takes_scene(converge);
  runs_many(converge, "out/converge-<scene>");
  converge->add_option("--mesh-levels", levels.mesh_levels, "the scene's mesh and finer ones")
      ->capture_default_str();
  converge->add_option("--step-levels", levels.step_levels, "the scene's time step and halved ones")
      ->capture_default_str();
  converge->add_flag(
      "--store", levels.store,
      "keep the result as <scene>.accuracy.json, for the uncertainties that run prints");
  TradeoffOptions trade;
  CLI::App* tradeoff = app.add_subcommand(
      "tradeoff", "measure speed against accuracy: methods, meshes and steps of a scene");
  takes_scene(tradeoff);
  runs_many(tradeoff, "out/tradeoff-<scene>");
  tradeoff
      ->add_option("--mesh-levels", trade.mesh_levels,
                   "the scene's mesh and finer ones; the reference is one finer still")
      ->capture_default_str();
  tradeoff->add_option("--step-levels", trade.step_levels, "the scene's time step and longer ones")
      ->capture_default_str();
  tradeoff->add_option("--repeats", trade.repeats, "of a run, for its median time")
      ->capture_default_str();
  PlanOptions plans;
  CLI::App* plan = app.add_subcommand(
      "plan", "find the heights and stops of the needles that bring the seeds to their targets");
  takes_scene(plan);
  const auto length = [&](const char* name, double& value, const char* doc) {
    plan->add_option_function<std::string>(
        name, [name, &value](const std::string& text) { value = in_unit(name, text, "m"); }, doc);
  };
  length("--depth-range", plans.depth_range,
         "how far a stop may be from the scene's, such as '10 mm' (default: 15 mm)");
  length("--height-range", plans.height_range,
         "how far a height may be from the scene's; '0 mm' keeps it (default: 5 mm)");
  length("--tolerance", plans.tolerance, "placement error that is good enough (default: 0.05 mm)");
  std::vector<std::string> speeds;
  plan->add_option("--speed-range", speeds,
                   "also choose the speed of insertion, between two such as '1 cm/s' '10 cm/s'")
      ->expected(2);
  plan->add_option("--most-runs", plans.most_runs, "for one needle")->capture_default_str();
  plan->add_option("--output", plans.output, "folder of the results (default: out/plan-<scene>)");
  plan->add_flag("--force", plans.force, "replace the results of an earlier plan");
  plan->add_flag("--quiet", plans.quiet, "print errors only");
  CLI::App* sweep = app.add_subcommand("sweep", "run a campaign: a scene with some keys varied");
  sweep->add_option("campaign", scene.file, "campaign file (YAML)")->required();
  sweep->add_option("--set", scene.overrides, "key=value of the scene, for all runs")
      ->allow_extra_args(false);
  runs_many(sweep, "out/sweep-<campaign>");
  SweepOptions campaign;
  std::string part;
  sweep->add_option("--part", part,
                    "K/N: run every N-th run, from the K-th on, into part-K in the folder; N of "
                    "these make the campaign");
  sweep->add_flag("--join", campaign.join,
                  "take over what parts in the folder have run, then run what is missing");
  CLI::App* schema =
      app.add_subcommand("schema", "all keys of a scene: type, unit, range, default");
  schema->add_flag("--markdown", markdown, "as a table for the README");

  if (!bad_options.empty()) throw InputError(bad_options);
  require_known_verb(app, arguments);
  const bool first = rank_of(MPI_COMM_WORLD) == 0;
  try {
    std::ranges::reverse(arguments);  // CLI11 takes them from the back
    app.parse(arguments);
  } catch (const CLI::Success& help) {
    if (first) app.exit(help);
    return static_cast<int>(ExitCode::done);
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + "; see stylet --help");
  }
  if (*run) {
    if (!accuracy.empty()) (void)in_unit("--accuracy", accuracy, "m");
    return run_verb(scene, options, accuracy);
  }
  if (*check) return check_verb(scene);
  if (*modes) return modes_verb(scene, n_modes);
  if (*converge) {
    levels.study = many;
    return converge_verb(scene, levels);
  }
  if (*tradeoff) {
    trade.study = many;
    return tradeoff_verb(scene, trade);
  }
  if (*plan) {
    if (!speeds.empty())
      plans.speeds = {in_unit("--speed-range", speeds[0], "m/s"),
                      in_unit("--speed-range", speeds[1], "m/s")};
    return plan_verb(scene, plans);
  }
  if (*sweep) {
    campaign.study = many;
    if (!part.empty()) campaign.part = parse_part(part);
    return sweep_verb(scene, campaign);
  }
  if (*stability) return stability_verb(scene, study);
  return schema_verb(markdown);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<char*> for_petsc;
  auto own = split({argv, static_cast<std::size_t>(argc)}, for_petsc);
  const std::string bad_options = trouble_with(std::span(for_petsc).subspan(1));
  if (!bad_options.empty()) for_petsc.resize(1);  // PETSc must not see it
  const stylet::Session session(static_cast<int>(for_petsc.size()), for_petsc.data());
  return stylet::run_guarded([&] { return program(std::move(own), bad_options); });
}
