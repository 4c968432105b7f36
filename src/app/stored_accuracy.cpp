#include "stylet/app/stored_accuracy.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/model.hpp"

#include <filesystem>
#include <utility>

namespace stylet {

StoredAccuracy stored_accuracy(const Scene& scene) {
  const std::string path = accuracy_path(scene.file);
  int there = 0;
  if (rank_of(MPI_COMM_WORLD) == 0) there = std::filesystem::exists(path) ? 1 : 0;
  MPI_Bcast(&there, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (there == 0) return {};
  try {
    Accuracy study(path, read_on_all(MPI_COMM_WORLD, path));
    const std::string mesh = mesh_path(scene);
    const std::string reason =
        study.mismatch(scene, mesh.empty() ? mesh : fingerprint(read_on_all(MPI_COMM_WORLD, mesh)));
    if (reason.empty()) return {std::move(study), {}};
    return {{}, reason};
  } catch (const InputError& error) {
    return {{}, error.what()};
  }
}

}  // namespace stylet
