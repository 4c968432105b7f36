#include "stylet/scene/document.hpp"

#include "example.hpp"
#include <gmock/gmock.h>

namespace stylet {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_yaml("scene.yaml", text));
    return "no error";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Document, NodesKnowPathAndPlace) {
  const Node root = parse_yaml("scene.yaml", "a:\n  - b: 1\n    c: [2, 3]\n");
  const Node& item = closest(root, "a.0.c.1");
  EXPECT_EQ(item.path, "a.0.c.1");
  EXPECT_EQ(item.where, "scene.yaml:3:12");
  EXPECT_EQ(item.text, "3");
  EXPECT_EQ(closest(root, "a.0.missing.too").path, "a.0");
}

TEST(Document, NamesWithDotsAreFound) {
  const Node root = parse_yaml("scene.yaml", "regions: {a.b: {E: 1}, a: {E: 2}}\n");
  EXPECT_EQ(closest(root, "regions.a.b.E").text, "1");
}

TEST(Document, SyntaxErrorsNameTheLine) {
  EXPECT_THAT(refusal("a: 1\nb: [1, 2\n"),
              AllOf(StartsWith("scene.yaml:"), HasSubstr("not valid YAML")));
  EXPECT_THAT(refusal("a:\n\t- 1\n"), StartsWith("scene.yaml:2:"));
  EXPECT_THAT(refusal("a: 1\n--- \nb: 2\n"), HasSubstr("second YAML document"));
  EXPECT_THAT(refusal("? [1, 2]\n: 3\n"), HasSubstr("plain word"));
}

TEST(Document, AKeyGivenTwiceIsRefused) {
  EXPECT_EQ(
      refusal("t:\n  step: 1 s\n  step: 2 s\n"),
      "scene.yaml:3:3: key 't.step': value '2 s' is the second one of this key; allowed: once");
}

TEST(Document, EndlessAnchorsAreRefused) {
  EXPECT_THAT(refusal("a: &x [*x]\n"), HasSubstr("nested too deeply"));
}

TEST(Document, TextReadsBackAsTheSameTree) {
  const std::string text =
      "a: ~\n\"null\": \"~\"\n\"x: y\": [1, ~, \"a, b\"]\nd:\n  - e: \"true\"\n";
  const Node root = parse_yaml("scene.yaml", text);
  EXPECT_EQ(shown(parse_yaml("scene.yaml", yaml_text(root))), shown(root));
  EXPECT_EQ(parse_yaml("scene.yaml", yaml_text(root)).find("null")->kind, Node::Kind::scalar);
  EXPECT_EQ(parse_yaml("scene.yaml", yaml_text(root)).find("a")->kind, Node::Kind::null);
}

}  // namespace
}  // namespace stylet
