// The tissue of a scene: mesh, numbering, operator, supports and loads.
#pragma once

#include "stylet/fem/tissue_operator.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/numbering.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/solvers/constraint_set.hpp"

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stylet {

/// A mesh in the numbers of this run, with the way back to the order of its source.
struct NumberedMesh {
  Mesh mesh;
  std::vector<int> first_node;  ///< rank r owns nodes first_node[r] .. first_node[r+1]-1
  std::vector<int> new_of_old_node;
  std::vector<int> old_cell_of_new;
  std::string file_fingerprint = {};  ///< of the bytes of mesh.file; empty for a rectangle
};

/// A file that a scene names, found from the scene's folder.
[[nodiscard]] std::string path_in(const Scene& scene, const std::string& name);
/// The mesh file of a scene, found from the scene's folder; empty for a rectangle.
[[nodiscard]] std::string mesh_path(const Scene& scene);

/// The same of its recorded procedure; empty if there is none.
[[nodiscard]] std::string procedure_path(const Scene& scene);

/// How long a needle of a recorded procedure is pushed (s).
struct Pushing {
  std::string needle;
  double duration = 0;
  double shortest = std::numeric_limits<double>::infinity();  ///< row: a step ends there
};
[[nodiscard]] std::vector<Pushing> pushings_of(const Scene& scene);

/// Of an insertion. The reference scene's placement error moves by 0.2 % from 450 steps to 5, by 2 % to 1.
constexpr int fewest_steps = 4;

/// Collective. The scene with the rows of its procedure, unless it has them; note: as read_procedure.
[[nodiscard]] Scene with_procedure(MPI_Comm comm, Scene scene, std::string& note);

/// The scene in the needle's coordinates (geometry/rotation.hpp): points, loads and displacements;
/// the mesh is turned by make_mesh.
[[nodiscard]] Scene in_needle_frame(Scene scene);

/// Collective. Reads or makes, checks, refines, turns and numbers the mesh of a scene. Throws
/// InputError.
[[nodiscard]] NumberedMesh make_mesh(MPI_Comm comm, const Scene& scene);

/// Collective. Everything that a scene says of its mesh by name or by place exists: regions, curves,
/// targets and probes inside the tissue, needles that meet it. Throws InputError. Locks the curves
/// that carry conditions.
void check_against_mesh(const Scene& scene, Mesh& mesh);

/// Throws InputError where steps of this length (s) are too long for the insertion of a needle.
void check_step(const Scene& scene, const Mesh& mesh, double step);

/// Nodes whose edges needles at these heights (m) may flip, in the mesh as it is now; both are lent.
[[nodiscard]] std::function<bool(int)> near_needles(const Scene& scene,
                                                    const Mesh& mesh,
                                                    const std::vector<double>& heights);

/// Collective. Nodes near a needle's axis get room for edge flips. live: needles are not known yet, and
/// the tissue may be changed.
[[nodiscard]] std::unique_ptr<TissueOperator> make_tissue(MPI_Comm comm,
                                                          const Scene& scene,
                                                          const NumberedMesh& numbered,
                                                          bool live = false,
                                                          Stiffness kept = Stiffness::matrix);

/// The outer outline of a region as closed polygon of mesh points, counter-clockwise; holes in it,
/// such as another region inside, are left out. Throws InputError if it is not one closed curve.
[[nodiscard]] std::vector<ReferencePoint> region_outline(const Mesh& mesh,
                                                         const std::string& region);

}  // namespace stylet
