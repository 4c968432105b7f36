// The rules that tie several keys of a scene together. What needs the mesh (is a target inside the
// tissue, does a curve exist) is checked where the mesh is.
#pragma once

#include "stylet/scene/document.hpp"
#include "stylet/scene/scene.hpp"

namespace stylet {

/// Everything a scene made in code has to keep: the range of every key and the rules. Throws
/// InputError, as load_scene does, with scene.file as the place. load_scene has already done it, a
/// Simulation does it for scenes without a document.
void check(const Scene& scene);

/// The same for a needle that enters by a hand's orders (LiveHand), whatever its `motion`: keys are
/// called as those of the scene's first needle would be.
void check_needle(const Scene& scene, const NeedleParameters& needle);

/// The place of scenes that have no file, in messages.
inline constexpr const char* scene_in_code = "scene";

/// The rules alone, with messages that point into the document the scene was read from.
void check_rules(const Scene& scene, const Node& document);

/// Why the seeds of a run that ends at its last implant are not where they come to rest; empty if
/// they are: linear tissue that nothing acts on any more goes back to where it was.
[[nodiscard]] std::string why_not_at_rest(const Scene& scene);

/// True if a run ends beside a needle in space that is still in. The mesh moves as if the needle's force were spread
/// over its kernel, so it does not tell where seeds are (MODEL, section 13).
[[nodiscard]] bool hides_places(const Scene& scene);
/// Throws InputError if that is so.
void require_places(const Scene& scene);

/// Throws InputError `place: key 'path': message`, for what shows only where the mesh is. The place
/// is that in the document, or the file of a scene that was made in code.
[[noreturn]] void refuse_key(const Scene& scene,
                             const std::string& path,
                             const std::string& message);

}  // namespace stylet
