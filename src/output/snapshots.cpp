#include "stylet/output/snapshots.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/disk_space.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/output/hdf5.hpp"
#include "stylet/output/snapshot_size.hpp"
#include "stylet/output/status_file.hpp"
#include "stylet/output/text_file.hpp"
#include "stylet/output/xdmf.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <deque>
#include <exception>
#include <optional>

namespace stylet {

namespace {

constexpr unsigned long long format_version = 1;
constexpr std::uint64_t first_bytes = 64 * 1024;  // a new file with its attributes takes less

std::string numbered(const std::string& name, int number) {
  constexpr std::size_t digits = 6;
  const std::string text = std::to_string(number);
  return name + '_' + std::string(digits - std::min(digits, text.size()), '0') + text;
}

/// Two components a row become three with z = 0, because ParaView warps by such vectors only.
std::vector<double> with_zero_z(std::span<const double> values) {
  std::vector<double> result(values.size() / 2 * 3, 0.0);
  for (std::size_t i = 0; 2 * i < values.size(); ++i) {
    result[3 * i] = values[2 * i];
    result[3 * i + 1] = values[2 * i + 1];
  }
  return result;
}

}  // namespace

/// The open file, its XDMF companions and what a snapshot has in the making.
class SnapshotWriter::File {
 public:
  File(MPI_Comm comm, const std::string& folder);

  void write(const Snapshot& snapshot);
  void close();
  /// Leaves the handle to the end of MPI, which closes it where all ranks meet.
  void abandon() {
    if (h5_) h5_->release();
  }
  [[nodiscard]] int n_written() const { return n_written_; }

 private:
  void reserve(const Snapshot& snapshot);
  [[noreturn]] void end_job(const Error& error) const;
  void create_step(const Snapshot& snapshot);
  void create_mesh(const Snapshot& snapshot);
  void create_fields(hid_t step, const Snapshot& snapshot);
  void create_shapes(hid_t step, const Snapshot& snapshot);
  StoredArray create_points(hid_t parent,
                            const std::string& path,
                            const std::string& name,
                            const std::vector<std::array<double, 2>>& points);
  void write_pending();
  void write_xdmf();

  [[nodiscard]] Range rows(int n) const { return chunk(n, rank_, n_ranks_); }

  MPI_Comm comm_;
  int rank_;
  int n_ranks_;
  std::string folder_;
  std::string h5_path_;
  std::optional<Hdf5Id> h5_;
  int n_written_ = 0;

  std::string step_name_;
  std::optional<std::uint64_t> mesh_version_;
  std::optional<std::uint64_t> connectivity_version_;
  std::string connectivity_;  ///< path of that array
  int n_meshes_ = 0;
  int n_nodes_ = 0;
  int n_cells_ = 0;
  XdmfGrid tissue_;
  std::vector<XdmfGrid> shapes_;
  std::vector<PendingArray> pending_;
  std::deque<std::vector<double>> padded_;  // addresses stay valid until written

