// What a killed program leaves: snapshots.h5 as it is before and after every write, and where the system
// stops within one, at the end of a page.
#include "stylet/output/committed_file.hpp"
#include "stylet/output/hdf5.hpp"
#include "stylet/output/snapshots.hpp"

#include "fixture.hpp"
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <sys/syscall.h>
#include <unistd.h>
#include <utility>

namespace {

std::function<void()>& watch() {
  static std::function<void()> the;
  return the;
}

}  // namespace

// In the place of the C library's: HDF5's driver and CommittedFile call it.
extern "C" ssize_t pwrite64(int file, const void* data, size_t size, off_t at) {
  constexpr off_t page = 4096;
  size_t done = 0;
  while (done < size) {
    const auto here = at + static_cast<off_t>(done);
    const auto part = std::min(size - done, static_cast<size_t>(page - here % page));
    const auto written =
        ::syscall(SYS_pwrite64, file, static_cast<const char*>(data) + done, part, here);
    if (written < 0) return written;
    done += static_cast<size_t>(written);
    if (watch()) watch()();
  }
  return static_cast<ssize_t>(done);
}
extern "C" ssize_t pwrite(int file, const void* data, size_t size, off_t at) {
  return pwrite64(file, data, size, at);
}

namespace stylet {

namespace {

using testing::contents;

class KilledWriter : public testing::FolderTest {
 protected:
  /// A square of many triangles, so that arrays go over pages.
  static constexpr int n = 700;

  void write(SnapshotWriter& writer, int number) {
    Snapshot s;
    s.time = number;
    s.phase = "inserting";
    coordinates_.assign(2 * n, number);
    connectivity_.assign(3 * n, number);
    s.coordinates = coordinates_;
    s.connectivity = connectivity_;
    s.mesh_version = static_cast<std::uint64_t>(number / 2);
    s.connectivity_version = static_cast<std::uint64_t>(number / 5);
    s.fields = {{"u", false, 2, std::vector<double>(2 * n, number), "m"}};
    s.flags = {{"region", true, std::vector<int>(n, 1)}};
    s.polylines = {{"membrane", {{number + 0.5, 0}, {1, 0}, {1, 1}}, true}};
    s.point_sets = {{"targets", {{0.5, 0.5}}}};
    writer.write(s);
  }

  /// Number of steps in these bytes, of which all is as it was written; -1 if they cannot be read.
  int steps_in(const std::string& bytes) {
    const std::string file = path("left.h5");
    std::ofstream(file, std::ios::binary) << bytes;
    const Hdf5Id h5(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, file);
    H5G_info_t info{};
    check_hdf5(H5Gget_info(h5.get(), &info), file);
    int n_steps = 0;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
      char name[20];
      check_hdf5(static_cast<herr_t>(H5Lget_name_by_idx(h5.get(), ".", H5_INDEX_NAME, H5_ITER_INC,
                                                        i, name, sizeof name, H5P_DEFAULT)),
                 file);
      if (!std::string(name).starts_with("step_")) continue;
      const int number = std::stoi(name + 5);
      EXPECT_EQ(number, n_steps++);
      const std::string step = std::string("/") + name;
      EXPECT_EQ(first_of(h5.get(), step + "/u", H5T_NATIVE_DOUBLE, 3 * n), number);
      EXPECT_EQ(first_of(h5.get(), step + "/region", H5T_NATIVE_DOUBLE, n), 1);
      EXPECT_EQ(first_of(h5.get(), step + "/polylines/membrane", H5T_NATIVE_DOUBLE, 6),
                number + 0.5);
      const std::string mesh = "/mesh_00000" + std::to_string(number / 2);
      EXPECT_EQ(first_of(h5.get(), mesh + "/coordinates", H5T_NATIVE_DOUBLE, 2 * n),
                number - number % 2);
    }
    return n_steps;
  }

