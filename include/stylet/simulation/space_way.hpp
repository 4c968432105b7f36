// The ways of needles in space: straight lines, known before the run.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/embedded_path.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/needle_path.hpp"

#include <memory>
#include <string>
#include <vector>

namespace stylet {

/// Throws InputError for a key of a needle.
[[noreturn]] void refuse_needle(const Scene& scene,
                                const NeedleParameters& needle,
                                const std::string& key,
                                const std::string& why);

/// What find_path finds in the plane. Throws InputError, with the needle's keys, for a line that misses the
/// tissue, or begins inside it.
[[nodiscard]] NeedlePath find_way(const Scene& scene,
                                  const Mesh& mesh,
                                  const NeedleParameters& needle);

/// The triangles of the scene's membrane; none without one. Throws InputError where they leave gaps.
[[nodiscard]] std::vector<SurfaceTriangle> membrane_surface(const Scene& scene, const Mesh& mesh);

/// The skin around the entry is a plane as far as the kernel reaches, and the needle no more than 40 degrees
/// from its normal: else the near field does not know the skin.
[[nodiscard]] bool has_plane_skin(const Mesh& mesh,
                                  const NeedleParameters& needle,
                                  const NeedlePath& path);

/// From the needle's way to the nearest surface that a support or a prescribed displacement holds (m).
[[nodiscard]] double distance_to_held(const Scene& scene,
                                      const Mesh& mesh,
                                      const NeedleParameters& needle,
                                      const NeedlePath& path);

/// Of the kernel's edge along the way, that lies in tissue of another modulus than the needle there.
[[nodiscard]] double share_in_other_tissue(const Scene& scene,
                                           const Mesh& mesh,
                                           const NeedleParameters& needle,
                                           const NeedlePath& path);

/// The path of a needle that stands at the skin. Throws InputError where its kernel lies outside the tissue.
[[nodiscard]] std::unique_ptr<EmbeddedPath> make_path(const Scene& scene,
                                                      const Mesh& mesh,
                                                      const NeedleParameters& needle,
                                                      NeedleTissue tissue);

/// Throws InputError for needles that leave the tissue, whose kernel reaches what is held or another side of
/// the tissue, and for all that make_path refuses.
void check_ways(const Scene& scene, const Mesh& mesh);

}  // namespace stylet
