#include "stylet/output/xdmf.hpp"

#include "stylet/output/csv.hpp"

namespace stylet {

namespace {

const char* const first_tags =
    "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
    "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string time_element(double time) {
  std::string value;
  append_number(value, time);
  return "<Time Value=\"" + value + "\"/>\n";
}

/// Explicit point numbers 0, 1, ... because readers differ in what they assume without them.
std::string topology(const std::string& type, int n_elements, int n_nodes, bool closed) {
  const std::string elements = std::to_string(n_elements);
  const std::string nodes = std::to_string(n_nodes);
  std::string text = "<Topology TopologyType=\"" + type + "\" NumberOfElements=\"" + elements +
                     "\" NodesPerElement=\"" + nodes + "\"><DataItem Dimensions=\"" + elements +
                     ' ' + nodes + "\" NumberType=\"Int\" Precision=\"4\" Format=\"XML\">";
  const int n = n_elements * n_nodes - (closed ? 1 : 0);
  for (int i = 0; i < n; ++i) text += std::to_string(i) + ' ';
  return text + (closed ? "0" : "") + "</DataItem></Topology>\n";
}

}  // namespace

XdmfSeries::XdmfSeries(const std::string& path, std::string h5_name, std::string text)
    : h5_name_(std::move(h5_name)),
      file_(path, text.empty() ? first_tags : std::move(text), "</Grid>\n</Domain>\n</Xdmf>\n") {}

std::string XdmfSeries::data_item(const StoredArray& array) const {
  std::string extent = std::to_string(array.n_rows);
  if (array.n_columns > 1) extent += ' ' + std::to_string(array.n_columns);
  const char* type =
      array.integer ? "NumberType=\"Int\" Precision=\"4\"" : "NumberType=\"Float\" Precision=\"8\"";
  return "<DataItem Dimensions=\"" + extent + "\" " + type + " Format=\"HDF\">" +
         escaped(h5_name_) + ":" + array.path + "</DataItem>";
}

std::string XdmfSeries::grid_text(const XdmfGrid& grid, const std::string& time) const {
  std::string text = "<Grid Name=\"" + escaped(grid.name) + "\" GridType=\"Uniform\">\n" + time;
  const int n_points = static_cast<int>(grid.points.n_rows);
  switch (grid.shape) {
    case XdmfGrid::Shape::triangles:
    case XdmfGrid::Shape::tetrahedra:
      text += std::string("<Topology TopologyType=\"") +
              (grid.shape == XdmfGrid::Shape::triangles ? "Triangle" : "Tetrahedron") +
              "\" NumberOfElements=\"" + std::to_string(grid.connectivity.n_rows) + "\">" +
              data_item(grid.connectivity) + "</Topology>\n";
      break;
    case XdmfGrid::Shape::polyline:
      text += topology("Polyline", 1, n_points, false);
      break;
    case XdmfGrid::Shape::closed_polyline:
      text += topology("Polyline", 1, n_points + 1, true);
      break;
    case XdmfGrid::Shape::points:
      text += topology("Polyvertex", n_points, 1, false);
      break;
  }
  text += std::string("<Geometry GeometryType=\"") + (grid.points.n_columns == 3 ? "XYZ" : "XY") +
          "\">" + data_item(grid.points) + "</Geometry>\n";
  for (const XdmfAttribute& attribute : grid.attributes) {
    text += "<Attribute Name=\"" + escaped(attribute.name) + "\" AttributeType=\"" +
            (attribute.values.n_columns == 3 ? "Vector" : "Scalar") + "\" Center=\"" +
            (attribute.on_cells ? "Cell" : "Node") + "\">" + data_item(attribute.values) +
            "</Attribute>\n";
  }
  return text + "</Grid>\n";
}

void XdmfSeries::add(double time, const XdmfGrid& grid) {
  file_.append(grid_text(grid, time_element(time)));
}

void XdmfSeries::add(double time, const std::vector<XdmfGrid>& grids) {
  std::string text = "<Grid Name=\"parts\" GridType=\"Collection\" CollectionType=\"Spatial\">\n" +
                     time_element(time);
  for (const XdmfGrid& grid : grids) text += grid_text(grid, "");
  file_.append(text + "</Grid>\n");
}

}  // namespace stylet
