#include "stylet/output/history.hpp"

#include "stylet/base/fingerprint.hpp"
#include "stylet/output/csv.hpp"

#include "fixture.hpp"
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

namespace stylet {

namespace {

using testing::contents;
using testing::failure_of;
using testing::FileSizeLimit;
using ::testing::HasSubstr;

std::string shown(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

TEST(Number, IsShortAndExact) {
  EXPECT_EQ(shown(3), "3");
  EXPECT_EQ(shown(-0.0), "0");
  EXPECT_EQ(shown(100000), "100000");
  EXPECT_EQ(shown(0.1), "0.1");
  EXPECT_EQ(shown(1e22), "1e+22");
  EXPECT_EQ(shown(std::nan("")), "nan");
  EXPECT_EQ(shown(std::numeric_limits<double>::infinity()), "inf");
  for (const double value : {1.0 / 3, 6.02214076e23, -4.9e-324, 0.1 + 0.2}) {
    EXPECT_EQ(std::strtod(shown(value).c_str(), nullptr), value);
  }
}

class History : public testing::FolderTest {
 protected:
  std::string file() const { return path("history.csv"); }
};

TEST_F(History, HasUnitsInItsHeader) {
  HistoryWriter history(MPI_COMM_WORLD, file(), {{"time", "s"}, {"step", ""}, {"a,b", "N"}});
  history.write(std::array{0.25, 7.0, -1.5});
  history.close();
  EXPECT_EQ(contents(file()), "time [s],step,\"a,b [N]\"\n0.25,7,-1.5\n");
}

TEST_F(History, GoesOnBehindTheRowsThatAreKept) {
  const auto writer = [&](const HistoryPlace& kept, const char* unit = "s") {
    return std::make_unique<HistoryWriter>(MPI_COMM_WORLD, file(),
                                           std::vector<Column>{{"time", unit}}, kept);
  };
  HistoryPlace kept;
  {
    const auto history = writer(kept);
    history->write(std::array{0.5});
    kept = history->settle();
    EXPECT_EQ(kept.bytes, contents(file()).size());
    EXPECT_EQ(kept.fingerprint, fingerprint(contents(file())));
    history->write(std::array{0.75});
    history->close();
  }
  {
    const auto history = writer(kept);
    history->write(std::array{1.5});
    history->close();
  }
  EXPECT_EQ(contents(file()), "time [s]\n0.5\n1.5\n");
  std::string message;
  HistoryPlace of_another = kept;
  of_another.fingerprint = fingerprint("time [s]\n0.6\n");
  using Wrong = std::pair<HistoryPlace, const char*>;
  for (const auto& [place, unit] : {Wrong{kept, "ms"},
                                    {{kept.bytes + 1, kept.fingerprint}, "s"},
                                    {{kept.bytes + 100, kept.fingerprint}, "s"},
                                    {of_another, "s"}}) {
    EXPECT_EQ(failure_of([&] { writer(place, unit); }, &message), ExitCode::bad_input);
    EXPECT_THAT(message, HasSubstr("history.csv"));
  }
  EXPECT_EQ(contents(file()), "time [s]\n0.5\n1.5\n");
}

TEST_F(History, SurvivesADeadProgram) {
  HistoryWriter history(MPI_COMM_WORLD, file(), {{"time", "s"}});
  EXPECT_EQ(contents(file()), "time [s]\n");
  std::this_thread::sleep_for(std::chrono::milliseconds(150));  // beyond the longest delay
  history.write(std::array{1.0});
  EXPECT_EQ(contents(file()), "time [s]\n1\n");
  history.write(std::array{2.0});
  history.flush();
  EXPECT_EQ(contents(file()), "time [s]\n1\n2\n");
}

TEST_F(History, WritesTheRestWhenItGoes) {
  {
    HistoryWriter history(MPI_COMM_WORLD, file(), {{"time", "s"}});
    history.write(std::array{1.0});
  }
  EXPECT_EQ(contents(file()), "time [s]\n1\n");
}

TEST_F(History, FullDiskShowsAtFlush) {
  HistoryWriter history(MPI_COMM_WORLD, file(), {{"time", "s"}});
  const FileSizeLimit limit(1000);
  EXPECT_FALSE(history.failed());
  for (int i = 0; i < 1000; ++i) history.write(std::array{0.1 * i});
  std::string message;
  EXPECT_EQ(failure_of([&] { history.flush(); }, &message), ExitCode::io);
  EXPECT_THAT(message, HasSubstr("File too large"));
  EXPECT_THAT(message, HasSubstr(file()));
  EXPECT_EQ(failure_of([&] { history.close(); }), ExitCode::io);
}

TEST_F(History, NoRoomForTheHeader) {
  const FileSizeLimit limit(4);
  EXPECT_EQ(failure_of([&] {
              HistoryWriter(MPI_COMM_WORLD, file(), {{"time", "s"}});
            }),
            ExitCode::io);
  EXPECT_FALSE(std::filesystem::exists(file()));
}

TEST_F(History, WrongRowIsAnError) {
  HistoryWriter history(MPI_COMM_WORLD, file(), {{"time", "s"}, {"force", "N"}});
  EXPECT_EQ(failure_of([&] { history.write(std::array{1.0}); }), ExitCode::other);
}

}  // namespace

}  // namespace stylet
