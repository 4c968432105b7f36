#include "stylet/output/snapshots.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/committed_file.hpp"
#include "stylet/output/disk_space.hpp"
#include "stylet/output/snapshot_place.hpp"
#include "stylet/output/snapshot_size.hpp"
#include "stylet/output/status_file.hpp"
#include "stylet/output/text_file.hpp"
#include "stylet/output/xdmf.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <type_traits>

namespace stylet {

namespace {

constexpr unsigned long long format_version = 1;
constexpr std::uint64_t first_bytes = 64 * 1024;  // a new file with its attributes takes less
constexpr std::uint64_t bytes_per_step = 1024;    // a second root takes less

/// Two components a row become three with z = 0, because ParaView warps by such vectors only.
std::vector<double> with_zero_z(std::span<const double> values) {
  std::vector<double> result(values.size() / 2 * 3, 0.0);
  for (std::size_t i = 0; 2 * i < values.size(); ++i) {
    result[3 * i] = values[2 * i];
    result[3 * i + 1] = values[2 * i + 1];
  }
  return result;
}

/// Collective. The rows of all ranks, on rank 0.
template <class Value>
std::vector<Value> all_rows(MPI_Comm comm,
                            const std::vector<Value>& mine,
                            int n_rows,
                            int columns) {
  const int n_ranks = size_of(comm);
  if (n_ranks == 1) return mine;
  std::vector<int> counts;
  std::vector<int> starts;
  for (int rank = 0; rank < n_ranks; ++rank) {
    const Range rows = chunk(n_rows, rank, n_ranks);
    counts.push_back(columns * rows.size());
    starts.push_back(columns * rows.begin);
  }
  std::vector<Value> all;
  if (rank_of(comm) == 0) all.resize(static_cast<std::size_t>(columns * n_rows));
  const MPI_Datatype type = std::is_same_v<Value, double> ? MPI_DOUBLE : MPI_INT;
  MPI_Gatherv(mine.data(), static_cast<int>(mine.size()), type, all.data(), counts.data(),
              starts.data(), type, 0, comm);
  return all;
}

}  // namespace

/// The open file, its XDMF companions and what is known of the arrays in it. Rank 0 writes.
class SnapshotWriter::File {
 public:
  File(MPI_Comm comm, const std::string& folder, const SnapshotPlace* from);

  void write(const Snapshot& snapshot);
  [[nodiscard]] SnapshotPlace settle();
  void close();
  [[nodiscard]] int n_written() const { return n_written_; }

 private:
  /// What was stored last under a name.
  template <class Value>
  struct Kept {
    std::vector<Value> values;
    Hdf5Id array;
  };
  template <class Value>
  using AllKept = std::map<std::string, Kept<Value>>;

  void create();
  void go_on(const SnapshotPlace& from);
  void reserve(const Snapshot& snapshot);
  [[noreturn]] void end_job(const Error& error) const;
  void write_step(const Snapshot& snapshot);
  void write_mesh(const Snapshot& snapshot);
  void write_fields(hid_t step, const Snapshot& snapshot);
  void write_shapes(hid_t step, const Snapshot& snapshot);
  void tell(const Snapshot& snapshot);
  void store_points(hid_t group,
                    const std::string& group_name,
                    const std::string& name,
                    const SnapshotPoints& points,
                    XdmfGrid::Shape shape);
  [[nodiscard]] StoredArray stored(const std::string& name, int n_rows, int columns, bool integer) {
    return {"/" + step_name_ + "/" + name, n_rows, columns, integer};
  }
  [[nodiscard]] int rows_of(bool on_cells) const { return on_cells ? n_cells_ : n_nodes_; }

  MPI_Comm comm_;
  int rank_;
  std::string folder_;
  std::string h5_path_;
  bool is_open_ = true;
  std::optional<CommittedFile> h5_;  ///< rank 0's
  DiskReserve room_;
  int n_written_ = 0;
  double time_ = 0;  ///< of the last snapshot (s)

