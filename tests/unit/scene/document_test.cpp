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

TEST(Document, NamesWithDotsAreQuotedInPaths) {
  // Whatever their order: a.b is no key of a.
  for (const char* text :
       {"regions: {a.b: {E: 1}, a: {b: {E: 2}}}", "regions: {a: {b: {E: 2}}, a.b: {E: 1}}"}) {
    const Node root = parse_yaml("scene.yaml", text);
    EXPECT_EQ(closest(root, R"(regions."a.b".E)").text, "1");
    EXPECT_EQ(closest(root, "regions.a.b.E").text, "2");
  }
}

TEST(Document, SyntaxErrorsNameTheLine) {
  EXPECT_THAT(refusal("a: 1\nb: [1, 2\n"),
              AllOf(StartsWith("scene.yaml:"), HasSubstr("not valid YAML")));
  EXPECT_THAT(refusal("a:\n\t- 1\n"), StartsWith("scene.yaml:2:"));
  EXPECT_THAT(refusal("a: 1\n--- \nb: 2\n"), HasSubstr("second YAML document"));
  EXPECT_THAT(refusal("? [1, 2]\n: 3\n"), HasSubstr("plain word"));
}

TEST(Document, TextThatIsNoUtf8IsNamed) {
  EXPECT_EQ(refusal("a: 1\nb: 2  # caf\xE9\n"),
            "scene.yaml:2:12: byte 0xE9 is not UTF-8; save the file as UTF-8");
  EXPECT_THAT(refusal("\xFF\xFE" + std::string("a\0:\0", 4)),
              HasSubstr("scene.yaml:1:1: byte 0xFF"));
  EXPECT_EQ(refusal(std::string("a: 1\0", 5)),
            "scene.yaml:1:5: control character U+0000 (null character)");
  EXPECT_THAT(refusal(R"(a: "1\0.7 N")"), HasSubstr("'1<U+0000>.7 N' has an invisible character"));
  EXPECT_EQ(refusal("a: \"caf\u00E9\"  # \u00A0\u200B\n"), "no error");
}

TEST(Document, AMarkOfByteOrderIsNoText) {
  EXPECT_EQ(parse_yaml("scene.yaml", "\uFEFFa: 1\n").find("a")->where, "scene.yaml:1:4");
}

TEST(Document, InvisibleCharactersAreNamed) {
  EXPECT_THAT(refusal("a: 1\nb\u200B: 2\n"),
              AllOf(StartsWith("scene.yaml:2:1: "), HasSubstr("U+200B (zero-width space)")));
  EXPECT_THAT(refusal("a: st\u00ADress\n"), HasSubstr("U+00AD (soft hyphen)"));
  EXPECT_THAT(refusal("a:\n  b\u00A0: 2\n"),
              AllOf(StartsWith("scene.yaml:2:3: "), HasSubstr("U+00A0 (non-breaking space)")));
  EXPECT_THAT(refusal("a: 1\nb:\u00A02\nc: 3\n"), HasSubstr("line 2 has a U+00A0 (non-breaking"));
  EXPECT_THAT(refusal("a:\n\tb: 1\n  c: 2\n"), HasSubstr("line 2 begins with a tab"));
  EXPECT_THAT(refusal("a: \u201Cstress\u201D\n"), HasSubstr("typographic quotes"));
  EXPECT_EQ(refusal("title: Poisson\u2019s ratio\n"), "no error");
}

TEST(Document, AKeyGivenTwiceIsRefused) {
  EXPECT_EQ(
      refusal("t:\n  step: 1 s\n  step: 2 s\n"),
      "scene.yaml:3:3: key 't.step': value '2 s' is the second one of this key; allowed: once");
}

TEST(Document, EndlessAnchorsAreRefused) {
  EXPECT_THAT(refusal("a: &x [*x]\n"), HasSubstr("nested too deeply"));
}

TEST(Document, NothingGrowsOutOfProportion) {
  // Each is some hundred kilobytes and would be gigabytes as a tree.
  std::string items;
  for (int i = 0; i < 50'000; ++i) items += "1,";
  EXPECT_THAT(refusal("? " + std::string(100'000, 'k') + "\n: [" + items + "]\n"),
              HasSubstr("too large"));
  EXPECT_THAT(
      refusal("a: &a [" + items + "]\nb: &b [*a, *a, *a, *a, *a, *a, *a, *a]\nc: [*b, *b, *b]"),
      HasSubstr("too large"));
  EXPECT_THAT(refusal("a: &a " + std::string(100'000, 'x') + "\nb: [" +
                      [] {
                        std::string uses;
                        for (int i = 0; i < 10'000; ++i) uses += "*a,";
                        return uses;
                      }() +
                      "]\n"),
              HasSubstr("too large"));
  EXPECT_THAT(refusal(std::string(100'000, '[')), HasSubstr("scene.yaml:1:"));
  EXPECT_THAT(refusal("a: " + std::string(30, '[') + std::string(30, ']')),
              HasSubstr("nested too deeply"));
  const std::string entry = "? " + std::string(100'000, 'k') + "\n: 1\n";
  EXPECT_LT(refusal(entry + entry).size(), 500U);
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
