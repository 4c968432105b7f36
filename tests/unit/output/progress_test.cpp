#include "stylet/output/progress.hpp"

#include "fixture.hpp"

#include <cmath>

namespace stylet {

namespace {

using testing::contents;

TEST(ProgressLine, ShowsShareAndTimes) {
  EXPECT_EQ(clock_text(0.4), "0:00");
  EXPECT_EQ(clock_text(75), "1:15");
  EXPECT_EQ(clock_text(3 * 3600 + 62), "3:01:02");
  EXPECT_EQ(progress_line(0.25, 10, "step 5"), " 25 %  step 5  elapsed 0:10, left 0:30");
  EXPECT_EQ(progress_line(0, 10, ""), "  0 %  elapsed 0:10");
  EXPECT_EQ(progress_line(2, 10, ""), "100 %  elapsed 0:10, left 0:00");
  EXPECT_EQ(progress_line(std::nan(""), 1, ""), "  0 %  elapsed 0:01");
}

class ProgressTest : public testing::FolderTest {
 protected:
  /// What a short run leaves in a log file.
  std::string log(bool quiet) {
    std::FILE* file = std::fopen(path("log").c_str(), "w");
    {
      Progress progress(MPI_COMM_WORLD, quiet, file);
      for (int i = 0; i < 1000; ++i) progress.update(i / 1000.0, "step");
      EXPECT_FALSE(progress.due());
      progress.note("done");
    }
    std::fclose(file);
    return contents(path("log"));
  }
};

TEST_F(ProgressTest, IsSparseInALogFile) {
  EXPECT_EQ(log(false), "done\n");
}
TEST_F(ProgressTest, SaysNothingIfQuiet) {
  EXPECT_EQ(log(true), "");
}

}  // namespace

}  // namespace stylet
