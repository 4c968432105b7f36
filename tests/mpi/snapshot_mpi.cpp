// Snapshots written by several ranks are those of one rank, and a full disk stops all ranks alike.
// `snapshot_mpi --example FOLDER [columns [frames]]` writes a made-up run to look at.
#include "stylet/base/errors.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/history.hpp"
#include "stylet/output/snapshots.hpp"
#include "stylet/output/summary.hpp"
#include "stylet/petsc/session.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <mpi.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <sys/resource.h>
#include <vector>

namespace stylet {

namespace {

/// A needle enters an 8 x 6 cm tissue from the right, leaves a seed and goes back. The displacement
/// is a formula, not mechanics.
class Example {
 public:
  Example(MPI_Comm comm, int columns) : columns_(columns), rows_(columns * 3 / 4) {
    for (int j = 0; j <= rows_; ++j) {
      for (int i = 0; i <= columns_; ++i) {
        coordinates_.push_back(width * i / columns_);
        coordinates_.push_back(height * j / rows_);
      }
    }
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        const int a = j * (columns_ + 1) + i;
        const int b = a + columns_ + 1;
        if ((i + j) % 2 == 0) {
          connectivity_.insert(connectivity_.end(), {a, a + 1, b + 1, a, b + 1, b});
        } else {
          connectivity_.insert(connectivity_.end(), {a, a + 1, b, a + 1, b + 1, b});
        }
      }
    }
    nodes_ = chunk(static_cast<int>(coordinates_.size() / 2), rank_of(comm), size_of(comm));
    cells_ = chunk(static_cast<int>(connectivity_.size() / 3), rank_of(comm), size_of(comm));
  }

  /// `progress` from 0 (outside) over 0.5 (deepest) to 1 (withdrawn).
  [[nodiscard]] Snapshot at(double progress) const {
    const double depth = deepest * std::min(1.0, 2.4 * std::min(progress, 1 - progress));
    const double sign = progress < 0.5 ? 1 : -0.5;
    Snapshot s;
    s.time = 4 * progress;
    s.phase = depth == 0         ? (progress < 0.5 ? "outside" : "withdrawn")
              : depth == deepest ? "holding"
              : progress < 0.5   ? "inserting"
                                 : "retracting";
    s.coordinates = coordinates_;
    s.connectivity = connectivity_;
    s.mesh_version = static_cast<std::uint64_t>(4 * progress);
    const Push push{width - depth, depth == 0 ? 0 : sign * 0.006 * depth / deepest};

    Field u{"u", false, 2, {}, "m"};
    FlagField state{"node_state", false, {}};
    for (int n = nodes_.begin; n < nodes_.end; ++n) {
      u.values.insert(u.values.end(), {-push.at(x(n), y(n)), 0.1 * push.at(x(n), y(n))});
      const bool on_shaft = std::abs(y(n) - axis) < 1e-6 && x(n) > width - depth;
      state.values.push_back(x(n) == 0 ? 1 : on_shaft ? 3 : 0);
    }
    Field v{"v", false, 2, u.values, "m/s"};
    Field stress{"von_mises", true, 1, {}, "Pa"};
    FlagField region{"region", true, {}};
    for (int c = cells_.begin; c < cells_.end; ++c) {
      const int n = connectivity_[3 * static_cast<std::size_t>(c)];
      stress.values.push_back(6e5 * std::abs(push.at(x(n), y(n))));
      region.values.push_back(std::hypot((x(n) - 0.035) / 0.0175, (y(n) - 0.03) / 0.013) < 1);
    }
    s.fields = {std::move(u), std::move(v), std::move(stress)};
    s.flags = {std::move(state), std::move(region)};

    Polyline needle{"needle", {}, false};
    if (depth > 0) needle.points = {{width + 0.004, axis}, {width - depth, axis}};
    Polyline membrane{"membrane", {}, true};
    for (int i = 0; i < 64; ++i) {
      const double angle = 2 * std::numbers::pi * i / 64;
      const double px = 0.035 + 0.0175 * std::cos(angle);
      const double py = 0.03 + 0.013 * std::sin(angle);
      membrane.points.push_back({px - push.at(px, py), py + 0.1 * push.at(px, py)});
    }
    s.polylines = {needle, membrane};
    PointSet seeds{"seeds", {}};
    const double drift = 0.0065 * (2 * progress - 1);
    if (progress > 0.5) seeds.points.push_back({0.035 + drift, axis});
    if (progress > 0.6) seeds.points.push_back({0.045 + 0.9 * drift, axis});
    s.point_sets = {seeds, {"targets", {{0.035, axis}, {0.045, axis}}}};
    return s;
  }

 private:
  static constexpr double width = 0.08;
  static constexpr double height = 0.06;
  static constexpr double axis = 0.032;
  static constexpr double deepest = 0.045;

