// The picture that belongs to a scene.
#pragma once

#include "stylet/image/picture.hpp"
#include "stylet/mesh/mesh.hpp"
#include "stylet/scene/scene.hpp"

namespace stylet {

/// The scene's image file, or where it names none a picture like ultrasound, made from regions and
/// membrane; the same bytes on any machine. scene, mesh: of a Simulation. Not collective. Throws
/// InputError where the file cannot be used, with key and file.
[[nodiscard]] Picture picture_of(const Scene& scene, const Mesh& mesh);

}  // namespace stylet