  static double first_of(hid_t h5, const std::string& name, hid_t type, std::size_t size) {
    const Hdf5Id set(H5Dopen2(h5, name.c_str(), H5P_DEFAULT), H5Dclose, name);
    std::vector<double> values(size);
    check_hdf5(H5Dread(set.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
    const bool is_polygon = size == 6;
    EXPECT_EQ(values[size - 2], is_polygon ? 1 : values.front()) << name;  // the last of u is a z
    return values.front();
  }

  std::vector<double> coordinates_;
  std::vector<int> connectivity_;
};

TEST_F(KilledWriter, LeavesEverySnapshotThatItReported) {
  constexpr int n_snapshots = 12;  // more than fit into one leaf of a group
  struct Left {
    int reported;
    std::string bytes;
  };
  std::vector<Left> states;
  int reported = 0;
  {
    SnapshotWriter writer(MPI_COMM_WORLD, folder_);
    watch() = [&] {
      std::string bytes = contents(path("snapshots.h5"));
      if (states.empty() || states.back().bytes != bytes) states.push_back({reported, bytes});
    };
    for (; reported < n_snapshots; ++reported) write(writer, reported);
    writer.close();
    watch() = nullptr;
  }
  states.push_back({reported, contents(path("snapshots.h5"))});
  EXPECT_GT(states.size(), 20U * n_snapshots);
  for (std::size_t i = 0; i < states.size(); ++i) {
    SCOPED_TRACE("write " + std::to_string(i));
    int n_steps = -1;
    ASSERT_NO_THROW(n_steps = steps_in(states[i].bytes));
    EXPECT_GE(n_steps, states[i].reported);
    EXPECT_LE(n_steps, states[i].reported + 1);
  }
}

// A run that is resumed drops what came after its checkpoint, from whatever a kill has left, and may be
// killed there too.
TEST_F(KilledWriter, GoesBackFromWhateverWasLeft) {
  constexpr int n_kept = 3;
  constexpr int n_first = 7;
  constexpr int n_second = 6;
  constexpr std::size_t stride = 7;  // of the states that are gone on with
  const std::string file = path("snapshots.h5");
  std::vector<std::string> states;
  const auto collect = [&] {
    std::string bytes = contents(file);
    if (states.empty() || states.back() != bytes) states.push_back(bytes);
  };
  SnapshotPlace place;
  {
    SnapshotWriter writer(MPI_COMM_WORLD, folder_);
    for (int i = 0; i < n_kept; ++i) write(writer, i);
    place = writer.settle();
    watch() = collect;
    for (int i = n_kept; i < n_first; ++i) write(writer, i);
    writer.close();
    watch() = nullptr;
  }
  const auto left = std::exchange(states, {});
  for (std::size_t i = 0; i < left.size(); i += stride) {
    SCOPED_TRACE("left by write " + std::to_string(i));
    std::ofstream(file, std::ios::binary) << left[i];
    watch() = collect;
    SnapshotWriter writer(MPI_COMM_WORLD, folder_, place);
    watch() = nullptr;
    EXPECT_EQ(writer.n_written(), n_kept);
    EXPECT_EQ(steps_in(contents(file)), n_kept);
    for (int k = n_kept; k < n_second; ++k) write(writer, k);
    EXPECT_EQ(steps_in(contents(file)), n_second);
    writer.close();
    EXPECT_EQ(steps_in(contents(file)), n_second);
  }
  EXPECT_GT(states.size(), left.size() / stride);
  for (std::size_t i = 0; i < states.size(); ++i) {
    SCOPED_TRACE("while it goes back, write " + std::to_string(i));
    int n_steps = -1;
    ASSERT_NO_THROW(n_steps = steps_in(states[i]));
    EXPECT_GE(n_steps, n_kept);
  }
}

TEST_F(KilledWriter, CanBeGoneOnWith) {
  const std::string file = path("file.h5");
  const auto add = [&](CommittedFile::Open how, const std::string& name, bool closes) {
    CommittedFile h5(file, how);
    h5.set_root_attribute("format", 1ULL);
    (void)write_array(h5.create_group(name), "x", "m", 1, std::vector<double>{1, 2});
    h5.commit();
    std::filesystem::copy_file(file, path(name + ".h5"));
    if (closes) h5.close();
  };
  add(CommittedFile::Open::anew, "first", true);
  add(CommittedFile::Open::go_on, "second", false);
  add(CommittedFile::Open::go_on, "third", true);
  const std::string copy = path("third.h5");
  const Hdf5Id h5(H5Fopen(copy.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, copy);
  for (const char* name : {"first", "second", "third"}) {
    EXPECT_EQ(first_of(h5.get(), std::string(name) + "/x", H5T_NATIVE_DOUBLE, 2), 1) << name;
  }
  EXPECT_GT(H5Aexists(h5.get(), "format"), 0);
}

}  // namespace

}  // namespace stylet
