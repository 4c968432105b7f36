#include "stylet/app/command_line.hpp"
#include "stylet/base/errors.hpp"
#include "stylet/petsc/session.hpp"

#include <array>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace stylet;

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
      "-ksp_",         "-pc_",     "-sub_",      "-mg_",          "-mat_mumps_",
      "-eps_",         "-st_",     "-log_",      "-options_left", "-mat_superlu_dist_",
      "-mat_cholmod_", "-ts_view", "-ts_monitor"};
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
             "-st_*, -log_*, -ts_view, -ts_monitor*";
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

int program(std::vector<std::string> arguments, const std::string& bad_options) {
  Asked asked;
  CLI::App app;
  declare(app, asked);
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
  const std::string verb = app.get_subcommands().front()->get_name();
  if (verb == "run") return run_verb(asked.scene, asked.run, asked.accuracy);
  if (verb == "check") return check_verb(asked.scene);
  if (verb == "modes") return modes_verb(asked.scene, asked.n_modes);
  if (verb == "stability") return stability_verb(asked.scene, asked.stability);
  if (verb == "converge") return converge_verb(asked.scene, asked.converge);
  if (verb == "tradeoff") return tradeoff_verb(asked.scene, asked.tradeoff);
  if (verb == "plan") return plan_verb(asked.scene, asked.plan);
  if (verb == "sweep") return sweep_verb(asked.scene, asked.sweep);
  if (verb == "view") return view_verb(asked.scene, asked.view);
  return schema_verb(asked.markdown);
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
