#include "stylet/output/snapshots.hpp"

#include "stylet/output/hdf5.hpp"

#include "fixture.hpp"
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <numeric>

namespace stylet {

namespace {

using testing::contents;
using testing::failure_of;
using testing::FileSizeLimit;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Chunk, CoversAllRowsOnce) {
  for (const int n : {0, 1, 2, 7, 100}) {
    for (const int n_ranks : {1, 2, 3, 8}) {
      int next = 0;
      for (int rank = 0; rank < n_ranks; ++rank) {
        const Range rows = chunk(n, rank, n_ranks);
        EXPECT_EQ(rows.begin, next);
        EXPECT_LE(std::abs(rows.size() - n / n_ranks), 1);
        next = rows.end;
      }
      EXPECT_EQ(next, n);
    }
  }
}

/// Read by a file handle of its own, as another program would.
template <class Value>
std::vector<Value> read(const std::string& file, const std::string& name, hid_t type) {
  const Hdf5Id h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, file);
  const Hdf5Id set(H5Dopen2(h5.get(), name.c_str(), H5P_DEFAULT), H5Dclose, name);
  const Hdf5Id space(H5Dget_space(set.get()), H5Sclose, name);
  std::vector<Value> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  check_hdf5(H5Dread(set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
  return values;
}

bool exists(const std::string& file, const std::string& name) {
  const Hdf5Id h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, file);
  return H5Lexists(h5.get(), name.c_str(), H5P_DEFAULT) > 0;
}

class Snapshots : public testing::FolderTest {
 protected:
  /// Two triangles.
  Snapshot snapshot(double time) const {
    Snapshot s;
    s.time = time;
    s.phase = "inserting";
    s.coordinates = coordinates_;
    s.connectivity = connectivity_;
    s.fields = {{"u", false, 2, {1, 2, 3, 4, 5, 6, 7, 8}, "m"},
                {"von_mises", true, 1, {10 * time, 20}, "Pa"}};
    s.flags = {{"node_state", false, {0, 1, 2, 3}}};
    s.polylines = {{"needle", {{1, 0.5}, {0.5, 0.5}}, false},
                   {"membrane", {{0, 0}, {1, 0}, {1, 1}}, true}};
    s.point_sets = {{"seeds", {}}, {"targets", {{0.5, 0.5}}}};
    return s;
  }
  std::string h5() const { return path("snapshots.h5"); }

