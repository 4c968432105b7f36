// Fits triangles to the outlines of inner regions.
//
// Of every edge that crosses an outline the nearer end is moved onto it; polygon corners get their
// nearest node first. A few sweeps then flip edges and smooth the nodes nearby where that raises
// the worst quality around them. The number of nodes and of cells stays.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/mesh/outline.hpp"

#include <span>
#include <string>
#include <vector>

namespace stylet {

/// A side of the mesh or a piece of a named curve: nodes on it move along it only.
struct KeptLine {
  ReferencePoint a;
  ReferencePoint b;
};

/// `advice` ends the message of the InputError thrown where an outline cannot be met.
void conform(Mesh& mesh,
             const std::vector<InnerRegion>& regions,
             std::span<const KeptLine> lines,
             const std::string& advice);

/// Points closer than this are one (m).
[[nodiscard]] double coincidence(const Mesh& mesh);

[[nodiscard]] ReferencePoint centroid(const Mesh& mesh, int c);

}  // namespace stylet
