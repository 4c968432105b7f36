// What decides the numbers of a study beside its scene: the program, its solver options, the bytes of
// mesh files.
#pragma once

#include "stylet/scene/scene.hpp"

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <map>
#include <span>
#include <string>

namespace stylet {

/// Fingerprints of mesh files by their names in the scene.
using MeshFiles = std::map<std::string, std::string>;

/// Collective. Of all these scenes; scenes whose mesh is made have none.
[[nodiscard]] MeshFiles mesh_files(MPI_Comm comm, std::span<const Scene> scenes);

/// Adds them to what a study says of itself.
void add_identity(nlohmann::ordered_json& plan, const MeshFiles& meshes);

/// Names of what differs between two studies; empty if nothing does.
[[nodiscard]] std::string differences(const nlohmann::ordered_json& earlier,
                                      const nlohmann::ordered_json& now);

}  // namespace stylet