  XdmfSeries tissue_series_{"snapshots.h5"};
  XdmfSeries shape_series_{"snapshots.h5"};
};

SnapshotWriter::File::File(MPI_Comm comm, const std::string& folder)
    : comm_(comm),
      rank_(rank_of(comm)),
      n_ranks_(size_of(comm)),
      folder_(folder),
      h5_path_(folder + "/snapshots.h5") {
  // HDF5 cannot close a file whose first bytes found no room, so they are sure to find it; and the
  // file has its name once it can be read.
  const std::string draft = draft_of(h5_path_);
  agree_after(comm, [&] {
    if (rank_ == 0) require_room(draft, h5_path_, first_bytes);
  });
  try {
    agree_after(comm, [&] {
      h5_ = create_hdf5_file(comm, draft);
      set_attribute(h5_->get(), "program", std::string("stylet"));
      set_attribute(h5_->get(), "version", std::string(STYLET_VERSION));
      set_attribute(h5_->get(), "format", format_version);
      check_hdf5(H5Fflush(h5_->get(), H5F_SCOPE_LOCAL), h5_path_);
    });
  } catch (const Error& error) {
    if (h5_) end_job(error);
    throw;
  }
  agree_after(comm, [&] {
    if (rank_ == 0 && std::rename(draft.c_str(), h5_path_.c_str()) != 0) {
      throw_io_error(h5_path_, "cannot be created");
    }
  });
  write_xdmf();
}

void SnapshotWriter::File::write(const Snapshot& snapshot) {
  if (!h5_) throw IoError(h5_path_ + ": is closed");
  agree_after(comm_, [&] { check_sizes(snapshot, rank_, n_ranks_); });
  reserve(snapshot);
  step_name_ = numbered("step", n_written_);
  try {
    agree_after(comm_, [&] { create_step(snapshot); });
    write_pending();
  } catch (const Error& error) {
    end_job(error);
  }
  tissue_series_.add(snapshot.time, tissue_);
  if (!shapes_.empty()) shape_series_.add(snapshot.time, shapes_);
  ++n_written_;
  write_xdmf();
}

/// A full disk shows here, where the file is still whole and can be closed.
void SnapshotWriter::File::reserve(const Snapshot& snapshot) {
  try {
    agree_after(comm_, [&] {
      if (rank_ != 0) return;
      const bool with_mesh = mesh_version_ != snapshot.mesh_version;
      reserve_space(h5_path_,
                    stored_bytes(snapshot, with_mesh) + metadata_bytes(snapshot, n_written_));
    });
  } catch (const Error&) {
    h5_.reset();
    throw;
  }
}

/// HDF5 can neither go on nor close a file when a collective write failed on some ranks only: it
/// hangs or crashes, at the latest when MPI ends. The snapshots before are whole on the disk.
void SnapshotWriter::File::end_job(const Error& error) const {
  if (rank_ == 0) {
    std::fprintf(stderr, "\nstylet: %s\n", error.what());
    StatusFile::fail_at_once(error.what());
  }
  abort_job(static_cast<int>(error.code()));
}

void SnapshotWriter::File::create_step(const Snapshot& snapshot) {
  pending_.clear();
  padded_.clear();
  if (mesh_version_ != snapshot.mesh_version) create_mesh(snapshot);
  const Hdf5Id step = create_group(h5_->get(), step_name_);
  set_attribute(step.get(), "time", snapshot.time);
  set_attribute(step.get(), "phase", snapshot.phase);
  set_attribute(step.get(), "index", static_cast<unsigned long long>(n_written_));
  set_attribute(step.get(), "mesh", numbered("mesh", n_meshes_ - 1));
  create_fields(step.get(), snapshot);
  create_shapes(step.get(), snapshot);
}

void SnapshotWriter::File::create_mesh(const Snapshot& snapshot) {
  n_nodes_ = static_cast<int>(snapshot.coordinates.size() / 2);
  n_cells_ = static_cast<int>(snapshot.connectivity.size() / 3);
  const std::string name = numbered("mesh", n_meshes_++);
  const Hdf5Id mesh = create_group(h5_->get(), name);
  set_attribute(mesh.get(), "mesh_version", static_cast<unsigned long long>(snapshot.mesh_version));
  const Range nodes = rows(n_nodes_);
  const Range cells = rows(n_cells_);
  pending_.push_back(create_array(mesh.get(), "coordinates", "m",
                                  {static_cast<hsize_t>(n_nodes_), 2}, nodes,
                                  snapshot.coordinates.data() + 2 * std::ptrdiff_t{nodes.begin}));
  if (connectivity_version_ == snapshot.connectivity_version) {
    check_hdf5(H5Lcreate_hard(h5_->get(), connectivity_.c_str(), mesh.get(), "connectivity",
                              H5P_DEFAULT, H5P_DEFAULT),
               h5_path_);
  } else {
    pending_.push_back(
        create_array(mesh.get(), "connectivity", "", {static_cast<hsize_t>(n_cells_), 3}, cells,
                     snapshot.connectivity.data() + 3 * std::ptrdiff_t{cells.begin}));
    connectivity_version_ = snapshot.connectivity_version;
    connectivity_ = "/" + name + "/connectivity";
  }
  tissue_.name = "tissue";
  tissue_.points = {"/" + name + "/coordinates", n_nodes_, 2, false};
  tissue_.connectivity = {"/" + name + "/connectivity", n_cells_, 3, true};
  mesh_version_ = snapshot.mesh_version;
}

void SnapshotWriter::File::create_fields(hid_t step, const Snapshot& snapshot) {
  tissue_.attributes.clear();
  const auto stored = [&](const std::string& name, bool on_cells, int columns, bool integer) {
    const int n = on_cells ? n_cells_ : n_nodes_;
    tissue_.attributes.push_back(
        {name, on_cells, {"/" + step_name_ + "/" + name, n, columns, integer}});
    return ArrayShape{static_cast<hsize_t>(n), static_cast<hsize_t>(columns)};
  };
  for (const Field& field : snapshot.fields) {
    const Range mine = rows(field.on_cells ? n_cells_ : n_nodes_);
    const double* data = field.values.data();
    if (field.components == 2) data = padded_.emplace_back(with_zero_z(field.values)).data();
    const ArrayShape shape =
        stored(field.name, field.on_cells, field.components == 1 ? 1 : 3, false);
    pending_.push_back(create_array(step, field.name, field.unit, shape, mine, data));
  }
  for (const FlagField& flag : snapshot.flags) {
    const Range mine = rows(flag.on_cells ? n_cells_ : n_nodes_);
    const ArrayShape shape = stored(flag.name, flag.on_cells, 1, true);
    pending_.push_back(create_array(step, flag.name, "", shape, mine, flag.values.data()));
  }
}

void SnapshotWriter::File::create_shapes(hid_t step, const Snapshot& snapshot) {
  shapes_.clear();
  const std::string path = "/" + step_name_;
  if (!snapshot.polylines.empty()) {
    const Hdf5Id group = create_group(step, "polylines");
    for (const Polyline& line : snapshot.polylines) {
      if (line.points.empty()) continue;
      const auto shape = line.closed ? XdmfGrid::Shape::closed_polyline : XdmfGrid::Shape::polyline;
      shapes_.push_back({line.name,
                         shape,
                         create_points(group.get(), path + "/polylines/", line.name, line.points),
                         {},
                         {}});
      set_attribute(pending_.back().dataset.get(), "closed", line.closed ? 1ULL : 0ULL);
    }
  }
  if (!snapshot.point_sets.empty()) {
    const Hdf5Id group = create_group(step, "point_sets");
    for (const PointSet& set : snapshot.point_sets) {
      if (set.points.empty()) continue;
      shapes_.push_back({set.name,
                         XdmfGrid::Shape::points,
                         create_points(group.get(), path + "/point_sets/", set.name, set.points),
                         {},
                         {}});
    }
  }
}

StoredArray SnapshotWriter::File::create_points(hid_t parent,
                                                const std::string& path,
                                                const std::string& name,
                                                const std::vector<std::array<double, 2>>& points) {
  const int n = static_cast<int>(points.size());
  const Range mine = rank_ == 0 ? Range{0, n} : Range{0, 0};
  pending_.push_back(
      create_array(parent, name, "m", {static_cast<hsize_t>(n), 2}, mine, points.front().data()));
  return {path + name, n, 2, false};
}

void SnapshotWriter::File::write_pending() {
  std::optional<Failure> failure;
  for (const PendingArray& array : pending_) {
    // No way out of this loop: the other ranks are in the same collective write.
    const auto message = write_array(array);
    if (message && !failure) failure = Failure{ExitCode::io, h5_path_ + ": " + *message};
  }
  pending_.clear();
  padded_.clear();
  agree(comm_, failure);
  agree_after(comm_, [&] { check_hdf5(H5Fflush(h5_->get(), H5F_SCOPE_LOCAL), h5_path_); });
}

void SnapshotWriter::File::write_xdmf() {
  const bool writes = rank_ == 0;
  try {
    write_text_atomically(comm_, folder_ + "/snapshots.xdmf",
                          writes ? tissue_series_.text() : std::string(), Durable::no);
    write_text_atomically(comm_, folder_ + "/snapshots_needle.xdmf",
                          writes ? shape_series_.text() : std::string(), Durable::no);
  } catch (const Error&) {
    h5_.reset();
    throw;
  }
}

void SnapshotWriter::File::close() {
  if (!h5_) return;
  const hid_t id = h5_->release();
  h5_.reset();
  agree_after(comm_, [&] { check_hdf5(H5Fclose(id), h5_path_); });
}

SnapshotWriter::SnapshotWriter(MPI_Comm comm, const std::string& folder)
    : file_(std::make_unique<File>(comm, folder)) {}

SnapshotWriter::~SnapshotWriter() {
  if (std::uncaught_exceptions() > 0) file_->abandon();
}

void SnapshotWriter::write(const Snapshot& snapshot) {
  file_->write(snapshot);
}
void SnapshotWriter::close() {
  file_->close();
}
int SnapshotWriter::n_written() const {
  return file_->n_written();
}

}  // namespace stylet
