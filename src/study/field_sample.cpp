#include "stylet/study/field_sample.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/dynamics/state.hpp"
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
  data.cell_region.assign(sample.cells.size() / 3, 0);
  data.region_names = {"tissue"};
  return data;
}

Vector2 value_at(const FieldSample& sample, const Mesh& mesh, const EmbeddedPoint& point) {
  Vector2 value{};
  const auto nodes = mesh.cell(point.cell);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto node = 2 * static_cast<std::size_t>(nodes[k]);
    value.x += point.weights[k] * sample.u[node];
    value.y += point.weights[k] * sample.u[node + 1];
  }
  return value;
}

}  // namespace

void archive(Archive& archive, FieldSample& sample) {
  auto& [time, coordinates, cells, u] = sample;
  archive("time", time);
  archive("coordinates", coordinates);
  archive("cells", cells);
  archive("u", u);
}

FieldSample field_now(const Simulation& simulation) {
  FieldSample sample;
  sample.time = simulation.time();
  sample.coordinates = simulation.mesh().data().coordinates;
  sample.cells = simulation.mesh().data().cells;
  sample.u = gather_all(simulation.state().u.get());
  return sample;
}

void write_fields(const std::string& path, const std::vector<FieldSample>& samples) {
  nlohmann::json document = nlohmann::json::array();
  for (const auto& sample : samples) {
    document.push_back({{"time", sample.time},
                        {"coordinates", sample.coordinates},
                        {"cells", sample.cells},
                        {"u", sample.u}});
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
           entry.at("cells").get<std::vector<int>>(), entry.at("u").get<std::vector<double>>()});
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
    const auto nodes = fine_mesh.cell(c);
    const double weight = fine_mesh.cell_measure(c) / 3;
    for (std::size_t k = 0; k < 3; ++k) {  // the middles of the edges
      EmbeddedPoint here{
          midpoint(fine_mesh.point(nodes[k]), fine_mesh.point(nodes[(k + 1) % 3])), c, {}};
      here.weights[k] = here.weights[(k + 1) % 3] = 0.5;
      const auto there = locate(coarse_mesh, here.x, hint);
      if (!there) throw InputError("the fields to be compared are not of the same tissue");
      hint = there->cell;
      const Vector2 a = value_at(fine, fine_mesh, here);
      const Vector2 b = value_at(coarse, coarse_mesh, *there);
      difference += weight * ((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
      size += weight * (a.x * a.x + a.y * a.y);
    }
  }
  return size > 0 ? std::sqrt(difference / size) : 0;
}

}  // namespace stylet
