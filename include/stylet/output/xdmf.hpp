// The text of the XDMF files that tell ParaView what snapshots.h5 holds.
#pragma once

#include <string>
#include <vector>

namespace stylet {

/// Where an array lies in the HDF5 file.
struct StoredArray {
  std::string path;  ///< inside the file
  long long n_rows = 0;
  int n_columns = 1;  ///< 1 or 3 for attributes
  bool integer = false;
};

struct XdmfAttribute {
  std::string name;
  bool on_cells = false;
  StoredArray values;
};

/// Points in the plane and what connects them.
struct XdmfGrid {
  enum class Shape { triangles, polyline, closed_polyline, points };
  std::string name;
  Shape shape = Shape::triangles;
  StoredArray points;        ///< 2 columns
  StoredArray connectivity;  ///< of triangles only
  std::vector<XdmfAttribute> attributes;
};

/// A series in time, built up as text so that a new snapshot costs its own part only.
class XdmfSeries {
 public:
  /// `h5_name`: the HDF5 file, relative to the folder of the XDMF file.
  explicit XdmfSeries(std::string h5_name) : h5_name_(std::move(h5_name)) {}

  void add(double time, const XdmfGrid& grid);
  /// Several grids at one time.
  void add(double time, const std::vector<XdmfGrid>& grids);
  /// The whole file.
  [[nodiscard]] std::string text() const;

 private:
  void append_grid(const XdmfGrid& grid, const std::string& time_element);
  [[nodiscard]] std::string data_item(const StoredArray& array) const;

  std::string h5_name_;
  std::string steps_;
};

}  // namespace stylet
