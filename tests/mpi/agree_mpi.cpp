// A failure of one rank becomes the same error on all.
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace stylet {

namespace {

const MPI_Comm world = MPI_COMM_WORLD;
using testing::HasSubstr;

TEST(Agree, NoFailureNoError) {
  EXPECT_NO_THROW(agree(world, std::nullopt));
}

TEST(Agree, LastRankFails) {
  const int last = size_of(world) - 1;
  std::optional<Failure> failure;
  if (rank_of(world) == last) failure = Failure{ExitCode::numerical, "inverted element 17"};
  try {
    agree(world, failure);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::numerical);
    EXPECT_STREQ(error.what(), "inverted element 17");
  }
}

TEST(Agree, LowestRankSpeaks) {
  const std::string mine = "rank " + std::to_string(rank_of(world));
  try {
    agree(world, Failure{ExitCode::io, mine});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "rank 0");
  }
}

TEST(Agree, EmptyMessage) {
  EXPECT_THROW(agree(world, Failure{ExitCode::other, ""}), Error);
}

TEST(Agree, AfterABodyThatThrowsOnOneRank) {
  const int last = size_of(world) - 1;
  const auto body = [&] {
    if (rank_of(world) == last) throw InputError("line 3");
  };
  EXPECT_THROW(agree_after(world, body), Error);
  EXPECT_NO_THROW(agree_after(world, [] {}));  // and the communicator is in order
}

TEST(ReadOnAll, BytesOfRankZero) {
  const auto folder = std::filesystem::temp_directory_path();
  const std::string file = (folder / "stylet_read_on_all.txt").string();
  const std::string bytes("a\0b\r\nc", 6);
  if (rank_of(world) == 0) std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_EQ(read_on_all(world, file), bytes);
  if (rank_of(world) == 0) {
    std::ofstream(file, std::ios::binary | std::ios::trunc).close();
  }
  EXPECT_EQ(read_on_all(world, file), "");
  if (rank_of(world) == 0) std::filesystem::remove(file);
}

TEST(ReadOnAll, MissingFileAndFolder) {
  for (const std::string path : {"no/such/file", "."}) {
    try {
      static_cast<void>(read_on_all(world, path));
      FAIL() << "no error for " << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::bad_input);
      EXPECT_THAT(error.what(), HasSubstr(path));
    }
  }
}

}  // namespace

}  // namespace stylet