  struct Push {
    double tip;
    double size;
    [[nodiscard]] double at(double px, double py) const {
      const double along = px > tip ? 0.5 * (px - tip) : px - tip;
      const double decay = std::exp(-(along * along + (py - axis) * (py - axis)) / 3e-4);
      return size * decay * std::min(1.0, 50 * px);
    }
  };

  [[nodiscard]] double x(int n) const { return coordinates_[2 * static_cast<std::size_t>(n)]; }
  [[nodiscard]] double y(int n) const { return coordinates_[2 * static_cast<std::size_t>(n) + 1]; }

  int columns_;
  int rows_;
  std::vector<double> coordinates_;
  std::vector<int> connectivity_;
  Range nodes_;
  Range cells_;
};

void write_example(MPI_Comm comm, const std::string& folder, int columns, int n_frames) {
  if (rank_of(comm) == 0) std::filesystem::create_directories(folder);
  MPI_Barrier(comm);
  const Example example(comm, columns);
  SnapshotWriter snapshots(comm, folder);
  HistoryWriter history(comm, folder + "/history.csv", {{"time", "s"}, {"seconds", "s"}});
  for (int i = 0; i < n_frames; ++i) {
    const Snapshot snapshot = example.at(i / std::max(1.0, n_frames - 1.0));
    const double start = MPI_Wtime();
    snapshots.write(snapshot);
    history.write(std::vector<double>{snapshot.time, MPI_Wtime() - start});
  }
  snapshots.close();
  history.close();
  write_summary(comm, folder + "/summary.json",
                {{"seeds",
                  {{{"world", {0.0415, 0.032}},
                    {"target_point", {0.035, 0.032}},
                    {"placement_error", 0.0065}}}}});
}

/// A folder that all ranks know.
std::string shared_folder(const std::string& name) {
  const std::string base = std::filesystem::temp_directory_path() / "stylet_snapshot_mpi";
  const std::string folder = base + "_" + std::to_string(size_of(MPI_COMM_WORLD)) + "/" + name;
  if (rank_of(MPI_COMM_WORLD) == 0) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  return folder;
}

std::vector<double> read(const std::string& file, const char* name) {
  const hid_t h5 = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t set = H5Dopen2(h5, name, H5P_DEFAULT);
  const hid_t space = H5Dget_space(set);
  std::vector<double> values(
      static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space))));
  H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(h5);
  return values;
}

TEST(SnapshotMpi, RanksWriteWhatOneRankWrites) {
  const std::string together = shared_folder("together");
  const std::string alone = shared_folder("alone");
  write_example(MPI_COMM_WORLD, together, 21, 5);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    write_example(MPI_COMM_SELF, alone, 21, 5);
    for (const char* name :
         {"/mesh_000000/coordinates", "/mesh_000000/connectivity", "/step_000003/u",
          "/step_000003/von_mises", "/step_000003/node_state", "/step_000003/region",
          "/step_000003/polylines/membrane", "/step_000003/point_sets/seeds"}) {
      const auto expected = read(alone + "/snapshots.h5", name);
      EXPECT_FALSE(expected.empty()) << name;
      EXPECT_EQ(read(together + "/snapshots.h5", name), expected) << name;
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(SnapshotMpi, MoreRanksThanRows) {
  const std::string folder = shared_folder("tiny");
  write_example(MPI_COMM_WORLD, folder, 2, 2);  // 3 x 2 nodes, 4 triangles
}

TEST(SnapshotMpi, FullDiskStopsAllRanks) {
  const std::string folder = shared_folder("full");
  const Example example(MPI_COMM_WORLD, 100);
  SnapshotWriter writer(MPI_COMM_WORLD, folder);
  writer.write(example.at(0.1));
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit limit{std::filesystem::file_size(folder + "/snapshots.h5") + 1000, before.rlim_max};
  if (rank_of(MPI_COMM_WORLD) == 0) setrlimit(RLIMIT_FSIZE, &limit);  // all must hear of it
  ExitCode code = ExitCode::done;
  try {
    writer.write(example.at(0.2));
  } catch (const Error& error) {
    code = error.code();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(code, ExitCode::io);
  EXPECT_THROW(writer.write(example.at(0.3)), Error);
  EXPECT_EQ(read(folder + "/snapshots.h5", "/step_000000/region").size(), 15000U);
}

}  // namespace

}  // namespace stylet

int main(int argc, char** argv) {
  const stylet::Session session(1, argv);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() >= 2 && arguments[0] == "--example") {
    const int columns = arguments.size() > 2 ? std::stoi(arguments[2]) : 40;
    const int n_frames = arguments.size() > 3 ? std::stoi(arguments[3]) : 25;
    try {
      stylet::write_example(MPI_COMM_WORLD, arguments[1], columns, n_frames);
    } catch (const stylet::Error& error) {
      std::fprintf(stderr, "%s\n", error.what());
      return static_cast<int>(error.code());
    }
    return 0;
  }
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