  std::string step_name_;
  std::optional<std::uint64_t> mesh_version_;
  std::optional<std::uint64_t> connectivity_version_;
  std::optional<Hdf5Id> connectivity_;
  int n_meshes_ = 0;
  int n_nodes_ = 0;
  int n_cells_ = 0;
  AllKept<int> flags_;
  AllKept<double> points_;
  XdmfGrid tissue_;
  std::vector<XdmfGrid> shapes_;

  std::optional<XdmfSeries> tissue_series_;  ///< rank 0's
  std::optional<XdmfSeries> shape_series_;
};

namespace {

/// A new array in a group; or a link, and false, if what was stored last under this key was the same.
template <class Value, class AllKept>
bool store(AllKept& all,
           const std::string& key,
           hid_t group,
           const std::string& name,
           const std::string& unit,
           int columns,
           std::vector<Value> values) {
  const auto last = all.find(key);
  if (last != all.end() && last->second.values == values) {
    link_array(last->second.array.get(), group, name);
    return false;
  }
  Hdf5Id array = write_array(group, name, unit, columns, values);
  all.insert_or_assign(key, typename AllKept::mapped_type{std::move(values), std::move(array)});
  return true;
}

}  // namespace

SnapshotWriter::File::File(MPI_Comm comm, const std::string& folder, const SnapshotPlace* from)
    : comm_(comm),
      rank_(rank_of(comm)),
      folder_(folder),
      h5_path_(folder + "/snapshots.h5"),
      room_(h5_path_) {
  agree_after(comm, [&] {
    if (rank_ != 0) return;
    from == nullptr ? create() : go_on(*from);
  });
  if (from == nullptr) return;
  n_written_ = from->n_written;
  time_ = from->time;
  n_meshes_ = from->n_meshes;
  mesh_version_ = from->mesh_version;
  connectivity_version_ = from->connectivity_version;
}

// HDF5 cannot close a file whose first bytes found no room, so they are sure to find it; and the file
// has its name once it can be read.
void SnapshotWriter::File::create() {
  const std::string draft = draft_of(h5_path_);
  require_room(draft, h5_path_, first_bytes);
  h5_.emplace(draft);
  try {
    h5_->set_root_attribute("program", std::string("stylet"));
    h5_->set_root_attribute("version", std::string(STYLET_VERSION));
    h5_->set_root_attribute("format", format_version);
    h5_->commit();
  } catch (const Error& error) {
    end_job(error);
  }
  if (std::rename(draft.c_str(), h5_path_.c_str()) != 0) {
    throw_io_error(h5_path_, "cannot be created");
  }
  tissue_series_.emplace(folder_ + "/snapshots.xdmf", "snapshots.h5");
  shape_series_.emplace(folder_ + "/snapshots_needle.xdmf", "snapshots.h5");
}

// The XDMF files tell at no time of snapshots that are gone. Flags and points that stay as they are will be
// stored once more.
void SnapshotWriter::File::go_on(const SnapshotPlace& from) {
  require_there(h5_path_);
  room_.require(first_bytes + bytes_per_step * static_cast<std::uint64_t>(from.n_written));
  h5_.emplace(h5_path_, CommittedFile::Open::go_on);
  const std::vector<std::string> later = later_than(from, *h5_, h5_path_);
  tissue_series_.emplace(folder_ + "/snapshots.xdmf", "snapshots.h5", from.tissue_xdmf);
  shape_series_.emplace(folder_ + "/snapshots_needle.xdmf", "snapshots.h5", from.shape_xdmf);
  try {
    h5_->remove(later);
    connectivity_ = h5_->open(numbered("mesh", from.n_meshes - 1) + "/connectivity");
  } catch (const Error& error) {
    end_job(error);
  }
}

SnapshotPlace SnapshotWriter::File::settle() {
  if (!is_open_) throw IoError(h5_path_ + ": is closed");
  SnapshotPlace place{n_written_, n_meshes_, time_, mesh_version_.value_or(0),
                      connectivity_version_.value_or(0)};
  agree_after(comm_, [&] {
    if (rank_ != 0) return;
    h5_->sync();
    place.tissue_xdmf = tissue_series_->text();
    place.shape_xdmf = shape_series_->text();
    if (n_written_ > 0) place.displacement = displacement_of(*h5_, n_written_ - 1);
  });
  return place;
}

void SnapshotWriter::File::write(const Snapshot& snapshot) {
  if (!is_open_) throw IoError(h5_path_ + ": is closed");
  agree_after(comm_, [&] { check_sizes(snapshot, rank_, size_of(comm_)); });
  n_nodes_ = static_cast<int>(snapshot.coordinates.size()) / snapshot.dim;
  n_cells_ = static_cast<int>(snapshot.connectivity.size()) / (snapshot.dim + 1);
  Snapshot whole = snapshot;
  for (Field& f : whole.fields) {
    f.values = all_rows(comm_, f.values, rows_of(f.on_cells), f.components);
  }
  for (FlagField& f : whole.flags) f.values = all_rows(comm_, f.values, rows_of(f.on_cells), 1);
  reserve(whole);
  try {
    agree_after(comm_, [&] {
      if (rank_ == 0) write_step(whole);
    });
  } catch (const Error& error) {
    end_job(error);
  }
  mesh_version_ = snapshot.mesh_version;
  connectivity_version_ = snapshot.connectivity_version;
  time_ = snapshot.time;
  ++n_written_;
  tell(snapshot);
}

/// A full disk shows here, where the file is still whole and can be closed.
void SnapshotWriter::File::reserve(const Snapshot& snapshot) {
  try {
    agree_after(comm_, [&] {
      if (rank_ != 0) return;
      const bool with_mesh = mesh_version_ != snapshot.mesh_version;
      room_.require(stored_bytes(snapshot, with_mesh) + metadata_bytes(snapshot, n_written_));
    });
  } catch (const Error&) {
    close();
    throw;
  }
}

/// HDF5 can neither go on nor close a file when a write failed: it hangs or crashes, at the latest when
/// MPI ends. The snapshots before are whole.
void SnapshotWriter::File::end_job(const Error& error) const {
  if (rank_ == 0) StatusFile::fail_at_once(with_next_step(error.what()));
  abort_job(static_cast<int>(error.code()));
}

void SnapshotWriter::File::write_step(const Snapshot& snapshot) {
  step_name_ = numbered("step", n_written_);
  if (mesh_version_ != snapshot.mesh_version) write_mesh(snapshot);
  const std::string mesh_name = numbered("mesh", n_meshes_ - 1);
  tissue_.name = "tissue";
  tissue_.shape = snapshot.dim == 2 ? XdmfGrid::Shape::triangles : XdmfGrid::Shape::tetrahedra;
  tissue_.points = {"/" + mesh_name + "/coordinates", n_nodes_, snapshot.dim, false};
  tissue_.connectivity = {"/" + mesh_name + "/connectivity", n_cells_, snapshot.dim + 1, true};
  const hid_t step = h5_->create_group(step_name_);
  set_attribute(step, "time", snapshot.time);
  set_attribute(step, "phase", snapshot.phase);
  set_attribute(step, "index", static_cast<unsigned long long>(n_written_));
  set_attribute(step, "mesh", mesh_name);
  write_fields(step, snapshot);
  write_shapes(step, snapshot);
  h5_->commit();
}

void SnapshotWriter::File::write_mesh(const Snapshot& snapshot) {
  const std::string name = numbered("mesh", n_meshes_++);
  const hid_t mesh = h5_->create_group(name);
  set_attribute(mesh, "mesh_version", static_cast<unsigned long long>(snapshot.mesh_version));
  (void)write_array(mesh, "coordinates", "m", snapshot.dim, snapshot.coordinates);
  if (connectivity_version_ == snapshot.connectivity_version) {
    link_array(connectivity_->get(), mesh, "connectivity");
  } else {
    connectivity_ = write_array(mesh, "connectivity", "", snapshot.dim + 1, snapshot.connectivity);
  }
}

void SnapshotWriter::File::write_fields(hid_t step, const Snapshot& snapshot) {
  tissue_.attributes.clear();
  for (const Field& f : snapshot.fields) {
    const int columns = f.components == 1 ? 1 : 3;
    (void)write_array(step, f.name, f.unit, columns,
                      f.components == 2 ? with_zero_z(f.values) : f.values);
    tissue_.attributes.push_back(
        {f.name, f.on_cells, stored(f.name, rows_of(f.on_cells), columns, false)});
  }
  for (const FlagField& f : snapshot.flags) {
    store(flags_, f.name, step, f.name, "", 1, f.values);
    tissue_.attributes.push_back(
        {f.name, f.on_cells, stored(f.name, rows_of(f.on_cells), 1, true)});
  }
}

void SnapshotWriter::File::write_shapes(hid_t step, const Snapshot& snapshot) {
  shapes_.clear();
  if (!snapshot.polylines.empty()) {
    const Hdf5Id group = create_group(step, "polylines");
    for (const Polyline& line : snapshot.polylines) {
      store_points(group.get(), "polylines", line.name, line.points,
                   line.closed ? XdmfGrid::Shape::closed_polyline : XdmfGrid::Shape::polyline);
    }
  }
  if (!snapshot.point_sets.empty()) {
    const Hdf5Id group = create_group(step, "point_sets");
    for (const PointSet& set : snapshot.point_sets) {
      store_points(group.get(), "point_sets", set.name, set.points, XdmfGrid::Shape::points);
    }
  }
}

void SnapshotWriter::File::store_points(hid_t group,
                                        const std::string& group_name,
                                        const std::string& name,
                                        const SnapshotPoints& points,
                                        XdmfGrid::Shape shape) {
  if (points.empty()) return;
  const int dim = tissue_.points.n_columns;
  std::vector<double> values;
  for (const auto& point : points) values.insert(values.end(), point.begin(), point.begin() + dim);
  const std::string path = group_name + "/" + name;
  if (store(points_, path, group, name, "m", dim, std::move(values)) &&
      shape != XdmfGrid::Shape::points) {
    set_attribute(points_.at(path).array.get(), "closed",
                  shape == XdmfGrid::Shape::closed_polyline ? 1ULL : 0ULL);
  }
  shapes_.push_back({name, shape, stored(path, int(points.size()), dim, false), {}, {}});
}

void SnapshotWriter::File::tell(const Snapshot& snapshot) {
  try {
    agree_after(comm_, [&] {
      if (rank_ != 0) return;
      tissue_series_->add(snapshot.time, tissue_);
      if (!shapes_.empty()) shape_series_->add(snapshot.time, shapes_);
    });
  } catch (const Error&) {
    close();
    throw;
  }
}

void SnapshotWriter::File::close() {
  if (!std::exchange(is_open_, false)) return;
  agree_after(comm_, [&] {
    if (!h5_) return;
    flags_.clear();
    points_.clear();
    connectivity_.reset();
    try {
      h5_->close();
    } catch (const Error& error) {
      end_job(error);
    }
    room_.free();
    tissue_series_->finish();
    shape_series_->finish();
  });
}

SnapshotWriter::SnapshotWriter(MPI_Comm comm, const std::string& folder)
    : file_(std::make_unique<File>(comm, folder, nullptr)) {}

SnapshotWriter::SnapshotWriter(MPI_Comm comm, const std::string& folder, const SnapshotPlace& from)
    : file_(std::make_unique<File>(comm, folder, &from)) {}

SnapshotWriter::~SnapshotWriter() = default;

void SnapshotWriter::write(const Snapshot& snapshot) {
  file_->write(snapshot);
}
SnapshotPlace SnapshotWriter::settle() {
  return file_->settle();
}
void SnapshotWriter::close() {
  file_->close();
}
int SnapshotWriter::n_written() const {
  return file_->n_written();
}

}  // namespace stylet
