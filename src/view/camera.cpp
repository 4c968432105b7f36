#include "stylet/view/camera.hpp"

#include <algorithm>
#include <cstddef>

namespace stylet {

void Camera::fit(std::span<const float> coordinates) {
  if (coordinates.size() < 2) return;
  double low[2] = {coordinates[0], coordinates[1]};
  double high[2] = {low[0], low[1]};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    low[i % 2] = std::min<double>(low[i % 2], coordinates[i]);
    high[i % 2] = std::max<double>(high[i % 2], coordinates[i]);
  }
  constexpr double margin = 1.08;
  centre_ = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])};
  extent_ = {margin * (high[0] - low[0]), margin * (high[1] - low[1])};
}

double Camera::metres_per_pixel() const {
  return std::max(extent_.x / pane_.width, extent_.y / pane_.height);
}

Pixel Camera::pixel_of(WorldPoint x) const {
  const double scale = metres_per_pixel();
  const Pixel m = middle();
  return {m.x + (x.x - centre_.x) / scale, m.y - (x.y - centre_.y) / scale};
}

WorldPoint Camera::point_at(Pixel p) const {
  const double scale = metres_per_pixel();
  const Pixel m = middle();
  return {centre_.x + (p.x - m.x) * scale, centre_.y - (p.y - m.y) * scale};
}

void Camera::zoom(double factor, Pixel at) {
  const WorldPoint before = point_at(at);
  extent_ = (1 / factor) * extent_;
  const WorldPoint after = point_at(at);
  centre_ = centre_ + (before - after);
}

void Camera::drag(Pixel from, Pixel to) {
  centre_ = centre_ + (point_at(from) - point_at(to));
}

}  // namespace stylet
