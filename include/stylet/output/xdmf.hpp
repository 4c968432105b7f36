// The XDMF files that tell ParaView what snapshots.h5 holds.
#pragma once

#include "stylet/output/growing_xml.hpp"

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

/// Points in the plane or in space and what connects them.
struct XdmfGrid {
  enum class Shape { triangles, tetrahedra, polyline, closed_polyline, points };
  std::string name;
  Shape shape = Shape::triangles;
  StoredArray points;        ///< 2 or 3 columns
  StoredArray connectivity;  ///< of cells only
  std::vector<XdmfAttribute> attributes;
};

/// A file of a series in time, which can be read at every moment.
class XdmfSeries {
 public:
  /// Writes it anew. `h5_name`: the HDF5 file, relative to the folder of the XDMF file; text: of a series
  /// that it goes on with, empty for no steps.
  XdmfSeries(const std::string& path, std::string h5_name, std::string text = {});

  /// With all steps so far.
  [[nodiscard]] const std::string& text() const { return file_.text(); }

  void add(double time, const XdmfGrid& grid);
  /// Several grids at one time.
  void add(double time, const std::vector<XdmfGrid>& grids);
  void finish() { file_.finish(); }

 private:
  [[nodiscard]] std::string grid_text(const XdmfGrid& grid, const std::string& time_element) const;
  [[nodiscard]] std::string data_item(const StoredArray& array) const;

  std::string h5_name_;
  GrowingXml file_;
};

}  // namespace stylet
