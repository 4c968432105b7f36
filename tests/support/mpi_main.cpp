// main of test programs that need MPI and PETSc.
#include "stylet/petsc/session.hpp"

#include <gtest/gtest.h>

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (testing::GTEST_FLAG(list_tests)) return RUN_ALL_TESTS();  // at build time: without MPI
  const stylet::Session session(1, argv);
  return RUN_ALL_TESTS();
}
