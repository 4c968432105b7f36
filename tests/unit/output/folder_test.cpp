#include "stylet/output/folder.hpp"

#include "stylet/output/text_file.hpp"

#include "fixture.hpp"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

namespace stylet {

namespace {

namespace fs = std::filesystem;
using testing::contents;
using testing::failure_of;
using testing::FileSizeLimit;
using ::testing::HasSubstr;
using testing::put;

class Folder : public testing::FolderTest {
 protected:
  /// A verb that wrote these files and has ended.
  void run(const std::string& place,
           const std::vector<std::string>& names,
           Earlier earlier = Earlier::refuse,
           const std::string& text = "ours") {
    const OutputFolder folder(MPI_COMM_WORLD, place, {"run", names, {}}, earlier, OnSignal::tell);
    for (const auto& name : names) {
      if (!name.ends_with("/")) put(place + "/" + name, text);
    }
  }

  void expect_refused(const std::vector<std::string>& names,
                      Earlier earlier,
                      const std::vector<std::string>& parts) {
    std::string message;
    EXPECT_EQ(failure_of([&] { run(folder_, names, earlier); }, &message), ExitCode::bad_input);
    for (const auto& part : parts) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_FALSE(fs::exists(path(".stylet.lock")));
  }
};

TEST_F(Folder, CreatesParents) {
  run(path("a/b/c"), {});
  EXPECT_TRUE(fs::is_directory(path("a/b/c")));
  run(path("a/b/c"), {});  // empty: no objection
}

TEST_F(Folder, RefusesWhatIsNotMarked) {
  put(path("notes.txt"), "mine");
  for (const Earlier earlier : {Earlier::refuse, Earlier::replace, Earlier::keep}) {
    expect_refused({"history.csv"}, earlier, {folder_, "notes.txt", "--output"});
  }
  EXPECT_FALSE(fs::exists(path(".stylet")));
}

TEST_F(Folder, RefusesEarlierResultsUnlessTold) {
  run(folder_, {"history.csv"});
  expect_refused({"history.csv"}, Earlier::refuse, {"not empty", "--force", "--output"});
  run(folder_, {"history.csv"}, Earlier::replace, "new");
  EXPECT_EQ(contents(path("history.csv")), "new");
}

TEST_F(Folder, ReplacesOwnFilesOnly) {
  run(folder_, {"old.csv", "history.csv", "fields/"});
  put(path("fields/notes.txt"), "mine");
  put(path("notes.txt"), "mine");
  run(folder_, {"history.csv"}, Earlier::replace);
  EXPECT_FALSE(fs::exists(path("old.csv")));
  EXPECT_EQ(contents(path("notes.txt")), "mine");
  EXPECT_EQ(contents(path("fields/notes.txt")), "mine");
}

TEST_F(Folder, RefusesForeignFilesOfItsNames) {
  run(folder_, {"history.csv"});
  put(path("results.csv"), "mine");
  expect_refused({"results.csv"}, Earlier::replace, {"results.csv", "did not write"});
  expect_refused({"results.csv"}, Earlier::keep, {"results.csv"});
  run(folder_, {"history.csv"}, Earlier::replace);
  EXPECT_EQ(contents(path("results.csv")), "mine");
}

TEST_F(Folder, RefusesOwnFilesThatWereChanged) {
  run(folder_, {"scene.yaml"});
  put(path("scene.yaml"), "by hand");
  expect_refused({"scene.yaml"}, Earlier::replace, {"scene.yaml", "changed"});
  EXPECT_EQ(contents(path("scene.yaml")), "by hand");
}

TEST_F(Folder, LargeFilesCountByTheirEnds) {
  const std::string large(3 << 20, 'x');
  run(folder_, {"snapshots.h5"}, Earlier::refuse, large);
  put(path("snapshots.h5"), large.substr(1) + "y");
  expect_refused({"snapshots.h5"}, Earlier::replace, {"snapshots.h5"});
  put(path("snapshots.h5"), large + "x");
  expect_refused({"snapshots.h5"}, Earlier::replace, {"snapshots.h5"});
  put(path("snapshots.h5"), large);
  run(folder_, {"snapshots.h5"}, Earlier::replace);
}

TEST_F(Folder, NumberedFilesAreOwnInFoldersOfThis) {
  {
    const OutputFolder folder(MPI_COMM_WORLD, folder_, {"run", {"scenes/"}, {}}, Earlier::refuse,
                              OnSignal::tell);
    put(path("scenes/00001.yaml"), "ours");
  }
  put(path("scenes/00002.yaml"), "mine");
  put(path("scenes/1.yaml"), "mine");
  expect_refused({"scenes/"}, Earlier::replace, {"scenes/00002.yaml"});
  fs::remove(path("scenes/00002.yaml"));
  run(folder_, {"scenes/"}, Earlier::replace);
  EXPECT_FALSE(fs::exists(path("scenes/00001.yaml")));
  EXPECT_EQ(contents(path("scenes/1.yaml")), "mine");
}

TEST_F(Folder, DoesNotFollowLinks) {
  run(folder_, {"history.csv", "fields/"});
  put(path("elsewhere"), "mine");
  fs::remove(path("history.csv"));
  fs::create_symlink(path("elsewhere"), path("history.csv"));
  expect_refused({"history.csv"}, Earlier::replace, {"history.csv"});
  EXPECT_EQ(contents(path("elsewhere")), "mine");
}

TEST_F(Folder, MarksThatLeadOutOfItCountForNothing) {
  put(path("elsewhere"), "mine");
  fs::create_directories(path("a"));
  fs::create_directories(path("scenes"));
  put(path("scenes/00001.yaml"), "mine");
  put(path("a/.stylet"), "stylet 0.2.0 run\nopen ../elsewhere\nopen ../scenes/\nopen " +
                             path("elsewhere") + "\nopen history.csv\n");
  put(path("a/history.csv"), "ours");
  run(path("a"), {"scene.yaml"}, Earlier::replace);
  EXPECT_EQ(contents(path("elsewhere")), "mine");
  EXPECT_EQ(contents(path("scenes/00001.yaml")), "mine");
  EXPECT_FALSE(fs::exists(path("a/history.csv")));
}

TEST_F(Folder, FilesOfOthersAreNotMarksOrDrafts) {
  put(path(".stylet"), "my notes");
  expect_refused({"history.csv"}, Earlier::replace, {folder_, "'.stylet'"});
  EXPECT_EQ(contents(path(".stylet")), "my notes");
  fs::remove(path(".stylet"));
  fs::create_symlink(path("nowhere"), path(".stylet"));
  expect_refused({"history.csv"}, Earlier::replace, {folder_, "'.stylet'"});
  EXPECT_TRUE(fs::is_symlink(path(".stylet")));
  fs::remove(path(".stylet"));
  put(path(".stylet.txt"), "mine");
  expect_refused({"history.csv"}, Earlier::replace, {folder_, "'.stylet.txt'"});
  fs::remove(path(".stylet.txt"));
  put(draft_of(path("history.csv")), "of a run that was killed");
  run(folder_, {"history.csv"});
  put(path(".stylet.txt"), "mine");
  run(folder_, {"history.csv"}, Earlier::replace);
  EXPECT_EQ(contents(path(".stylet.txt")), "mine");
  EXPECT_FALSE(fs::exists(draft_of(path("history.csv"))));
}

TEST_F(Folder, IsLockedWhileItIsUsed) {
  const OutputFolder folder(MPI_COMM_WORLD, path("a"), {"run", {}, {}}, Earlier::refuse,
                            OnSignal::tell);
  std::string message;
  EXPECT_EQ(failure_of([&] { run(path("a"), {}, Earlier::replace); }, &message),
            ExitCode::bad_input);
  EXPECT_THAT(message, HasSubstr("in use by process " + std::to_string(::getpid()) + " on "));
  EXPECT_THAT(message, HasSubstr(" since 20"));
}

TEST_F(Folder, TakesTheLockOfADeadProcess) {
  run(folder_, {"history.csv"});
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  put(path(".stylet.lock"), "4000000 " + std::string(host) + " 17 2020-01-01 00:00:00 UTC\n");
  run(folder_, {"history.csv"}, Earlier::replace);
  put(path(".stylet.lock"), "4000000 elsewhere 17 2020-01-01 00:00:00 UTC\n");
  std::string message;
  EXPECT_EQ(failure_of([&] { run(folder_, {}, Earlier::replace); }, &message), ExitCode::bad_input);
  EXPECT_THAT(message, HasSubstr("4000000 on elsewhere since 2020-01-01 00:00:00 UTC"));
  EXPECT_THAT(message, HasSubstr("remove " + path(".stylet.lock")));
}

TEST_F(Folder, KeepsWhatCanGoOn) {
  const Contents contents_of{"sweep", {"results.csv", "plan.json"}, {"results.csv"}};
  const auto open = [&](Earlier earlier) {
    const OutputFolder folder(MPI_COMM_WORLD, folder_, contents_of, earlier, OnSignal::tell);
    if (earlier == Earlier::refuse) put(path("results.csv"), "rows"), put(path("plan.json"), "{}");
  };
  open(Earlier::refuse);
  put(path("results.csv"), "fewer rows");
  open(Earlier::keep);
  EXPECT_EQ(contents(path("results.csv")), "fewer rows");
  put(path("plan.json"), "another");
  EXPECT_EQ(failure_of([&] { open(Earlier::keep); }), ExitCode::bad_input);
}

TEST_F(Folder, ParentsHoldFoldersOfOurs) {
  mark_parent(MPI_COMM_WORLD, path("a"));
  run(path("a/part-1"), {"results.csv"});
  mark_parent(MPI_COMM_WORLD, path("a"));
  const OutputFolder joined(MPI_COMM_WORLD, path("a"), {"sweep", {"results.csv"}, {}},
                            Earlier::keep, OnSignal::tell);
  put(path("notes.txt"), "mine");
  EXPECT_EQ(failure_of([&] { mark_parent(MPI_COMM_WORLD, folder_); }), ExitCode::bad_input);
}

TEST_F(Folder, NamesWhatStandsInTheWay) {
  put(path("file"), "x");
  std::string message;
  EXPECT_EQ(failure_of([&] { run(path("file"), {}, Earlier::replace); }, &message), ExitCode::io);
  EXPECT_EQ(failure_of([&] { run(path("file/below"), {}, Earlier::replace); }, &message),
            ExitCode::io);
  EXPECT_THAT(message, HasSubstr("Not a directory"));
}

TEST_F(Folder, SummaryTellsOfAFailure) {
  const auto status = [&] {
    return nlohmann::json::parse(contents(path("summary.json"))).at("status").get<std::string>();
  };
  OutputFolder folder(MPI_COMM_WORLD, folder_, {"run", {}, {}}, Earlier::refuse, OnSignal::tell);
  folder.go_on();
  EXPECT_EQ(status(), "running");
  folder.fail(IoError("the disk is full"));
  EXPECT_EQ(status(), "failed");
  EXPECT_THAT(contents(path("summary.json")), HasSubstr("the disk is full"));
  folder.fail(IoError("and then another"));
  EXPECT_THAT(contents(path("summary.json")), HasSubstr("the disk is full"));
}

class TextWrite : public testing::FolderTest {};

TEST_F(TextWrite, ReplacesTheOldText) {
  write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "old and long");
  write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "new");
  EXPECT_EQ(contents(path("a.txt")), "new");
  EXPECT_FALSE(fs::exists(draft_of(path("a.txt"))));
}

TEST_F(TextWrite, FullDiskKeepsTheOldText) {
  put(path("a.txt"), "old");
  std::string message;
  {
    const FileSizeLimit limit(2);
    EXPECT_EQ(
        failure_of([&] { write_text_atomically(MPI_COMM_WORLD, path("a.txt"), "new"); }, &message),
        ExitCode::io);
  }
  EXPECT_THAT(message, HasSubstr("File too large"));
  EXPECT_EQ(contents(path("a.txt")), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
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
