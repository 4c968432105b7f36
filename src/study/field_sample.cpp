#include "stylet/study/field_sample.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/dynamics/state.hpp"
#include "stylet/geometry/tetrahedron_quadrature.hpp"
#include "stylet/mesh/embedded_point.hpp"
#include "stylet/output/text_file.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>

namespace stylet {

namespace {

MeshData mesh_data(const FieldSample& sample) {
  MeshData data;
  data.coordinates = sample.coordinates;
  data.cells = sample.cells;
  data.quadratic_cells = sample.quadratic_cells;
  data.dim = sample.dim;
  data.cell_region.assign(static_cast<std::size_t>(data.n_cells()), 0);
  data.region_names = {"tissue"};
  return data;
}

Vector3 value_at(const FieldSample& sample, const Mesh& mesh, const EmbeddedPoint& point) {
  const auto dim = static_cast<std::size_t>(sample.dim);
  double value[3] = {0, 0, 0};
  for (const auto& [node, weight] : node_weights(mesh, point)) {
    const double* u = &sample.u[dim * static_cast<std::size_t>(node)];
    for (std::size_t k = 0; k < dim; ++k) value[k] += weight * u[k];
  }
  return {value[0], value[1], value[2]};
}

struct QuadraturePoint {
  EmbeddedPoint at;
  double weight;  // m^2 or m^3
};

EmbeddedPoint in_tetrahedron(const Mesh& mesh, int c, const std::array<double, 4>& weights) {
  EmbeddedPoint point{{}, c, weights};
  for (std::size_t k = 0; k < 4; ++k) {
    point.x = point.x + weights[k] * (mesh.place(mesh.cell(c)[k]) - ReferencePlace{});
  }
  return point;
}

// Exact for the square of the field: the middles of a triangle's edges, the four points of a tetrahedron, and
// for quadratic ones those of degree five.
std::vector<QuadraturePoint> quadrature(const Mesh& mesh, int c) {
  std::vector<QuadraturePoint> points;
  const double measure = mesh.cell_measure(c);
  if (mesh.dim() == 2) {
    const auto n = mesh.cell(c);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t next = (corner + 1) % 3;
      EmbeddedPoint point{midpoint(mesh.point(n[corner]), mesh.point(n[next])), c, {}};
      point.weights[corner] = point.weights[next] = 0.5;
      points.push_back({point, measure / 3});
    }
  } else if (mesh.nodes(c).size() > 4) {
    for (const auto& [weights, share] : fine_tetrahedron_points()) {
      points.push_back({in_tetrahedron(mesh, c, weights), share * measure});
    }
  } else {
    for (const auto& weights : tetrahedron_points()) {
      points.push_back({in_tetrahedron(mesh, c, weights), measure / 4});
    }
  }
  return points;
}

}  // namespace

void archive(Archive& archive, FieldSample& sample) {
  auto& [time, coordinates, cells, u, dim, quadratic_cells] = sample;
  archive("dim", dim);
  archive("time", time);
  archive("coordinates", coordinates);
  archive("cells", cells);
  archive("u", u);
  archive("quadratic_cells", quadratic_cells);
}

FieldSample field_now(const Simulation& simulation) {
  FieldSample sample;
  sample.time = simulation.time();
  sample.coordinates = simulation.mesh().data().coordinates;
  sample.cells = simulation.mesh().data().cells;
  sample.u = gather_all(simulation.state().u.get());
  sample.dim = simulation.mesh().dim();
  sample.quadratic_cells = simulation.mesh().data().quadratic_cells;
  return sample;
}

void write_fields(const std::string& path, const std::vector<FieldSample>& samples) {
  nlohmann::json document = nlohmann::json::array();
  for (const auto& sample : samples) {
    document.push_back({{"time", sample.time},
                        {"coordinates", sample.coordinates},
                        {"cells", sample.cells},
                        {"u", sample.u},
                        {"dim", sample.dim},
                        {"quadratic_cells", sample.quadratic_cells}});
  }
  const auto bytes = nlohmann::json::to_cbor(document);
  TextFile file(path);
  file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  file.close();
  file.appear();
}

std::vector<FieldSample> read_fields(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path + ": cannot be read");
  std::vector<FieldSample> samples;
  try {
    for (const auto& entry : nlohmann::json::from_cbor(file)) {
      samples.push_back(
          {entry.at("time").get<double>(), entry.at("coordinates").get<std::vector<double>>(),
           entry.at("cells").get<std::vector<int>>(), entry.at("u").get<std::vector<double>>(),
           entry.value("dim", 2), entry.value("quadratic_cells", std::vector<int>{})});
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path + ": holds no fields: " + error.what());
  }
  return samples;
}

double relative_distance(const FieldSample& coarse, const FieldSample& fine) {
  const Mesh coarse_mesh(mesh_data(coarse));
  const Mesh fine_mesh(mesh_data(fine));
  double difference = 0;
  double size = 0;
  int hint = 0;
  for (int c = 0; c < fine_mesh.n_cells(); ++c) {
    for (const auto& [here, weight] : quadrature(fine_mesh, c)) {
      const auto there = locate(coarse_mesh, here.x, hint);
      if (!there) throw InputError("the fields to be compared are not of the same tissue");
      hint = there->cell;
      const Vector3 a = value_at(fine, fine_mesh, here);
      const Vector3 b = value_at(coarse, coarse_mesh, *there);
      difference += weight * dot(a - b, a - b);
      size += weight * dot(a, a);
    }
  }
  return size > 0 ? std::sqrt(difference / size) : 0;
}

}  // namespace stylet
