#include "stylet/simulation/strain.hpp"

#include "stylet/fem/simplex.hpp"
#include "stylet/geometry/tetrahedron.hpp"
#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace stylet {

namespace {

double principal(const LinearSimplex<2>::Block& h) {
  const double mean = 0.5 * (h[0][0] + h[1][1]);
  const double radius = std::hypot(0.5 * (h[0][0] - h[1][1]), 0.5 * (h[0][1] + h[1][0]));
  return std::abs(mean) + radius;
}

// The eigenvalues of a symmetric matrix of trace 0 are 2 p cos(angle + 2 pi k / 3), where its squares add
// up to 6 p^2 and its determinant is 2 p^3 cos(3 angle).
double principal(const LinearSimplex<3>::Block& h) {
  const double mean = (h[0][0] + h[1][1] + h[2][2]) / 3;
  LinearSimplex<3>::Block s{};
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      s[i][k] = 0.5 * (h[i][k] + h[k][i]) - (i == k ? mean : 0.0);
      squares += s[i][k] * s[i][k];
    }
  }
  const double p = std::sqrt(squares / 6);
  if (p == 0) return std::abs(mean);
  const double det = s[0][0] * (s[1][1] * s[2][2] - s[1][2] * s[2][1]) -
                     s[0][1] * (s[1][0] * s[2][2] - s[1][2] * s[2][0]) +
                     s[0][2] * (s[1][0] * s[2][1] - s[1][1] * s[2][0]);
  const double angle = std::acos(std::clamp(det / (2 * p * p * p), -1.0, 1.0)) / 3;
  const double highest = mean + 2 * p * std::cos(angle);
  const double lowest = mean + 2 * p * std::cos(angle + 2 * std::numbers::pi / 3);
  return std::max(std::abs(highest), std::abs(lowest));
}

template <int Dim>
double largest_principal_strain(const Mesh& mesh, int c, std::span<const double> u) {
  return principal(simplex<Dim>(mesh, c).displacement_gradient(corner_values<Dim>(mesh, c, u)));
}

double largest_principal_strain(const Mesh& mesh, int c, std::span<const double> u) {
  if (mesh.dim() == 2) return largest_principal_strain<2>(mesh, c, u);
  if (!mesh.is_quadratic()) return largest_principal_strain<3>(mesh, c, u);
  double largest = 0;
  for (const auto& point : tetrahedron_points()) {
    largest = std::max(largest, principal(gradient_at(mesh, c, point, u)));
  }
  return largest;
}

// Somewhere, as its corners tell.
bool is_turned_over_in_space(const Mesh& mesh, int c, std::span<const double> u) {
  for (std::size_t corner = 0; corner < 4; ++corner) {
    std::array<double, 4> l{};
    l[corner] = 1;
    auto f = gradient_at(mesh, c, l, u);
    for (std::size_t i = 0; i < 3; ++i) f[i][i] += 1;
    const Vector3 rows[3] = {
        {f[0][0], f[0][1], f[0][2]}, {f[1][0], f[1][1], f[1][2]}, {f[2][0], f[2][1], f[2][2]}};
    if (dot(rows[0], cross(rows[1], rows[2])) <= 0) return true;
  }
  return false;
}

ReferencePlace centre_of(const Mesh& mesh, int c) {
  const auto n = mesh.cell(c);
  const auto a = mesh.place(n[0]);
  Vector3 sum = (mesh.place(n[1]) - a) + (mesh.place(n[2]) - a);
  if (n.size() == 4) sum = sum + (mesh.place(n[3]) - a);
  return a + (1.0 / static_cast<double>(n.size())) * sum;
}

