#include "stylet/base/fingerprint.hpp"

#include <gtest/gtest.h>

namespace stylet {

namespace {

// NIST's example values for SHA-256.
TEST(Fingerprint, KnownValues) {
  EXPECT_EQ(fingerprint(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(fingerprint("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(fingerprint("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(fingerprint(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Fingerprint, PiecesMakeTheWhole) {
  const std::string text(200, 'x');
  for (std::size_t cut = 0; cut <= text.size(); cut += 7) {
    Fingerprint pieces;
    pieces.add(text.substr(0, cut)).add(text.substr(cut));
    EXPECT_EQ(pieces.text(), fingerprint(text)) << cut;
  }
}

}  // namespace

}  // namespace stylet
