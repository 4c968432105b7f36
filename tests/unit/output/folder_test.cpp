#include "stylet/output/folder.hpp"

#include "fixture.hpp"
#include <gmock/gmock.h>

#include <sys/stat.h>

namespace stylet {

namespace {

namespace fs = std::filesystem;
using testing::contents;
using testing::failure_of;
using testing::FileSizeLimit;
using ::testing::HasSubstr;
using testing::put;

class Folder : public testing::FolderTest {};

TEST_F(Folder, CreatesParents) {
  prepare_folder(MPI_COMM_WORLD, path("a/b/c"), false);
  EXPECT_TRUE(fs::is_directory(path("a/b/c")));
  prepare_folder(MPI_COMM_WORLD, path("a/b/c"), false);  // empty: no objection
}

TEST_F(Folder, RefusesWhatIsNotEmpty) {
  put(path("notes.txt"), "mine");
  std::string message;
  EXPECT_EQ(failure_of([&] { prepare_folder(MPI_COMM_WORLD, folder_, false); }, &message),
            ExitCode::bad_input);
  EXPECT_THAT(message, HasSubstr("--force"));
  EXPECT_THAT(message, HasSubstr("--output"));
  EXPECT_THAT(message, HasSubstr(folder_));
}

TEST_F(Folder, ForceRemovesOwnFilesOnly) {
  fs::create_directory(path("frames"));
  fs::create_directory(path("history.csv"));  // a folder of one of our names
  put(path("history.csv/inside"), "keep");
  for (const char* name :
       {"snapshots.h5", "snapshots.xdmf", "snapshots_needle.xdmf", "summary.json", "scene.yaml",
        "summary.json.tmp", "frames/frame_0003.png", "frames/overview.gif"}) {
    put(path(name), "old");
  }
  const auto others = {"notes.txt", "frames/frame_x.png", "frames/frame_.png", "frames/talk.png",
                       "history.csv.bak"};
  for (const char* name : others) put(path(name), "keep");
  prepare_folder(MPI_COMM_WORLD, folder_, true);
  for (const char* name : others) EXPECT_TRUE(fs::exists(path(name))) << name;
  EXPECT_TRUE(fs::exists(path("history.csv/inside")));
  EXPECT_FALSE(fs::exists(path("snapshots.h5")));
  EXPECT_FALSE(fs::exists(path("summary.json.tmp")));
  EXPECT_FALSE(fs::exists(path("frames/frame_0003.png")));
  EXPECT_FALSE(fs::exists(path("frames/overview.gif")));
}

TEST_F(Folder, ForceRemovesEmptiedFramesButDoesNotFollowLinks) {
  fs::create_directory(path("frames"));
  put(path("frames/frame_0000.png"), "old");
  prepare_folder(MPI_COMM_WORLD, folder_, true);
  EXPECT_FALSE(fs::exists(path("frames")));

  fs::create_directory(path("elsewhere"));
  put(path("elsewhere/frame_0000.png"), "keep");
  fs::create_directory_symlink(path("elsewhere"), path("frames"));
  prepare_folder(MPI_COMM_WORLD, folder_, true);
  EXPECT_TRUE(fs::exists(path("elsewhere/frame_0000.png")));
}

TEST_F(Folder, NamesWhatStandsInTheWay) {
  put(path("file"), "x");
  std::string message;
  EXPECT_EQ(failure_of([&] { prepare_folder(MPI_COMM_WORLD, path("file"), true); }, &message),
            ExitCode::io);
  EXPECT_EQ(failure_of([&] { prepare_folder(MPI_COMM_WORLD, path("file/below"), true); }, &message),
            ExitCode::io);
  EXPECT_THAT(message, HasSubstr("Not a directory"));
}

class TextWrite : public testing::FolderTest {};

TEST_F(TextWrite, ReplacesTheOldText) {
  write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "old and long");
  write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "new");
  EXPECT_EQ(contents(path("a.txt")), "new");
  EXPECT_FALSE(fs::exists(path("a.txt.tmp")));
}

TEST_F(TextWrite, FullDiskKeepsTheOldText) {
  put(path("a.txt"), "old");
  // The draft is written through this link into a device that is always full.
  fs::create_symlink("/dev/full", path("a.txt.tmp"));
  std::string message;
  EXPECT_EQ(
      failure_of([&] { write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "new"); }, &message),
      ExitCode::io);
  EXPECT_THAT(message, HasSubstr("No space left on device"));
  EXPECT_EQ(contents(path("a.txt")), "old");
  EXPECT_FALSE(fs::exists(fs::symlink_status(path("a.txt.tmp"))));
}

TEST_F(TextWrite, PartialWriteIsAFailure) {
  const FileSizeLimit limit(1000);
  EXPECT_EQ(failure_of([&] {
              write_text_atomically(MPI_COMM_WORLD, path("a.txt"), std::string(5000, 'x'));
            }),
            ExitCode::io);
  EXPECT_FALSE(fs::exists(path("a.txt")));
}

TEST_F(TextWrite, MissingFolder) {
  EXPECT_EQ(failure_of([&] { write_text_atomically(MPI_COMM_WORLD, path("no/a.txt"), "x"); }),
            ExitCode::io);
}

}  // namespace

}  // namespace stylet
