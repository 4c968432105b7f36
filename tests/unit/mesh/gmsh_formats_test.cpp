// Gmsh files of formats 2.2, 4.0 and 4.1; binary ones of both byte orders are written from the same
// numbers as ASCII ones.
#include "stylet/base/errors.hpp"
#include "stylet/mesh/gmsh_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <variant>
#include <vector>

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

enum class How { ascii, binary, swapped };

/// One file, three ways to write its numbers.
class Writer {
 public:
  explicit Writer(How how) : how_(how) {}

  Writer& text(const std::string& line) {
    bytes_ += line + "\n";
    return *this;
  }
  Writer& format(const std::string& version) {
    text("$MeshFormat").text(version + (how_ == How::ascii ? " 0 8" : " 1 8"));
    if (how_ != How::ascii) put(std::int32_t{1}).text("");
    return text("$EndMeshFormat");
  }
  template <class T>
  Writer& put(T value) {
    if (how_ == How::ascii) {
      text(std::to_string(value));
      return *this;
    }
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (how_ == How::swapped) std::ranges::reverse(raw);
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  Writer& ints(std::initializer_list<std::int32_t> values) {
    for (const auto value : values) put(value);
    return *this;
  }
  Writer& sizes(std::initializer_list<std::uint64_t> values) {
    for (const auto value : values) put(value);
    return *this;
  }
  Writer& reals(std::initializer_list<double> values) {
    for (const auto value : values) put(value);
    return *this;
  }
  [[nodiscard]] bool is_ascii() const { return how_ == How::ascii; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  How how_;
  std::string bytes_;
};

const char* names = "$PhysicalNames\n2\n1 3 \"side\"\n2 1 \"tissue\"\n$EndPhysicalNames";

/// Two triangles (one of them in a group without a name), one line, one point that nothing uses.
std::string format_2(How how) {
  Writer w(how);
  w.format("2.2").text(names).text("$Nodes").text("5");
  const double xy[5][2] = {{0, 0}, {1, 0}, {7, 7}, {1, 1}, {0, 0.3}};
  for (int i = 0; i < 5; ++i) w.ints({10 * (i + 1)}).reals({xy[i][0], xy[i][1], 0});
  w.text("$EndNodes").text("$Elements").text("3");
  if (w.is_ascii()) {
    w.ints({1, 1, 2, 3, 1, 10, 20});
    w.ints({2, 2, 2, 1, 1, 10, 20, 40}).ints({5, 2, 2, 9, 1, 10, 40, 50});
  } else {
    w.ints({1, 1, 2}).ints({1, 3, 1, 10, 20});
    w.ints({2, 2, 2}).ints({2, 1, 1, 10, 20, 40}).ints({5, 9, 1, 10, 40, 50});
  }
  w.text("$EndElements");
  return w.bytes();
}

std::string format_41(How how) {
  Writer w(how);
  w.format("4.1").text(names).text("$Entities");
  w.sizes({1, 1, 2, 0});
  w.ints({1}).reals({0, 0, 0}).sizes({0});
  w.ints({1}).reals({0, 0, 0, 1, 0, 0}).sizes({1}).ints({3}).sizes({2}).ints({1, -1});
  w.ints({1}).reals({0, 0, 0, 1, 1, 0}).sizes({1}).ints({1}).sizes({0});
  w.ints({2}).reals({0, 0, 0, 1, 1, 0}).sizes({1}).ints({9}).sizes({1}).ints({1});
  w.text("$EndEntities").text("$Nodes");
  w.sizes({2, 5, 10, 50});
  w.ints({0, 1, 0}).sizes({1, 10}).reals({0, 0, 0});
  w.ints({2, 1, 0}).sizes({4, 20, 30, 40, 50}).reals({1, 0, 0, 7, 7, 0, 1, 1, 0, 0, 0.3, 0});
  w.text("$EndNodes").text("$Elements");
  w.sizes({3, 3, 1, 5});
  w.ints({1, 1, 1}).sizes({1, 1, 10, 20});
  w.ints({2, 1, 2}).sizes({1, 2, 10, 20, 40});
  w.ints({2, 2, 2}).sizes({1, 5, 10, 40, 50});
  w.text("$EndElements");
  return w.bytes();
}

void expect_equal(const MeshData& a, const MeshData& b) {
  EXPECT_EQ(a.coordinates, b.coordinates);
  EXPECT_EQ(a.cells, b.cells);
  EXPECT_EQ(a.cell_region, b.cell_region);
  EXPECT_EQ(a.region_names, b.region_names);
  EXPECT_EQ(a.facets, b.facets);
  EXPECT_EQ(a.curve_names, b.curve_names);
  EXPECT_EQ(a.origin.cell_number, b.origin.cell_number);
  EXPECT_EQ(a.origin.node_number, b.origin.node_number);
}

TEST(GmshFormats, BothFormatsAndByteOrdersGiveTheSameMesh) {
  const MeshData ascii = read_gmsh("m", format_2(How::ascii));
  EXPECT_THAT(ascii.region_names, testing::ElementsAre("tissue", "9"));
  EXPECT_THAT(ascii.coordinates, testing::ElementsAre(0, 0, 1, 0, 1, 1, 0, 0.3));
  for (const How how : {How::binary, How::swapped}) {
    expect_equal(read_gmsh("m", format_2(how)), ascii);
    expect_equal(read_gmsh("m", format_41(how)), ascii);
  }
  expect_equal(read_gmsh("m", format_41(How::ascii)), ascii);
}

TEST(GmshFormats, EveryTruncationIsAnError) {
  for (const auto& bytes : {format_2(How::binary), format_41(How::swapped)}) {
    for (std::size_t n = 0; n + 1 < bytes.size(); ++n) {
      EXPECT_THROW(read_gmsh("m", bytes.substr(0, n)), InputError) << n;
    }
  }
}

TEST(GmshFormats, MessagesGiveTheByte) {
  std::string bytes = format_2(How::binary);
  const std::size_t triangle = bytes.find("$Elements") + 12 + 8 * 4 + 3 * 4;  // behind both heads
  bytes[triangle + 5 * 4] = 33;                                               // its last node
  EXPECT_THAT([&] { read_gmsh("m", bytes); },
              ThrowsMessage<InputError>("m: byte " + std::to_string(triangle + 6 * 4) +
                                        ": triangle 2 uses node 33, which is not in $Nodes"));
  bytes = format_2(How::binary);
  bytes[bytes.find("$EndMeshFormat") - 4] = 7;
  EXPECT_THAT([&] { read_gmsh("m", bytes); },
              ThrowsMessage<InputError>(HasSubstr("expected the binary number 1")));
  EXPECT_THAT([] { read_gmsh("m", "$MeshFormat\n2.2 1 4\n"); },
              ThrowsMessage<InputError>("m:2: numbers of 4 bytes in a binary file; allowed: 8"));
}

TEST(GmshFormats, Format2WithTopology) {
  // As gmsh -format msh22 -setnumber Mesh.SaveTopology 1 writes it.
  std::string text = format_2(How::ascii);
  const std::string topology =
      "$Entities\n2 1 1 0\n1 0 \n2 0 \n1 2 1 2 1 1 \n1 1 1 0\n$EndEntities\n";
  text.insert(text.find("$Nodes"), topology);
  expect_equal(read_gmsh("m", text), read_gmsh("m", format_2(How::ascii)));
}

TEST(GmshFormats, Format40) {
  const std::string text = R"($MeshFormat
4 0 8
$EndMeshFormat
$Entities
1 1 1 0
1 0 0 0 0 0 0 0
3 0 0 0 1 0 0 1 3 2 1 -2
1 0 0 0 1 1 0 1 2 1 3
$EndEntities
$Nodes
2 3
1 0 0 1
1 0 0 0
3 1 0 2
2 1 0 0
3 0 1 0
$EndNodes
$Elements
2 2
3 1 1 1
1 1 2
1 2 2 1
2 1 2 3
$EndElements
)";
  const MeshData mesh = read_gmsh("a", text);
  EXPECT_THAT(mesh.coordinates, testing::ElementsAre(0, 0, 1, 0, 0, 1));
  EXPECT_THAT(mesh.region_names, testing::ElementsAre("2"));
  EXPECT_THAT(mesh.curve_names, testing::ElementsAre("3"));
}

}  // namespace
}  // namespace stylet