  std::vector<double> coordinates_ = {0, 0, 1, 0, 1, 1, 0, 1};
  std::vector<int> connectivity_ = {0, 1, 2, 0, 2, 3};
};

TEST_F(Snapshots, GoOnAsIfNothingHadBeenWrittenSince) {
  std::filesystem::create_directories(path("plain"));
  for (const std::string& folder : {folder_, path("plain")}) {
    SnapshotWriter writer(MPI_COMM_WORLD, folder);
    writer.write(snapshot(0.5));
    SnapshotPlace place = writer.settle();
    if (folder == folder_) {
      for (const double t : {0.7, 0.8, 0.9}) {
        Snapshot other = snapshot(t);
        other.mesh_version = static_cast<std::uint64_t>(10 * t);
        writer.write(other);
      }
      writer.close();
      SnapshotWriter second(MPI_COMM_WORLD, folder, place);
      second.write(snapshot(1.5));
      second.close();
    } else {
      writer.write(snapshot(1.5));
      writer.close();
    }
  }
  for (const char* name : {"snapshots.xdmf", "snapshots_needle.xdmf"}) {
    EXPECT_EQ(contents(path(name)), contents(path("plain") + "/" + name));
  }
  for (const char* name : {"mesh_000000", "step_000000", "step_000001"}) {
    EXPECT_TRUE(exists(h5(), name)) << name;
  }
  for (const char* name : {"mesh_000001", "step_000002"}) EXPECT_FALSE(exists(h5(), name)) << name;
  EXPECT_EQ(read<double>(h5(), "/step_000001/von_mises", H5T_NATIVE_DOUBLE),
            (std::vector<double>{15, 20}));
}

TEST_F(Snapshots, GoOnOnlyWithTheirFile) {
  SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  writer.write(snapshot(0.5));
  const SnapshotPlace place = writer.settle();
  writer.close();
  const std::string before = contents(path("snapshots.xdmf"));
  SnapshotPlace later = place;
  later.n_written = 2;
  SnapshotPlace other = place;
  other.time = 0.6;
  SnapshotPlace moved = place;
  moved.displacement.back() ^= 1;
  for (const SnapshotPlace& wrong : {later, other, moved}) {
    std::string message;
    EXPECT_EQ(failure_of([&] { SnapshotWriter(MPI_COMM_WORLD, folder_, wrong); }, &message),
              ExitCode::bad_input);
    EXPECT_THAT(message, HasSubstr("snapshots.h5"));
    EXPECT_EQ(contents(path("snapshots.xdmf")), before);
  }
}

TEST_F(Snapshots, ReadBack) {
  SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  writer.write(snapshot(0.5));
  writer.close();
  EXPECT_EQ(read<double>(h5(), "/mesh_000000/coordinates", H5T_NATIVE_DOUBLE), coordinates_);
  EXPECT_EQ(read<int>(h5(), "/mesh_000000/connectivity", H5T_NATIVE_INT), connectivity_);
  const std::vector<double> padded = {1, 2, 0, 3, 4, 0, 5, 6, 0, 7, 8, 0};
  EXPECT_EQ(read<double>(h5(), "/step_000000/u", H5T_NATIVE_DOUBLE), padded);
  EXPECT_EQ(read<double>(h5(), "/step_000000/von_mises", H5T_NATIVE_DOUBLE),
            (std::vector<double>{5, 20}));
  EXPECT_EQ(read<int>(h5(), "/step_000000/node_state", H5T_NATIVE_INT),
            (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(read<double>(h5(), "/step_000000/polylines/needle", H5T_NATIVE_DOUBLE),
            (std::vector<double>{1, 0.5, 0.5, 0.5}));
  EXPECT_FALSE(exists(h5(), "/step_000000/point_sets/seeds"));  // no seeds yet
}

TEST_F(Snapshots, StoreTheMeshAgainOnlyIfItChanged) {
  SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  writer.write(snapshot(0));
  writer.write(snapshot(1));
  coordinates_[0] = -0.25;
  Snapshot edited = snapshot(2);
  edited.mesh_version = 5;
  writer.write(edited);
  EXPECT_EQ(writer.n_written(), 3);
  writer.close();
  EXPECT_EQ(read<double>(h5(), "/mesh_000001/coordinates", H5T_NATIVE_DOUBLE), coordinates_);
  EXPECT_FALSE(exists(h5(), "/mesh_000002"));
  const std::string xdmf = contents(path("snapshots.xdmf"));
  EXPECT_THAT(xdmf, HasSubstr("snapshots.h5:/mesh_000001/connectivity"));
  EXPECT_THAT(xdmf, HasSubstr("snapshots.h5:/step_000002/u"));
  EXPECT_THAT(xdmf, Not(HasSubstr("node_state\" AttributeType=\"Vector")));
}

TEST_F(Snapshots, AreReadableWhileTheRunGoesOn) {
  SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  EXPECT_THAT(contents(path("snapshots.xdmf")), HasSubstr("</Xdmf>"));
  writer.write(snapshot(0));
  std::filesystem::copy_file(h5(), path("copy.h5"));  // the bytes a killed run leaves
  EXPECT_EQ(read<double>(path("copy.h5"), "/mesh_000000/coordinates", H5T_NATIVE_DOUBLE),
            coordinates_);
  EXPECT_THAT(contents(path("snapshots.xdmf")), HasSubstr("/step_000000/u"));
}

TEST_F(Snapshots, RefuseAFieldOfTheWrongSize) {
  SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  Snapshot wrong = snapshot(0);
  wrong.fields[1].values.push_back(0);
  std::string message;
  EXPECT_EQ(failure_of([&] { writer.write(wrong); }, &message), ExitCode::other);
  EXPECT_THAT(message, HasSubstr("von_mises"));
  writer.write(snapshot(0));  // nothing was touched
}

TEST_F(Snapshots, MissingFolder) {
  std::string message;
  EXPECT_EQ(failure_of([&] { SnapshotWriter(MPI_COMM_WORLD, path("no")); }, &message),
            ExitCode::io);
  EXPECT_THAT(message, HasSubstr("snapshots.h5"));
}

TEST_F(Snapshots, FullDiskKeepsTheSnapshotsBefore) {
  constexpr int n = 20000;
  coordinates_.assign(2 * n, 0.5);
  connectivity_.assign(3 * n, 0);
  Snapshot big;
  big.coordinates = coordinates_;
  big.connectivity = connectivity_;
  big.fields = {{"u", false, 2, std::vector<double>(2 * n, 1.0), "m"}};
  {
    SnapshotWriter writer(MPI_COMM_WORLD, folder_);
    writer.write(big);
    std::string message;
    {
      const FileSizeLimit limit(std::filesystem::file_size(h5()) + 100000);
      EXPECT_EQ(failure_of([&] { writer.write(big); }, &message), ExitCode::io);
    }
    EXPECT_THAT(message, HasSubstr("snapshots.h5"));
    EXPECT_EQ(failure_of([&] { writer.write(big); }), ExitCode::io);
  }
  EXPECT_EQ(read<double>(h5(), "/step_000000/u", H5T_NATIVE_DOUBLE).size(), 3U * n);
  EXPECT_FALSE(exists(h5(), "/step_000001"));
  EXPECT_THAT(contents(path("snapshots.xdmf")), Not(HasSubstr("step_000001")));
}

TEST_F(Snapshots, NoRoomForTheFirstBytes) {
  const FileSizeLimit limit(8192);
  std::string message;
  EXPECT_EQ(failure_of([&] { SnapshotWriter(MPI_COMM_WORLD, folder_); }, &message), ExitCode::io);
  EXPECT_THAT(message, HasSubstr("snapshots.h5"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(Snapshots, CanBeReadFromTheStart) {
  const SnapshotWriter writer(MPI_COMM_WORLD, folder_);
  std::filesystem::copy_file(h5(), path("copy.h5"));  // the bytes a killed run leaves
  EXPECT_FALSE(exists(path("copy.h5"), "/step_000000"));
}

TEST_F(Snapshots, LeaveNoHandles) {
  {
    SnapshotWriter writer(MPI_COMM_WORLD, folder_);
    writer.write(snapshot(0));
  }
  EXPECT_EQ(H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL), 0);
}

}  // namespace

}  // namespace stylet
