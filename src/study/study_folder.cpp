#include "stylet/study/study_folder.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/run.hpp"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace stylet {

namespace {

namespace fs = std::filesystem;

/// Waits for a program; whether it ended well. Not std::system: quotes in a folder's name.
bool succeeds(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) {
    return false;
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Collective. As rank 0 sees it.
bool exists(MPI_Comm comm, const std::string& path) {
  int there = 0;
  if (rank_of(comm) == 0) there = fs::exists(path) ? 1 : 0;
  MPI_Bcast(&there, 1, MPI_INT, 0, comm);
  return there == 1;
}

}  // namespace

std::string study_folder(const StudyOptions& options,
                         const std::string& verb,
                         const std::string& file) {
  if (!options.output.empty()) return options.output;
  return "out/" + verb + "-" + fs::path(file).stem().string();
}

bool holds_study(MPI_Comm comm, const std::string& folder) {
  return exists(comm, folder + "/plan.json");
}

Table open_study(MPI_Comm comm,
                 const std::string& folder,
                 const StudyOptions& options,
                 const nlohmann::ordered_json& plan,
                 std::vector<std::string> columns) {
  const std::string plan_path = folder + "/plan.json";
  const std::string results_path = folder + "/results.csv";
  const std::string text = plan.dump(1) + "\n";
  if (options.resume && options.force) {
    throw InputError("--resume keeps earlier results, --force replaces them: give one of them");
  }
  if (options.resume && exists(comm, plan_path)) {
    if (read_on_all(comm, plan_path) != text) {
      throw InputError(plan_path +
                       ": the study in this folder was another one, so it cannot be resumed; use "
                       "another folder with --output, or --force to replace it");
    }
    if (!exists(comm, results_path)) return {std::move(columns), {}};
    Table table = read_csv(results_path, read_on_all(comm, results_path));
    if (!table.columns.empty() && table.columns != columns) {
      throw InputError(results_path + ": its columns are not those of this study");
    }
    table.columns = std::move(columns);
    return table;
  }
  prepare_folder(comm, folder, options.force);
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    std::error_code failed;
    fs::create_directories(folder + "/scenes", failed);
    if (failed) throw IoError(folder + "/scenes: cannot be created: " + failed.message());
  });
  write_text_atomically(comm, plan_path, text);
  return {std::move(columns), {}};
}

void keep_scene(MPI_Comm comm,
                const std::string& folder,
                const std::string& id,
                const Scene& scene) {
  write_text_atomically(comm, folder + "/scenes/" + id + ".yaml", resolved_text(scene),
                        Durable::no);
}

void draw(MPI_Comm comm, const std::string& script, const std::string& folder, bool quiet) {
  if (rank_of(comm) == 0) {
    const std::string path = std::string(STYLET_JOBS) + "/" + script;
    std::fflush(stdout);
    std::vector<std::string> arguments{"python3", "-B", path, folder};
    if (quiet) arguments.emplace_back("--quiet");
    if (!succeeds("/usr/bin/python3", arguments)) {
      std::fprintf(stderr, "stylet: no picture; to draw it: /usr/bin/python3 %s %s\n", path.c_str(),
                   folder.c_str());
    }
  }
  MPI_Barrier(comm);
}

}  // namespace stylet
