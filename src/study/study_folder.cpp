#include "stylet/study/study_folder.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/checkpoint.hpp"
#include "stylet/simulation/run.hpp"
#include "stylet/study/identity.hpp"

#include <nlohmann/json.hpp>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace stylet {

namespace {

namespace fs = std::filesystem;

/// Waits for a program; whether it ended well. Not std::system: quotes in a folder's name.
bool succeeds(const std::vector<std::string>& arguments) {
  const char* program = arguments.front().c_str();
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawn(&child, program, nullptr, nullptr, argv.data(), environ) != 0) {
    return false;
  }
  int status = 0;
  while (waitpid(child, &status, 0) != child) {
    if (errno != EINTR) return false;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Collective. As rank 0 sees it.
bool exists(MPI_Comm comm, const std::string& path) {
  int there = 0;
  if (rank_of(comm) == 0) there = fs::exists(path) ? 1 : 0;
  MPI_Bcast(&there, 1, MPI_INT, 0, comm);
  return there == 1;
}

std::string plan_text(const nlohmann::ordered_json& plan) {
  return plan.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Table rows_of(MPI_Comm comm,
              const std::string& path,
              const nlohmann::ordered_json& plan,
              std::vector<std::string> columns) {
  const std::string plan_path = path + "/plan.json";
  const std::string results_path = path + "/results.csv";
  const std::string earlier = read_on_all(comm, plan_path);
  if (earlier != plan_text(plan)) {
    const auto parsed = nlohmann::ordered_json::parse(earlier, nullptr, false);
    const std::string what = parsed.is_object() ? differences(parsed, plan) : "it is no plan";
    throw InputError(
        plan_path +
        ": the study in this folder was another one, so it cannot go on; what differs: " + what +
        "; use another folder with --output, or --force to replace it");
  }
  const std::string of_plan = fingerprint(earlier);
  if (!exists(comm, results_path)) return {std::move(columns), {}, of_plan};
  Table table = read_results(results_path, read_on_all(comm, results_path), of_plan);
  if (!table.columns.empty() && table.columns != columns) {
    throw InputError(results_path + ": its columns are not those of this study");
  }
  table.columns = std::move(columns);
  return table;
}

}  // namespace

std::string study_folder(const StudyOptions& options,
                         const std::string& verb,
                         const std::string& file) {
  if (!options.output.empty()) return options.output;
  return "out/" + verb + "-" + fs::path(file).stem().string();
}

OpenStudy open_study(MPI_Comm comm,
                     const std::string& path,
                     const std::string& verb,
                     std::vector<std::string> names,
                     const StudyOptions& options,
                     const nlohmann::ordered_json& plan,
                     std::vector<std::string> columns) {
  if (options.resume && options.force) {
    throw InputError("--resume keeps earlier results, --force replaces them: give one of them");
  }
  names.insert(names.end(), {"plan.json", "results.csv", "scenes/", Checkpoints::folder_name,
                             "study.png", "report.md"});
  const Earlier earlier = options.resume  ? Earlier::keep
                          : options.force ? Earlier::replace
                                          : Earlier::refuse;
  OpenStudy study;
  // Rows of results.csv may have been taken out, to compute them again.
  study.folder = std::make_unique<OutputFolder>(
      comm, path, Contents{verb, std::move(names), {"results.csv"}}, earlier, OnSignal::tell);
  if (exists(comm, path + "/plan.json")) {
    study.kept = rows_of(comm, path, plan, std::move(columns));
  } else {
    study.kept = {std::move(columns), {}, fingerprint(plan_text(plan))};
    write_text_atomically(comm, path + "/plan.json", plan_text(plan));
  }
  study.folder->go_on();
  return study;
}

Table read_study(MPI_Comm comm,
                 const std::string& path,
                 const nlohmann::ordered_json& plan,
                 std::vector<std::string> columns) {
  std::optional<FolderLock> lock;
  agree_after(comm, [&] {
    if (rank_of(comm) == 0) lock.emplace(path);
  });
  return rows_of(comm, path, plan, std::move(columns));
}

void keep_scene(MPI_Comm comm,
                const std::string& folder,
                const std::string& id,
                const Scene& scene) {
  write_text_atomically(comm, folder + "/scenes/" + id + ".yaml", resolved_text(scene),
                        Durable::no);
}

std::string script_path(const std::string& script) {
  std::error_code unknown;
  const fs::path here = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  const fs::path installed = (here / STYLET_SCRIPTS / script).lexically_normal();
  const fs::path built = here / "jobs" / script;
  return (fs::exists(built) && !fs::exists(installed) ? built : installed).string();
}

void draw(MPI_Comm comm, const std::string& script, const std::string& folder, bool quiet) {
  if (rank_of(comm) == 0) {
    const std::string path = script_path(script);
    std::fflush(stdout);
    // By its whole name: Python seeks its modules where its name is found first.
    std::vector<std::string> arguments{"/usr/bin/python3", "-B", path, folder};
    if (quiet) arguments.emplace_back("--quiet");
    if (!succeeds(arguments)) {
      std::fprintf(stderr, "stylet: no picture; to draw it: /usr/bin/python3 %s %s\n", path.c_str(),
                   folder.c_str());
    }
  }
  MPI_Barrier(comm);
}

}  // namespace stylet