/// The needle's path: cells with a node of it, and all whose centre is within the reach.
class Zone {
 public:
  Zone(const Mesh& mesh, const Track* track, double reach) : reach_(reach) {
    if (track == nullptr) return;
    for (const ShaftNode& shaft : track->nodes()) {
      points_.push_back(mesh.point(shaft.node));
      for (const int c : mesh.cells_around(shaft.node)) cells_.push_back(c);
    }
    std::ranges::sort(cells_);
  }
  [[nodiscard]] bool holds(int c, ReferencePoint centre) const {
    if (std::ranges::binary_search(cells_, c)) return true;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const ReferencePoint b = points_[std::min(i + 1, points_.size() - 1)];
      if (distance(nearest(points_[i], b, centre), centre) < reach_) return true;
    }
    return false;
  }

 private:
  static ReferencePoint nearest(ReferencePoint a, ReferencePoint b, ReferencePoint p) {
    const Vector2 edge = b - a;
    const double squared = dot(edge, edge);
    const double s = squared > 0 ? std::clamp(dot(p - a, edge) / squared, 0.0, 1.0) : 0.0;
    return a + s * edge;
  }

  double reach_;
  std::vector<ReferencePoint> points_;
  std::vector<int> cells_;
};

}  // namespace

void TurnedOver::add(const Mesh& mesh, int cell) {
  if (triangles++ == 0) place = centre_of(mesh, cell);
  area += mesh.cell_measure(cell);
}

bool is_turned_over(const Mesh& mesh, int cell, const std::array<Vector2, 3>& displacements) {
  const auto nodes = mesh.cell(cell);
  const auto x = [&](std::size_t k) { return displaced(mesh.point(nodes[k]), displacements[k]); };
  return signed_area(x(0), x(1), x(2)) <= 0;
}

TurnedOver turned_over(const Mesh& mesh, std::span<const double> u, double time) {
  TurnedOver all;
  all.time = time;
  const auto dim = static_cast<std::size_t>(mesh.dim());
  std::vector<WorldPlace> x;
  x.reserve(static_cast<std::size_t>(mesh.n_nodes()));
  for (int node = 0; node < mesh.n_nodes(); ++node) {
    const auto at = dim * static_cast<std::size_t>(node);
    x.push_back(displaced(mesh.place(node), {u[at], u[at + 1], dim == 3 ? u[at + 2] : 0}));
  }
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (mesh.is_quadratic()) {
      if (is_turned_over_in_space(mesh, c, u)) all.add(mesh, c);
      continue;
    }
    const auto nodes = mesh.cell(c);
    const auto corner = [&](std::size_t k) { return x[static_cast<std::size_t>(nodes[k])]; };
    const double measure =
        dim == 3 ? signed_volume(std::array{corner(0), corner(1), corner(2), corner(3)})
                 : signed_area(corner(0).in_plane(), corner(1).in_plane(), corner(2).in_plane());
    if (measure <= 0) all.add(mesh, c);
  }
  return all;
}

void raise(LargestStrain& largest,
           const Mesh& mesh,
           std::span<const double> u,
           double time,
           const Track* track,
           double tip_length) {
  constexpr double share = 1e-3;
  const Zone zone(mesh, track, tip_length);
  struct Strained {
    double strain;
    double area;
    ReferencePlace centre;
  };
  std::vector<Strained> candidates;
  double area = 0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    area += mesh.cell_measure(c);
    const double strain = largest_principal_strain(mesh, c, u);
    if (!(strain > largest.widespread.value)) continue;
    const ReferencePlace centre = centre_of(mesh, c);
    if (strain > largest.anywhere.value) largest.anywhere = {strain, time, centre};
    if (!zone.holds(c, centre.in_plane()))
      candidates.push_back({strain, mesh.cell_measure(c), centre});
  }
  std::ranges::sort(candidates, std::greater(), &Strained::strain);
  double exceeded_on = 0;
  for (const Strained& cell : candidates) {
    exceeded_on += cell.area;
    if (exceeded_on < share * area) continue;
    largest.widespread = {cell.strain, time, cell.centre};
    return;
  }
}

}  // namespace stylet
