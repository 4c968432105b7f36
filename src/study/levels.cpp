#include "stylet/study/levels.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/point_text.hpp"
#include "stylet/simulation/room.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

void require_levels(MPI_Comm comm,
                    const std::string& verb,
                    const Scene& scene,
                    double refine,
                    double shortest,
                    double longest) {
  NumberedMesh numbered = make_mesh(comm, scene);
  const Scene turned = in_needle_frame(scene);
  check_against_mesh(turned, numbered.mesh);
  constexpr double beyond_all = 1000;
  const int finest = static_cast<int>(std::min(refine, beyond_all));
  const double source = numbered.mesh.n_cells() / std::pow(2.0, scene.dim() * scene.mesh.refine);
  const Room room = room_for(comm, scene, source, finest);
  if (!room.lack.empty()) {
    const int spare = finest - room.finest;  // levels
    throw InputError(verb + ": --mesh-levels: the finest mesh, with mesh.refine " + brief(refine) +
                     ", has " + room.lack + "; allowed here: a finest mesh with mesh.refine " +
                     std::to_string(room.finest) + ", " + std::to_string(spare) +
                     (spare == 1 ? " level" : " levels") + " fewer");
  }
  for (const double step : {shortest, longest}) {
    try {
      check_step(turned, numbered.mesh, step);
    } catch (const InputError& error) {
      throw InputError(verb + ": --step-levels: " + error.what());
    }
  }
}

}  // namespace stylet
