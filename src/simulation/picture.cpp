#include "stylet/simulation/picture.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/geometry/rotation.hpp"
#include "stylet/image/file.hpp"
#include "stylet/image/ultrasound.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/simulation/model.hpp"
#include "stylet/simulation/point_text.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

struct Box {
  ReferencePoint low;
  ReferencePoint high;
};

// Of the tissue, in the scene's frame.
Box box_of(const Mesh& mesh, const Rotation& turn) {
  Box box{turn.to_scene(mesh.point(0)), turn.to_scene(mesh.point(0))};
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto x = turn.to_scene(mesh.point(node));
    box.low = {std::min(box.low.x, x.x), std::min(box.low.y, x.y)};
    box.high = {std::max(box.high.x, x.x), std::max(box.high.y, x.y)};
  }
  return box;
}

Picture file_picture(const Scene& scene, const Box& tissue) {
  const ImageParameters& image = *scene.image;
  Picture picture;
  try {
    const std::string path = path_in(scene, image.file);
    picture = read_picture(path, read_file(path));
  } catch (const Error& error) {
    refuse_key(scene, "image.file", error.what());
  }
  picture.origin = *image.origin;
  picture.size = *image.size;
  const ReferencePoint end = picture.origin + picture.size;
  const bool meets = picture.origin.x < tissue.high.x && picture.origin.y < tissue.high.y &&
                     end.x > tissue.low.x && end.y > tissue.low.y;
  constexpr double far = 100;
  const Vector2 extent = tissue.high - tissue.low;
  if (!meets || picture.size.x > far * extent.x || picture.size.y > far * extent.y) {
    refuse_key(scene, meets ? "image.size" : "image.origin",
               "the picture lies from (" + brief(picture.origin.x) + ", " +
                   brief(picture.origin.y) + ") m to (" + brief(end.x) + ", " + brief(end.y) +
                   ") m; allowed: a place on the tissue, which spans (" + brief(tissue.low.x) +
                   ", " + brief(tissue.low.y) + ") m to (" + brief(tissue.high.x) + ", " +
                   brief(tissue.high.y) + ") m");
  }
  return picture;
}

Picture made_picture(const Scene& scene, const Mesh& mesh, const Box& tissue) {
  constexpr double longest = 512;  // pixels
  const Rotation turn(scene.needle_angle);
  const ImageParameters image = scene.image.value_or(ImageParameters{});
  Echoes echoes;
  echoes.frame.origin = tissue.low;
  echoes.frame.size = tissue.high - tissue.low;
  const Vector2 size = echoes.frame.size;
  const double pixel = std::max(size.x, size.y) / longest;
  echoes.frame.width = std::max(1, static_cast<int>(std::lround(size.x / pixel)));
  echoes.frame.height = std::max(1, static_cast<int>(std::lround(size.y / pixel)));
  echoes.region.assign(
      static_cast<std::size_t>(echoes.frame.width) * static_cast<std::size_t>(echoes.frame.height),
      Echoes::nothing);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto n = mesh.cell(c);
    const auto x = [&](std::size_t i) { return turn.to_scene(mesh.point(n[i])); };
    cover(echoes, x(0), x(1), x(2), mesh.region(c));
  }
  if (scene.membrane) {
    for (const auto& vertex : scene.membrane->polygon) {
      echoes.capsule.push_back(turn.to_scene(vertex));
    }
  }
  return ultrasound(echoes, static_cast<std::uint32_t>(image.seed), image.attenuation);
}

}  // namespace

Picture picture_of(const Scene& scene, const Mesh& mesh) {
  const Box tissue = box_of(mesh, Rotation(scene.needle_angle));
  if (scene.image && !scene.image->file.empty()) return file_picture(scene, tissue);
  return made_picture(scene, mesh, tissue);
}

}  // namespace stylet
