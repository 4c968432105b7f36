#include "stylet/study/identity.hpp"

#include "stylet/base/fingerprint.hpp"
#include "stylet/base/text.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/simulation/accuracy.hpp"
#include "stylet/simulation/model.hpp"

#include <nlohmann/json.hpp>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

void compare(const Json& a,
             const Json& b,
             const std::string& what,
             std::vector<std::string>& found) {
  for (const auto& [key, value] : a.items()) {
    if (!b.contains(key) || b[key] != value) found.push_back(what + key);
  }
  for (const auto& [key, value] : b.items()) {
    if (!a.contains(key)) found.push_back(what + key);
  }
}

}  // namespace

MeshFiles mesh_files(MPI_Comm comm, std::span<const Scene> scenes) {
  MeshFiles files;
  for (const Scene& scene : scenes) {
    if (const std::string path = procedure_path(scene); !path.empty()) {
      files[scene.procedure->file] = fingerprint(read_on_all(comm, path));
    }
    if (scene.start) {
      files[scene.start->from] = fingerprint(read_on_all(comm, path_in(scene, scene.start->from)));
    }
    const auto* name = std::get_if<std::string>(&scene.mesh.source);
    if (name == nullptr || files.contains(*name)) continue;
    files[*name] = fingerprint(read_on_all(comm, mesh_path(scene)));
  }
  return files;
}

void add_identity(Json& plan, const MeshFiles& meshes) {
  plan["program"] = std::string("stylet ") + STYLET_VERSION;
  plan["solver_options"] = deciding_options();
  plan["mesh_files"] = meshes;
}

std::string differences(const Json& earlier, const Json& now) {
  std::vector<std::string> found;
  Json a = earlier;
  Json b = now;
  for (Json* plan : {&a, &b}) plan->erase("mesh_files");
  compare(a, b, "", found);
  compare(earlier.value("mesh_files", Json::object()), now.value("mesh_files", Json::object()),
          "the bytes of ", found);
  return join(found);
}

}  // namespace stylet
